//! 32-bit boxes that hold 64-bit ones, and rounding that never loses anything.

use super::HUGE;
use crate::math::{Bounds, DVec3};

/// The largest `f32` not above `x`.
#[inline]
pub fn round_down(x: f64) -> f32 {
    let f = x as f32;
    if f64::from(f) > x { f.next_down() } else { f }
}

/// The smallest `f32` not below `x`.
#[inline]
pub fn round_up(x: f64) -> f32 {
    let f = x as f32;
    if f64::from(f) < x { f.next_up() } else { f }
}

/// An axis-aligned box in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxF {
    /// Lower corner.
    pub lo: [f32; 3],
    /// Upper corner.
    pub hi: [f32; 3],
}

impl BoxF {
    /// Holds nothing; the neutral element of [`BoxF::grow`].
    pub const EMPTY: BoxF = BoxF { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    /// The smallest box around `b`; numbers that are exact in 32 bits stay, so flat things stay flat. `None` when `b` is empty or NaN.
    #[inline]
    pub fn around(b: &Bounds) -> Option<Self> {
        if b.is_empty() {
            return None;
        }
        let cut = DVec3::splat(HUGE);
        let (min, max) = (b.min.clamp(-cut, cut), b.max.clamp(-cut, cut));
        Some(Self {
            lo: [round_down(min.x), round_down(min.y), round_down(min.z)],
            hi: [round_up(max.x), round_up(max.y), round_up(max.z)],
        })
    }

    /// The same box in double precision.
    #[inline]
    pub fn to_bounds(self) -> Bounds {
        let v = |c: [f32; 3]| DVec3::new(c[0].into(), c[1].into(), c[2].into());
        Bounds { min: v(self.lo), max: v(self.hi) }
    }

    /// Grows to hold `other` too.
    #[inline]
    pub fn grow(&mut self, other: &BoxF) {
        // Not f32::min: no side is NaN, and this is one instruction.
        for k in 0..3 {
            self.lo[k] = if other.lo[k] < self.lo[k] { other.lo[k] } else { self.lo[k] };
            self.hi[k] = if other.hi[k] > self.hi[k] { other.hi[k] } else { self.hi[k] };
        }
    }

    /// The smallest box around both.
    #[inline]
    pub fn merged(mut self, other: BoxF) -> Self {
        self.grow(&other);
        self
    }

    /// What both hold; `None` when that is nothing.
    #[inline]
    pub fn intersection(&self, other: &BoxF) -> Option<Self> {
        let b = Self { lo: std::array::from_fn(|k| self.lo[k].max(other.lo[k])), hi: std::array::from_fn(|k| self.hi[k].min(other.hi[k])) };
        (0..3).all(|k| b.lo[k] <= b.hi[k]).then_some(b)
    }

    /// Half the surface area, 0 when empty.
    #[inline]
    pub fn half_area(&self) -> f64 {
        let s: [f64; 3] = std::array::from_fn(|k| (f64::from(self.hi[k]) - f64::from(self.lo[k])).max(0.0));
        s[0] * s[1] + s[1] * s[2] + s[2] * s[0]
    }

    /// The largest absolute coordinate.
    #[inline]
    pub fn max_abs(&self) -> f64 {
        let m = |k: usize| self.lo[k].abs().max(self.hi[k].abs());
        m(0).max(m(1)).max(m(2)).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_goes_outward_and_leaves_exact_numbers_alone() {
        for x in [0.1, -0.1, 1.0, 148376.3, -1e-42, 1e300, -1e300, 0.0] {
            assert!(f64::from(round_down(x)) <= x && f64::from(round_up(x)) >= x, "{x}");
        }
        assert_eq!((round_down(0.5), round_up(0.5)), (0.5, 0.5));
        assert_eq!(BoxF::around(&Bounds { min: DVec3::NAN, max: DVec3::ONE }), None);
    }
}
