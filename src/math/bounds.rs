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

    /// Whether a point lies in it, its faces included.
    #[inline(always)]
    pub fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
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

    /// The box of the transformed corners, as POV-Ray bounds transformed objects. Empty boxes stay so; a box without end along some
    /// axes (at ±1e10) has none along the axes that those are turned to.
    pub fn transformed(&self, t: &Transform) -> Self {
        if self.is_empty() {
            return *self;
        }
        let (m, end) = (t.forward.matrix3, 0.9 * Self::UNBOUNDED.max.x);
        let mut out = Self { min: t.forward.translation, max: t.forward.translation };
        for k in 0..3 {
            let row = [m.x_axis[k], m.y_axis[k], m.z_axis[k]];
            let most = row.iter().fold(0.0f64, |a, v| a.max(v.abs()));
            for (j, f) in row.into_iter().enumerate() {
                // What is left of a turn by a right angle is no turn.
                let endless = f.abs() > 1e-9 * most;
                let at = |v: f64| if v.abs() >= end && endless { f * v * 1e10 } else { f * v };
                let (a, b) = (at(self.min[j]), at(self.max[j]));
                out.min[k] += a.min(b);
                out.max[k] += a.max(b);
            }
        }
        Self { min: out.min.max(Self::UNBOUNDED.min), max: out.max.min(Self::UNBOUNDED.max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_without_end_along_an_axis_keep_their_ends_along_the_others() {
        let rod = Bounds { min: DVec3::new(-1e10, -1.0, -2.0), max: DVec3::new(1e10, 1.0, 2.0) };
        let scaled = rod.transformed(&Transform::scaling(DVec3::new(1e-6, 10.0, 10.0)));
        assert_eq!((scaled.min, scaled.max), (DVec3::new(-1e10, -10.0, -20.0), DVec3::new(1e10, 10.0, 20.0)));
        let turned = rod.transformed(&Transform::rotation_deg(DVec3::new(0.0, 0.0, 90.0)));
        assert!(turned.max.y == 1e10 && (turned.max.x - 1.0).abs() < 1e-5 && turned.max.z == 2.0, "{turned:?}");
        assert!(rod.transformed(&Transform::rotation_deg(DVec3::new(0.0, 45.0, 0.0))).max.z == 1e10);
        assert_eq!(Bounds::UNBOUNDED.transformed(&Transform::scaling(DVec3::splat(1e-9))), Bounds::UNBOUNDED);
    }

    #[test]
    fn transformed_box_holds_the_transformed_corners_tightly() {
        let b = Bounds { min: DVec3::new(-1.0, 0.0, 2.0), max: DVec3::new(3.0, 1.0, 5.0) };
        let t = Transform::rotation_deg(DVec3::new(10.0, 20.0, 30.0)).then(&Transform::translation(DVec3::ONE));
        let (got, want) = (b.transformed(&t), Bounds::from_points(b.corners().map(|c| t.point(c))));
        assert!((got.min - want.min).length() < 1e-12 && (got.max - want.max).length() < 1e-12);
    }
}
