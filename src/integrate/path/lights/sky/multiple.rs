//! A clear sky whose light is scattered many times: air, dust and ozone at four wavelengths, what is scattered more than once and what the
//! ground sends back by a fit.
//!
//! Source: García Liñán 2022 (master's thesis; its shader and `skytracer` are published under the MIT licence), over the data of Bucholtz 1995 (air),
//! Guimera et al. 2018 (heights and cross sections of a city's dust), Gorshelev et al. 2014 and Dütsch 1973 (ozone). Sizes of the steps and tables
//! are Cycles' (measured in bpy 5.0: `tests/measured/cycles_sky.txt`), since they are coarse enough to be seen: even steps across 100 km see 16 %
//! less of the dust than there is.

use super::{Model, Placement, fraction};
use crate::math::{DVec3, Rgb, Vec3};
use crate::scene::environment::Sky;
use std::f64::consts::{PI, TAU};

/// Radius of the earth, and height of its air, kilometres.
const EARTH: f64 = 6371.0;
const THICKNESS: f64 = 100.0;
/// Even steps along a ray, for light on its way to the eye and from the sun.
const STEPS: usize = 64;

/// A value for each of 630, 560, 490 and 430 nm.
type Waves = [f64; 4];

/// Scattering of air at the sea, 1/km.
const AIR: Waves = [6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2];
/// Absorption of ozone, m² a molecule.
const OZONE: Waves = [3.472e-25, 3.914e-25, 1.349e-25, 1.103e-26];
/// Molecules over a square metre of a Dobson unit, and the units of the year's mean.
const DOBSON: f64 = 2.6867e20;
const OZONE_UNITS: f64 = 334.0;
/// Dust of a city: cross sections, how many at the sea and far above, the height over which they become fewer by e, the mean cosine.
const DUST_ABSORPTION: Waves = [2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23];
const DUST_SCATTERING: Waves = [1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22];
const DUST: f64 = 1.3681e20;
const DUST_FAR: f64 = 2e6;
const DUST_SCALE: f64 = 0.73;
const DUST_FORWARD: f64 = 0.8;
/// Sunlight outside the air, W/m²/nm.
const SUNLIGHT: Waves = [1.679, 1.828, 1.986, 1.307];
/// Albedo of the ground.
const GROUND: f64 = 0.3;
/// Light that was scattered more than once, of that from the sun.
const MORE: Waves = [0.02 * 0.217, 0.02 * 0.347, 0.02 * 0.594, 0.02];

/// Linear Rec.709 of the spectrum whose values at the four wavelengths are these, fitted to skies.
fn color(v: &Waves) -> Rgb {
    const OF: [[f64; 3]; 4] = [
        [137.672_389_24, -8.632_904_716, -1.718_156_739],
        [32.549_094_029, 91.298_014_172, -12.005_406_445],
        [-38.914_283_926, 34.316_654_715, 29.890_448_072],
        [8.572_844_238, -11.103_384_66, 117.475_852_776],
    ];
    let channel = |c: usize| v.iter().zip(OF).map(|(v, of)| v * of[c]).sum::<f64>() as f32;
    Vec3::new(channel(0), channel(1), channel(2))
}

/// The air with its densities.
pub(super) struct Air {
    /// Of molecules, dust, ozone.
    scale: DVec3,
    eye: DVec3,
    to_sun: Transmittance,
}

/// What a point of the air does to light: scattering by molecules and by dust, extinction; 1/km.
struct Matter {
    air: Waves,
    dust: Waves,
    extinction: Waves,
}

impl Air {
    pub(super) fn new(sky: &Sky) -> Self {
        let scale = DVec3::new(sky.air_density.into(), sky.dust_density.into(), sky.ozone_density.into());
        let altitude = (f64::from(sky.altitude_m) * 1e-3).clamp(1e-3, THICKNESS - 1e-3);
        // Cycles has it in 32 bits, half a metre apart.
        let eye = DVec3::new(0.0, 0.0, f64::from((EARTH + altitude) as f32));
        Self { scale, eye, to_sun: Transmittance::new(scale) }
    }
}

fn matter(scale: DVec3, height: f64) -> Matter {
    let h = height.max(0.0);
    let molecules = (-0.077_719_71 * h.powf(1.163_642_43)).exp() * scale.x;
    let dust = (DUST * (-h / DUST_SCALE).exp() + DUST_FAR) * scale.y;
    // Fitted to Dütsch's layers: ozone is densest at 23 km.
    let up = h + 1e-4;
    let t = up.ln() - 3.222_61;
    let ozone = 1.408_97 * DOBSON * OZONE_UNITS / up * (-t * t / 0.18).exp() * scale.z;
    let air = AIR.map(|v| v * molecules);
    Matter {
        air,
        dust: DUST_SCATTERING.map(|v| v * dust),
        extinction: std::array::from_fn(|k| air[k] + (DUST_SCATTERING[k] + DUST_ABSORPTION[k]) * dust + OZONE[k] * ozone),
    }
}

