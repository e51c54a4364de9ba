//! Vectors of sixteen rays. No closures in here, nor in what uses it: they might not be inlined, and then every operation would be
//! a call.

use crate::kernels::{F32, I32, Lanes, Mask};

/// Three coordinates or colours, lane = ray.
pub(super) type V3<S> = [F32<S, 16>; 3];

#[inline(always)]
pub(super) fn dot<S: Lanes<16>>(a: V3<S>, b: V3<S>) -> F32<S, 16> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn add<S: Lanes<16>>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(super) fn sub<S: Lanes<16>>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(super) fn scale<S: Lanes<16>>(a: V3<S>, by: F32<S, 16>) -> V3<S> {
    [a[0] * by, a[1] * by, a[2] * by]
}

/// `if lane { a } else { b }`
#[inline(always)]
pub(super) fn select<S: Lanes<16>>(lanes: Mask<S, 16>, a: V3<S>, b: V3<S>) -> V3<S> {
    [lanes.select(a[0], b[0]), lanes.select(a[1], b[1]), lanes.select(a[2], b[2])]
}

/// Flips the signs of the lanes whose sign bit is set.
#[inline(always)]
pub(super) fn flip<S: Lanes<16>>(a: V3<S>, sign: I32<S, 16>) -> V3<S> {
    [a[0].flip(sign), a[1].flip(sign), a[2].flip(sign)]
}

#[inline(always)]
pub(super) fn normalize<S: Lanes<16>>(s: S, a: V3<S>) -> V3<S> {
    scale(a, F32::splat(s, 1.0) / dot(a, a).sqrt())
}

#[inline(always)]
pub(super) fn splat<S: Lanes<16>>(s: S, a: [f32; 3]) -> V3<S> {
    [F32::splat(s, a[0]), F32::splat(s, a[1]), F32::splat(s, a[2])]
}

#[inline(always)]
pub(super) fn load<S: Lanes<16>>(s: S, a: &[[f32; 16]; 3]) -> V3<S> {
    [F32::load(s, &a[0]), F32::load(s, &a[1]), F32::load(s, &a[2])]
}

#[inline(always)]
pub(super) fn store<S: Lanes<16>>(a: V3<S>, to: &mut [[f32; 16]; 3]) {
    for k in 0..3 {
        a[k].store(&mut to[k]);
    }
}

/// Two unit vectors that stand on the unit vector `n` and on each other (Duff et al., "Building an Orthonormal Basis,
/// Revisited", JCGT 2017).
#[inline(always)]
pub(super) fn basis<S: Lanes<16>>(s: S, n: V3<S>) -> [V3<S>; 2] {
    let one = F32::splat(s, 1.0);
    let sign = (one.bits() | n[2].sign()).floats();
    let a = F32::splat(s, -1.0) / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [[one + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]]]
}

/// Where the local coordinates `at` about `n` are.
#[inline(always)]
pub(super) fn about<S: Lanes<16>>(s: S, n: V3<S>, at: V3<S>) -> V3<S> {
    let [t, b] = basis(s, n);
    add(add(scale(t, at[0]), scale(b, at[1])), scale(n, at[2]))
}

/// The lanes of sixteen integers.
#[inline(always)]
pub(super) fn lanes<S: Lanes<16>>(s: S, of: &[u32], at: usize) -> I32<S, 16> {
    I32::load(s, (&of[at..at + 16]).try_into().expect("16 lanes"))
}
