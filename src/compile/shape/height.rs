//! Height fields ready to be walked. Source: spec/objects.md, section 7.

use crate::math::{Bounds, DVec3, Transform};
use crate::scene::shape::HeightGrid;
use std::sync::Arc;

/// Side of a block of cells whose least and greatest height is kept.
pub const BLOCK: u32 = 8;

/// A height field in grid units: x and z count vertices, y is 0..=65535.
#[derive(Clone, Debug)]
pub struct HeightFieldShape {
    /// Heights.
    pub grid: Arc<HeightGrid>,
    /// Nothing is seen below.
    pub low: f64,
    /// Nothing is above.
    pub high: f64,
    /// Points below are inside wherever they are.
    pub water: f64,
    /// Normals are interpolated.
    pub smooth: bool,
    /// Blocks along x.
    pub blocks_x: u32,
    /// Least and greatest height of each block of `BLOCK` x `BLOCK` cells, `[z][x]`.
    pub blocks: Vec<(u16, u16)>,
}

impl HeightFieldShape {
    /// `None` with fewer than 2 x 2 vertices.
    pub fn new(grid: Arc<HeightGrid>, water_level: f64, smooth: bool) -> Option<Self> {
        let (w, h) = (grid.width, grid.height);
        if w < 2 || h < 2 || grid.heights.len() != w as usize * h as usize {
            return None;
        }
        let blocks_x = (w - 1).div_ceil(BLOCK);
        let blocks_z = (h - 1).div_ceil(BLOCK);
        let mut blocks = vec![(u16::MAX, 0); (blocks_x * blocks_z) as usize];
        for bz in 0..blocks_z {
            for bx in 0..blocks_x {
                let b = &mut blocks[(bz * blocks_x + bx) as usize];
                for z in bz * BLOCK..=((bz + 1) * BLOCK).min(h - 1) {
                    for x in bx * BLOCK..=((bx + 1) * BLOCK).min(w - 1) {
                        let v = grid.heights[(z * w + x) as usize];
                        *b = (b.0.min(v), b.1.max(v));
                    }
                }
            }
        }
        let (least, most) = blocks.iter().fold((u16::MAX, 0), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let water = f64::from(least).max(water_level * 65536.0);
        Some(Self { grid, low: water - 0.001, high: f64::from(most) + 0.001, water, smooth, blocks_x, blocks })
    }

    /// Shape space (the unit square in x and z) from grid units.
    pub fn frame(&self) -> Transform {
        let (w, h) = (f64::from(self.grid.width - 1), f64::from(self.grid.height - 1));
        Transform::scaling(DVec3::new(1.0 / w, 1.0 / 65536.0, 1.0 / h))
    }

    /// Box in grid units.
    pub fn bounds(&self) -> Bounds {
        let (w, h) = (f64::from(self.grid.width - 1), f64::from(self.grid.height - 1));
        Bounds { min: DVec3::new(0.0, self.low, 0.0), max: DVec3::new(w, self.high, h) }
    }

    /// Height of a vertex.
    #[inline]
    pub fn height(&self, x: u32, z: u32) -> f64 {
        f64::from(self.grid.heights[(z * self.grid.width + x) as usize])
    }
}
