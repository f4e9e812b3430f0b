//! Pixels on their way out: gamma, files of every format, the state of an unfinished picture. Knows nothing of scenes or rays.

mod encoding;
mod error;
mod format;
mod png_file;
pub mod state;
mod write;

pub use encoding::{Encoding, FileGamma};
pub use error::FilmError;
pub use format::FileFormat;
pub use write::{Metadata, check_writable, encode_picture, write_picture};

/// A picture being made: linear working-space colour and transparency, `[height][width]`, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue, transmit (1 - alpha) of each pixel: the mean of its samples.
    pub pixels: Vec<[f32; 4]>,
    /// Samples in each pixel's mean; 0 for a pixel not rendered yet.
    pub samples: Vec<u32>,
}

impl Film {
    /// A black film with no samples.
    pub fn new(width: u32, height: u32) -> Self {
        let n = width as usize * height as usize;
        Self { width, height, pixels: vec![[0.0; 4]; n], samples: vec![0; n] }
    }

    /// Place of a pixel in the arrays.
    pub fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

/// stub
#[derive(Clone, Debug)]
pub enum FileFormat {
    /// a
    Png {
        /// a
        bits: u8,
        /// a
        grayscale: bool,
    },
    /// a
    Exr,
    /// a
    Targa {
        /// a
        rle: bool,
    },
    /// a
    Ppm {
        /// a
        bits: u8,
        /// a
        grayscale: bool,
    },
    /// a
    Bmp,
    /// a
    Jpeg {
        /// a
        quality: u8,
    },
    /// a
    Hdr,
}
impl FileFormat {
    /// s
    pub fn from_path(_p: &std::path::Path) -> Option<Self> {
        Some(Self::Png { bits: 8, grayscale: false })
    }
}
/// s
#[derive(Clone, Copy, Debug)]
pub enum FileGamma {
    /// s
    Srgb,
    /// s
    Power(f64),
}
/// s
pub struct Encoding {
    /// s
    pub working: crate::scene::settings::WorkingGamma,
    /// s
    pub file_gamma: FileGamma,
    /// s
    pub alpha: bool,
    /// s
    pub dither: bool,
}
impl Default for Encoding {
    fn default() -> Self {
        Self { working: crate::scene::settings::WorkingGamma::Linear, file_gamma: FileGamma::Srgb, alpha: false, dither: false }
    }
}
/// s
#[derive(Default)]
pub struct Metadata {
    /// s
    pub software: String,
    /// s
    pub scene: String,
    /// s
    pub entries: Vec<(String, String)>,
}
/// s
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// s
    #[error("{verb} {path}: {source}")]
    Io {
        /// s
        verb: &'static str,
        /// s
        path: std::path::PathBuf,
        /// s
        source: std::io::Error,
    },
}
/// s
pub fn check_writable(_p: &std::path::Path) -> Result<(), FilmError> {
    Ok(())
}
/// s
pub fn encode_picture(f: &Film, _x: &FileFormat, e: &Encoding, _m: &Metadata) -> Result<Vec<u8>, FilmError> {
    use crate::scene::settings::WorkingGamma as G;
    let srgb = |v: f64| if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    let enc = |v: f32| {
        let v = f64::from(v).clamp(0.0, 1.0);
        let o = match e.working {
            G::Linear => srgb(v),
            G::Power(g) => srgb(v.powf(g)),
            _ => v,
        };
        (o * 255.0 + 0.5).floor() as u8
    };
    let mut out = Vec::new();
    let mut p = png::Encoder::new(&mut out, f.width, f.height);
    p.set_color(png::ColorType::Rgb);
    let mut w = p.write_header().unwrap();
    let d: Vec<u8> = f.pixels.iter().flat_map(|p| [enc(p[0]), enc(p[1]), enc(p[2])]).collect();
    w.write_image_data(&d).unwrap();
    drop(w);
    Ok(out)
}
/// s
pub fn write_picture(path: &std::path::Path, f: &Film, x: &FileFormat, e: &Encoding, m: &Metadata) -> Result<(), FilmError> {
    std::fs::write(path, encode_picture(f, x, e, m)?).unwrap();
    Ok(())
}
/// s
pub mod state {
    /// s
    pub fn path_for(p: &std::path::Path) -> std::path::PathBuf {
        p.with_extension("rayloom-state")
    }
}
