//! What a ray is offered: boxes against rays, and which of a tree's primitives are worth a test.

use crate::compile::geometry::Geometry;
use crate::math::{Bounds, DVec3, Ray};

/// A ray made ready for box tests.
pub(super) struct Slabs {
    origin: DVec3,
    inverse: DVec3,
}

impl Slabs {
    /// For `ray`.
    pub fn new(ray: &Ray) -> Self {
        Self { origin: ray.origin, inverse: ray.dir.recip() }
    }

    /// Where the ray's line enters the box and where it leaves it, the first above the second when it misses.
    #[inline]
    pub fn interval(&self, b: &Bounds) -> (f64, f64) {
        let (a, c) = ((b.min - self.origin) * self.inverse, (b.max - self.origin) * self.inverse);
        // 0 * infinity is NaN where the ray runs in a face; f64::min and max then take the other side.
        (a.x.min(c.x).max(a.y.min(c.y)).max(a.z.min(c.z)), a.x.max(c.x).min(a.y.max(c.y)).min(a.z.max(c.z)))
    }

    /// Whether the ray meets the box between 0 and `t_max`, both included.
    #[inline]
    pub fn hits(&self, b: &Bounds, t_max: f64) -> bool {
        let (near, far) = self.interval(b);
        near.max(0.0) <= far.min(t_max) * (1.0 + 4.0 * f64::EPSILON)
    }
}

/// Places for primitives that a ray has tested.
const N_TESTED: usize = 32;

/// Which of the primitives that a tree offers a ray are worth a test, for trees that do not test the primitives' own boxes.
///
/// A cell of such a tree may be met where the primitive's box is not, and most shapes cost more than a box; and it may offer one again and
/// again.
pub(super) struct Offers<'g> {
    bounds: &'g [Bounds],
    slabs: Slabs,
    tested: [u32; N_TESTED],
}

impl<'g> Offers<'g> {
    /// For a ray.
    #[inline]
    pub fn new(g: &'g Geometry, ray: &Ray) -> Self {
        Self { bounds: &g.bounds, slabs: Slabs::new(ray), tested: [u32::MAX; N_TESTED] }
    }

    /// Whether it was not offered before (as far as that is remembered) and its box is met before depth `far`. What lay too far once does
    /// so ever after: the limit only shrinks.
    #[inline]
    pub fn is_worth(&mut self, prim_ix: u32, far: f64) -> bool {
        std::mem::replace(&mut self.tested[prim_ix as usize % N_TESTED], prim_ix) != prim_ix
            && self.slabs.hits(&self.bounds[prim_ix as usize], far)
    }
}
