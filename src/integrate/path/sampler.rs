//! The random numbers of one sample: Owen-scrambled Sobol sets, a few for the camera and a few for each bounce.

use crate::math::sobol::{hash, hash2, sobol4};

/// Sets of numbers of a bounce.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Set {
    /// Direction of the bounce.
    Bsdf = 0,
    /// Light, and roulette.
    Light = 1,
    /// Which way to go on; walks below the surface.
    Choice = 2,
    /// Distance in a volume, phase, its light.
    Volume = 3,
}

const CAMERA_SETS: u32 = 2;
const SETS: u32 = 4;

/// Numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    seed: u32,
    index: u32,
}

impl Sampler {
    /// Sample `index` of the pixel at (x, y).
    pub fn new(x: u32, y: u32, seed: u32, index: u32) -> Self {
        Self { seed: hash2(hash2(x, y), hash(seed ^ 0x5bd1_e995)), index }
    }

    /// Filter (two), lens (two).
    pub fn camera(&self) -> [f32; 4] {
        sobol4(self.seed, self.index, 0)
    }

    /// Time of the shutter, and three more.
    pub fn time(&self) -> [f32; 4] {
        sobol4(self.seed, self.index, 1)
    }

    /// Numbers at the `step`th event of the path.
    #[inline]
    pub fn at(&self, step: u32, set: Set) -> [f32; 4] {
        sobol4(self.seed, self.index, CAMERA_SETS + SETS * step + set as u32)
    }

    /// Seed of a stream of plain numbers for an event.
    pub fn stream(&self, step: u32) -> u32 {
        hash2(hash2(self.seed, self.index), step)
    }
}
