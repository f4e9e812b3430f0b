//! Noise and the nearest of many points in AVX2, chosen at run time, and their plain twins.
//!
//! Written in the processor's own instructions: rows of the lattice are loaded and transposed, which [`super::Simd`] has no words for.
//! Twins give the same bits: the same operations in the same order, never a fused multiply-add. A test runs both.

use crate::math::noise::{octave_sum, octave_sum_vector, ranged};
use crate::math::{DVec3, lattice};

/// Calls the AVX2 twin where the processor has AVX2 (the answer is kept by the standard library), else the plain one.
macro_rules! dispatch {
    ($name:ident($($arg:expr),*), $plain:expr) => {{
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2, the only thing that the function asks for.
            return unsafe { avx2::$name($($arg),*) };
        }
        $plain
    }};
}

/// The lattice's value at a point.
#[inline]
pub(in crate::math) fn lattice_scalar(p: DVec3) -> f64 {
    dispatch!(scalar(p.x, p.y, p.z), lattice::scalar(p))
}

/// Three values of the lattice at a point.
#[inline]
pub(in crate::math) fn lattice_vector(p: DVec3) -> DVec3 {
    dispatch!(vector(p.x, p.y, p.z), lattice::vector(p))
}

/// Scalar turbulence of generators 1 and 2.
#[inline]
pub(in crate::math) fn turbulence(p: DVec3, octaves: u32, omega: f32, lambda: f32, generator: u8) -> f64 {
    dispatch!(
        turbulence(p.x, p.y, p.z, octaves, omega, lambda, generator),
        octave_sum(p, octaves, omega, lambda, generator, |p| ranged(lattice::scalar(p), generator))
    )
}

/// Vector turbulence.
#[inline]
pub(in crate::math) fn turbulence_vector(p: DVec3, octaves: u32, omega: f32, lambda: f32) -> DVec3 {
    dispatch!(turbulence_vector(p.x, p.y, p.z, octaves, omega, lambda), octave_sum_vector(p, octaves, omega, lambda, lattice::vector))
}

/// The lattice's values at a point times 1, 2, 4, ...
#[inline]
pub(in crate::math) fn lattice_doublings<const N: usize>(p: DVec3) -> [f64; N] {
    dispatch!(doublings(p.x, p.y, p.z), doublings_plain(p))
}

fn doublings_plain<const N: usize>(mut p: DVec3) -> [f64; N] {
    std::array::from_fn(|_| {
        let v = lattice::scalar(p);
        p += p;
        v
    })
}

/// Points by axis, 28 of them.
pub(crate) type NearestOf = [[f64; 28]; 3];

