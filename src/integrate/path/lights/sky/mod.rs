//! Clear skies as tables of radiance, and their sun's disc; `single` and `multiple` say how light is scattered.
//!
//! Directions are in the sky's own space, +z up. Radiance is in the units of Blender's Sky Texture: W/m²/sr by the CIE's weights, not
//! normalised.

use crate::math::{DVec3, Rgb, Vec3};
use crate::scene::environment::{Sky, SkyModel};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

mod multiple;
mod single;
#[cfg(test)]
mod tests;

/// Size of the table of the sky: half turns from the sun, and heights (denser near the horizon) of half a sky. Cycles' own, since between entries it
/// goes wrong by up to 4 % (measured).
pub const COLUMNS: usize = 256;
/// Heights of half a sky.
pub const ROWS: usize = 128;

/// Air that scatters light.
trait Model {
    fn placement(&self) -> Placement;
    /// Radiance towards the eye along `dir`, both unit.
    fn scattered(&self, dir: DVec3, sun: DVec3) -> Rgb;
    /// Irradiance of the sun at the eye, face on, if it stood at `elevation`.
    fn direct(&self, elevation: f64) -> Rgb;
}

/// Which directions the entries of a model's table are worked out for; they stand in the middle of their steps. Source: Cycles (measured).
#[derive(Clone, Copy)]
struct Placement {
    /// Place in its step, columns and rows.
    step: [f64; 2],
    /// Of heights.
    stretch: f64,
    /// The table goes down to the nadir; else what is below the horizon is its row, faded out by [`fade`].
    below: bool,
}

impl Placement {
    fn turn(self, column: usize) -> f64 {
        (column as f64 + self.step[0]) * PI / COLUMNS as f64
    }

    fn height(self, row: usize) -> f64 {
        let of_half = if self.below { row as f64 - ROWS as f64 } else { row as f64 };
        let y = (of_half + self.step[1]) / ROWS as f64;
        y * y.abs() * FRAC_PI_2 * self.stretch
    }
}

/// A sky made ready.
pub struct ReadySky {
    /// Direction to the sun.
    pub sun: DVec3,
    /// Rows of `COLUMNS` over half a turn from the sun: `ROWS` of them over the heights 0..90°, squared, or as many again before those, from the
    /// nadir up.
    pub table: Vec<Rgb>,
    /// The table has both halves.
    pub below: bool,
    disc: Option<Disc>,
}

/// The sun's disc. Its radiance changes evenly with height, is dimmed towards the rim, and none comes from below the horizon. Source: measured of
/// Cycles 4.5 and 5.0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// To its middle, unit.
    pub dir: DVec3,
    /// To the zenith, unit.
    pub up: DVec3,
    /// Half its angle.
    pub half: f64,
    /// Heights of its foot and its top.
    pub heights: [f64; 2],
    /// Radiance there, without the rim.
    pub radiance: [Rgb; 2],
}

impl Disc {
    /// Radiance along `dir`, which is within it. Source: Cycles' limb darkening, 1 - 0.6 (1 - sqrt(1 - r²)).
    pub fn toward(&self, dir: DVec3) -> Rgb {
        let rise = dir.dot(self.up);
        if rise < 0.0 {
            return Vec3::ZERO;
        }
        let angle = dir.cross(self.dir).length().clamp(0.0, 1.0).asin();
        let r = (angle / self.half).min(1.0);
        let share = (rise.min(1.0).asin() - self.heights[0]) / (self.heights[1] - self.heights[0]);
        let c = self.radiance[0].lerp(self.radiance[1], share as f32);
        c.max(Vec3::ZERO) * (1.0 - 0.6 * (1.0 - (1.0 - r * r).sqrt())) as f32
    }

    /// Radiance on the mean over the part above the horizon, about.
    pub fn mean(&self) -> Rgb {
        (self.radiance[0] + self.radiance[1]).max(Vec3::ZERO) * 0.5
    }
}

impl ReadySky {
    /// Of parameters.
    pub fn new(sky: &Sky) -> Self {
        match sky.model {
            SkyModel::Multiple => Self::of(sky, &multiple::Air::new(sky)),
            SkyModel::Nishita | SkyModel::Single => Self::of(sky, &single::Air::new(sky)),
        }
    }

