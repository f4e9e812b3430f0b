//! Several numbers at once: AVX2 where the processor has it, else plain arrays that give the same numbers to the last bit (nothing is
//! fused but in `noise`, by both). The module with `unsafe` for the processor's instructions.
//!
//! A [`Kernel`] is written once, over a [`Simd`], and compiled for both; [`run`] takes the one that the processor can do. All of it that
//! is `#[inline(always)]` is compiled for AVX2 too.
#![allow(unsafe_code)]

pub(crate) mod kernels;
pub(in crate::math) mod noise;

/// Work that is compiled for each kind of processor.
pub trait Kernel {
    /// What it gives.
    type Output;
    /// Does it. Implementations are `#[inline(always)]`.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Whether the processor has more than plain arrays.
#[inline]
pub fn is_wide() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Does `kernel` with the widest instructions here. Always inlined: a kernel handed on is copied, and numbers just stored one by one are waited for
/// when they are loaded side by side.
#[inline(always)]
pub fn run<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        return unsafe { avx2::run(kernel) };
    }
    kernel.run(Portable)
}

/// As [`run`], with AVX-512 where the processor has it: for kernels that use lanes of eight double-precision numbers.
#[inline(always)]
pub fn run_widest<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl") && is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2 and the two parts of AVX-512.
        return unsafe { avx512::run(kernel) };
    }
    run(kernel)
}

/// The processor's lanes. Comparisons give a bit a lane, the first lowest; what is compared with NaN is false.
/// `min` and `max` give `b` where either is NaN; of two zeros the sign is not said (compilers pick either for plain arrays).
#[expect(missing_docs, reason = "the names say it")]
pub trait Simd: Copy {
    type F32x8: Copy;
    type F64x4: Copy;
    type F64x8: Copy;

