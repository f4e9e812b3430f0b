//! Rays in double precision.

use super::{DVec3, Transform};

/// A half line; `dir` need not be unit, `t` is in units of `dir`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start point.
    pub origin: DVec3,
    /// Direction, not zero.
    pub dir: DVec3,
}

impl Ray {
    /// A ray from its parts.
    #[inline]
    pub fn new(origin: DVec3, dir: DVec3) -> Self {
        Self { origin, dir }
    }

    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.dir
    }

    /// The ray in the space before `t` was applied; parameters stay the same.
    pub fn into_object(&self, t: &Transform) -> Self {
        Self { origin: t.inverse_point(self.origin), dir: t.inverse_vector(self.dir) }
    }
}
