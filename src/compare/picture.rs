//! Picture files → pixels that can be compared.

use crate::film::{linear_from_srgb, srgb_from_linear};
use image::{DynamicImage, ImageDecoder, ImageReader};
use rayon::prelude::*;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest number of pixels that is read unless more is asked for: 16 bytes each.
pub const DEFAULT_MAX_PIXELS: u64 = 100_000_000;

/// How an EXR file begins.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Why a picture cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Not there, or not allowed.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// No picture, a damaged one, or a format that is not read.
    #[error("cannot read {} as a picture: {reason}", path.display())]
    Decode {
        /// Which file.
        path: PathBuf,
        /// What the decoder says.
        reason: String,
    },
    /// More pixels than the limit, found before any is read.
    #[error("{}: {width} by {height} pixels are more than the limit of {limit} (--max-pixels)", path.display())]
    TooLarge {
        /// Which file.
        path: PathBuf,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Pixels.
        limit: u64,
    },
}

/// A decoded picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue, alpha, `[height][width]`, row-major, top row first. Colours are multiplied by alpha: what is seen over black.
    pub pixels: Vec<[f32; 4]>,
    /// The file has alpha; without it every alpha is 1.
    pub has_alpha: bool,
    /// Values are linear light and may exceed 1 (EXR, HDR); else they are sRGB in 0..=1.
    pub linear: bool,
    /// "8-bit sRGB", "32-bit float".
    pub depth: String,
}

impl Picture {
    /// Reads a picture file of any format that the program reads; the content decides, the extension only where there is no other sign.
    pub fn read(path: &Path, max_pixels: u64) -> Result<Self, PictureError> {
        let io = |source| PictureError::Io { path: path.to_owned(), source };
        let mut magic = [0; 4];
        let n = std::fs::File::open(path).and_then(|f| f.take(4).read(&mut magic)).map_err(io)?;
        if magic[..n] == EXR_MAGIC { super::layers::read_main(path, max_pixels) } else { Self::read_other(path, max_pixels) }
    }

    fn read_other(path: &Path, max_pixels: u64) -> Result<Self, PictureError> {
        let io = |source| PictureError::Io { path: path.to_owned(), source };
        let bad = |e: image::ImageError| PictureError::Decode { path: path.to_owned(), reason: e.to_string() };
        let mut reader = ImageReader::open(path).map_err(io)?.with_guessed_format().map_err(io)?;
        reader.no_limits();
        let decoder = reader.into_decoder().map_err(bad)?;
        let (width, height) = decoder.dimensions();
        if u64::from(width) * u64::from(height) > max_pixels {
            return Err(PictureError::TooLarge { path: path.to_owned(), width, height, limit: max_pixels });
        }
        let color = decoder.color_type();
        let image = DynamicImage::from_decoder(decoder).map_err(bad)?;
        let has_alpha = color.has_alpha();
        let linear = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
        let bits = color.bytes_per_pixel() as u32 * 8 / u32::from(color.channel_count());
        let gamma = if linear { None } else { png_gamma(path) };
        let depth = match (linear, gamma) {
            (true, _) => format!("{bits}-bit float, linear light"),
            (false, None) => format!("{bits}-bit sRGB"),
            (false, Some(g)) => format!("{bits}-bit, gamma {:.3}", 1.0 / g),
        };
        let mut pixels: Vec<[f32; 4]> = image.into_rgba32f().pixels().map(|p| p.0).collect();
        if let Some(g) = gamma {
            pixels.par_iter_mut().for_each(|p| {
                for v in &mut p[..3] {
                    *v = srgb_from_linear(v.powf(1.0 / g));
                }
            });
        }
        if has_alpha {
            pixels.par_iter_mut().filter(|p| p[3] != 1.0).for_each(|p| *p = over_black(*p, linear));
        }
        Ok(Self { width, height, pixels, has_alpha, linear, depth })
    }

    /// Whether a file is an EXR.
    pub fn is_exr(path: &Path) -> bool {
        let mut magic = [0; 4];
        std::fs::File::open(path).and_then(|mut f| f.read_exact(&mut magic)).is_ok() && magic == EXR_MAGIC
    }

