//! A scene's primitives and solids as trees see them.

use super::super::geometry::{Geometry, PrimKind};
use crate::accel::PrimSet;
use crate::math::{Bounds, DVec3};

/// The bounded primitives as a tree sees them.
pub(super) struct BoundedPrims<'a> {
    pub geometry: &'a Geometry,
}

/// The boxes of what points can be inside.
pub(super) struct SolidPrims<'a>(pub &'a [(Bounds, u32)]);

impl PrimSet for SolidPrims<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        self.0[k].0
    }
}

impl PrimSet for BoundedPrims<'_> {
    fn len(&self) -> usize {
        self.geometry.bounded.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        self.geometry.bounds[self.geometry.bounded[k] as usize]
    }

    /// Slanted rods fill little of their box: the part of the axis near the cell says where.
    fn clipped_bounds(&self, k: usize, cell: &Bounds) -> Bounds {
        let b = self.bounds(k).intersection(*cell);
        let prim = &self.geometry.prims[self.geometry.bounded[k] as usize];
        if b.is_empty() || !matches!(prim.kind, PrimKind::Cylinder | PrimKind::Cone) {
            return b;
        }
        let t = &self.geometry.transforms[prim.transform_ix as usize];
        let m = t.forward.matrix3;
        // No point of the rod is farther from the axis; the last bits are for roundings.
        let r = DVec3::splat((m.x_axis.length_squared() + m.y_axis.length_squared()).sqrt() * (1.0 + 1e-9));
        let (from, along) = (t.forward.translation, m.z_axis);
        let (mut s0, mut s1) = (0.0f64, 1.0f64);
        for axis in 0..3 {
            let (low, high) = (b.min[axis] - r[axis] - from[axis], b.max[axis] + r[axis] - from[axis]);
            if along[axis].abs() > 1e-12 {
                let (x, y) = (low / along[axis], high / along[axis]);
                s0 = s0.max(x.min(y) - 1e-9);
                s1 = s1.min(x.max(y) + 1e-9);
            } else if low > 0.0 || high < 0.0 {
                return Bounds::EMPTY;
            }
        }
        if s0 > s1 {
            return Bounds::EMPTY;
        }
        let part = Bounds::from_corners(from + s0 * along, from + s1 * along);
        b.intersection(Bounds { min: part.min - r, max: part.max + r })
    }
}
