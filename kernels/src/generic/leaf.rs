//! Setting up a block of triangles for one origin, lane = triangle.
//!
//! With vertices a, b, c relative to the origin, the three edge functions det(b, c, d), det(c, a, d), det(a, b, d)
//! and the inverse depth (n . d) / (n . a) are linear in the direction d = (u, v, 1). Their coefficients are computed
//! here once; per ray each costs two multiply-adds and no division.
//!
//! # Error bounds
//!
//! Let e = 2^-24, and let the *permanent* perm(p x q) be the cross product with all its products made positive: an
//! axis-aligned wall has an exact normal, and a small permanent says so. For |u|, |v| <= 1, fused or not:
//!
//! * The edge normal of b and c is (b + c) x (c - b) = 2 b x c. Sum and difference are off by e each, products and
//!   their difference by e each: a coefficient by 4 e of its permanent. The evaluation adds 3 e at most, the bound added
//!   to the constant e where that is not among them: 7 e times the sum of the permanent's components in all. `K` = 10 e
//!   also covers terms of second order and the rounding of the bound itself. At the corner of a slope rectangle the same
//!   operations are done.
//! * With P = the sum of perm((b - a) x (c - a)) and A = its dot product with |a|, n is off by 4 e P and the denominator
//!   n . a by 7 e A. With g = A / |n . a| >= 1, the inverse depth is off by at most (P / |n . a|) (11 e + 7 e g): 4 e for n,
//!   7 e g for the denominator, e each for the quotient, the product with it, adding and subtracting the bound, and
//!   3 e for the evaluation. `K` (1 + g) is more, by 10 %, as long as n . a is known to 6 per cent: where it is not, the
//!   triangle is *doubtful* and every ray that might meet it is decided exactly.
//! * [`TINY`] covers underflow.
//!
//! The bounds are folded into the constant coefficients, so that testing "possibly inside" costs nothing extra. Without
//! exactness they are zero, and triangles seen edge-on are not hit.

use super::{F8, Frame};
use crate::{
    node::TriBlock,
    simd::Simd,
    vector::{I32, Mask},
    visibility::Policy,
};

/// 10 * 2^-24.
const K: f32 = 5.960_464_5e-7;
/// Above anything that underflow can hide in a product of two differences of coordinates.
pub(super) const TINY: f32 = 1.0e-36;

/// Coefficients of eight triangles: `f(u, v) = x * u + y * v + z`.
pub(crate) struct Leaf<S: Simd> {
    /// Edge functions, oriented so that inside is positive, plus their error bound.
    pub(crate) edges: [[F8<S>; 3]; 3],
    /// Inverse depth plus its error bound.
    pub(crate) depth: [F8<S>; 3],
    /// An edge function (with its bound added) above this is positive beyond doubt.
    pub(crate) edge_doubt: F8<S>,
    /// Twice the error bound of the inverse depth.
    pub(crate) depth_doubt: F8<S>,
}

/// The cross product and its permanent.
#[inline(always)]
fn cross<S: Simd>(a: [F8<S>; 3], b: [F8<S>; 3]) -> ([F8<S>; 3], [F8<S>; 3]) {
    let (x0, x1) = (a[1] * b[2], a[2] * b[1]);
    let (y0, y1) = (a[2] * b[0], a[0] * b[2]);
    let (z0, z1) = (a[0] * b[1], a[1] * b[0]);
    ([x0 - x1, y0 - y1, z0 - z1], [x0.abs() + x1.abs(), y0.abs() + y1.abs(), z0.abs() + z1.abs()])
}

