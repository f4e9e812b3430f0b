//! Blender's clear sky: sunlight scattered once by air, dust and ozone, and the sun's disc.

use crate::math::{DVec3, Rgb};
use crate::scene::environment::Sky;

/// A sky made ready.
pub struct ReadySky {
    _sky: Sky,
}

impl ReadySky {
    /// Of parameters.
    pub fn new(sky: &Sky) -> Self {
        Self { _sky: sky.clone() }
    }

    /// Radiance without the disc.
    pub fn radiance(&self, _dir: DVec3) -> Rgb {
        Rgb::ZERO
    }

    /// Direction to the sun, half angle, radiance at the middle of the disc.
    pub fn disc(&self) -> Option<(DVec3, f64, Rgb)> {
        None
    }
}
