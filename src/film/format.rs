//! Kinds of picture files.

use std::path::Path;

/// Kind of picture file. Source for what POV-Ray writes into each: tests/film.rs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// PNG.
    Png {
        /// Bits a channel as POV-Ray's `+FN` takes them, 5..=16: up to 8 give an 8-bit file, more a 16-bit one.
        bits: u8,
        /// One grey channel of 16 bits.
        grayscale: bool,
    },
    /// OpenEXR, 32-bit float, linear light.
    Exr,
    /// Targa, 24 or 32 bits a pixel.
    Targa {
        /// Run-length compressed.
        rle: bool,
    },
    /// Binary PPM or PGM.
    Ppm {
        /// Bits a channel, 5..=16.
        bits: u8,
        /// PGM.
        grayscale: bool,
    },
    /// Windows bitmap, 24 bits a pixel.
    Bmp,
    /// JPEG.
    Jpeg {
        /// 1..=100.
        quality: u8,
    },
    /// Radiance RGBE, linear light.
    Hdr,
}

impl FileFormat {
    /// The extension that POV-Ray gives such a file, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png { .. } => "png",
            Self::Exr => "exr",
            Self::Targa { .. } => "tga",
            Self::Ppm { .. } => "ppm",
            Self::Bmp => "bmp",
            Self::Jpeg { .. } => "jpg",
            Self::Hdr => "hdr",
        }
    }

    /// The format with its defaults for a file name; `None` for an extension that nothing is written as.
    pub fn from_path(path: &Path) -> Option<Self> {
        Some(match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Self::Png { bits: 8, grayscale: false },
            "exr" => Self::Exr,
            "tga" => Self::Targa { rle: false },
            "ppm" => Self::Ppm { bits: 8, grayscale: false },
            "pgm" => Self::Ppm { bits: 8, grayscale: true },
            "bmp" => Self::Bmp,
            "jpg" | "jpeg" => Self::Jpeg { quality: 85 },
            "hdr" => Self::Hdr,
            _ => return None,
        })
    }

    /// The format's name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png { .. } => "PNG",
            Self::Exr => "OpenEXR",
            Self::Targa { .. } => "Targa",
            Self::Ppm { .. } => "PPM",
            Self::Bmp => "BMP",
            Self::Jpeg { .. } => "JPEG",
            Self::Hdr => "Radiance HDR",
        }
    }
}
