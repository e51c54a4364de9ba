//! Portable lanes without intrinsics: the fallback of every machine and the reference of the others.

use crate::{
    isa::Isa,
    simd::{Kernel, Lanes, Simd},
};
use std::array::from_fn;

/// Token of the portable instruction set; exists everywhere.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;

impl Simd for Scalar {
    const ISA: Isa = Isa::Scalar;

    #[inline(always)]
    fn apart<K: Kernel>(self, kernel: K) -> K::Output {
        crate::dispatch::scalar::apart(kernel)
    }
}

const fn truth(b: bool) -> u32 {
    if b { u32::MAX } else { 0 }
}

impl<const W: usize> Lanes<W> for Scalar {
    type F = [f32; W];
    type I = [u32; W];
    type M = [u32; W];

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; W] {
        [x; W]
    }
    #[inline(always)]
    fn load(self, from: &[f32; W]) -> [f32; W] {
        *from
    }
    #[inline(always)]
    fn store(self, v: [f32; W], to: &mut [f32; W]) {
        *to = v;
    }
    #[inline(always)]
    fn add(self, a: [f32; W], b: [f32; W]) -> [f32; W] {
        from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub(self, a: [f32; W], b: [f32; W]) -> [f32; W] {
        from_fn(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul(self, a: [f32; W], b: [f32; W]) -> [f32; W] {
        from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn div(self, a: [f32; W], b: [f32; W]) -> [f32; W] {
        from_fn(|i| a[i] / b[i])
    }
    #[inline(always)]
    fn sqrt(self, a: [f32; W]) -> [f32; W] {
        from_fn(|i| a[i].sqrt())
    }
    #[inline(always)]
    fn mul_add(self, a: [f32; W], b: [f32; W], c: [f32; W]) -> [f32; W] {
        from_fn(|i| a[i] * b[i] + c[i])
    }
    #[inline(always)]
    fn min(self, a: [f32; W], b: [f32; W]) -> [f32; W] {
        from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max(self, a: [f32; W], b: [f32; W]) -> [f32; W] {
        from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn lt(self, a: [f32; W], b: [f32; W]) -> [u32; W] {
        from_fn(|i| truth(a[i] < b[i]))
    }
    #[inline(always)]
    fn le(self, a: [f32; W], b: [f32; W]) -> [u32; W] {
        from_fn(|i| truth(a[i] <= b[i]))
    }
    #[inline(always)]
    fn select(self, m: [u32; W], a: [f32; W], b: [f32; W]) -> [f32; W] {
        from_fn(|i| if m[i] != 0 { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn reduce_min(self, a: [f32; W]) -> f32 {
        let mut least = a[0];
        for x in a {
            least = if x < least { x } else { least };
        }
        least
    }
    #[inline(always)]
    fn to_bits(self, a: [f32; W]) -> [u32; W] {
        from_fn(|i| a[i].to_bits())
    }
    #[inline(always)]
    fn from_bits(self, a: [u32; W]) -> [f32; W] {
        from_fn(|i| f32::from_bits(a[i]))
    }
    #[inline(always)]
    fn isplat(self, x: u32) -> [u32; W] {
        [x; W]
    }
    #[inline(always)]
    fn iload(self, from: &[u32; W]) -> [u32; W] {
        *from
    }
    #[inline(always)]
    fn istore(self, v: [u32; W], to: &mut [u32; W]) {
        *to = v;
    }
    #[inline(always)]
    fn iadd(self, a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i].wrapping_add(b[i]))
    }
    #[inline(always)]
    fn isub(self, a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i].wrapping_sub(b[i]))
    }
    #[inline(always)]
    fn iand(self, a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i] & b[i])
    }
    #[inline(always)]
    fn ior(self, a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i] | b[i])
    }
    #[inline(always)]
    fn ixor(self, a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i] ^ b[i])
    }
    #[inline(always)]
    fn ishl<const N: i32>(self, a: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i] << N)
    }
    #[inline(always)]
    fn ishr<const N: i32>(self, a: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i] >> N)
    }
    #[inline(always)]
    fn ieq(self, a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| truth(a[i] == b[i]))
    }
    #[inline(always)]
    fn iselect(self, m: [u32; W], a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| if m[i] != 0 { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn to_float(self, a: [u32; W]) -> [f32; W] {
        from_fn(|i| a[i] as i32 as f32)
    }
    #[inline(always)]
    fn trunc(self, a: [f32; W]) -> [u32; W] {
        from_fn(|i| a[i] as i32 as u32)
    }
    #[inline(always)]
    fn mbits(self, m: [u32; W]) -> u32 {
        let mut bits = 0;
        for (i, lane) in m.iter().enumerate() {
            bits |= (lane & 1) << i;
        }
        bits
    }
    #[inline(always)]
    fn mfrom(self, bits: u32) -> [u32; W] {
        from_fn(|i| truth(bits >> i & 1 != 0))
    }
    #[inline(always)]
    fn mand(self, a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i] & b[i])
    }
    #[inline(always)]
    fn mor(self, a: [u32; W], b: [u32; W]) -> [u32; W] {
        from_fn(|i| a[i] | b[i])
    }
}