    /// The picture as it is shown: sRGB in 0..=1. Numbers that are none stay what they are.
    #[must_use]
    pub fn into_display(self) -> Self {
        self.into_space(false, 0.0)
    }

    /// The picture in linear light.
    #[must_use]
    pub fn into_linear(self) -> Self {
        self.into_space(true, 0.0)
    }

    /// The picture in linear light or as it is shown, brightened by `exposure` stops. Numbers that are none stay what they are.
    #[must_use]
    pub fn into_space(mut self, linear: bool, exposure: f32) -> Self {
        if self.linear == linear && exposure == 0.0 {
            return self;
        }
        let (from_linear, factor) = (self.linear, exposure.exp2());
        let convert = move |v: f32| {
            let light = factor * if from_linear { v } else { linear_from_srgb(v) };
            if linear { light } else { srgb_from_linear(light.clamp(0.0, 1.0)) }
        };
        self.linear = linear;
        self.pixels.par_iter_mut().for_each(|p| {
            for v in &mut p[..3] {
                if v.is_finite() {
                    *v = convert(*v);
                }
            }
        });
        self
    }

    /// The picture's means, in light, over squares of `side` pixels; those at the right and lower rim may be smaller.
    #[must_use]
    pub fn into_means(self, side: u32) -> Self {
        let was_linear = self.linear;
        let p = self.into_linear();
        let side = side.max(1);
        let (width, height) = (p.width.div_ceil(side), p.height.div_ceil(side));
        let mean = |k: u32| {
            let (x0, y0) = (k % width * side, k / width * side);
            let (x1, y1) = ((x0 + side).min(p.width), (y0 + side).min(p.height));
            let mut sum = [0.0f64; 4];
            for y in y0..y1 {
                for v in &p.pixels[(y * p.width + x0) as usize..(y * p.width + x1) as usize] {
                    (0..4).for_each(|c| sum[c] += f64::from(v[c]));
                }
            }
            sum.map(|s| (s / f64::from((x1 - x0) * (y1 - y0))) as f32)
        };
        let pixels = (0..width * height).map(mean).collect();
        Self { width, height, pixels, ..p }.into_space(was_linear, 0.0)
    }
}

/// A pixel of straight alpha with its colour multiplied by alpha, in light.
fn over_black([r, g, b, a]: [f32; 4], linear: bool) -> [f32; 4] {
    let times_alpha = |v: f32| {
        if linear { v * a } else { srgb_from_linear(linear_from_srgb(v) * a) }
    };
    [times_alpha(r), times_alpha(g), times_alpha(b), a]
}

/// The exponent of light in a PNG whose values are not sRGB: its gAMA, unless the file says sRGB or means it.
fn png_gamma(path: &Path) -> Option<f32> {
    let file = std::io::BufReader::new(std::fs::File::open(path).ok()?);
    let reader = png::Decoder::new(file).read_info().ok()?;
    let info = reader.info();
    if info.srgb.is_some() {
        return None;
    }
    let gamma = info.gama_chunk?.into_value();
    (gamma > 0.0 && (gamma - 1.0 / 2.2).abs() > 1e-3).then_some(gamma)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_taken_in_light_and_of_the_pixels_that_are_there() {
        let of = |width: u32, height: u32, values: &[f32]| Picture {
            width,
            height,
            pixels: values.iter().map(|v| [*v, 0.5, 0.0, 1.0]).collect(),
            has_alpha: false,
            linear: true,
            depth: String::new(),
        };
        let m = of(3, 2, &[0.0, 1.0, 0.25, 0.5, 0.5, 0.75]).into_means(2);
        assert_eq!((m.width, m.height, m.pixels[0], m.pixels[1]), (2, 1, [0.5, 0.5, 0.0, 1.0], [0.5, 0.5, 0.0, 1.0]));
        // Black and white in equal parts are half of the light, which shows as 0.735.
        let m = Picture { linear: false, ..of(2, 1, &[0.0, 1.0]) }.into_means(2);
        assert!((m.pixels[0][0] - 0.7354).abs() < 1e-3, "{}", m.pixels[0][0]);
    }
}
