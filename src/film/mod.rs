//! Pixels on their way out: gamma, files of every format, the state of an unfinished picture. Knows nothing of scenes or rays.

mod catcher;
pub mod cryptomatte;
mod dither;
mod encoding;
mod error;
mod exr_file;
pub mod exr_layers;
mod format;
mod hdr_file;
mod layer;
mod merge;
mod png_file;
mod simple_files;
pub mod state;
mod write;

pub use catcher::CatcherView;
pub use dither::DitherMethod;
pub use encoding::{Encoding, FileGamma, linear_from_srgb, srgb_from_linear};
pub use error::FilmError;
pub use exr_file::{Part, read_exr};
pub use format::FileFormat;
pub use layer::{Layer, PixelSamples, add_share, write_ranks};
pub use merge::merge;
pub(crate) use write::replace_file;
pub use write::{DENOISED, Metadata, check_writable, encode_picture, write_picture};

/// A picture being made: linear working-space colour and transparency, `[height][width]`, row-major, top row first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Film {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue, transmit (1 - alpha) of each pixel: the mean of its samples.
    pub pixels: Vec<[f32; 4]>,
    /// Samples in each pixel's mean; 0 for a pixel not rendered yet.
    pub samples: Vec<u32>,
    /// Passes besides the colours, in their order.
    pub layers: Vec<Layer>,
    /// Red, green, blue of each pixel after denoising; files show them in place of those of `pixels`, and hold both where they can.
    pub denoised: Option<Vec<[f32; 3]>>,
}

impl Film {
    /// A black film with no samples.
    pub fn new(width: u32, height: u32) -> Self {
        let n = width as usize * height as usize;
        Self { width, height, pixels: vec![[0.0; 4]; n], samples: vec![0; n], layers: Vec::new(), denoised: None }
    }

    /// The film with its denoised colours, if there are any, in place of the noisy ones.
    pub fn shown(&self) -> std::borrow::Cow<'_, Self> {
        let Some(clean) = &self.denoised else { return std::borrow::Cow::Borrowed(self) };
        let pixels = self.pixels.iter().zip(clean).map(|(p, [r, g, b])| [*r, *g, *b, p[3]]).collect();
        std::borrow::Cow::Owned(Self { pixels, denoised: None, ..self.clone() })
    }

    /// Place of a pixel in the arrays.
    pub fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}
