//! OpenEXR files with all that they hold: every layer of every part as a picture of its own.

use super::{Picture, PictureError};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;

/// A channel's samples over its part's data window.
struct Plane {
    samples: FlatSamples,
    /// Size of the data window, and its place in the picture.
    size: [usize; 2],
    at: [i64; 2],
}

/// Reads every layer of an EXR file, by name; the colours without a layer are called "".
///
/// Channels `NAME.R`, `NAME.G`, ... make the layer `NAME`, a part's name stands before its layers'. Any other channel makes a grey layer
/// of its own name.
pub fn read_layers(path: &Path, max_pixels: u64) -> Result<BTreeMap<String, Picture>, PictureError> {
    let bad = |reason: String| PictureError::Decode { path: path.to_owned(), reason };
    let io = |source| PictureError::Io { path: path.to_owned(), source };
    let file = std::fs::File::open(path).map_err(io)?;
    let meta = exr::meta::MetaData::read_from_buffered(std::io::BufReader::new(file), false).map_err(|e| bad(e.to_string()))?;
    let display = meta.headers.first().ok_or_else(|| bad("the file has no picture".into()))?.shared_attributes.display_window;
    let [width, height] = [display.size.0, display.size.1];
    if width == 0 || height == 0 {
        return Err(bad("the picture has no pixels".into()));
    }
    let data: u64 = meta.headers.iter().map(|h| h.layer_size.area() as u64).max().unwrap_or(0);
    if (width as u64 * height as u64).max(data) > max_pixels {
        return Err(PictureError::TooLarge { path: path.to_owned(), width: width as u32, height: height as u32, limit: max_pixels });
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(path)
        .map_err(|e| bad(e.to_string()))?;
    let n_parts = image.layer_data.len();
    let mut layers: BTreeMap<String, BTreeMap<String, Plane>> = BTreeMap::new();
    for (k, part) in image.layer_data.into_iter().enumerate() {
        let part_name = match &part.attributes.layer_name {
            Some(name) if n_parts > 1 => name.to_string(),
            None if k > 0 => format!("part {k}"),
            _ => String::new(),
        };
        let offset = part.attributes.layer_position - display.position;
        for channel in part.channel_data.list {
            let name = channel.name.to_string();
            let (layer, short) = name.rsplit_once('.').unwrap_or(("", &name));
            let full = [part_name.as_str(), layer].iter().filter(|s| !s.is_empty()).copied().collect::<Vec<_>>().join(".");
            let plane = Plane { samples: channel.sample_data, size: [part.size.0, part.size.1], at: [offset.0.into(), offset.1.into()] };
            layers.entry(full).or_default().insert(short.to_owned(), plane);
        }
    }
    let mut out = BTreeMap::new();
    for (name, mut planes) in layers {
        let find = |planes: &mut BTreeMap<String, Plane>, names: &[&str]| names.iter().find_map(|n| planes.remove(*n));
        let colors = ["R", "G", "B"].map(|c| find(&mut planes, &[c, &c.to_lowercase()]));
        let alpha = find(&mut planes, &["A", "a"]);
        if let [Some(r), Some(g), Some(b)] = &colors {
            out.insert(name.clone(), picture([r, g, b], alpha.as_ref(), width, height));
        }
        for (short, plane) in planes {
            let full = if short == "Y" { name.clone() } else { [name.as_str(), &short].join(".").trim_start_matches('.').to_owned() };
            out.insert(full, picture([&plane; 3], None, width, height));
        }
    }
    if out.is_empty() {
        return Err(bad("the file has no channels".into()));
    }
    Ok(out)
}

/// The picture of a file: its colours, else its first layer.
pub(super) fn read_main(path: &Path, max_pixels: u64) -> Result<Picture, PictureError> {
    let mut layers = read_layers(path, max_pixels)?;
    let none = || PictureError::Decode { path: path.to_owned(), reason: "the file has no channels R, G and B".into() };
    let colors = layers.keys().find(|k| k.is_empty() || k.ends_with("Combined")).cloned();
    colors.and_then(|k| layers.remove(&k)).ok_or_else(none)
}

fn picture(colors: [&Plane; 3], alpha: Option<&Plane>, width: usize, height: usize) -> Picture {
    let mut pixels = vec![[0.0, 0.0, 0.0, if alpha.is_some() { 0.0 } else { 1.0 }]; width * height];
    for (c, plane) in colors.into_iter().chain(alpha).enumerate() {
        match &plane.samples {
            FlatSamples::F32(v) => fill(&mut pixels, c, plane, v, width, |v| *v),
            FlatSamples::F16(v) => fill(&mut pixels, c, plane, v, width, |v| v.to_f32()),
            FlatSamples::U32(v) => fill(&mut pixels, c, plane, v, width, |v| *v as f32),
        }
    }
    Picture {
        width: width as u32,
        height: height as u32,
        pixels,
        has_alpha: alpha.is_some(),
        linear: true,
        depth: "OpenEXR, linear light".into(),
    }
}

/// Copies a plane into channel `c`, where its data window lies in the picture.
fn fill<T: Sync>(pixels: &mut [[f32; 4]], c: usize, plane: &Plane, samples: &[T], width: usize, value: impl Fn(&T) -> f32 + Sync) {
    let [w, h] = plane.size;
    pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let from = y as i64 - plane.at[1];
        if from < 0 || from >= h as i64 {
            return;
        }
        let line = &samples[from as usize * w..(from as usize + 1) * w];
        for (x, p) in row.iter_mut().enumerate() {
            let from = x as i64 - plane.at[0];
            if from >= 0 && from < w as i64 {
                p[c] = value(&line[from as usize]);
            }
        }
    });
}
