//! AVX-512 F, VL, DQ and BW: 16 lanes in a register; 8 lanes in half of one, with mask registers as well.

use super::{lanes, prefetch_lines};
use crate::{
    isa::Isa,
    simd::{Kernel, Simd},
};
use core::arch::x86_64::*;

/// Token of AVX-512; only [`crate::Kernels`] makes one, after detection.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(pub(crate) ());

impl Simd for Avx512 {
    const ISA: Isa = Isa::Avx512;

    #[inline(always)]
    fn prefetch<T>(self, target: *const T) {
        prefetch_lines(target);
    }

    #[inline(always)]
    fn apart<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: the token can only be had where its features were detected (see `Kernels::for_isa`).
        unsafe { crate::dispatch::avx512::apart(kernel) }
    }
}

lanes! { Avx512, 16, __m512, __m512i, __mmask16;
    splat(x: f32) -> __m512 = _mm512_set1_ps(x);
    load(from: &[f32; 16]) -> __m512 = core::mem::transmute::<[f32; 16], __m512>(*from);
    store(v: __m512, to: &mut [f32; 16]) = _mm512_storeu_ps(to.as_mut_ptr(), v);
    add(a: __m512, b: __m512) -> __m512 = _mm512_add_ps(a, b);
    sub(a: __m512, b: __m512) -> __m512 = _mm512_sub_ps(a, b);
    mul(a: __m512, b: __m512) -> __m512 = _mm512_mul_ps(a, b);
    div(a: __m512, b: __m512) -> __m512 = _mm512_div_ps(a, b);
    sqrt(a: __m512) -> __m512 = _mm512_sqrt_ps(a);
    mul_add(a: __m512, b: __m512, c: __m512) -> __m512 = _mm512_fmadd_ps(a, b, c);
    min(a: __m512, b: __m512) -> __m512 = _mm512_min_ps(a, b);
    max(a: __m512, b: __m512) -> __m512 = _mm512_max_ps(a, b);
    // Selects the greater magnitude (3) and clears its sign (2 << 2).
    max_abs(a: __m512, b: __m512) -> __m512 = _mm512_range_ps::<0b1011>(a, b);
    lt(a: __m512, b: __m512) -> __mmask16 = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b);
    le(a: __m512, b: __m512) -> __mmask16 = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b);
    select(m: __mmask16, a: __m512, b: __m512) -> __m512 = _mm512_mask_blend_ps(m, b, a);
    reduce_min(a: __m512) -> f32 = _mm512_reduce_min_ps(a);
    reduce_min4(a: [__m512; 4]) -> [f32; 4] = {
        // Quarters of two vectors, then of all four, side by side; each quarter ends up holding one vector's minimum.
        let ab = _mm512_min_ps(_mm512_shuffle_f32x4::<0x44>(a[0], a[1]), _mm512_shuffle_f32x4::<0xee>(a[0], a[1]));
        let cd = _mm512_min_ps(_mm512_shuffle_f32x4::<0x44>(a[2], a[3]), _mm512_shuffle_f32x4::<0xee>(a[2], a[3]));
        let four = _mm512_min_ps(_mm512_shuffle_f32x4::<0x88>(ab, cd), _mm512_shuffle_f32x4::<0xdd>(ab, cd));
        let two = _mm512_min_ps(four, _mm512_permute_ps::<0x4e>(four));
        let one = _mm512_min_ps(two, _mm512_permute_ps::<0xb1>(two));
        let first = _mm512_castps512_ps128(_mm512_maskz_compress_ps(0x1111, one));
        core::mem::transmute::<__m128, [f32; 4]>(first)
    };
    to_bits(a: __m512) -> __m512i = _mm512_castps_si512(a);
    from_bits(a: __m512i) -> __m512 = _mm512_castsi512_ps(a);
    isplat(x: u32) -> __m512i = _mm512_set1_epi32(x as i32);
    iload(from: &[u32; 16]) -> __m512i = _mm512_loadu_si512(from.as_ptr().cast());
    istore(v: __m512i, to: &mut [u32; 16]) = _mm512_storeu_si512(to.as_mut_ptr().cast(), v);
    iadd(a: __m512i, b: __m512i) -> __m512i = _mm512_add_epi32(a, b);
    isub(a: __m512i, b: __m512i) -> __m512i = _mm512_sub_epi32(a, b);
    iand(a: __m512i, b: __m512i) -> __m512i = _mm512_and_si512(a, b);
    ior(a: __m512i, b: __m512i) -> __m512i = _mm512_or_si512(a, b);
    ixor(a: __m512i, b: __m512i) -> __m512i = _mm512_xor_si512(a, b);
    ishl<const N>(a: __m512i) -> __m512i = _mm512_sll_epi32(a, _mm_cvtsi32_si128(N));
    ishr<const N>(a: __m512i) -> __m512i = _mm512_srl_epi32(a, _mm_cvtsi32_si128(N));
    ieq(a: __m512i, b: __m512i) -> __mmask16 = _mm512_cmpeq_epi32_mask(a, b);
    iselect(m: __mmask16, a: __m512i, b: __m512i) -> __m512i = _mm512_mask_blend_epi32(m, b, a);
    ipermute(a: __m512i, from: __m512i) -> __m512i = _mm512_permutexvar_epi32(from, a);
    ishrv(a: __m512i, b: __m512i) -> __m512i = _mm512_srlv_epi32(a, b);
    compress(bits: u32, a: __m512i, to: &mut [u32; 16]) =
        _mm512_storeu_si512(to.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(bits as __mmask16, a));
    to_float(a: __m512i) -> __m512 = _mm512_cvtepi32_ps(a);
    trunc(a: __m512) -> __m512i = _mm512_cvttps_epi32(a);
    mbits(m: __mmask16) -> u32 = u32::from(m);
    mfrom(bits: u32) -> __mmask16 = bits as __mmask16;
    mand(a: __mmask16, b: __mmask16) -> __mmask16 = a & b;
    mor(a: __mmask16, b: __mmask16) -> __mmask16 = a | b;
}

