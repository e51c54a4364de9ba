//! Vectors with operators, so that algorithms read like the mathematics.

use crate::simd::Lanes;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Sub};

/// `W` floats of the instruction set `S`.
#[derive(Clone, Copy)]
pub struct F32<S: Lanes<W>, const W: usize> {
    v: S::F,
    s: S,
}

/// `W` 32-bit integers of the instruction set `S`.
#[derive(Clone, Copy)]
pub struct I32<S: Lanes<W>, const W: usize> {
    v: S::I,
    s: S,
}

/// `W` truth values of the instruction set `S`.
#[derive(Clone, Copy)]
pub struct Mask<S: Lanes<W>, const W: usize> {
    v: S::M,
    s: S,
}

impl<S: Lanes<W>, const W: usize> F32<S, W> {
    /// All lanes `x`.
    #[inline(always)]
    pub fn splat(s: S, x: f32) -> Self {
        F32 { v: s.splat(x), s }
    }
    /// Lanes from memory.
    #[inline(always)]
    pub fn load(s: S, from: &[f32; W]) -> Self {
        F32 { v: s.load(from), s }
    }
    /// Lanes `at..at + W` of a slice.
    ///
    /// # Panics
    /// If the slice is shorter than that.
    #[inline(always)]
    pub fn load_at(s: S, from: &[f32], at: usize) -> Self {
        let lanes: &[f32; W] = from[at..at + W].try_into().expect("W lanes");
        F32 { v: s.load(lanes), s }
    }
    /// Lanes to memory.
    #[inline(always)]
    pub fn store(self, to: &mut [f32; W]) {
        self.s.store(self.v, to);
    }
    /// Lanes to `at..at + W` of a slice.
    ///
    /// # Panics
    /// If the slice is shorter than that.
    #[inline(always)]
    pub fn store_at(self, to: &mut [f32], at: usize) {
        let lanes: &mut [f32; W] = (&mut to[at..at + W]).try_into().expect("W lanes");
        self.s.store(self.v, lanes);
    }
    /// Lanes as an array.
    #[inline(always)]
    pub fn to_array(self) -> [f32; W] {
        let mut a = [0.0; W];
        self.store(&mut a);
        a
    }
    /// self * b + c, perhaps fused: for filters only.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        F32 { v: self.s.mul_add(self.v, b.v, c.v), s: self.s }
    }
    /// Lesser of the two; `o` if either is NaN.
    #[inline(always)]
    pub fn min(self, o: Self) -> Self {
        F32 { v: self.s.min(self.v, o.v), s: self.s }
    }
    /// Greater of the two; `o` if either is NaN.
    #[inline(always)]
    pub fn max(self, o: Self) -> Self {
        F32 { v: self.s.max(self.v, o.v), s: self.s }
    }
    /// The greater of the two magnitudes; unspecified if either is NaN.
    #[inline(always)]
    pub fn max_abs(self, o: Self) -> Self {
        F32 { v: self.s.max_abs(self.v, o.v), s: self.s }
    }
    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        F32 { v: self.s.sqrt(self.v), s: self.s }
    }
    /// The least lane; unspecified if one is NaN.
    #[inline(always)]
    pub fn reduce_min(self) -> f32 {
        self.s.reduce_min(self.v)
    }
    /// The least lane of each of four; unspecified if one is NaN.
    #[inline(always)]
    pub fn reduce_min4(s: S, a: [Self; 4]) -> [f32; 4] {
        s.reduce_min4([a[0].v, a[1].v, a[2].v, a[3].v])
    }
    /// The greatest lane; unspecified if one is NaN.
    #[inline(always)]
    pub fn reduce_max(self) -> f32 {
        -(-self).reduce_min()
    }
    /// Magnitude.
    #[inline(always)]
    pub fn abs(self) -> Self {
        (self.bits() & I32::splat(self.s, 0x7fff_ffff)).floats()
    }
    /// The sign bit of each lane, the other bits zero.
    #[inline(always)]
    pub fn sign(self) -> I32<S, W> {
        self.bits() & I32::splat(self.s, 0x8000_0000)
    }
    /// Flips the sign of the lanes whose sign bit is set in `sign`.
    #[inline(always)]
    pub fn flip(self, sign: I32<S, W>) -> Self {
        (self.bits() ^ sign).floats()
    }
    /// self < o
    #[inline(always)]
    pub fn lt(self, o: Self) -> Mask<S, W> {
        Mask { v: self.s.lt(self.v, o.v), s: self.s }
    }
    /// self <= o
    #[inline(always)]
    pub fn le(self, o: Self) -> Mask<S, W> {
        Mask { v: self.s.le(self.v, o.v), s: self.s }
    }
    /// The bits of the floats.
    #[inline(always)]
    pub fn bits(self) -> I32<S, W> {
        I32 { v: self.s.to_bits(self.v), s: self.s }
    }
    /// Signed integers, rounded towards zero.
    #[inline(always)]
    pub fn trunc(self) -> I32<S, W> {
        I32 { v: self.s.trunc(self.v), s: self.s }
    }
}

