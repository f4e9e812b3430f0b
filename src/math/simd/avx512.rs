//! Eight double-precision lanes in one register of AVX-512; lanes of four and of single precision are AVX2's.

use super::{Kernel, Simd};
use std::arch::x86_64::*;

/// Proof that the processor has AVX2 and AVX-512 with its shorter vectors: only [`run`] makes one.
#[derive(Clone, Copy)]
pub struct Avx512(());

/// All of the kernel, for AVX-512.
#[target_feature(enable = "avx2,avx512f,avx512vl")]
pub fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx512(()))
}

impl Simd for Avx512 {
    type F64x8 = __m512d;

    lanes_of_avx2!();
    operations! {
        splat_x8(v: f64) -> __m512d { _mm512_set1_pd(v) }
        load_x8(v: &[f64; 8]) -> __m512d { std::mem::transmute::<[f64; 8], __m512d>(*v) }
        array_x8(v: __m512d) -> [f64; 8] { std::mem::transmute::<__m512d, [f64; 8]>(v) }
        add_x8(a: __m512d, b: __m512d) -> __m512d { _mm512_add_pd(a, b) }
        sub_x8(a: __m512d, b: __m512d) -> __m512d { _mm512_sub_pd(a, b) }
        mul_x8(a: __m512d, b: __m512d) -> __m512d { _mm512_mul_pd(a, b) }
        min_x8(a: __m512d, b: __m512d) -> __m512d { _mm512_min_pd(a, b) }
        max_x8(a: __m512d, b: __m512d) -> __m512d { _mm512_max_pd(a, b) }
        div_x8(a: __m512d, b: __m512d) -> __m512d { _mm512_div_pd(a, b) }
        lt_x8(a: __m512d, b: __m512d) -> u32 { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b).into() }
        select_x8(mask: u32, a: __m512d, b: __m512d) -> __m512d { _mm512_mask_blend_pd(mask as u8, b, a) }
        narrow_x8(a: __m512d) -> __m256 { _mm512_cvtpd_ps(a) }
    }
}
