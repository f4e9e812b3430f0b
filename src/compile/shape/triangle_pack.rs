//! Triangles side by side, as a wide tree's leaves hold them.

use crate::accel::PACK;
use crate::math::Vec3;

/// Up to four triangles: `[corner][axis][triangle]`. Missing ones are a point, which no ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct TrianglePack(pub [[[f32; PACK]; 3]; 3]);

impl TrianglePack {
    /// Of the corners of at most [`PACK`] triangles.
    pub fn new(triangles: impl Iterator<Item = [Vec3; 3]>) -> Self {
        let mut pack = Self([[[0.0; PACK]; 3]; 3]);
        for (lane, triangle) in triangles.take(PACK).enumerate() {
            for (corner, v) in triangle.iter().enumerate() {
                for axis in 0..3 {
                    pack.0[corner][axis][lane] = v[axis];
                }
            }
        }
        pack
    }

    /// Corners of one of them.
    pub fn corners(&self, lane: usize) -> [Vec3; 3] {
        std::array::from_fn(|c| Vec3::from_array(std::array::from_fn(|axis| self.0[c][axis][lane])))
    }
}