/// What the air leaves of light that comes from outside against `dir`. The earth does not stand in the way, but the air is as thick below the ground
/// as at it.
fn transmitted(scale: DVec3, from: DVec3, dir: DVec3) -> Waves {
    let step = length_of_air(from, dir) / STEPS as f64;
    let mut depth = [0.0; 4];
    for i in 0..STEPS {
        let m = matter(scale, (from + dir * (step * (i as f64 + 0.5))).length() - EARTH);
        for (d, e) in depth.iter_mut().zip(m.extinction) {
            *d += e * step;
        }
    }
    depth.map(|d| (-d).exp())
}

/// How much of the sun's light reaches a height: a table of cosines to the zenith by heights, both even.
struct Transmittance {
    table: Vec<Waves>,
}

impl Transmittance {
    const COSINES: usize = 256;
    const HEIGHTS: usize = 64;

    fn new(scale: DVec3) -> Self {
        use rayon::prelude::*;
        let at = |k: usize| {
            let (row, column) = (k / Self::COSINES, k % Self::COSINES);
            let r = EARTH + THICKNESS * row as f64 / (Self::HEIGHTS - 1) as f64;
            let mu = 2.0 * column as f64 / (Self::COSINES - 1) as f64 - 1.0;
            transmitted(scale, DVec3::new(0.0, 0.0, r), DVec3::new((1.0 - mu * mu).sqrt(), 0.0, mu))
        };
        Self { table: (0..Self::COSINES * Self::HEIGHTS).into_par_iter().map(at).collect() }
    }

    /// At `height` kilometres, along a ray of cosine `mu` to the zenith.
    fn at(&self, height: f64, mu: f64) -> Waves {
        let (i, fx) = fraction((0.5 + 0.5 * mu) * (Self::COSINES - 1) as f64, Self::COSINES);
        let (j, fy) = fraction(height / THICKNESS * (Self::HEIGHTS - 1) as f64, Self::HEIGHTS);
        let [low, high] = [j, j + 1].map(|j| (&self.table[j * Self::COSINES + i], &self.table[j * Self::COSINES + i + 1]));
        let mix = |a: f64, b: f64, f: f64| a + (b - a) * f;
        std::array::from_fn(|k| mix(mix(low.0[k], low.1[k], fx), mix(high.0[k], high.1[k], fx), fy))
    }
}

impl Model for Air {
    fn placement(&self) -> Placement {
        Placement { step: [0.5; 2], stretch: 1.0, below: true }
    }

    fn scattered(&self, dir: DVec3, sun: DVec3) -> Rgb {
        let length = length_to_ground(self.eye, dir).unwrap_or_else(|| length_of_air(self.eye, dir));
        let step = length / STEPS as f64;
        let cos = dir.dot(sun);
        let phase_air = 3.0 / (16.0 * PI) * (1.0 + cos * cos);
        let g = DUST_FORWARD;
        let phase_dust = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5));
        let to_zenith = self.to_sun.at(0.0, 1.0);
        let (mut sum, mut left) = ([0.0; 4], [1.0; 4]);
        for i in 0..STEPS {
            let p = self.eye + dir * (step * (i as f64 + 0.5));
            let r = p.length();
            let (height, mu) = (r - EARTH, p.dot(sun) / r);
            let m = matter(self.scale, height);
            let (from_sun, on_ground, above) = (self.to_sun.at(height, mu), self.to_sun.at(0.0, mu), self.to_sun.at(height, 1.0));
            let ground_seen = TAU * (1.0 - (r * r - EARTH * EARTH).max(0.0).sqrt() / r);
            let from_ground = ground_seen * GROUND * mu / (4.0 * PI * PI);
            let day = 1.0 / (1.0 + 5.0 * (-17.92 * mu).exp());
            for k in 0..4 {
                let more = MORE[k] * day + from_ground * on_ground[k] * if above[k] > 0.0 { to_zenith[k] / above[k] } else { 0.0 };
                let source = from_sun[k] * (phase_air * m.air[k] + phase_dust * m.dust[k]) + more * (m.air[k] + m.dust[k]);
                let through = (-m.extinction[k] * step).exp();
                let way = if m.extinction[k] > 0.0 { (1.0 - through) / m.extinction[k] } else { step };
                sum[k] += left[k] * source * way;
                left[k] *= through;
            }
        }
        color(&std::array::from_fn(|k| sum[k] * SUNLIGHT[k]))
    }

    fn direct(&self, elevation: f64) -> Rgb {
        // Not by the table: measured.
        let left = transmitted(self.scale, self.eye, DVec3::new(elevation.cos(), 0.0, elevation.sin()));
        color(&std::array::from_fn(|k| left[k] * SUNLIGHT[k]))
    }
}

/// Length within the air of a ray that starts in it.
fn length_of_air(from: DVec3, dir: DVec3) -> f64 {
    let b = -from.dot(dir);
    let r = EARTH + THICKNESS;
    b + (b * b - from.length_squared() + r * r).max(0.0).sqrt()
}

/// Length to the ground, if the ray meets it.
fn length_to_ground(from: DVec3, dir: DVec3) -> Option<f64> {
    let b = -from.dot(dir);
    let d = b * b - from.length_squared() + EARTH * EARTH;
    (b >= 0.0 && d >= 0.0).then(|| (b - d.sqrt()).max(0.0))
}