    fn of(sky: &Sky, air: &(impl Model + Sync)) -> Self {
        use rayon::prelude::*;
        // A sun beyond the zenith stands on the other side.
        let (sin, cos) = f64::from(sky.sun_elevation_rad).sin_cos();
        let elevation = sin.asin();
        let rotation = f64::from(sky.sun_rotation_rad) + if cos < 0.0 { PI } else { 0.0 };
        let flat = |elevation: f64, turn: f64| {
            let (se, ce) = elevation.sin_cos();
            DVec3::new(ce * turn.cos(), ce * turn.sin(), se)
        };
        let sun_in_table = flat(elevation, 0.0);
        let at = air.placement();
        let rows = if at.below { 2 * ROWS } else { ROWS };
        let table = (0..rows * COLUMNS)
            .into_par_iter()
            .map(|k| air.scattered(flat(at.height(k / COLUMNS), at.turn(k % COLUMNS)), sun_in_table))
            .collect();
        // Measured of Cycles: the sun stands at (sin, cos) of its rotation, like a compass.
        let (se, ce) = elevation.sin_cos();
        let sun = DVec3::new(ce * rotation.sin(), ce * rotation.cos(), se);
        Self { sun, table, below: at.below, disc: disc(sky, air, elevation, sun) }
    }

    /// Radiance without the disc.
    pub fn radiance(&self, dir: DVec3) -> Rgb {
        let fade = if self.below { 1.0 } else { fade(dir.z) };
        let up = dir.z.clamp(-1.0, 1.0).asin();
        let around = dir.x.hypot(dir.y);
        let flat_sun = self.sun.x.hypot(self.sun.y);
        let cos = if around > 0.0 && flat_sun > 0.0 { (dir.x * self.sun.x + dir.y * self.sun.y) / (around * flat_sun) } else { 1.0 };
        let (i, fx) = fraction(cos.clamp(-1.0, 1.0).acos() / PI * COLUMNS as f64 - 0.5, COLUMNS);
        let y = (up.abs() / FRAC_PI_2).sqrt().copysign(up) * ROWS as f64 - 0.5;
        let (j, fy) = if self.below { fraction(y + ROWS as f64, 2 * ROWS) } else { fraction(y.max(0.0), ROWS) };
        let (fx, fy) = (fx as f32, fy as f32);
        let at = |r: usize, c: usize| self.table[r * COLUMNS + c];
        let c = at(j, i).lerp(at(j, i + 1), fx).lerp(at(j + 1, i).lerp(at(j + 1, i + 1), fx), fy);
        (c * fade as f32).max(Vec3::ZERO)
    }

    /// The sun's disc, if it is shown and any of it is above the horizon.
    pub fn disc(&self) -> Option<Disc> {
        self.disc
    }
}

/// How much of the horizon's light the ground shows below it, where light is scattered once.
fn fade(z: f64) -> f64 {
    if z >= 0.0 { 1.0 } else { (1.0 + 2.5 * z).max(0.0).powi(3) }
}

/// Place and share of the next of `x` in a table of `n` entries, held within it.
fn fraction(x: f64, n: usize) -> (usize, f64) {
    let x = x.clamp(0.0, (n - 1) as f64);
    let i = (x as usize).min(n - 2);
    (i, x - i as f64)
}

fn disc(sky: &Sky, air: &impl Model, elevation: f64, dir: DVec3) -> Option<Disc> {
    let half = 0.5 * f64::from(sky.sun_size_rad);
    let top = elevation + half;
    if !(sky.sun_disc && half > 0.0 && top > 0.0) {
        return None;
    }
    // Where light is scattered once the foot of a disc that sets is as bright as the horizon, and in Blender 4 stands there.
    let foot = elevation - half;
    let lit_foot = if sky.model == SkyModel::Multiple { foot } else { foot.max(0.0) };
    let foot = if sky.model == SkyModel::Nishita { lit_foot } else { foot };
    let scale = f64::from(sky.sun_intensity) / (TAU * (1.0 - half.cos()));
    let radiance = [lit_foot, top].map(|e| air.direct(e) * scale as f32);
    let disc = Disc { dir, up: DVec3::Z, half, heights: [foot, top], radiance };
    (disc.mean().max_element() > 0.0).then_some(disc)
}
