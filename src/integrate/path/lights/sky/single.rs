//! A clear sky whose light is scattered once: sunlight in air, dust and ozone above a round earth.
//!
//! Source: Nishita, Sirai, Tadamura and Nakamae 1993; sizes and densities as Blender's manual and measurement give them (docs/path.md); ozone
//! by Gorshelev et al. 2014; the sun is a black body of 5,778 K.

use super::{Model, Placement, fade};
use crate::kernel::bsdf::thin_film::rec709;
use crate::math::{DVec3, Rgb, Vec3};
use crate::scene::environment::{Sky, SkyModel};
use std::f64::consts::PI;

/// Radius of the earth and of its air, metres.
const EARTH: f64 = 6_360_000.0;
const AIR: f64 = 6_420_000.0;
/// Even steps along a ray, as many as Cycles has (measured: they are too few for dust near the horizon, alike).
const STEPS: usize = 32;
/// Points and weights times e^x of the ways to the sun, whose length is [`SUN_LENGTH`]: Gauss and Laguerre's for what falls off evenly. Air and
/// dust do; ozone does not, and comes out 2.4 % low under a high sun and 4 to 14 % high under one of 1 degree. Source: Abramowitz and Stegun, table
/// 25.9; that Cycles has 8 of them over 25, by what its ozone is off at 9 heights of the sun: of 3 to 16 points over 2 to 80 these fit
/// best, and with them skies of ten times as much of each agree within 0.1 %.
const SUN_POINTS: [[f64; 2]; 8] = [
    [0.170_279_632_305, 0.437_723_410_493],
    [0.903_701_776_799, 1.033_869_347_666],
    [2.251_086_629_866, 1.669_709_765_659],
    [4.266_700_170_288, 2.376_924_701_759],
    [7.045_905_402_393, 3.208_540_913_348],
    [10.758_516_010_181, 4.268_575_510_825],
    [15.740_678_641_278, 5.818_083_368_672],
    [22.863_131_736_889, 8.906_226_215_292],
];
const SUN_LENGTH: f64 = 25.0;
/// Wavelengths: 380 to 780 nm in steps of 20.
const N: usize = 21;
/// Heights over which air and dust become thinner by e.
const AIR_SCALE: f64 = 8000.0;
const DUST_SCALE: f64 = 1200.0;
/// Scattering of dust per metre at the sea, and its mean cosine.
const DUST: f64 = 2e-5;
const DUST_FORWARD: f64 = 0.76;
/// Extinction of dust over its scattering.
const DUST_EXTINCTION: f64 = 1.11;

/// Absorption of ozone per metre where it is densest, at the wavelengths above.
const OZONE: [f64; N] = [
    3.25e-9, 5.85e-9, 1.98e-8, 7.31e-8, 2.01e-7, 4.04e-7, 6.36e-7, 9.67e-7, 1.548e-6, 2.09e-6, 2.461e-6, 2.736e-6, 2.151e-6, 1.591e-6,
    1.124e-6, 7.35e-7, 4.65e-7, 3.31e-7, 2.25e-7, 1.49e-7, 1.68e-7,
];

fn wavelength(k: usize) -> f64 {
    380.0 + 20.0 * k as f64
}

/// Scattering of air per metre at the sea.
fn air(k: usize) -> f64 {
    let um = wavelength(k) * 1e-3;
    1.1312e-6 / (um * um * um * um)
}

/// Sunlight outside the air, W/m²/nm.
fn sunlight(k: usize) -> f64 {
    let m = wavelength(k) * 1e-9;
    let radiance = 2.0 * 6.626_07e-34 * 2.997_924_58e8f64.powi(2)
        / m.powi(5)
        / ((6.626_07e-34 * 2.997_924_58e8 / (m * 1.380_649e-23 * 5778.0)).exp_m1());
    // Solid angle of the sun.
    radiance * 1e-9 * 6.794e-5
}

/// CIE 1931 colour matching at the wavelengths above. Source: CIE 15:2004, table T.4.
const MATCHING: [[f32; 3]; N] = [
    [0.0014, 0.0, 0.0065],
    [0.0143, 0.0004, 0.0679],
    [0.1344, 0.004, 0.6456],
    [0.3483, 0.023, 1.7471],
    [0.2908, 0.06, 1.6692],
    [0.0956, 0.139, 0.813],
    [0.0049, 0.323, 0.272],
    [0.0633, 0.71, 0.0782],
    [0.2904, 0.954, 0.0203],
    [0.5945, 0.995, 0.0039],
    [0.9163, 0.87, 0.0017],
    [1.0622, 0.631, 0.0008],
    [0.8544, 0.381, 0.0002],
    [0.4479, 0.175, 0.0],
    [0.1649, 0.061, 0.0],
    [0.0468, 0.017, 0.0],
    [0.0114, 0.0041, 0.0],
    [0.0029, 0.001, 0.0],
    [0.0007, 0.0002, 0.0],
    [0.0002, 0.0001, 0.0],
    [0.0, 0.0, 0.0],
];

/// Linear Rec.709 of a spectrum.
fn color(spectrum: &[f64; N]) -> Rgb {
    let sum = spectrum.iter().zip(MATCHING).fold(Vec3::ZERO, |s, (v, m)| s + Vec3::from_array(m) * *v as f32);
    rec709(sum * 20.0)
}

/// The air with its densities.
pub(super) struct Air {
    /// Of molecules, dust, ozone.
    scale: DVec3,
    eye: DVec3,
    placement: Placement,
}

