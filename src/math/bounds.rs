//! Axis-aligned boxes in double precision.

use super::{BOUND_HUGE, DVec3, Transform};

/// An axis-aligned box; empty when `min` exceeds `max` on any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub min: DVec3,
    /// Upper corner.
    pub max: DVec3,
}

impl Bounds {
    /// The box that holds nothing; the neutral element of [`Bounds::union`].
    pub const EMPTY: Bounds = Bounds { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
    /// The box of an unbounded object: ±1e10 on every axis, as POV-Ray prints it.
    pub const UNBOUNDED: Bounds = Bounds { min: DVec3::splat(-BOUND_HUGE / 2.0), max: DVec3::splat(BOUND_HUGE / 2.0) };

    /// The box of two corners given in any order.
    pub fn from_corners(a: DVec3, b: DVec3) -> Self {
        Self { min: a.min(b), max: a.max(b) }
    }

    /// The smallest box around `points`.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| b.including(p))
    }

    /// This box grown to hold `p`.
    pub fn including(self, p: DVec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// What both boxes share; possibly empty.
    pub fn intersection(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Whether it holds no point (NaN counts as empty).
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Whether some side is longer than 1e6, POV-Ray's limit for an "infinite" object.
    pub fn is_unbounded(&self) -> bool {
        (self.max - self.min).max_element() > 1e6
    }

    /// Side lengths.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// Middle point.
    pub fn center(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Surface area; 0 when empty.
    pub fn area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let s = self.size();
        2.0 * (s.x * s.y + s.y * s.z + s.z * s.x)
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// The box of the transformed corners, as POV-Ray bounds transformed objects. Unbounded and empty boxes stay so.
    pub fn transformed(&self, t: &Transform) -> Self {
        if self.is_empty() || self.is_unbounded() {
            return *self;
        }
        Self::from_points(self.corners().map(|c| t.point(c)))
    }
}
