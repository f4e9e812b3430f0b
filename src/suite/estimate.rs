//! Files of noisy pictures: mean and variance of each pixel in one EXR, as layers that every viewer shows.

use super::error::SuiteError;
use crate::compare::{DEFAULT_MAX_PIXELS, Estimate, Picture, PictureError, read_layers};
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, Layer, LayerAttributes, WritableImage};
use std::path::Path;

/// Name of the layer that holds the variance of the mean.
const VARIANCE: &str = "variance";
/// Name of the channel that says how many pictures it comes from.
const SEEDS: &str = "seeds";

/// Reads a mean with its variance; a file without the layer is taken as exact.
pub fn read(path: &Path) -> Result<Estimate, PictureError> {
    let mut layers = read_layers(path, DEFAULT_MAX_PIXELS)?;
    let missing = || PictureError::Decode { path: path.to_owned(), reason: "the file has no channels R, G and B".into() };
    let mean = layers.remove("").ok_or_else(missing)?;
    let rgb = |p: Picture| p.pixels.iter().map(|p| [p[0], p[1], p[2]]).collect::<Vec<_>>();
    let n_seeds = layers.remove(SEEDS).and_then(|p| p.pixels.first().map(|p| p[0] as u32)).unwrap_or(0);
    let variance = layers.remove(VARIANCE).map_or_else(|| vec![[0.0; 3]; mean.pixels.len()], rgb);
    Ok(Estimate { width: mean.width, height: mean.height, mean: rgb(mean), variance, n_seeds })
}

/// The estimate of pictures made with different seeds.
pub fn of_files(paths: &[impl AsRef<Path>]) -> Result<Estimate, PictureError> {
    let mut pictures = Vec::new();
    let mut size = (0, 0);
    for path in paths {
        let p = Picture::read(path.as_ref(), DEFAULT_MAX_PIXELS)?.into_linear();
        size = (p.width, p.height);
        pictures.push(p.pixels.iter().map(|p| [p[0], p[1], p[2]]).collect());
    }
    let wrong = || PictureError::Decode {
        path: paths.first().map_or_else(Default::default, |p| p.as_ref().to_owned()),
        reason: "there must be several pictures of one size".into(),
    };
    Estimate::from_seeds(size.0, size.1, &pictures).ok_or_else(wrong)
}

/// Writes a mean with its variance.
pub fn write(path: &Path, e: &Estimate) -> Result<(), SuiteError> {
    let plane = |values: &[[f32; 3]], c: usize| FlatSamples::F32(values.iter().map(|v| v[c]).collect());
    let mut channels = Vec::new();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(AnyChannel::new(name, plane(&e.mean, c)));
        channels.push(AnyChannel::new(format!("{VARIANCE}.{name}").as_str(), plane(&e.variance, c)));
    }
    channels.push(AnyChannel::new(SEEDS, FlatSamples::U32(vec![e.n_seeds; e.mean.len()])));
    let layer = Layer::new(
        (e.width as usize, e.height as usize),
        LayerAttributes::default(),
        exr::image::Encoding { compression: exr::prelude::Compression::ZIP16, ..exr::image::Encoding::default() },
        AnyChannels::sort(channels.into()),
    );
    let bad = |e: exr::error::Error| SuiteError::Io { verb: "write", path: path.to_owned(), source: std::io::Error::other(e.to_string()) };
    Image::from_layer(layer).write().to_file(path).map_err(bad)
}