lanes! { Avx512, 8, __m256, __m256i, __mmask8;
    splat(x: f32) -> __m256 = _mm256_set1_ps(x);
    load(from: &[f32; 8]) -> __m256 = core::mem::transmute::<[f32; 8], __m256>(*from);
    store(v: __m256, to: &mut [f32; 8]) = _mm256_storeu_ps(to.as_mut_ptr(), v);
    add(a: __m256, b: __m256) -> __m256 = _mm256_add_ps(a, b);
    sub(a: __m256, b: __m256) -> __m256 = _mm256_sub_ps(a, b);
    mul(a: __m256, b: __m256) -> __m256 = _mm256_mul_ps(a, b);
    div(a: __m256, b: __m256) -> __m256 = _mm256_div_ps(a, b);
    sqrt(a: __m256) -> __m256 = _mm256_sqrt_ps(a);
    mul_add(a: __m256, b: __m256, c: __m256) -> __m256 = _mm256_fmadd_ps(a, b, c);
    min(a: __m256, b: __m256) -> __m256 = _mm256_min_ps(a, b);
    max(a: __m256, b: __m256) -> __m256 = _mm256_max_ps(a, b);
    // Selects the greater magnitude (3) and clears its sign (2 << 2).
    max_abs(a: __m256, b: __m256) -> __m256 = _mm256_range_ps::<0b1011>(a, b);
    lt(a: __m256, b: __m256) -> __mmask8 = _mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b);
    le(a: __m256, b: __m256) -> __mmask8 = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b);
    select(m: __mmask8, a: __m256, b: __m256) -> __m256 = _mm256_mask_blend_ps(m, b, a);
    reduce_min(a: __m256) -> f32 = {
        let four = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
        let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
        _mm_cvtss_f32(_mm_min_ss(two, _mm_shuffle_ps::<1>(two, two)))
    };
    to_bits(a: __m256) -> __m256i = _mm256_castps_si256(a);
    from_bits(a: __m256i) -> __m256 = _mm256_castsi256_ps(a);
    isplat(x: u32) -> __m256i = _mm256_set1_epi32(x as i32);
    iload(from: &[u32; 8]) -> __m256i = _mm256_loadu_si256(from.as_ptr().cast());
    istore(v: __m256i, to: &mut [u32; 8]) = _mm256_storeu_si256(to.as_mut_ptr().cast(), v);
    iadd(a: __m256i, b: __m256i) -> __m256i = _mm256_add_epi32(a, b);
    isub(a: __m256i, b: __m256i) -> __m256i = _mm256_sub_epi32(a, b);
    iand(a: __m256i, b: __m256i) -> __m256i = _mm256_and_si256(a, b);
    ior(a: __m256i, b: __m256i) -> __m256i = _mm256_or_si256(a, b);
    ixor(a: __m256i, b: __m256i) -> __m256i = _mm256_xor_si256(a, b);
    ishl<const N>(a: __m256i) -> __m256i = _mm256_slli_epi32::<N>(a);
    ishr<const N>(a: __m256i) -> __m256i = _mm256_srli_epi32::<N>(a);
    ieq(a: __m256i, b: __m256i) -> __mmask8 = _mm256_cmpeq_epi32_mask(a, b);
    iselect(m: __mmask8, a: __m256i, b: __m256i) -> __m256i = _mm256_mask_blend_epi32(m, b, a);
    ipermute(a: __m256i, from: __m256i) -> __m256i = _mm256_permutexvar_epi32(from, a);
    ishrv(a: __m256i, b: __m256i) -> __m256i = _mm256_srlv_epi32(a, b);
    compress(bits: u32, a: __m256i, to: &mut [u32; 8]) =
        _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(bits as __mmask8, a));
    to_float(a: __m256i) -> __m256 = _mm256_cvtepi32_ps(a);
    trunc(a: __m256) -> __m256i = _mm256_cvttps_epi32(a);
    mbits(m: __mmask8) -> u32 = u32::from(m);
    mfrom(bits: u32) -> __mmask8 = bits as __mmask8;
    mand(a: __mmask8, b: __mmask8) -> __mmask8 = a & b;
    mor(a: __mmask8, b: __mmask8) -> __mmask8 = a | b;
}
