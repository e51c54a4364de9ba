//! The instruction sets behind [`crate::Lanes`], one file each, and the feature string of each, written once.

mod scalar;
pub use scalar::Scalar;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod pair;
#[cfg(target_arch = "x86_64")]
mod sse42;
#[cfg(target_arch = "x86_64")]
pub(crate) use {avx2::Avx2, avx512::Avx512, sse42::Sse42};

/// [`crate::Simd::prefetch`] of x86-64.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn prefetch_lines<T>(target: *const T) {
    use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    let first = target.cast::<i8>();
    for line in 0..size_of::<T>().div_ceil(64) {
        // SAFETY: SSE is part of x86-64; a prefetch reads nothing, whatever the address, and `wrapping_add` makes no
        // claim about it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(64 * line)) }
    }
}

/// Implements [`crate::Lanes`] for a token from one expression per method.
#[cfg(target_arch = "x86_64")]
macro_rules! lanes {
    ($token:ty, $w:literal, $f:ty, $i:ty, $m:ty;
     $( $name:ident $(<const $n:ident>)? ( $($arg:ident : $t:ty),* ) $(-> $r:ty)? = $e:expr; )*) => {
        impl crate::simd::Lanes<$w> for $token {
            type F = $f;
            type I = $i;
            type M = $m;
            $(
                #[inline(always)]
                fn $name $(<const $n: i32>)? (self, $($arg: $t),*) $(-> $r)? {
                    // Loads are transmutes, because the intrinsics, which are only `#[inline]`, were seen to become calls.
                    #[allow(unused_unsafe)]
                    // SAFETY: the token can only be had where its features were detected (see `Kernels::for_isa`),
                    // and pointers come from references to arrays of the right length.
                    unsafe { $e }
                }
            )*
        }
    };
}
#[cfg(target_arch = "x86_64")]
pub(crate) use lanes;
