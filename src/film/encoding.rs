//! Working-space values → file values. Source: tests/measured/film.txt, every value of POV-Ray's own files.

use super::Film;
use super::dither::{Dither, DitherMethod};
use crate::math::Vec3;
use crate::math::color::grey;
use crate::scene::settings::WorkingGamma;
use rayon::prelude::*;

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
    /// What the file's values are to be. Formats of linear light (EXR, HDR) and scenes without a working gamma pass it over.
    pub file_gamma: FileGamma,
    /// Write an alpha channel where the format has one.
    pub alpha: bool,
    /// Spread rounding errors.
    pub dither: Option<DitherMethod>,
}

impl Default for Encoding {
    fn default() -> Self {
        Self { working: WorkingGamma::Linear, file_gamma: FileGamma::Srgb, alpha: false, dither: None }
    }
}

/// Channels of a file of whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Channels {
    /// One grey channel in place of three.
    pub grey: bool,
    /// Alpha follows the colours, which are then not multiplied by it.
    pub alpha: bool,
}

impl Channels {
    /// Values in a pixel.
    pub fn count(self) -> usize {
        (if self.grey { 1 } else { 3 }) + usize::from(self.alpha)
    }
}

/// `v` to a power, rounded to 32 bits once, as POV-Ray's values are; the exponent has 32 bits too.
fn power(v: f32, exponent: f32) -> f32 {
    f64::from(v.max(0.0)).powf(exponent.into()) as f32
}

/// Light → sRGB value, the exact piecewise curve of IEC 61966-2-1, with POV-Ray's rounding (measured on 9,216 values of 16 bits).
pub fn srgb_from_linear(v: f32) -> f32 {
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * power(v, 1.0 / 2.4) - 0.055 }
}

/// sRGB value → light.
pub fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { power((v + 0.055) / 1.055, 2.4) }
}

impl Encoding {
    /// The light of a working-space value. Colours without a working gamma are taken for sRGB, as the files say that hold them.
    pub fn linear(&self, v: f32) -> f32 {
        match self.working {
            WorkingGamma::Linear => v,
            WorkingGamma::Power(g) => power(v, g as f32),
            WorkingGamma::Srgb | WorkingGamma::None => linear_from_srgb(v),
        }
    }

    /// Whether the file's values are those of the working space.
    fn is_identity(&self) -> bool {
        match (self.working, self.file_gamma) {
            (WorkingGamma::None, _) | (WorkingGamma::Srgb, FileGamma::Srgb) => true,
            (WorkingGamma::Linear, FileGamma::Power(b)) => b == 1.0,
            (WorkingGamma::Power(a), FileGamma::Power(b)) => a == b,
            _ => false,
        }
    }

    /// The file's value for a working-space value, not clipped.
    pub fn encode(&self, v: f32) -> f32 {
        if self.is_identity() {
            return v;
        }
        match self.file_gamma {
            FileGamma::Srgb => srgb_from_linear(self.linear(v)),
            FileGamma::Power(1.0) => self.linear(v),
            FileGamma::Power(g) => power(self.linear(v), 1.0 / g as f32),
        }
    }

    /// What the file says that its values are.
    pub(super) fn written_gamma(&self) -> FileGamma {
        if self.working == WorkingGamma::None { FileGamma::Srgb } else { self.file_gamma }
    }

    /// The working-space value of a file's value in 0..=1: what [`Self::encode`] undoes.
    fn decode(&self, v: f32) -> f32 {
        if self.is_identity() {
            return v;
        }
        let light = match self.file_gamma {
            FileGamma::Srgb => linear_from_srgb(v),
            FileGamma::Power(g) => power(v, g as f32),
        };
        match self.working {
            WorkingGamma::Power(g) => power(light, 1.0 / g as f32),
            WorkingGamma::Srgb => srgb_from_linear(light),
            WorkingGamma::Linear | WorkingGamma::None => light,
        }
    }

    /// The channels of a pixel, alpha last, in the working space.
    ///
    /// With alpha the colours are divided by it. A pixel brighter than its alpha allows (a highlight on glass) is made more opaque:
    /// alpha is at least the grey of the colour.
    fn pixel(&self, pixel: [f32; 4], channels: Channels) -> [f32; 4] {
        let mut rgb = Vec3::new(pixel[0], pixel[1], pixel[2]);
        let mut alpha = (1.0 - pixel[3]).clamp(0.0, 1.0);
        if channels.alpha {
            alpha = alpha.max(grey(rgb)).min(1.0);
            rgb = if alpha > 0.0 { rgb / alpha } else { Vec3::ZERO };
        }
        if channels.grey { [grey(rgb), alpha, 0.0, 0.0] } else { [rgb.x, rgb.y, rgb.z, alpha] }
    }

    /// The film as whole numbers 0..=`max`, `[height][width][channels]`. NaN becomes 0.
    pub(super) fn quantize(&self, film: &Film, channels: Channels, max: u16) -> Vec<u16> {
        let (n, width) = (channels.count(), film.width as usize);
        let mut out = vec![0; film.pixels.len() * n];
        let scale = f32::from(max);
        let is_alpha = |c: usize| channels.alpha && c + 1 == n;
        // The file's value before it is rounded down: `bias` is one half where nothing is dithered.
        let number = |v: f32, c: usize, bias: f32| {
            let v = if is_alpha(c) { v } else { self.encode(v) };
            (v * scale + bias).min(scale) as u16
        };
        if let Some(method) = self.dither {
            let back = |v: u16, c: usize| {
                let v = f32::from(v) / scale;
                if is_alpha(c) { v } else { self.decode(v) }
            };
            let mut dither = Dither::new(method, width, n);
            for (row, out) in film.pixels.chunks(width).zip(out.chunks_mut(width * n)) {
                for (x, (pixel, out)) in row.iter().zip(out.chunks_mut(n)).enumerate() {
                    dither.quantize(x, &self.pixel(*pixel, channels)[..n], out, &number, &back);
                }
                dither.next_row();
            }
            return out;
        }
        out.par_chunks_mut(width * n).zip(film.pixels.par_chunks(width)).for_each(|(out, row)| {
            for (out, pixel) in out.chunks_mut(n).zip(row) {
                for (c, (out, v)) in out.iter_mut().zip(self.pixel(*pixel, channels)).enumerate() {
                    *out = number(v, c, 0.5);
                }
            }
        });
        out
    }
}
