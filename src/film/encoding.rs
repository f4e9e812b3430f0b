//! Working-space values → file values.

use crate::scene::settings::WorkingGamma;

/// How a file's values relate to light (`File_Gamma`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FileGamma {
    /// The exact sRGB curve.
    Srgb,
    /// A power: value = light^(1/gamma).
    Power(f64),
}

/// How a film becomes the values of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    /// What the film's values are.
    pub working: WorkingGamma,
    /// What the file's values are to be.
    pub file_gamma: FileGamma,
    /// Write an alpha channel where the format has one.
    pub alpha: bool,
    /// Spread rounding errors to neighbouring pixels.
    pub dither: bool,
}

impl Default for Encoding {
    fn default() -> Self {
        Self { working: WorkingGamma::Linear, file_gamma: FileGamma::Srgb, alpha: false, dither: false }
    }
}

/// Light → sRGB value, the exact piecewise curve of IEC 61966-2-1.
pub fn srgb_from_linear(v: f64) -> f64 {
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB value → light.
pub fn linear_from_srgb(v: f64) -> f64 {
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

impl Encoding {
    /// The light of a working-space value.
    pub fn linear(&self, v: f64) -> f64 {
        match self.working {
            WorkingGamma::Linear | WorkingGamma::None => v,
            WorkingGamma::Power(g) => v.max(0.0).powf(g),
            WorkingGamma::Srgb => linear_from_srgb(v),
        }
    }

    /// The file's value for a working-space value, not clipped.
    pub fn encode(&self, v: f64) -> f64 {
        if self.working == WorkingGamma::None {
            return v;
        }
        let light = self.linear(v).max(0.0);
        match self.file_gamma {
            FileGamma::Srgb => srgb_from_linear(light),
            FileGamma::Power(g) => light.powf(1.0 / g),
        }
    }
}
