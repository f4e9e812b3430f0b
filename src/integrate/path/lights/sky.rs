//! A clear sky: sunlight scattered once by air, dust and ozone above a round earth, and the sun's disc.
//!
//! Directions are in the sky's own space, +z up. Radiance is in the units of Blender's Sky Texture: W/m²/sr by the CIE's weights, not
//! normalised. Source: Nishita, Sirai, Tadamura and Nakamae 1993; sizes and densities as Blender's manual and measurement give them
//! (docs/path.md); ozone by Gorshelev et al. 2014; the sun is a black body of 5,778 K.

use crate::kernel::bsdf::thin_film::rec709;
use crate::math::{DVec3, Rgb, Vec3};
use crate::scene::environment::Sky;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

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

/// Size of the table of the sky: turns from the sun, heights (denser near the horizon). Cycles' own, since between entries and beside them
/// it goes wrong by up to 4 %: see `column_turn` and `row_height`.
pub const COLUMNS: usize = 256;
/// Heights of the table.
pub const ROWS: usize = 128;

/// Turn from the sun that a column is worked out for. It is shown half a column nearer: column `c` stands at `c + 0.5`. Source: Cycles
/// (measured; so are the rows).
fn column_turn(c: usize) -> f64 {
    (c + 1) as f64 * PI / COLUMNS as f64
}

/// Height that a row is worked out for. It stands at `(row + 0.5) / ROWS` of the square root of a quarter turn.
fn row_height(row: usize) -> f64 {
    (row as f64 / ROWS as f64).powi(2) * FRAC_PI_2 * (1.0 + 1.0 / 256.0)
}

/// A sky made ready.
pub struct ReadySky {
    sky: Sky,
    /// Direction to the sun.
    pub sun: DVec3,
    /// `ROWS` x `COLUMNS` over half a turn from the sun and the heights 0..90°, squared.
    pub table: Vec<Rgb>,
    disc: Rgb,
}

impl ReadySky {
    /// Of parameters.
    pub fn new(sky: &Sky) -> Self {
        use rayon::prelude::*;
        let elevation = f64::from(sky.sun_elevation_rad);
        let rotation = f64::from(sky.sun_rotation_rad);
        let flat = |elevation: f64, turn: f64| {
            let (se, ce) = elevation.sin_cos();
            DVec3::new(ce * turn.cos(), ce * turn.sin(), se)
        };
        let sun_in_table = flat(elevation, 0.0);
        let air = Air::new(sky);
        let table = (0..ROWS * COLUMNS)
            .into_par_iter()
            .map(|k| color(&air.scattered(flat(row_height(k / COLUMNS), column_turn(k % COLUMNS)), sun_in_table)))
            .collect();
        // Measured of Cycles: the sun stands at (sin, cos) of its rotation, like a compass.
        let (se, ce) = elevation.sin_cos();
        let sun = DVec3::new(ce * rotation.sin(), ce * rotation.cos(), se);
        let half = 0.5 * f64::from(sky.sun_size_rad);
        let solid = TAU * (1.0 - half.cos());
        let direct = air.direct(sun_in_table);
        let disc = color(&direct) * (f64::from(sky.sun_intensity) / solid) as f32;
        Self { sky: sky.clone(), sun, table, disc }
    }

    /// Radiance without the disc; the ground fades out below the horizon.
    pub fn radiance(&self, dir: DVec3) -> Rgb {
        let fade = if dir.z >= 0.0 {
            1.0
        } else if dir.z < -0.4 {
            return Vec3::ZERO;
        } else {
            (1.0 + 2.5 * dir.z).powi(3)
        };
        let up = dir.z.clamp(0.0, 1.0).asin();
        let around = dir.x.hypot(dir.y);
        let flat_sun = self.sun.x.hypot(self.sun.y);
        let cos = if around > 0.0 && flat_sun > 0.0 { (dir.x * self.sun.x + dir.y * self.sun.y) / (around * flat_sun) } else { 1.0 };
        let x = (cos.clamp(-1.0, 1.0).acos() / PI * COLUMNS as f64 - 0.5).clamp(0.0, (COLUMNS - 1) as f64);
        let y = ((up / FRAC_PI_2).sqrt() * ROWS as f64 - 0.5).clamp(0.0, (ROWS - 1) as f64);
        let (i, j) = ((x as usize).min(COLUMNS - 2), (y as usize).min(ROWS - 2));
        let (fx, fy) = ((x - i as f64) as f32, (y - j as f64) as f32);
        let at = |r: usize, c: usize| self.table[r * COLUMNS + c];
        let c = at(j, i).lerp(at(j, i + 1), fx).lerp(at(j + 1, i).lerp(at(j + 1, i + 1), fx), fy);
        (c * fade as f32).max(Vec3::ZERO)
    }

