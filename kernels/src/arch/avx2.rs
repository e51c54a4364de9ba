//! AVX2 with FMA: 8 lanes in a register, 16 in two.

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

/// Token of AVX2; only [`crate::Kernels`] makes one, after detection.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(pub(crate) ());

impl Simd for Avx2 {
    const ISA: Isa = Isa::Avx2;

    #[inline(always)]
    fn prefetch<T>(self, target: *const T) {
        prefetch_lines(target);
    }

    #[inline(always)]
    fn apart<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: the token can only be had where its features were detected (see `Kernels::for_isa`).
        unsafe { crate::dispatch::avx2::apart(kernel) }
    }
}

/// For each set of lanes, the lanes in it from the lowest on: three bits each, the first in the lowest.
const FRONT: [u32; 256] = {
    let mut table = [0; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut lane, mut at) = (0, 0);
        while lane < 8 {
            if bits >> lane & 1 != 0 {
                table[bits] |= lane << at;
                at += 3;
            }
            lane += 1;
        }
        bits += 1;
    }
    table
};

lanes! { Avx2, 8, __m256, __m256i, __m256;
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
    lt(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_LT_OQ>(a, b);
    le(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
    select(m: __m256, a: __m256, b: __m256) -> __m256 = _mm256_blendv_ps(b, a, m);
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
    ieq(a: __m256i, b: __m256i) -> __m256 = _mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b));
    iselect(m: __m256, a: __m256i, b: __m256i) -> __m256i = _mm256_blendv_epi8(b, a, _mm256_castps_si256(m));
    ipermute(a: __m256i, from: __m256i) -> __m256i = _mm256_permutevar8x32_epi32(a, from);
    compress(bits: u32, a: __m256i, to: &mut [u32; 8]) = {
        // Only the three lowest bits of each lane count.
        let from = _mm256_set1_epi32(FRONT[(bits & 255) as usize] as i32);
        let from = _mm256_srlv_epi32(from, _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21));
        _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(a, from));
    };
    ishrv(a: __m256i, b: __m256i) -> __m256i = _mm256_srlv_epi32(a, b);
    to_float(a: __m256i) -> __m256 = _mm256_cvtepi32_ps(a);
    trunc(a: __m256) -> __m256i = _mm256_cvttps_epi32(a);
    mbits(m: __m256) -> u32 = _mm256_movemask_ps(m) as u32;
    mfrom(bits: u32) -> __m256 = {
        let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        let set = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lane);
        _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane))
    };
    mand(a: __m256, b: __m256) -> __m256 = _mm256_and_ps(a, b);
    mor(a: __m256, b: __m256) -> __m256 = _mm256_or_ps(a, b);
}

pair!(Avx2, 16, 8);
