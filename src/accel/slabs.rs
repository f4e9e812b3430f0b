//! Rays made ready for planes and boxes: the slack is moved into the origin, so that it costs nothing per test.

use super::{BoxF, RAY_SLACK};
use crate::math::Ray;

/// A ray against axis-parallel planes, never too late at a near side nor too early at a far side.
///
/// All tests have the form (plane - origin) * inverse: the difference is taken first, so nothing cancels far from the origin.
/// No number of it is NaN or makes one: a direction component of zero (or nearly) gets a huge slope of its sign, so every plane is
/// far ahead or far behind. Source: Ize 2013, "Robust BVH ray traversal".
pub(super) struct SlabRay {
    /// 1 / direction.
    pub inv: [f64; 3],
    /// A plane at `s` is reached at `(s - enter) * inv` at the earliest ...
    pub enter: [f64; 3],
    /// ... and left behind at `(s - exit) * inv` at the latest.
    pub exit: [f64; 3],
    /// 1 where the ray runs down the axis: the index of a box's near side.
    pub near: [usize; 3],
}

impl SlabRay {
    /// For a usable ray in a tree whose largest absolute coordinate is `max_abs`.
    #[inline]
    pub fn new(ray: &Ray, max_abs: f64) -> Self {
        let slack = (RAY_SLACK * (ray.origin.abs().max_element() + max_abs)).max(1e-300);
        let d: [f64; 3] = ray.dir.into();
        let o: [f64; 3] = ray.origin.into();
        let inv = d.map(|d| if d.abs() < 1e-280 { 1e280_f64.copysign(d) } else { 1.0 / d });
        let toward = inv.map(|i| slack.copysign(i));
        Self {
            inv,
            enter: std::array::from_fn(|k| o[k] + toward[k]),
            exit: std::array::from_fn(|k| o[k] - toward[k]),
            near: inv.map(|i| usize::from(i < 0.0)),
        }
    }

    /// Part of `t_min..=t_max` in the box; empty (start above end) when it misses.
    #[inline]
    pub fn clip(&self, b: &BoxF, t_min: f64, t_max: f64) -> (f64, f64) {
        self.meet((b.lo.map(f64::from), b.hi.map(f64::from)), t_min, t_max)
    }

    /// The same for a box in double precision: lower and upper corner.
    #[inline]
    pub fn meet(&self, (lo, hi): ([f64; 3], [f64; 3]), t_min: f64, t_max: f64) -> (f64, f64) {
        let (mut t0, mut t1) = (t_min, t_max);
        for k in 0..3 {
            let (near, far) = if self.inv[k] > 0.0 { (lo[k], hi[k]) } else { (hi[k], lo[k]) };
            t0 = t0.max((near - self.enter[k]) * self.inv[k]);
            t1 = t1.min((far - self.exit[k]) * self.inv[k]);
        }
        (t0, t1)
    }
}