impl Air {
    pub(super) fn new(sky: &Sky) -> Self {
        let scale = DVec3::new(sky.air_density.into(), sky.dust_density.into(), sky.ozone_density.into());
        let altitude = f64::from(sky.altitude_m).clamp(1.0, 59_999.0);
        // Half a step beside, each way; Blender 4's heights are stretched too.
        let whole = sky.model == SkyModel::Single;
        let stretch = if whole { 1.0 } else { 1.0 + 1.0 / 256.0 };
        Self { scale, eye: DVec3::new(0.0, 0.0, EARTH + altitude), placement: Placement { step: [1.0, 0.0], stretch, below: whole } }
    }

    /// Densities at a height over the sea.
    fn densities(&self, height: f64) -> DVec3 {
        // Ozone begins at 10 km, is densest at 25 and ends at 40.
        let [low, middle, high] = [10_000.0, 25_000.0, 40_000.0];
        let ozone = ((height - low) / (middle - low)).min((high - height) / (high - middle)).max(0.0);
        DVec3::new((-height / AIR_SCALE).exp(), (-height / DUST_SCALE).exp(), ozone) * self.scale
    }

    /// Sums of densities on the way out of the air.
    fn depth(&self, from: DVec3, dir: DVec3) -> DVec3 {
        let unit = length_to_sphere(from, dir, AIR) / SUN_LENGTH;
        SUN_POINTS
            .iter()
            .fold(DVec3::ZERO, |sum, [x, weight]| sum + self.densities((from + dir * (unit * x)).length() - EARTH) * (unit * weight))
    }

    fn left(depth: DVec3, k: usize) -> f64 {
        (-(depth.x * air(k) + depth.y * DUST_EXTINCTION * DUST + depth.z * OZONE[k])).exp()
    }
}

impl Model for Air {
    fn placement(&self) -> Placement {
        self.placement
    }

    fn scattered(&self, dir: DVec3, sun: DVec3) -> Rgb {
        if dir.z < 0.0 {
            let flat = DVec3::new(dir.x, dir.y, 0.0).try_normalize().unwrap_or(DVec3::X);
            let left = fade(dir.z) as f32;
            return if left > 0.0 { self.scattered(flat, sun) * left } else { Vec3::ZERO };
        }
        let step = length_to_sphere(self.eye, dir, AIR) / STEPS as f64;
        let mu = dir.dot(sun);
        let phase_air = 3.0 / (16.0 * PI) * (1.0 + mu * mu);
        let g = DUST_FORWARD;
        let phase_dust = 3.0 * (1.0 - g * g) * (1.0 + mu * mu) / (8.0 * PI * (2.0 + g * g) * (1.0 + g * g - 2.0 * g * mu).powf(1.5));
        let mut spectrum = [0.0; N];
        let mut depth = DVec3::ZERO;
        for i in 0..STEPS {
            let p = self.eye + dir * (step * (i as f64 + 0.5));
            let density = self.densities(p.length() - EARTH);
            depth += density * step;
            if meets_earth(p, sun) {
                continue;
            }
            let whole = depth + self.depth(p, sun);
            for (k, s) in spectrum.iter_mut().enumerate() {
                let scattering = phase_air * density.x * air(k) + phase_dust * density.y * DUST;
                *s += Self::left(whole, k) * scattering * sunlight(k) * step;
            }
        }
        color(&spectrum)
    }

    fn direct(&self, elevation: f64) -> Rgb {
        let sun = DVec3::new(elevation.cos(), 0.0, elevation.sin());
        if meets_earth(self.eye, sun) {
            return Vec3::ZERO;
        }
        // Blender's disc goes without ozone (measured: with it the sun lacks 6 % of red).
        let depth = self.depth(self.eye, sun) * DVec3::new(1.0, 1.0, 0.0);
        color(&std::array::from_fn(|k| sunlight(k) * Self::left(depth, k)))
    }
}

/// Length of a ray within a sphere about the earth's middle that it starts in.
fn length_to_sphere(from: DVec3, dir: DVec3, radius: f64) -> f64 {
    let b = -from.dot(dir);
    b + (b * b - from.length_squared() + radius * radius).max(0.0).sqrt()
}

fn meets_earth(from: DVec3, dir: DVec3) -> bool {
    if dir.z >= 0.0 && from.x == 0.0 && from.y == 0.0 {
        return false;
    }
    let b = -from.dot(dir);
    b >= 0.0 && b * b - from.length_squared() + EARTH * EARTH >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_are_those_of_many_small_steps() {
        let air = Air::new(&Sky::default());
        for height in [1.0, 2000.0, 8000.0] {
            for degrees in [1.0f64, 3.0, 30.0, 90.0] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let (from, dir) = (DVec3::new(0.0, 0.0, EARTH + height), DVec3::new(cos, 0.0, sin));
                if meets_earth(from + DVec3::X, dir) {
                    continue;
                }
                let length = length_to_sphere(from, dir, AIR);
                let n = 40_000;
                let want = (0..n).fold(DVec3::ZERO, |s, k| {
                    let u = (f64::from(k) + 0.5) / f64::from(n);
                    s + air.densities((from + dir * (length * u * u)).length() - EARTH) * (2.0 * u * length / f64::from(n))
                });
                let off = (air.depth(from, dir) - want).abs();
                let limit = DVec3::new(4e-3, 1e-3, 0.15) * want + 1.0;
                assert!(off.cmple(limit).all(), "{height} {degrees}: {} {want}", air.depth(from, dir));
            }
        }
    }
}