/// The `N` least squared distances of points to `p`, in order; `N` is 1 to 3.
#[inline]
pub(crate) fn least_squares<const N: usize>(points: &NearestOf, p: DVec3) -> [f64; N] {
    dispatch!(least_squares(points, p.x, p.y, p.z), least_squares_plain(points, p))
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
    use super::{DVec3, NearestOf, keep_least, ranged};
    use crate::math::lattice::{CELL_BIAS, CELL_MASK, DOWN, ROWS, Row, VECTOR_ROWS, corner_rows};
    use std::arch::x86_64::*;

    /// A point's cell with its corners, the place inside and the s-curve of that, all axes at once.
    struct Corners {
        rows: [usize; 8],
        place: __m256d,
        share: __m256d,
    }

    /// Coordinates come in registers: three numbers just stored and loaded again as one vector stall the processor.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn point(x: f64, y: f64, z: f64) -> __m256d {
        _mm256_set_pd(0.0, z, y, x)
    }

    #[target_feature(enable = "avx2")]
    #[inline]
    fn three(v: __m256d) -> DVec3 {
        let (xy, z) = (_mm256_castpd256_pd128(v), _mm256_extractf128_pd::<1>(v));
        DVec3::new(_mm_cvtsd_f64(xy), _mm_cvtsd_f64(_mm_unpackhi_pd(xy, xy)), _mm_cvtsd_f64(z))
    }

    #[target_feature(enable = "avx2")]
    #[inline]
    fn corners(p: __m256d) -> Corners {
        // NaN is moved too, as in the plain twin.
        let at_or_above = _mm256_cmp_pd::<_CMP_GE_OQ>(p, _mm256_setzero_pd());
        let moved = _mm256_sub_pd(p, _mm256_andnot_pd(at_or_above, _mm256_set1_pd(DOWN)));
        let cell = _mm256_cvttpd_epi32(moved);
        let place = _mm256_sub_pd(p, _mm256_cvtepi32_pd(cell));
        let two_places = _mm256_mul_pd(_mm256_set1_pd(2.0), place);
        let share = _mm256_mul_pd(_mm256_mul_pd(place, place), _mm256_sub_pd(_mm256_set1_pd(3.0), two_places));
        let cell = _mm_and_si128(_mm_add_epi32(cell, _mm_set1_epi32(CELL_BIAS)), _mm_set1_epi32(CELL_MASK));
        // Below 4096, so the lower halves are all.
        let cell = [_mm_extract_epi16::<0>(cell), _mm_extract_epi16::<2>(cell), _mm_extract_epi16::<4>(cell)].map(|i| i as u16);
        Corners { rows: corner_rows(cell), place, share }
    }

    /// One axis of three in all lanes.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn lane<const AXIS: usize>(v: __m256d) -> __m256d {
        match AXIS {
            0 => _mm256_permute4x64_pd::<0b00_00_00_00>(v),
            1 => _mm256_permute4x64_pd::<0b01_01_01_01>(v),
            _ => _mm256_permute4x64_pd::<0b10_10_10_10>(v),
        }
    }

    /// One load; four numbers set one by one are six instructions.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn load(r: &Row) -> __m256d {
        // SAFETY: four numbers are four numbers. The load instruction's own function checks its pointer in debug builds.
        unsafe { std::mem::transmute::<Row, __m256d>(*r) }
    }

    /// v + a x + b y + c z, from the left.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn plane([v, a, b, c]: [__m256d; 4], [x, y, z]: [__m256d; 3]) -> __m256d {
        _mm256_add_pd(_mm256_add_pd(_mm256_add_pd(v, _mm256_mul_pd(a, x)), _mm256_mul_pd(b, y)), _mm256_mul_pd(c, z))
    }

    #[target_feature(enable = "avx2")]
    #[inline]
    fn mix(t: __m256d, a: __m256d, b: __m256d) -> __m256d {
        _mm256_add_pd(a, _mm256_mul_pd(t, _mm256_sub_pd(b, a)))
    }

    /// Four corners in the lanes.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn four_corners(rows: &[usize], at: [__m256d; 3]) -> __m256d {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| load(&ROWS[rows[k] & 255]));
        let (ab_low, ab_high) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
        let (cd_low, cd_high) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
        let v = _mm256_permute2f128_pd::<0x20>(ab_low, cd_low);
        let x = _mm256_permute2f128_pd::<0x20>(ab_high, cd_high);
        let y = _mm256_permute2f128_pd::<0x31>(ab_low, cd_low);
        let z = _mm256_permute2f128_pd::<0x31>(ab_high, cd_high);
        plane([v, x, y, z], at)
    }

    /// Corners in lanes.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn scalar_at(p: __m256d) -> f64 {
        let c = corners(p);
        let x = _mm256_sub_pd(lane::<0>(c.place), _mm256_set_pd(1.0, 0.0, 1.0, 0.0));
        let y = _mm256_sub_pd(lane::<1>(c.place), _mm256_set_pd(1.0, 1.0, 0.0, 0.0));
        let z = lane::<2>(c.place);
        let low = four_corners(&c.rows[..4], [x, y, z]);
        let high = four_corners(&c.rows[4..], [x, y, _mm256_sub_pd(z, _mm256_set1_pd(1.0))]);
        // Along x; what is left are (y, z) = 00, 01, 10, 11.
        let x = mix(lane::<0>(c.share), _mm256_unpacklo_pd(low, high), _mm256_unpackhi_pd(low, high));
        let (near, far) = (_mm256_castpd256_pd128(x), _mm256_extractf128_pd::<1>(x));
        let share_y = _mm256_castpd256_pd128(lane::<1>(c.share));
        let y = _mm_add_pd(near, _mm_mul_pd(share_y, _mm_sub_pd(far, near)));
        let (below, above) = (y, _mm_unpackhi_pd(y, y));
        let share_z = _mm256_castpd256_pd128(lane::<2>(c.share));
        _mm_cvtsd_f64(_mm_add_sd(below, _mm_mul_sd(share_z, _mm_sub_sd(above, below))))
    }

    /// Components in lanes.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn vector_at(p: __m256d) -> __m256d {
        let c = corners(p);
        let one = _mm256_set1_pd(1.0);
        let (x0, y0, z0) = (lane::<0>(c.place), lane::<1>(c.place), lane::<2>(c.place));
        let (x1, y1, z1) = (_mm256_sub_pd(x0, one), _mm256_sub_pd(y0, one), _mm256_sub_pd(z0, one));
        let (sx, sy, sz) = (lane::<0>(c.share), lane::<1>(c.share), lane::<2>(c.share));
        let at = |k: usize, x, y, z| {
            let [v, a, b, c] = &VECTOR_ROWS[c.rows[k] & 255];
            plane([load(v), load(a), load(b), load(c)], [x, y, z])
        };
        let low = mix(sy, mix(sx, at(0, x0, y0, z0), at(1, x1, y0, z0)), mix(sx, at(2, x0, y1, z0), at(3, x1, y1, z0)));
        let high = mix(sy, mix(sx, at(4, x0, y0, z1), at(5, x1, y0, z1)), mix(sx, at(6, x0, y1, z1), at(7, x1, y1, z1)));
        mix(sz, low, high)
    }

    #[target_feature(enable = "avx2")]
    pub fn scalar(x: f64, y: f64, z: f64) -> f64 {
        scalar_at(point(x, y, z))
    }

    #[target_feature(enable = "avx2")]
    pub fn vector(x: f64, y: f64, z: f64) -> DVec3 {
        three(vector_at(point(x, y, z)))
    }

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

    /// The octaves of `noise::turbulence`, the point in one vector all the way.
    #[target_feature(enable = "avx2")]
    pub fn turbulence(x: f64, y: f64, z: f64, octaves: u32, omega: f32, lambda: f32, generator: u8) -> f64 {
        let p = point(x, y, z);
        let one = |v: f64| if generator > 1 { 2.0 * ranged(v, generator) - 0.5 } else { ranged(v, generator) };
        let (omega, lambda) = (f64::from(omega), f64::from(lambda));
        let (mut sum, mut l, mut o) = (0.0, 1.0, 1.0);
        // One place that asks for the lattice: two would be two calls.
        for octave in 0..octaves.max(1) {
            let v = one(scalar_at(_mm256_mul_pd(p, _mm256_set1_pd(l))));
            sum = if octave > 0 {
                sum + o * v
            } else if generator > 1 {
                v.clamp(0.0, 1.0)
            } else {
                v
            };
            l *= lambda;
            o *= omega;
        }
        sum
    }

    /// The octaves of `noise::turbulence_vector`, likewise.
    #[target_feature(enable = "avx2")]
    pub fn turbulence_vector(x: f64, y: f64, z: f64, octaves: u32, omega: f32, lambda: f32) -> DVec3 {
        let p = point(x, y, z);
        let (omega, lambda) = (f64::from(omega), f64::from(lambda));
        // Nothing is added to -0: it leaves the sign of zeros alone.
        let (mut sum, mut l, mut o) = (_mm256_set1_pd(-0.0), 1.0, 1.0);
        for _ in 0..octaves.max(1) {
            let octave = vector_at(_mm256_mul_pd(p, _mm256_set1_pd(l)));
            sum = _mm256_add_pd(sum, _mm256_mul_pd(_mm256_set1_pd(o), octave));
            l *= lambda;
            o *= omega;
        }
        three(sum)
    }

    /// Values at a point times 1, 2, 4, ...
    #[target_feature(enable = "avx2")]
    pub fn doublings<const N: usize>(x: f64, y: f64, z: f64) -> [f64; N] {
        let mut p = point(x, y, z);
        let mut out = [0.0; N];
        for v in &mut out {
            *v = scalar_at(p);
            p = _mm256_add_pd(p, p);
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

    #[test]
    fn both_twins_give_the_same_bits() {
        let same = |a: f64, b: f64, p: DVec3| assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{a} is not {b} at {p}");
        let odd = [0.0, -0.0, -1e-11, 1.0, -1.0, 4095.5, -1e5, 3e9, -3e9, f64::INFINITY, f64::NAN];
        let far = (0..11 * 11).map(|i| DVec3::new(odd[i % 11], odd[i / 11], odd[(i * 7) % 11]));
        let near = (0..20_000).map(|i| {
            let i = f64::from(i);
            DVec3::new(i * 0.0137 - 100.0, (i * 0.731).sin() * 50.0, 77.0 - i * 0.0091)
        });
        for p in far.chain(near) {
            same(lattice_scalar(p), lattice::scalar(p), p);
            let (a, b) = (lattice_vector(p), lattice::vector(p));
            (0..3).for_each(|k| same(a[k], b[k], p));
            for generator in 1..=2 {
                let plain = octave_sum(p, 6, 0.5, 2.1, generator, |p| ranged(lattice::scalar(p), generator));
                same(turbulence(p, 6, 0.5, 2.1, generator), plain, p);
            }
            let (a, b): ([f64; 4], [f64; 4]) = (lattice_doublings(p), doublings_plain(p));
            (0..4).for_each(|k| same(a[k], b[k], p));
            let (a, b) = (turbulence_vector(p, 4, 0.6, 2.0), octave_sum_vector(p, 4, 0.6, 2.0, lattice::vector));
            (0..3).for_each(|k| same(a[k], b[k], p));
        }
    }
}
