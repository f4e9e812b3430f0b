//! Diffuse reflection: Lambert, and rough surfaces after Oren and Nayar. Values include the cosine of the light.
//! Source: Fujii 2012 (qualitative form); Portsmouth, Kutz and Hill 2025 (energy of many bounces, as OpenPBR and Cycles have it).

use crate::math::{Rgb, Vec3};
use std::f32::consts::PI;

/// A rough diffuse surface made ready for a colour and a viewer.
#[derive(Clone, Copy, Debug)]
pub struct OrenNayar {
    /// Weight of the single bounce.
    a: f32,
    roughness: f32,
    /// Colour of many bounces times (1 - E(v)) / (1 - mean E), in units of the surface's colour.
    multi: Rgb,
}

/// Single-bounce albedo at a cosine, without A.
fn single_albedo(cos: f32, roughness: f32, a: f32) -> f32 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let theta = cos.clamp(-1.0, 1.0).acos();
    let tan_term = if cos > 1e-4 { sin / cos * (1.0 - sin * sin * sin) } else { 0.0 };
    let g = sin * (theta - sin * cos) + 2.0 / 3.0 * (tan_term - sin);
    a * (1.0 + roughness * (g / PI))
}

impl OrenNayar {
    /// `cos_v` is the viewer's cosine with the normal, `color` the albedo.
    pub fn new(roughness: f32, color: Rgb, cos_v: f32) -> Self {
        let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
        let mean = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * roughness);
        let color = color.clamp(Vec3::ZERO, Vec3::ONE);
        let e = single_albedo(cos_v, roughness, a);
        // The colour once more than the energy asks for, as Cycles has it (measured); white stays white.
        let multi = color * color * mean / (Vec3::ONE - color * (1.0 - mean)) * ((1.0 - e).max(0.0) / (1.0 - mean).max(1e-7));
        Self { a, roughness, multi }
    }

    /// Share of light in units of colour / π, cosine included; `v` and `l` in the frame of the surface.
    pub fn eval(&self, v: Vec3, l: Vec3) -> Rgb {
        let s = l.dot(v) - l.z * v.z;
        let t = if s > 0.0 { s / l.z.max(v.z).max(1e-6) } else { s };
        let single = self.a * (1.0 + self.roughness * t);
        let many = self.multi * (1.0 - single_albedo(l.z, self.roughness, self.a)).max(0.0);
        (Vec3::splat(single.max(0.0)) + many) * (l.z / PI)
    }
}
