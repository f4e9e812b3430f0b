//! Noise in AVX2 and AVX-512, chosen at run time, and its plain twins.
//!
//! Written in the processor's own instructions: rows of the lattice are loaded whole, which [`super::Simd`] has no words for. A point
//! stands in the upper three lanes of four, the lowest is 0. Twins give the same bits: the same operations in the same order, the same of
//! them fused. A test runs all.

use crate::math::noise::{octave_sum, octave_sum_vector, ranged};
use crate::math::{DVec3, lattice};

/// Calls the widest twin that the processor has (the answer is kept by the standard library), else the plain one.
macro_rules! dispatch {
    ($name:ident($($arg:expr),*), $plain:expr) => {{
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            if std::arch::is_x86_feature_detected!("avx512f") && std::arch::is_x86_feature_detected!("avx512vl") {
                // SAFETY: the processor has all that the function asks for.
                return unsafe { avx512::$name($($arg),*) };
            }
            // SAFETY: the processor has AVX2 and fused multiply-add, all that the function asks for.
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

/// What both kinds of processors do, from a lattice value and three at once: `$scalar` and `$vector` are macros, for a function as long as
/// theirs is called, not made part of the loop.
#[cfg(target_arch = "x86_64")]
macro_rules! sums {
    ($features:literal, $scalar:ident, $vector:ident) => {
        /// Coordinates come in registers: three numbers just stored and loaded again as one vector stall the processor.
        #[target_feature(enable = $features)]
        #[inline]
        fn point(x: f64, y: f64, z: f64) -> __m256d {
            _mm256_set_pd(z, y, x, 0.0)
        }

        #[target_feature(enable = $features)]
        #[inline]
        fn three(v: __m256d) -> DVec3 {
            let (xy, z) = (_mm256_castpd256_pd128(v), _mm256_extractf128_pd::<1>(v));
            DVec3::new(_mm_cvtsd_f64(xy), _mm_cvtsd_f64(_mm_unpackhi_pd(xy, xy)), _mm_cvtsd_f64(z))
        }

        /// Rows of the corners of a point's cell, the place inside and the s-curve of that, all axes at once.
        #[target_feature(enable = $features)]
        #[inline]
        fn corners(p: __m256d) -> ([usize; 8], __m256d, __m256d) {
            // NaN is moved too, as in the plain twin.
            let at_or_above = _mm256_cmp_pd::<_CMP_GE_OQ>(p, _mm256_setzero_pd());
            let moved = _mm256_sub_pd(p, _mm256_andnot_pd(at_or_above, _mm256_set1_pd(DOWN)));
            let cell = _mm256_cvttpd_epi32(moved);
            let place = _mm256_sub_pd(p, _mm256_cvtepi32_pd(cell));
            let two_places = _mm256_add_pd(place, place);
            let share = _mm256_mul_pd(_mm256_mul_pd(place, place), _mm256_sub_pd(_mm256_set1_pd(3.0), two_places));
            let cell = _mm_and_si128(_mm_add_epi32(cell, _mm_set1_epi32(CELL_BIAS)), _mm_set1_epi32(CELL_MASK));
            // Below 4096, so the lower halves are all.
            let cell = [_mm_extract_epi16::<2>(cell), _mm_extract_epi16::<4>(cell), _mm_extract_epi16::<6>(cell)].map(|i| i as u16);
            (corner_rows(cell), place, share)
        }

        #[target_feature(enable = $features)]
        pub fn scalar(x: f64, y: f64, z: f64) -> f64 {
            $scalar!(point(x, y, z))
        }

        #[target_feature(enable = $features)]
        pub fn vector(x: f64, y: f64, z: f64) -> DVec3 {
            three($vector!(point(x, y, z)))
        }

        /// The octaves of `noise::turbulence`, the point in one vector all the way.
        #[target_feature(enable = $features)]
        pub fn turbulence(x: f64, y: f64, z: f64, octaves: u32, omega: f32, lambda: f32, generator: u8) -> f64 {
            let p = point(x, y, z);
            let one = |v: f64| if generator > 1 { 2.0 * ranged(v, generator) - 0.5 } else { ranged(v, generator) };
            let (omega, lambda) = (f64::from(omega), f64::from(lambda));
            let (mut sum, mut l, mut o) = (0.0, 1.0, 1.0);
            // One place that asks for the lattice: two would be two calls.
            for octave in 0..octaves.max(1) {
                let v = one($scalar!(_mm256_mul_pd(p, _mm256_set1_pd(l))));
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
        #[target_feature(enable = $features)]
        pub fn turbulence_vector(x: f64, y: f64, z: f64, octaves: u32, omega: f32, lambda: f32) -> DVec3 {
            let p = point(x, y, z);
            let (omega, lambda) = (f64::from(omega), f64::from(lambda));
            // Nothing is added to -0: it leaves the sign of zeros alone.
            let (mut sum, mut l, mut o) = (_mm256_set1_pd(-0.0), 1.0, 1.0);
            for _ in 0..octaves.max(1) {
                let octave = $vector!(_mm256_mul_pd(p, _mm256_set1_pd(l)));
                sum = _mm256_add_pd(sum, _mm256_mul_pd(_mm256_set1_pd(o), octave));
                l *= lambda;
                o *= omega;
            }
            three(sum)
        }

        /// Values at a point times 1, 2, 4, ...
        #[target_feature(enable = $features)]
        pub fn doublings<const N: usize>(x: f64, y: f64, z: f64) -> [f64; N] {
            let mut out = [0.0; N];
            doubled(point(x, y, z), &mut out);
            out
        }

        /// Not part of its caller, which would unroll it into as many calls.
        #[target_feature(enable = $features)]
        #[inline(never)]
        fn doubled(mut p: __m256d, out: &mut [f64]) {
            for v in out {
                *v = $scalar!(p);
                p = _mm256_add_pd(p, p);
            }
        }
    };
}

/// Corner by corner: four numbers of a plane in the lanes.
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{DVec3, ranged};
    use crate::math::lattice::{CELL_BIAS, CELL_MASK, DOWN, ROWS, Row, VECTOR_ROWS, WideRow, corner_rows};
    use std::arch::x86_64::*;

    /// One load; four numbers set one by one are six instructions.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn load(r: &Row) -> __m256d {
        // SAFETY: four numbers are four numbers. The load instruction's own function checks its pointer in debug builds.
        unsafe { std::mem::transmute::<Row, __m256d>(*r) }
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn halves(r: &WideRow) -> [__m256d; 2] {
        // SAFETY: eight numbers are twice four.
        unsafe { std::mem::transmute::<WideRow, [__m256d; 2]>(*r) }
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn mix(t: __m256d, a: __m256d, b: __m256d) -> __m256d {
        _mm256_fmadd_pd(t, _mm256_sub_pd(b, a), a)
    }

    /// One axis of three in all lanes.
    macro_rules! lane {
        ($v:expr, $axis:literal) => {
            _mm256_permute4x64_pd::<{ 0b01_01_01_01 * ($axis + 1) }>($v)
        };
    }

    macro_rules! scalar_at {
        ($p:expr) => {{
            let (rows, place, share) = corners($p);
            let (sx, sy, sz) = (lane!(share, 0), lane!(share, 1), lane!(share, 2));
            // The lowest lane is 1, the others lead from the corner to the place.
            let way = |x: f64, y: f64, z: f64| _mm256_sub_pd(place, _mm256_set_pd(z, y, x, -1.0));
            let at = |k: usize, way: __m256d| _mm256_mul_pd(load(&ROWS[rows[k] & 255]), way);
            let (a, b) = (at(0, way(0.0, 0.0, 0.0)), at(1, way(1.0, 0.0, 0.0)));
            let (c, d) = (at(2, way(0.0, 1.0, 0.0)), at(3, way(1.0, 1.0, 0.0)));
            let low = mix(sy, mix(sx, a, b), mix(sx, c, d));
            let (a, b) = (at(4, way(0.0, 0.0, 1.0)), at(5, way(1.0, 0.0, 1.0)));
            let (c, d) = (at(6, way(0.0, 1.0, 1.0)), at(7, way(1.0, 1.0, 1.0)));
            let all = mix(sz, low, mix(sy, mix(sx, a, b), mix(sx, c, d)));
            let pair = _mm_add_pd(_mm256_castpd256_pd128(all), _mm256_extractf128_pd::<1>(all));
            _mm_cvtsd_f64(_mm_add_sd(pair, _mm_unpackhi_pd(pair, pair)))
        }};
    }

    macro_rules! vector_at {
        ($p:expr) => {{
            let (rows, place, share) = corners($p);
            let one = _mm256_set1_pd(1.0);
            let (x0, y0, z0) = (lane!(place, 0), lane!(place, 1), lane!(place, 2));
            let (x1, y1, z1) = (_mm256_sub_pd(x0, one), _mm256_sub_pd(y0, one), _mm256_sub_pd(z0, one));
            let (sx, sy, sz) = (lane!(share, 0), lane!(share, 1), lane!(share, 2));
            let at = |k: usize, x: __m256d, y: __m256d, z: __m256d| {
                let [va, bc] = &VECTOR_ROWS[rows[k] & 255];
                let ([v, a], [b, c]) = (halves(va), halves(bc));
                [_mm256_fmadd_pd(b, y, v), _mm256_fmadd_pd(c, z, _mm256_mul_pd(a, x))]
            };
            let mix2 = |t: __m256d, [a, c]: [__m256d; 2], [b, d]: [__m256d; 2]| [mix(t, a, b), mix(t, c, d)];
            let low = mix2(sy, mix2(sx, at(0, x0, y0, z0), at(1, x1, y0, z0)), mix2(sx, at(2, x0, y1, z0), at(3, x1, y1, z0)));
            let high = mix2(sy, mix2(sx, at(4, x0, y0, z1), at(5, x1, y0, z1)), mix2(sx, at(6, x0, y1, z1), at(7, x1, y1, z1)));
            let [first, second] = mix2(sz, low, high);
            _mm256_add_pd(first, second)
        }};
    }

    sums!("avx2,fma", scalar_at, vector_at);
}

/// Two corners at once, or all four numbers of a corner for three components.
#[cfg(target_arch = "x86_64")]
mod avx512 {
    use super::{DVec3, ranged};
    use crate::math::lattice::{CELL_BIAS, CELL_MASK, DOWN, ROWS, Row, VECTOR_ROWS, WideRow, corner_rows};
    use std::arch::x86_64::*;

    /// What is taken off a place for two corners that lie above each other: the lowest lanes become 1.
    const fn corner_pair(x: f64, y: f64) -> WideRow {
        WideRow([-1.0, x, y, 0.0, -1.0, x, y, 1.0])
    }
    static PAIRS: [WideRow; 4] = [corner_pair(0.0, 0.0), corner_pair(1.0, 0.0), corner_pair(0.0, 1.0), corner_pair(1.0, 1.0)];
    /// Makes 1, x, y, z, 1, x - 1, y - 1, z - 1 of a place.
    static ENDS: WideRow = WideRow([-1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 1.0, 1.0]);

    #[target_feature(enable = "avx2,fma,avx512f,avx512vl")]
    #[inline]
    fn load(r: &WideRow) -> __m512d {
        // SAFETY: eight numbers are eight numbers.
        unsafe { std::mem::transmute::<WideRow, __m512d>(*r) }
    }

    #[target_feature(enable = "avx2,fma,avx512f,avx512vl")]
    #[inline]
    fn two_rows(a: usize, b: usize) -> __m512d {
        // SAFETY: four numbers are four numbers.
        let [a, b] = [a, b].map(|k| unsafe { std::mem::transmute::<Row, __m256d>(ROWS[k & 255]) });
        _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(a), b)
    }

    #[target_feature(enable = "avx2,fma,avx512f,avx512vl")]
    #[inline]
    fn mix(t: __m512d, a: __m512d, b: __m512d) -> __m512d {
        _mm512_fmadd_pd(t, _mm512_sub_pd(b, a), a)
    }

    macro_rules! scalar_at {
        ($p:expr) => {{
            let (r, place, share) = corners($p);
            let (place, share) = (_mm512_broadcast_f64x4(place), _mm512_broadcast_f64x4(share));
            let (sx, sy) = (_mm512_permutex_pd::<0b01_01_01_01>(share), _mm512_permutex_pd::<0b10_10_10_10>(share));
            let sz = _mm256_permute4x64_pd::<0b11_11_11_11>(_mm512_castpd512_pd256(share));
            // Not a closure: one that is called twice is not made part of the loop.
            let a = _mm512_mul_pd(two_rows(r[0], r[4]), _mm512_sub_pd(place, load(&PAIRS[0])));
            let b = _mm512_mul_pd(two_rows(r[1], r[5]), _mm512_sub_pd(place, load(&PAIRS[1])));
            let c = _mm512_mul_pd(two_rows(r[2], r[6]), _mm512_sub_pd(place, load(&PAIRS[2])));
            let d = _mm512_mul_pd(two_rows(r[3], r[7]), _mm512_sub_pd(place, load(&PAIRS[3])));
            let both = mix(sy, mix(sx, a, b), mix(sx, c, d));
            let (low, high) = (_mm512_castpd512_pd256(both), _mm512_extractf64x4_pd::<1>(both));
            let all = _mm256_fmadd_pd(sz, _mm256_sub_pd(high, low), low);
            let pair = _mm_add_pd(_mm256_castpd256_pd128(all), _mm256_extractf128_pd::<1>(all));
            _mm_cvtsd_f64(_mm_add_sd(pair, _mm_unpackhi_pd(pair, pair)))
        }};
    }

    macro_rules! vector_at {
        ($p:expr) => {{
            let (r, place, share) = corners($p);
            let (place, share) = (_mm512_broadcast_f64x4(place), _mm512_broadcast_f64x4(share));
            let (sx, sy) = (_mm512_permutex_pd::<0b01_01_01_01>(share), _mm512_permutex_pd::<0b10_10_10_10>(share));
            let sz = _mm512_permutex_pd::<0b11_11_11_11>(share);
            let ends = _mm512_sub_pd(place, load(&ENDS));
            let pick = |a: i64, b: i64| _mm512_permutexvar_pd(_mm512_set_epi64(b, b, b, b, a, a, a, a), ends);
            let (x0, x1) = (pick(0, 1), pick(0, 5));
            let (y0z0, y1z0, y0z1, y1z1) = (pick(2, 3), pick(6, 3), pick(2, 7), pick(6, 7));
            let at = |k: usize, x: __m512d, yz: __m512d| {
                let [va, bc] = &VECTOR_ROWS[r[k] & 255];
                _mm512_fmadd_pd(load(bc), yz, _mm512_mul_pd(load(va), x))
            };
            let low = mix(sy, mix(sx, at(0, x0, y0z0), at(1, x1, y0z0)), mix(sx, at(2, x0, y1z0), at(3, x1, y1z0)));
            let high = mix(sy, mix(sx, at(4, x0, y0z1), at(5, x1, y0z1)), mix(sx, at(6, x0, y1z1), at(7, x1, y1z1)));
            let all = mix(sz, low, high);
            _mm256_add_pd(_mm512_castpd512_pd256(all), _mm512_extractf64x4_pd::<1>(all))
        }};
    }

    sums!("avx2,fma,avx512f,avx512vl", scalar_at, vector_at);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_twins_give_the_same_bits() {
        let same = |a: f64, b: f64, p: DVec3| assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{a} is not {b} at {p}");
        let odd = [0.0, -0.0, -1e-11, 1.0, -1.0, 4095.5, -1e5, 3e9, -3e9, f64::INFINITY, f64::NAN];
        let far = (0..11 * 11).map(|i| DVec3::new(odd[i % 11], odd[i / 11], odd[(i * 7) % 11]));
        let near = (0..20_000).map(|i| {
            let i = f64::from(i);
            DVec3::new(i * 0.0137 - 100.0, (i * 0.731).sin() * 50.0, 77.0 - i * 0.0091)
        });
        for p in far.chain(near) {
            same(lattice_scalar(p), lattice::scalar(p), p);
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
                // SAFETY: the processor has both. Where it has AVX-512 too, these are not what the others compare.
                let (a, v) = unsafe { (avx2::scalar(p.x, p.y, p.z), avx2::vector(p.x, p.y, p.z)) };
                same(a, lattice::scalar(p), p);
                (0..3).for_each(|k| same(v[k], lattice::vector(p)[k], p));
            }
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