    fn splat_f32(self, v: f32) -> Self::F32x8;
    fn load_f32(self, v: &[f32; 8]) -> Self::F32x8;
    fn array_f32(self, v: Self::F32x8) -> [f32; 8];
    fn add_f32(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn sub_f32(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn mul_f32(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn min_f32(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn max_f32(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn div_f32(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn sqrt_f32(self, a: Self::F32x8) -> Self::F32x8;
    fn copysign_f32(self, a: Self::F32x8, sign: Self::F32x8) -> Self::F32x8;
    /// Lanes of `a` where `mask` has a bit, else of `b`.
    fn select_f32(self, mask: u32, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn le_f32(self, a: Self::F32x8, b: Self::F32x8) -> u32;

    fn splat(self, v: f64) -> Self::F64x4;
    fn widen(self, v: &[f32; 4]) -> Self::F64x4;
    fn array(self, v: Self::F64x4) -> [f64; 4];
    fn add(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn sub(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn mul(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn min(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn max(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn div(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn lt(self, a: Self::F64x4, b: Self::F64x4) -> u32;

    fn splat_x8(self, v: f64) -> Self::F64x8;
    fn load_x8(self, v: &[f64; 8]) -> Self::F64x8;
    fn array_x8(self, v: Self::F64x8) -> [f64; 8];
    fn add_x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn sub_x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn mul_x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn min_x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn max_x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn div_x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn lt_x8(self, a: Self::F64x8, b: Self::F64x8) -> u32;
    fn narrow_x8(self, a: Self::F64x8) -> Self::F32x8;
    /// As `select_f32`.
    fn select_x8(self, mask: u32, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
}

/// Arrays.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

#[inline(always)]
fn zip<T: Copy, const N: usize>(a: [T; N], b: [T; N], f: impl Fn(T, T) -> T) -> [T; N] {
    std::array::from_fn(|l| f(a[l], b[l]))
}

#[inline(always)]
fn bits<T: Copy, const N: usize>(a: [T; N], b: [T; N], f: impl Fn(T, T) -> bool) -> u32 {
    (0..N).fold(0, |m, l| m | u32::from(f(a[l], b[l])) << l)
}

// Operations of two arrays, lane by lane.
macro_rules! lane_by_lane {
    ($($name:ident: $lanes:ty = $f:expr;)*) => {
        $(
            #[inline(always)]
            fn $name(self, a: $lanes, b: $lanes) -> $lanes {
                zip(a, b, $f)
            }
        )*
    };
}

impl Simd for Portable {
    type F32x8 = [f32; 8];
    type F64x4 = [f64; 4];
    type F64x8 = [f64; 8];

    lane_by_lane! {
        add_f32: [f32; 8] = |a, b| a + b;
        sub_f32: [f32; 8] = |a, b| a - b;
        mul_f32: [f32; 8] = |a, b| a * b;
        min_f32: [f32; 8] = |a, b| if a < b { a } else { b };
        max_f32: [f32; 8] = |a, b| if a > b { a } else { b };
        div_f32: [f32; 8] = |a, b| a / b;
        add: [f64; 4] = |a, b| a + b;
        sub: [f64; 4] = |a, b| a - b;
        mul: [f64; 4] = |a, b| a * b;
        min: [f64; 4] = |a, b| if a < b { a } else { b };
        max: [f64; 4] = |a, b| if a > b { a } else { b };
        div: [f64; 4] = |a, b| a / b;
        add_x8: [f64; 8] = |a, b| a + b;
        sub_x8: [f64; 8] = |a, b| a - b;
        mul_x8: [f64; 8] = |a, b| a * b;
        min_x8: [f64; 8] = |a, b| if a < b { a } else { b };
        max_x8: [f64; 8] = |a, b| if a > b { a } else { b };
        div_x8: [f64; 8] = |a, b| a / b;
    }

    #[inline(always)]
    fn splat_f32(self, v: f32) -> [f32; 8] {
        [v; 8]
    }
    #[inline(always)]
    fn load_f32(self, v: &[f32; 8]) -> [f32; 8] {
        *v
    }
    #[inline(always)]
    fn array_f32(self, v: [f32; 8]) -> [f32; 8] {
        v
    }
    #[inline(always)]
    fn sqrt_f32(self, a: [f32; 8]) -> [f32; 8] {
        a.map(f32::sqrt)
    }
    #[inline(always)]
    fn copysign_f32(self, a: [f32; 8], sign: [f32; 8]) -> [f32; 8] {
        zip(a, sign, f32::copysign)
    }
    #[inline(always)]
    fn select_f32(self, mask: u32, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|l| if mask >> l & 1 == 1 { a[l] } else { b[l] })
    }
    #[inline(always)]
    fn le_f32(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        bits(a, b, |a, b| a <= b)
    }
    #[inline(always)]
    fn splat(self, v: f64) -> [f64; 4] {
        [v; 4]
    }
    #[inline(always)]
    fn widen(self, v: &[f32; 4]) -> [f64; 4] {
        v.map(f64::from)
    }
    #[inline(always)]
    fn array(self, v: [f64; 4]) -> [f64; 4] {
        v
    }
    #[inline(always)]
    fn lt(self, a: [f64; 4], b: [f64; 4]) -> u32 {
        bits(a, b, |a, b| a < b)
    }
    #[inline(always)]
    fn splat_x8(self, v: f64) -> [f64; 8] {
        [v; 8]
    }
    #[inline(always)]
    fn load_x8(self, v: &[f64; 8]) -> [f64; 8] {
        *v
    }
    #[inline(always)]
    fn array_x8(self, v: [f64; 8]) -> [f64; 8] {
        v
    }
    #[inline(always)]
    fn lt_x8(self, a: [f64; 8], b: [f64; 8]) -> u32 {
        bits(a, b, |a, b| a < b)
    }
    #[inline(always)]
    fn narrow_x8(self, a: [f64; 8]) -> [f32; 8] {
        a.map(|v| v as f32)
    }
    #[inline(always)]
    fn select_x8(self, mask: u32, a: [f64; 8], b: [f64; 8]) -> [f64; 8] {
        std::array::from_fn(|l| if mask >> l & 1 == 1 { a[l] } else { b[l] })
    }
}

// Intrinsics on values, and loads and stores of whole arrays, behind a proof that the processor has them.
#[cfg(target_arch = "x86_64")]
macro_rules! operations {
    ($($name:ident($($arg:ident: $kind:ty),*) -> $result:ty { $body:expr })*) => {
        $(
            #[inline(always)]
            fn $name(self, $($arg: $kind),*) -> $result {
                // SAFETY: the processor has what the proof (`self`) says; arrays are as long as what is loaded or stored.
                unsafe { $body }
            }
        )*
    };
}

/// The lanes of AVX2, which AVX-512 has too.
#[cfg(target_arch = "x86_64")]
macro_rules! lanes_of_avx2 {
    () => {
        type F32x8 = __m256;
        type F64x4 = __m256d;

        operations! {
            splat_f32(v: f32) -> __m256 { _mm256_set1_ps(v) }
            load_f32(v: &[f32; 8]) -> __m256 { _mm256_loadu_ps(v.as_ptr()) }
            array_f32(v: __m256) -> [f32; 8] { std::mem::transmute::<__m256, [f32; 8]>(v) }
            add_f32(a: __m256, b: __m256) -> __m256 { _mm256_add_ps(a, b) }
            sub_f32(a: __m256, b: __m256) -> __m256 { _mm256_sub_ps(a, b) }
            mul_f32(a: __m256, b: __m256) -> __m256 { _mm256_mul_ps(a, b) }
            min_f32(a: __m256, b: __m256) -> __m256 { _mm256_min_ps(a, b) }
            max_f32(a: __m256, b: __m256) -> __m256 { _mm256_max_ps(a, b) }
            div_f32(a: __m256, b: __m256) -> __m256 { _mm256_div_ps(a, b) }
            sqrt_f32(a: __m256) -> __m256 { _mm256_sqrt_ps(a) }
            copysign_f32(a: __m256, sign: __m256) -> __m256 {
                _mm256_or_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.0), a), _mm256_and_ps(_mm256_set1_ps(-0.0), sign))
            }
            le_f32(a: __m256, b: __m256) -> u32 { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32 }
            select_f32(mask: u32, a: __m256, b: __m256) -> __m256 {
                _mm256_blendv_ps(b, a, _mm256_castsi256_ps(_mm256_sllv_epi32(_mm256_set1_epi32(mask as i32), _mm256_setr_epi32(31, 30, 29, 28, 27, 26, 25, 24))))
            }
            splat(v: f64) -> __m256d { _mm256_set1_pd(v) }
            widen(v: &[f32; 4]) -> __m256d { _mm256_cvtps_pd(_mm_loadu_ps(v.as_ptr())) }
            array(v: __m256d) -> [f64; 4] { std::mem::transmute::<__m256d, [f64; 4]>(v) }
            add(a: __m256d, b: __m256d) -> __m256d { _mm256_add_pd(a, b) }
            sub(a: __m256d, b: __m256d) -> __m256d { _mm256_sub_pd(a, b) }
            mul(a: __m256d, b: __m256d) -> __m256d { _mm256_mul_pd(a, b) }
            min(a: __m256d, b: __m256d) -> __m256d { _mm256_min_pd(a, b) }
            max(a: __m256d, b: __m256d) -> __m256d { _mm256_max_pd(a, b) }
            div(a: __m256d, b: __m256d) -> __m256d { _mm256_div_pd(a, b) }
            lt(a: __m256d, b: __m256d) -> u32 { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)) as u32 }
        }
    };
}
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Kernel, Simd};
    use std::arch::x86_64::*;

    /// Proof that the processor has AVX2: only [`run`] makes one.
    #[derive(Clone, Copy)]
    pub struct Avx2(());

    /// All of the kernel, for AVX2.
    #[target_feature(enable = "avx2")]
    pub fn run<K: Kernel>(kernel: K) -> K::Output {
        kernel.run(Avx2(()))
    }

    impl Simd for Avx2 {
        type F64x8 = [__m256d; 2];

        lanes_of_avx2!();
        operations! {
            splat_x8(v: f64) -> [__m256d; 2] { [_mm256_set1_pd(v); 2] }
            load_x8(v: &[f64; 8]) -> [__m256d; 2] { std::mem::transmute::<[f64; 8], [__m256d; 2]>(*v) }
            array_x8(v: [__m256d; 2]) -> [f64; 8] { std::mem::transmute::<[__m256d; 2], [f64; 8]>(v) }
            add_x8(a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] { [_mm256_add_pd(a[0], b[0]), _mm256_add_pd(a[1], b[1])] }
            sub_x8(a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] { [_mm256_sub_pd(a[0], b[0]), _mm256_sub_pd(a[1], b[1])] }
            mul_x8(a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] { [_mm256_mul_pd(a[0], b[0]), _mm256_mul_pd(a[1], b[1])] }
            min_x8(a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] { [_mm256_min_pd(a[0], b[0]), _mm256_min_pd(a[1], b[1])] }
            max_x8(a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] { [_mm256_max_pd(a[0], b[0]), _mm256_max_pd(a[1], b[1])] }
            div_x8(a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] { [_mm256_div_pd(a[0], b[0]), _mm256_div_pd(a[1], b[1])] }
            lt_x8(a: [__m256d; 2], b: [__m256d; 2]) -> u32 {
                (_mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a[0], b[0])) | _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a[1], b[1])) << 4) as u32
            }
            select_x8(mask: u32, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
                [
                    _mm256_blendv_pd(b[0], a[0], _mm256_castsi256_pd(_mm256_sllv_epi64(_mm256_set1_epi64x(mask.into()), _mm256_setr_epi64x(63, 62, 61, 60)))),
                    _mm256_blendv_pd(b[1], a[1], _mm256_castsi256_pd(_mm256_sllv_epi64(_mm256_set1_epi64x(mask.into()), _mm256_setr_epi64x(59, 58, 57, 56)))),
                ]
            }
            narrow_x8(a: [__m256d; 2]) -> __m256 { _mm256_set_m128(_mm256_cvtpd_ps(a[1]), _mm256_cvtpd_ps(a[0])) }
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx512;

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation on two sets of numbers, as bits.
    struct All([f32; 8], [f32; 8]);

    impl Kernel for All {
        type Output = Vec<u64>;
        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> Vec<u64> {
            let (a, b) = (s.load_f32(&self.0), s.load_f32(&self.1));
            let mut out = vec![s.le_f32(a, b).into()];
            for v in [
                s.add_f32(a, b),
                s.sub_f32(a, b),
                s.mul_f32(a, b),
                s.div_f32(a, b),
                s.sqrt_f32(a),
                s.copysign_f32(a, b),
                s.select_f32(0b1001_1010, a, b),
                s.splat_f32(self.0[3]),
            ] {
                out.extend(s.array_f32(v).map(|v| if v.is_nan() { 1 } else { u64::from(v.to_bits()) }));
            }
            // Adding 0 makes both zeros one.
            for v in [s.min_f32(a, b), s.max_f32(a, b)] {
                out.extend(s.array_f32(v).map(|v| if v.is_nan() { 1 } else { u64::from((v + 0.0).to_bits()) }));
            }
            let half = |v: [f32; 8]| s.widen(&[v[0], v[1], v[2], v[3]]);
            let (a, b) = (half(self.0), half(self.1));
            out.push(s.lt(a, b).into());
            for v in [s.add(a, b), s.sub(a, b), s.mul(a, b), s.div(a, b), s.splat(self.0[3].into())] {
                out.extend(s.array(v).map(|v| if v.is_nan() { 1 } else { v.to_bits() }));
            }
            for v in [s.min(a, b), s.max(a, b)] {
                out.extend(s.array(v).map(|v| if v.is_nan() { 1 } else { (v + 0.0).to_bits() }));
            }
            let (a, b) = (s.load_x8(&self.0.map(f64::from)), s.load_x8(&self.1.map(f64::from)));
            out.push(s.lt_x8(a, b).into());
            for v in [
                s.add_x8(a, b),
                s.sub_x8(a, b),
                s.mul_x8(a, b),
                s.div_x8(a, b),
                s.select_x8(0b1001_1010, a, b),
                s.splat_x8(self.0[3].into()),
            ] {
                out.extend(s.array_x8(v).map(|v| if v.is_nan() { 1 } else { v.to_bits() }));
            }
            out.extend(s.array_f32(s.narrow_x8(s.mul_x8(a, s.splat_x8(1.1)))).map(|v| if v.is_nan() { 1 } else { u64::from(v.to_bits()) }));
            for v in [s.min_x8(a, b), s.max_x8(a, b)] {
                out.extend(s.array_x8(v).map(|v| if v.is_nan() { 1 } else { (v + 0.0).to_bits() }));
            }
            out
        }
    }

    #[test]
    fn wide_instructions_give_the_numbers_of_plain_arrays() {
        let odd = [0.0, -0.0, 1.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-45, -2.5];
        for shift in 0..8 {
            let mut other = odd;
            other.rotate_left(shift);
            assert_eq!(run(All(odd, other)), All(odd, other).run(Portable), "shift {shift}");
            assert_eq!(run_widest(All(odd, other)), All(odd, other).run(Portable), "widest, shift {shift}");
        }
    }
}
