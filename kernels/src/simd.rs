//! The vector interface: what an instruction set must offer for the generic algorithms to run on it.

use crate::isa::Isa;

/// One instruction set seen `W` lanes wide.
///
/// Implementations are zero-sized tokens. All methods are `#[inline(always)]`; none may be called through a function
/// pointer. Lane `i` of every operand meets lane `i` of the others. Rounding is to nearest even throughout.
pub trait Lanes<const W: usize>: Copy + 'static {
    /// `W` single-precision floats.
    type F: Copy;
    /// `W` 32-bit integers.
    type I: Copy;
    /// `W` truth values.
    type M: Copy;

    /// All lanes `x`.
    fn splat(self, x: f32) -> Self::F;
    /// Lanes from memory, no alignment needed.
    fn load(self, from: &[f32; W]) -> Self::F;
    /// Lanes to memory, no alignment needed.
    fn store(self, v: Self::F, to: &mut [f32; W]);
    /// a + b
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// a - b
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// a * b
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// a / b
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// Square root, correctly rounded.
    fn sqrt(self, a: Self::F) -> Self::F;
    /// a * b + c, fused where the instruction set fuses: for filters only.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// `if a < b { a } else { b }`: the second operand if either is NaN.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// `if a > b { a } else { b }`: the second operand if either is NaN.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// The greater of the two magnitudes; unspecified if either is NaN.
    #[inline(always)]
    fn max_abs(self, a: Self::F, b: Self::F) -> Self::F {
        let magnitude = self.isplat(0x7fff_ffff);
        let abs = |a| self.from_bits(self.iand(self.to_bits(a), magnitude));
        self.max(abs(a), abs(b))
    }
    /// a < b; false if either is NaN.
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    /// a <= b; false if either is NaN.
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    /// `if m { a } else { b }`
    fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// The least lane; unspecified if one is NaN.
    fn reduce_min(self, a: Self::F) -> f32;
    /// The least lane of each of four; unspecified if one is NaN.
    #[inline(always)]
    fn reduce_min4(self, a: [Self::F; 4]) -> [f32; 4] {
        [self.reduce_min(a[0]), self.reduce_min(a[1]), self.reduce_min(a[2]), self.reduce_min(a[3])]
    }
    /// The bits of each float.
    fn to_bits(self, a: Self::F) -> Self::I;
    /// Floats of these bits.
    fn from_bits(self, a: Self::I) -> Self::F;

    /// All lanes `x`.
    fn isplat(self, x: u32) -> Self::I;
    /// Lanes from memory, no alignment needed.
    fn iload(self, from: &[u32; W]) -> Self::I;
    /// Lanes to memory, no alignment needed.
    fn istore(self, v: Self::I, to: &mut [u32; W]);
    /// a + b, wrapping
    fn iadd(self, a: Self::I, b: Self::I) -> Self::I;
    /// a - b, wrapping
    fn isub(self, a: Self::I, b: Self::I) -> Self::I;
    /// a & b
    fn iand(self, a: Self::I, b: Self::I) -> Self::I;
    /// a | b
    fn ior(self, a: Self::I, b: Self::I) -> Self::I;
    /// a ^ b
    fn ixor(self, a: Self::I, b: Self::I) -> Self::I;
    /// a << N
    fn ishl<const N: i32>(self, a: Self::I) -> Self::I;
    /// a >> N, zeros shifted in
    fn ishr<const N: i32>(self, a: Self::I) -> Self::I;
    /// a == b
    fn ieq(self, a: Self::I, b: Self::I) -> Self::M;
    /// `if m { a } else { b }`
    fn iselect(self, m: Self::M, a: Self::I, b: Self::I) -> Self::I;
    /// Lane `i` = lane `from[i] % W` of `a`.
    #[inline(always)]
    fn ipermute(self, a: Self::I, from: Self::I) -> Self::I {
        let (mut lanes, mut at) = ([0; W], [0; W]);
        self.istore(a, &mut lanes);
        self.istore(from, &mut at);
        self.iload(&at.map(|lane| lanes[lane as usize % W]))
    }
    /// Each lane of a shifted right by the same lane of b, which is below 32.
    #[inline(always)]
    fn ishrv(self, a: Self::I, b: Self::I) -> Self::I {
        let (mut lanes, mut by) = ([0; W], [0; W]);
        self.istore(a, &mut lanes);
        self.istore(b, &mut by);
        for lane in 0..W {
            lanes[lane] >>= by[lane] & 31;
        }
        self.iload(&lanes)
    }
    /// The lanes whose bit is set, one after the other from the start of `to`; what is left of it is unspecified.
    #[inline(always)]
    fn compress(self, bits: u32, a: Self::I, to: &mut [u32; W]) {
        let mut lanes = [0; W];
        self.istore(a, &mut lanes);
        let (mut left, mut at) = (bits, 0);
        while left != 0 {
            to[at % W] = lanes[left.trailing_zeros() as usize % W];
            left &= left - 1;
            at += 1;
        }
    }
    /// Signed integer to float, rounding to nearest.
    fn to_float(self, a: Self::I) -> Self::F;
    /// Float to signed integer, rounding towards zero; values outside the range are unspecified.
    fn trunc(self, a: Self::F) -> Self::I;

    /// Bit `i` = lane `i`.
    fn mbits(self, m: Self::M) -> u32;
    /// Lane `i` = bit `i`.
    fn mfrom(self, bits: u32) -> Self::M;
    /// a & b
    fn mand(self, a: Self::M, b: Self::M) -> Self::M;
    /// a | b
    fn mor(self, a: Self::M, b: Self::M) -> Self::M;
}

/// An instruction set with the two widths that the algorithms use: 8 (children, triangles) and 16 (rays,
/// sub-packets).
pub trait Simd: Lanes<8> + Lanes<16> {
    /// Which one it is.
    const ISA: Isa;

    /// Asks for all cache lines of `target`, which need not exist; a hint.
    #[inline(always)]
    fn prefetch<T>(self, target: *const T) {
        let _ = target;
    }

    /// Runs what is rarely needed in a function of its own, so that it takes no registers from its caller.
    fn apart<K: Kernel>(self, kernel: K) -> K::Output;
}

/// A computation that is generic over the instruction set, run by [`crate::Kernels::run`].
///
/// `run` must be `#[inline(always)]`, and so must every generic function it calls.
pub trait Kernel {
    /// What it computes.
    type Output;
    /// Computes it with the instruction set of `s`.
    fn run<S: Simd>(self, s: S) -> Self::Output;
}