    /// Direction to the sun, half angle, radiance at the middle of the disc.
    pub fn disc(&self) -> Option<(DVec3, f64, Rgb)> {
        let half = 0.5 * f64::from(self.sky.sun_size_rad);
        (self.sky.sun_disc && half > 0.0 && self.disc.max_element() > 0.0).then_some((self.sun, half, self.disc.max(Vec3::ZERO)))
    }
}

/// The air with its densities.
struct Air {
    /// Of molecules, dust, ozone.
    scale: DVec3,
    eye: DVec3,
}

impl Air {
    fn new(sky: &Sky) -> Self {
        let scale = DVec3::new(sky.air_density.into(), sky.dust_density.into(), sky.ozone_density.into());
        let altitude = f64::from(sky.altitude_m).clamp(1.0, 59_999.0);
        Self { scale, eye: DVec3::new(0.0, 0.0, EARTH + altitude) }
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

    /// Light scattered towards the eye along `dir`.
    fn scattered(&self, dir: DVec3, sun: DVec3) -> [f64; N] {
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
        spectrum
    }

    /// Sunlight that reaches the eye.
    fn direct(&self, sun: DVec3) -> [f64; N] {
        if meets_earth(self.eye, sun) {
            return [0.0; N];
        }
        // Blender's disc goes without ozone (measured: with it the sun lacks 6 % of red).
        let depth = self.depth(self.eye, sun) * DVec3::new(1.0, 1.0, 0.0);
        std::array::from_fn(|k| sunlight(k) * Self::left(depth, k))
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
    fn sun_is_bright_white_above_and_red_at_the_horizon() {
        let high = ReadySky::new(&Sky { sun_elevation_rad: 1.2, ..Sky::default() });
        let low = ReadySky::new(&Sky { sun_elevation_rad: 0.02, ..Sky::default() });
        let (_, _, noon) = high.disc().expect("a disc");
        let (_, _, dusk) = low.disc().expect("a disc");
        assert!(noon.x / noon.z < 1.6 && dusk.x / dusk.z > 5.0, "{noon} {dusk}");
        assert_eq!(high.radiance(DVec3::NEG_Z), Vec3::ZERO);
    }

    #[test]
    fn the_sky_is_as_bright_as_cycles_measures_it() {
        let mut wrong = Vec::new();
        let mut made: Option<(Sky, ReadySky)> = None;
        for line in include_str!("../../../../tests/measured/cycles_sky.txt").lines().filter(|l| l.starts_with("sky")) {
            let v: Vec<f32> = line.split(' ').skip(1).map(|w| w.parse().expect("a number")).collect();
            let sky = Sky {
                sun_disc: false,
                sun_elevation_rad: v[0].to_radians(),
                sun_rotation_rad: v[1].to_radians(),
                air_density: v[2],
                dust_density: v[3],
                ozone_density: v[4],
                altitude_m: v[5],
                ..Sky::default()
            };
            if made.as_ref().is_none_or(|m| m.0 != sky) {
                made = Some((sky.clone(), ReadySky::new(&sky)));
            }
            let Some((_, ready)) = &made else { continue };
            let (e, a) = (v[6].to_radians(), v[7].to_radians());
            let got = ready.radiance(Vec3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin()).as_dvec3());
            let want = Vec3::new(v[8], v[9], v[10]);
            let limit = if v[4] > 1.0 { 5e-3 } else { 2e-3 };
            let off = ((got - want) / want.max_element()).abs().max_element();
            if off > limit {
                wrong.push(format!("{line}: {got}, off by {off:.4}"));
            }
        }
        assert!(wrong.is_empty(), "{} differ\n{}", wrong.len(), wrong.join("\n"));
    }

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

    #[test]
    fn the_sun_shines_as_cycles_measures_it() {
        // Source: Cycles 4.5.15, a white plane that faces the sun, lit by the disc alone: elevation, irradiance.
        for (degrees, want) in [
            (10.0f32, [105.30, 69.58, 30.22]),
            (25.0, [136.17, 106.16, 71.82]),
            (60.0, [149.62, 123.98, 98.73]),
            (90.0, [152.64, 127.48, 103.66]),
        ] {
            let sky = ReadySky::new(&Sky { sun_elevation_rad: degrees.to_radians(), ..Sky::default() });
            let (_, half, radiance) = sky.disc().expect("a disc");
            // 1 - 0.6 (1 - sqrt(1 - r²)) is 0.8 on the mean over a disc.
            let got = radiance * (0.8 * TAU * (1.0 - half.cos())) as f32;
            let want = Vec3::from_array(want);
            assert!(((got - want) / want).abs().max_element() < 1e-2, "{degrees}: {got}, not {want}");
        }
    }
}