impl<S: Lanes<W>, const W: usize> I32<S, W> {
    /// All lanes `x`.
    #[inline(always)]
    pub fn splat(s: S, x: u32) -> Self {
        I32 { v: s.isplat(x), s }
    }
    /// Lanes from memory.
    #[inline(always)]
    pub fn load(s: S, from: &[u32; W]) -> Self {
        I32 { v: s.iload(from), s }
    }
    /// Lanes to memory.
    #[inline(always)]
    pub fn store(self, to: &mut [u32; W]) {
        self.s.istore(self.v, to);
    }
    /// The lanes whose bit is set, one after the other from the start of `to`; what is left of it is unspecified.
    #[inline(always)]
    pub fn compress(self, bits: u32, to: &mut [u32; W]) {
        self.s.compress(bits, self.v, to);
    }
    /// Shifted left by `N` bits.
    #[inline(always)]
    pub fn shl<const N: i32>(self) -> Self {
        I32 { v: self.s.ishl::<N>(self.v), s: self.s }
    }
    /// Shifted right by `N` bits, zeros shifted in.
    #[inline(always)]
    pub fn shr<const N: i32>(self) -> Self {
        I32 { v: self.s.ishr::<N>(self.v), s: self.s }
    }
    /// Each lane shifted right by the same lane of `o`, which is below 32.
    #[inline(always)]
    pub fn shr_by(self, o: Self) -> Self {
        I32 { v: self.s.ishrv(self.v, o.v), s: self.s }
    }
    /// Lane `i` = lane `from[i] % W`.
    #[inline(always)]
    pub fn permute(self, from: Self) -> Self {
        I32 { v: self.s.ipermute(self.v, from.v), s: self.s }
    }
    /// self == o
    #[inline(always)]
    pub fn eq(self, o: Self) -> Mask<S, W> {
        Mask { v: self.s.ieq(self.v, o.v), s: self.s }
    }
    /// Floats of these bits.
    #[inline(always)]
    pub fn floats(self) -> F32<S, W> {
        F32 { v: self.s.from_bits(self.v), s: self.s }
    }
    /// Signed integers as floats.
    #[inline(always)]
    pub fn to_float(self) -> F32<S, W> {
        F32 { v: self.s.to_float(self.v), s: self.s }
    }
}

impl<S: Lanes<W>, const W: usize> Mask<S, W> {
    /// Lane `i` = bit `i`.
    #[inline(always)]
    pub fn from_bits(s: S, bits: u32) -> Self {
        Mask { v: s.mfrom(bits), s }
    }
    /// Bit `i` = lane `i`.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.s.mbits(self.v)
    }
    /// `if lane { a } else { b }`
    #[inline(always)]
    pub fn select(self, a: F32<S, W>, b: F32<S, W>) -> F32<S, W> {
        F32 { v: self.s.select(self.v, a.v, b.v), s: self.s }
    }
    /// `if lane { a } else { b }`
    #[inline(always)]
    pub fn iselect(self, a: I32<S, W>, b: I32<S, W>) -> I32<S, W> {
        I32 { v: self.s.iselect(self.v, a.v, b.v), s: self.s }
    }
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $op:ident) => {
        impl<S: Lanes<W>, const W: usize> $trait for $type<S, W> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                $type { v: self.s.$op(self.v, o.v), s: self.s }
            }
        }
    };
}

operator!(F32, Add, add, add);
operator!(F32, Sub, sub, sub);
operator!(F32, Mul, mul, mul);
operator!(F32, Div, div, div);
operator!(I32, Add, add, iadd);
operator!(I32, Sub, sub, isub);
operator!(I32, BitAnd, bitand, iand);
operator!(I32, BitOr, bitor, ior);
operator!(I32, BitXor, bitxor, ixor);
operator!(Mask, BitAnd, bitand, mand);
operator!(Mask, BitOr, bitor, mor);

impl<S: Lanes<W>, const W: usize> Neg for F32<S, W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.flip(I32::splat(self.s, 0x8000_0000))
    }
}
