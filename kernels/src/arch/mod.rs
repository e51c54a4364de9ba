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
                    // SAFETY: the token can only be had where its features were detected (see `Kernels::for_isa`),
                    // and pointers come from references to arrays of the right length. Loads are transmutes, because the
                    // intrinsics, which are only `#[inline]`, were seen to become calls.
                    #[allow(unused_unsafe)]
                    unsafe { $e }
                }
            )*
        }
    };
}
#[cfg(target_arch = "x86_64")]
pub(crate) use lanes;

/// Asks for the cache line of an address, which need not be valid.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn prefetch(at: *const u8) {
    use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    // SAFETY: a hint that never faults; SSE is part of x86_64.
    unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) };
}