#[inline(always)]
fn add<S: Simd>(a: [F8<S>; 3], b: [F8<S>; 3]) -> [F8<S>; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn sub<S: Simd>(a: [F8<S>; 3], b: [F8<S>; 3]) -> [F8<S>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

impl<S: Simd> Leaf<S> {
    /// The coefficients of a block's triangles, and their corners relative to the origin.
    #[inline(always)]
    pub(crate) fn new<V: Policy>(s: S, block: &TriBlock, frame: &Frame) -> (Leaf<S>, [[F8<S>; 3]; 3]) {
        let corners = corners(s, block, frame);
        let [a, b, c] = corners;
        let (n, perm) = cross(sub(b, a), sub(c, a));
        let na = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
        let orient = na.sign();

        let k = F8::splat(s, K);
        let one = F8::splat(s, 1.0);
        let tiny = F8::splat(s, TINY);
        let inverse = one / na;
        if !V::EXACT {
            return (Leaf::plain(s, &corners, n, inverse, orient), corners);
        }
        let distance = [a[0].abs(), a[1].abs(), a[2].abs()];
        let ratio = (perm[0] + perm[1] + perm[2]) * inverse.abs();
        let g = (perm[0] * distance[0] + perm[1] * distance[1] + perm[2] * distance[2]) * inverse.abs();
        // False for NaN as well: then everything about the triangle is doubtful.
        let least = tiny * (one + distance[0] + distance[1] + distance[2]);
        let sound = g.lt(F8::splat(s, (1 << 17) as f32)) & least.lt(na.abs());
        let bound = ratio * k * (one + g);
        let depth = planes(s, sound, [n[0] * inverse, n[1] * inverse, n[2] * inverse], bound);

        let mut edges = [depth; 3];
        let mut worst = tiny;
        for i in 0..3 {
            let (p, q) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
            let (normal, perm) = cross(add(p, q), sub(q, p));
            let bound = (perm[0] + perm[1] + perm[2]) * k + tiny;
            worst = worst.max(bound);
            let normal = [normal[0].flip(orient), normal[1].flip(orient), normal[2].flip(orient)];
            edges[i] = planes(s, sound, normal, bound);
        }
        let infinity = F8::splat(s, f32::INFINITY);
        let leaf = Leaf {
            edges,
            depth,
            edge_doubt: sound.select(worst + worst, infinity),
            depth_doubt: sound.select(bound + bound, infinity),
        };
        (leaf, corners)
    }

    /// The coefficients without error bounds.
    #[inline(always)]
    fn plain(s: S, corners: &[[F8<S>; 3]; 3], n: [F8<S>; 3], inverse: F8<S>, orient: I32<S, 8>) -> Leaf<S> {
        let (zero, infinity) = (F8::splat(s, 0.0), F8::splat(s, f32::INFINITY));
        let sound = zero.lt(inverse.abs()) & inverse.abs().lt(infinity);
        let planes = |f: [F8<S>; 3]| {
            [sound.select(f[0], zero), sound.select(f[1], zero), sound.select(f[2], -infinity)]
        };
        let depth = planes([n[0] * inverse, n[1] * inverse, n[2] * inverse]);
        let mut edges = [depth; 3];
        for i in 0..3 {
            let (p, q) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
            let (normal, _) = cross(add(p, q), sub(q, p));
            edges[i] = planes([normal[0].flip(orient), normal[1].flip(orient), normal[2].flip(orient)]);
        }
        Leaf { edges, depth, edge_doubt: zero, depth_doubt: zero }
    }
}

/// Coefficients with the bound added; +infinity everywhere for triangles that are not sound.
#[inline(always)]
fn planes<S: Simd>(s: S, sound: Mask<S, 8>, f: [F8<S>; 3], bound: F8<S>) -> [F8<S>; 3] {
    let zero = F8::splat(s, 0.0);
    [
        sound.select(f[0], zero),
        sound.select(f[1], zero),
        sound.select(f[2] + bound, F8::splat(s, f32::INFINITY)),
    ]
}

/// The corners relative to the origin, in permuted axes.
#[inline(always)]
pub(super) fn corners<S: Simd>(s: S, block: &TriBlock, frame: &Frame) -> [[F8<S>; 3]; 3] {
    let [iu, iv, iz] = frame.axes;
    let org = [F8::splat(s, frame.org[0]), F8::splat(s, frame.org[1]), F8::splat(s, frame.org[2])];
    let flip = I32::splat(s, frame.flip);
    let mut corners = [org; 3];
    for i in 0..3 {
        let v = &block.v[i];
        let x = F8::load(s, &v[iu]) - org[0];
        let y = F8::load(s, &v[iv]) - org[1];
        corners[i] = [x, y, (F8::load(s, &v[iz]) - org[2]).flip(flip)];
    }
    corners
}

/// The corners of one triangle relative to the origin, in permuted axes: the same numbers as in [`Leaf::new`].
#[inline(always)]
pub(crate) fn triangle(block: &TriBlock, lane: usize, frame: &Frame) -> [[f32; 3]; 3] {
    let mut corners = [[0.0; 3]; 3];
    for (corner, v) in corners.iter_mut().zip(&block.v) {
        for k in 0..3 {
            corner[k] = v[frame.axes[k]][lane] - frame.org[k];
        }
        corner[2] = f32::from_bits(corner[2].to_bits() ^ frame.flip);
    }
    corners
}
