//! Lanes twice as wide as another: two registers side by side, operation by operation.

/// Implements [`crate::Lanes`]`<$w>` for a token by pairs of its [`crate::Lanes`]`<$h>`.
macro_rules! pair {
    ($token:ty, $w:literal, $h:literal) => {
        impl crate::simd::Lanes<$w> for $token {
            type F = [<Self as crate::simd::Lanes<$h>>::F; 2];
            type I = [<Self as crate::simd::Lanes<$h>>::I; 2];
            type M = [<Self as crate::simd::Lanes<$h>>::M; 2];

            crate::arch::pair::pair_methods! { $w, $h;
                splat(x: f32 => same) -> F;
                add(a: F => part, b: F => part) -> F;
                sub(a: F => part, b: F => part) -> F;
                mul(a: F => part, b: F => part) -> F;
                div(a: F => part, b: F => part) -> F;
                sqrt(a: F => part) -> F;
                mul_add(a: F => part, b: F => part, c: F => part) -> F;
                min(a: F => part, b: F => part) -> F;
                max(a: F => part, b: F => part) -> F;
                lt(a: F => part, b: F => part) -> M;
                le(a: F => part, b: F => part) -> M;
                select(m: M => part, a: F => part, b: F => part) -> F;
                to_bits(a: F => part) -> I;
                from_bits(a: I => part) -> F;
                isplat(x: u32 => same) -> I;
                iadd(a: I => part, b: I => part) -> I;
                isub(a: I => part, b: I => part) -> I;
                iand(a: I => part, b: I => part) -> I;
                ior(a: I => part, b: I => part) -> I;
                ixor(a: I => part, b: I => part) -> I;
                ieq(a: I => part, b: I => part) -> M;
                iselect(m: M => part, a: I => part, b: I => part) -> I;
                to_float(a: I => part) -> F;
                trunc(a: F => part) -> I;
                mand(a: M => part, b: M => part) -> M;
                mor(a: M => part, b: M => part) -> M;
            }

            #[inline(always)]
            fn load(self, from: &[f32; $w]) -> Self::F {
                let (lo, hi) = halves::<f32, $w, $h>(from);
                [crate::simd::Lanes::<$h>::load(self, lo), crate::simd::Lanes::<$h>::load(self, hi)]
            }
            #[inline(always)]
            fn store(self, v: Self::F, to: &mut [f32; $w]) {
                let (lo, hi) = halves_mut::<f32, $w, $h>(to);
                crate::simd::Lanes::<$h>::store(self, v[0], lo);
                crate::simd::Lanes::<$h>::store(self, v[1], hi);
            }
            #[inline(always)]
            fn iload(self, from: &[u32; $w]) -> Self::I {
                let (lo, hi) = halves::<u32, $w, $h>(from);
                [crate::simd::Lanes::<$h>::iload(self, lo), crate::simd::Lanes::<$h>::iload(self, hi)]
            }
            #[inline(always)]
            fn istore(self, v: Self::I, to: &mut [u32; $w]) {
                let (lo, hi) = halves_mut::<u32, $w, $h>(to);
                crate::simd::Lanes::<$h>::istore(self, v[0], lo);
                crate::simd::Lanes::<$h>::istore(self, v[1], hi);
            }
            #[inline(always)]
            fn ishl<const N: i32>(self, a: Self::I) -> Self::I {
                [
                    crate::simd::Lanes::<$h>::ishl::<N>(self, a[0]),
                    crate::simd::Lanes::<$h>::ishl::<N>(self, a[1]),
                ]
            }
            #[inline(always)]
            fn ishr<const N: i32>(self, a: Self::I) -> Self::I {
                [
                    crate::simd::Lanes::<$h>::ishr::<N>(self, a[0]),
                    crate::simd::Lanes::<$h>::ishr::<N>(self, a[1]),
                ]
            }
            #[inline(always)]
            fn reduce_min(self, a: Self::F) -> f32 {
                crate::simd::Lanes::<$h>::reduce_min(self, crate::simd::Lanes::<$h>::min(self, a[0], a[1]))
            }
            #[inline(always)]
            fn mbits(self, m: Self::M) -> u32 {
                let lo = crate::simd::Lanes::<$h>::mbits(self, m[0]);
                let hi = crate::simd::Lanes::<$h>::mbits(self, m[1]);
                lo | hi << $h
            }
            #[inline(always)]
            fn mfrom(self, bits: u32) -> Self::M {
                let low = bits & ((1 << $h) - 1);
                [
                    crate::simd::Lanes::<$h>::mfrom(self, low),
                    crate::simd::Lanes::<$h>::mfrom(self, bits >> $h),
                ]
            }
        }
    };
}

/// One method per line: `part` arguments are split into halves, `same` ones go to both.
macro_rules! pair_methods {
    ($w:literal, $h:literal; $( $name:ident ( $($arg:ident : $t:ident => $how:ident),* ) -> $r:ident; )*) => {
        $(
            #[inline(always)]
            fn $name(self, $($arg: crate::arch::pair::pair_type!($t)),*) -> Self::$r {
                [
                    crate::simd::Lanes::<$h>::$name(self, $(crate::arch::pair::pair_arg!($how, $arg, 0)),*),
                    crate::simd::Lanes::<$h>::$name(self, $(crate::arch::pair::pair_arg!($how, $arg, 1)),*),
                ]
            }
        )*
    };
}

macro_rules! pair_type {
    (F) => {
        Self::F
    };
    (I) => {
        Self::I
    };
    (M) => {
        Self::M
    };
    ($t:ident) => {
        $t
    };
}

macro_rules! pair_arg {
    (part, $arg:ident, $k:literal) => {
        $arg[$k]
    };
    (same, $arg:ident, $k:literal) => {
        $arg
    };
}

pub(crate) use {pair, pair_arg, pair_methods, pair_type};

/// The lower and upper half of an array.
#[inline(always)]
pub(crate) fn halves<T, const W: usize, const H: usize>(a: &[T; W]) -> (&[T; H], &[T; H]) {
    const { assert!(W == 2 * H) };
    (a.first_chunk().expect("W = 2 H"), a.last_chunk().expect("W = 2 H"))
}

/// The lower and upper half of an array.
#[inline(always)]
pub(crate) fn halves_mut<T, const W: usize, const H: usize>(a: &mut [T; W]) -> (&mut [T; H], &mut [T; H]) {
    const { assert!(W == 2 * H) };
    let (lo, hi) = a.split_at_mut(H);
    (lo.first_chunk_mut().expect("W = 2 H"), hi.first_chunk_mut().expect("W = 2 H"))
}
