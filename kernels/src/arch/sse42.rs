//! SSE4.2: 4 lanes in a register, 8 in two, 16 in four.

use super::{
    lanes,
    pair::{halves, halves_mut, pair},
    prefetch_lines,
};
use crate::{
    isa::Isa,
    simd::{Kernel, Simd},
};
use core::arch::x86_64::*;

/// Token of SSE4.2; only [`crate::Kernels`] makes one, after detection.
#[derive(Clone, Copy)]
pub(crate) struct Sse42(pub(crate) ());

impl Simd for Sse42 {
    const ISA: Isa = Isa::Sse42;

    #[inline(always)]
    fn prefetch<T>(self, target: *const T) {
        prefetch_lines(target);
    }

    #[inline(always)]
    fn apart<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: the token can only be had where its features were detected (see `Kernels::for_isa`).
        unsafe { crate::dispatch::sse42::apart(kernel) }
    }
}

lanes! { Sse42, 4, __m128, __m128i, __m128;
    splat(x: f32) -> __m128 = _mm_set1_ps(x);
    load(from: &[f32; 4]) -> __m128 = core::mem::transmute::<[f32; 4], __m128>(*from);
    store(v: __m128, to: &mut [f32; 4]) = _mm_storeu_ps(to.as_mut_ptr(), v);
    add(a: __m128, b: __m128) -> __m128 = _mm_add_ps(a, b);
    sub(a: __m128, b: __m128) -> __m128 = _mm_sub_ps(a, b);
    mul(a: __m128, b: __m128) -> __m128 = _mm_mul_ps(a, b);
    div(a: __m128, b: __m128) -> __m128 = _mm_div_ps(a, b);
    sqrt(a: __m128) -> __m128 = _mm_sqrt_ps(a);
    mul_add(a: __m128, b: __m128, c: __m128) -> __m128 = _mm_add_ps(_mm_mul_ps(a, b), c);
    min(a: __m128, b: __m128) -> __m128 = _mm_min_ps(a, b);
    max(a: __m128, b: __m128) -> __m128 = _mm_max_ps(a, b);
    lt(a: __m128, b: __m128) -> __m128 = _mm_cmplt_ps(a, b);
    le(a: __m128, b: __m128) -> __m128 = _mm_cmple_ps(a, b);
    select(m: __m128, a: __m128, b: __m128) -> __m128 = _mm_blendv_ps(b, a, m);
    reduce_min(a: __m128) -> f32 = {
        let two = _mm_min_ps(a, _mm_movehl_ps(a, a));
        _mm_cvtss_f32(_mm_min_ss(two, _mm_shuffle_ps::<1>(two, two)))
    };
    to_bits(a: __m128) -> __m128i = _mm_castps_si128(a);
    from_bits(a: __m128i) -> __m128 = _mm_castsi128_ps(a);
    isplat(x: u32) -> __m128i = _mm_set1_epi32(x as i32);
    iload(from: &[u32; 4]) -> __m128i = _mm_loadu_si128(from.as_ptr().cast());
    istore(v: __m128i, to: &mut [u32; 4]) = _mm_storeu_si128(to.as_mut_ptr().cast(), v);
    iadd(a: __m128i, b: __m128i) -> __m128i = _mm_add_epi32(a, b);
    isub(a: __m128i, b: __m128i) -> __m128i = _mm_sub_epi32(a, b);
    iand(a: __m128i, b: __m128i) -> __m128i = _mm_and_si128(a, b);
    ior(a: __m128i, b: __m128i) -> __m128i = _mm_or_si128(a, b);
    ixor(a: __m128i, b: __m128i) -> __m128i = _mm_xor_si128(a, b);
    ishl<const N>(a: __m128i) -> __m128i = _mm_slli_epi32::<N>(a);
    ishr<const N>(a: __m128i) -> __m128i = _mm_srli_epi32::<N>(a);
    ieq(a: __m128i, b: __m128i) -> __m128 = _mm_castsi128_ps(_mm_cmpeq_epi32(a, b));
    iselect(m: __m128, a: __m128i, b: __m128i) -> __m128i = _mm_blendv_epi8(b, a, _mm_castps_si128(m));
    to_float(a: __m128i) -> __m128 = _mm_cvtepi32_ps(a);
    trunc(a: __m128) -> __m128i = _mm_cvttps_epi32(a);
    mbits(m: __m128) -> u32 = _mm_movemask_ps(m) as u32;
    mfrom(bits: u32) -> __m128 = {
        let lane = _mm_setr_epi32(1, 2, 4, 8);
        let set = _mm_and_si128(_mm_set1_epi32(bits as i32), lane);
        _mm_castsi128_ps(_mm_cmpeq_epi32(set, lane))
    };
    mand(a: __m128, b: __m128) -> __m128 = _mm_and_ps(a, b);
    mor(a: __m128, b: __m128) -> __m128 = _mm_or_ps(a, b);
}

pair!(Sse42, 8, 4);
pair!(Sse42, 16, 8);
