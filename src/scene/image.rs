//! Pixels that scenes use, decoded, and how an image becomes a pattern.

use crate::math::Rgbft;
use std::sync::Arc;

/// The pixels of an image file in the working colour space, `[height][width]`, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names of the fields say it")]
pub enum Pixels {
    /// Index into a palette of at most 256 colours.
    Indexed { indices: Vec<u8>, palette: Vec<Rgbft> },
    /// One grey channel with its file's depth, 0..=65535; 8-bit files are stored times 257.
    Gray16(Vec<u16>),
    /// Colour with transmit = 1 - alpha.
    Color(Vec<Rgbft>),
}

/// A decoded image.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Pixels.
    pub pixels: Pixels,
    /// The file had transparency.
    pub has_alpha: bool,
    /// The file's channels had more than 8 bits (height fields read such files differently).
    pub deep: bool,
    /// For height fields: high and low byte of each pixel's height, red and green of 8-bit colour files, `[height][width][2]`;
    /// empty otherwise.
    pub raw_rg: Vec<[u8; 2]>,
}

/// Projection of an image to space. Source: spec/textures.md, section 7.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapType {
    /// x and y.
    Planar,
    /// Angle and elevation.
    Spherical,
    /// Angle and height.
    Cylindrical,
    /// Around a torus of major radius 1.
    Torus,
}

/// How neighbouring pixels mix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Nearest.
    None,
    /// POV-Ray's 2.
    Bilinear,
    /// POV-Ray's 3.
    Bicubic,
    /// POV-Ray's 4.
    NormalizedDistance,
}

/// An image with its mapping.
#[derive(Clone, Debug)]
pub struct ImageMap {
    /// The pixels.
    pub image: Arc<Image>,
    /// Projection.
    pub map_type: MapType,
    /// Mixing.
    pub interpolation: Interpolation,
    /// Nothing outside the unit square.
    pub once: bool,
    /// Repeats of the picture along u and v in one unit.
    pub repeat: (f64, f64),
    /// Shift in pictures.
    pub offset: (f64, f64),
    /// bump_map and material_map: the palette index is the value.
    pub use_index: bool,
    /// image_pattern: alpha is the value.
    pub use_alpha: bool,
    /// Added to every pixel's filter (images without a palette).
    pub filter_all: f32,
    /// Added to every pixel's transmit (images without a palette).
    pub transmit_all: f32,
    /// Interpolate with colour times alpha.
    pub premultiplied: bool,
}
