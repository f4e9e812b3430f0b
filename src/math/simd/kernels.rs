//! The nearest of many points in AVX2, chosen at run time, and its plain twin.
//!
//! Twins give the same bits: the same operations in the same order, never a fused multiply-add. A test runs both.

use crate::math::DVec3;

/// Points by axis, 28 of them.
pub(crate) type NearestOf = [[f64; 28]; 3];

/// The `N` least squared distances of points to `p`, in order; `N` is 1 to 3.
#[inline]
pub(crate) fn least_squares<const N: usize>(points: &NearestOf, p: DVec3) -> [f64; N] {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2, the only thing that the function asks for.
        return unsafe { avx2::least_squares(points, p.x, p.y, p.z) };
    }
    least_squares_plain(points, p)
}

fn least_squares_plain<const N: usize>(points: &NearestOf, p: DVec3) -> [f64; N] {
    let mut least = [f64::INFINITY; N];
    for k in 0..28 {
        let e = DVec3::new(points[0][k], points[1][k], points[2][k]) - p;
        keep_least(&mut least, e.x * e.x + e.y * e.y + e.z * e.z);
    }
    least
}

/// Puts a number in its place of a sorted list and drops the largest.
#[inline(always)]
fn keep_least<const N: usize>(least: &mut [f64; N], mut v: f64) {
    for kept in least {
        let (low, high) = if v < *kept { (v, *kept) } else { (*kept, v) };
        (*kept, v) = (low, high);
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{NearestOf, keep_least};
    use std::arch::x86_64::*;

    /// Each lane keeps the least of every fourth point.
    #[target_feature(enable = "avx2")]
    pub fn least_squares<const N: usize>(points: &NearestOf, x: f64, y: f64, z: f64) -> [f64; N] {
        let p = [x, y, z].map(|v| _mm256_set1_pd(v));
        let mut least = [_mm256_set1_pd(f64::INFINITY); N];
        for k in (0..28).step_by(4) {
            let square = |axis: usize| {
                let four: &[f64; 4] = points[axis][k..].first_chunk().expect("28 is a multiple of 4");
                // SAFETY: four numbers are four numbers.
                let e = _mm256_sub_pd(unsafe { std::mem::transmute::<[f64; 4], __m256d>(*four) }, p[axis]);
                _mm256_mul_pd(e, e)
            };
            let mut v = _mm256_add_pd(_mm256_add_pd(square(0), square(1)), square(2));
            for kept in &mut least {
                let low = _mm256_min_pd(v, *kept);
                v = _mm256_max_pd(v, *kept);
                *kept = low;
            }
        }
        let mut out = [f64::INFINITY; N];
        for lanes in least {
            let (a, b) = (_mm256_castpd256_pd128(lanes), _mm256_extractf128_pd::<1>(lanes));
            for pair in [a, b] {
                keep_least(&mut out, _mm_cvtsd_f64(pair));
                keep_least(&mut out, _mm_cvtsd_f64(_mm_unpackhi_pd(pair, pair)));
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_squares_are_the_same_with_both_twins() {
        let points: NearestOf = std::array::from_fn(|axis| std::array::from_fn(|k| ((k * 7 + axis * 5) as f64 * 1.37).sin() * 2.0));
        for i in 0..500 {
            let p = DVec3::new((f64::from(i) * 0.7).sin(), f64::from(i) * 0.01, (f64::from(i) * 0.3).cos());
            assert_eq!(least_squares::<3>(&points, p), least_squares_plain::<3>(&points, p));
            assert_eq!(least_squares::<1>(&points, p), least_squares_plain::<1>(&points, p));
        }
    }
}
