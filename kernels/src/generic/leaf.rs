//! Setting up a block of triangles for one origin, lane = triangle.
//!
//! With vertices a, b, c relative to the origin, the three edge functions det(b, c, d), det(c, a, d), det(a, b, d)
//! and the inverse depth (n . d) / (n . a) are linear in the direction d = (u, v, 1). Their coefficients are computed
//! here once; per ray each costs two multiply-adds and no division.
//!
//! # Error bounds
//!
//! With e = 2^-24 and |.| the 1-norm, for |u|, |v| <= 1, fused or not:
//!
//! * The edge normal of b and c is (b + c) x (c - b) = 2 b x c. Sum and difference are off by e each, products and
//!   their difference by e each, the evaluation by 3 e: at most 8 e (|b| + |c|) |c - b| in all. `K` = 16 e allows
//!   twice that, which also covers adding the bound itself, and evaluation at the corner of a slope rectangle.
//! * With E = |b - a| |c - a| >= |n| and g = E |a| / |n . a|, the inverse depth is off by at most
//!   (E / |n . a|) (9 e + 8 e g); again `K` allows about twice that. It holds while n . a is known to a few per cent:
//!   where it is not, the triangle is *doubtful* and every ray that might meet it is decided exactly.
//! * `TINY` stands above anything that underflow can hide.
//!
//! The bounds are folded into the constant coefficients, so that testing "possibly inside" costs nothing extra.

use super::{F8, Frame};
use crate::{
    node::TriBlock,
    simd::Simd,
    vector::{I32, Mask},
};

/// 16 * 2^-24.
const K: f32 = 9.536_743e-7;
const TINY: f32 = 1.0e-36;

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

#[inline(always)]
fn norm1<S: Simd>(v: [F8<S>; 3]) -> F8<S> {
    v[0].abs() + v[1].abs() + v[2].abs()
}

#[inline(always)]
fn cross<S: Simd>(a: [F8<S>; 3], b: [F8<S>; 3]) -> [F8<S>; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
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
    #[inline(always)]
    pub(crate) fn new(s: S, block: &TriBlock, frame: &Frame) -> Leaf<S> {
        let [a, b, c] = corners(s, block, frame);
        let (e1, e2) = (sub(b, a), sub(c, a));
        let n = cross(e1, e2);
        let na = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
        let orient = na.sign();
        let (la, lb, lc) = (norm1(a), norm1(b), norm1(c));

        let k = F8::splat(s, K);
        let tiny = F8::splat(s, TINY);
        let inverse = F8::splat(s, 1.0) / na;
        let spread = norm1(e1) * norm1(e2);
        let ratio = spread * inverse.abs();
        let g = ratio * la;
        // False for NaN as well: then everything about the triangle is doubtful.
        let sound = g.lt(F8::splat(s, (1 << 17) as f32)) & tiny.lt(na.abs());
        let bound = ratio * k * (F8::splat(s, 1.0) + g);
        let depth = planes(s, sound, [n[0] * inverse, n[1] * inverse, n[2] * inverse], bound);

        let mut edges = [depth; 3];
        let mut worst = tiny;
        let pairs = [(b, c, lb + lc), (c, a, lc + la), (a, b, la + lb)];
        for (edge, (p, q, size)) in edges.iter_mut().zip(pairs) {
            let r = sub(q, p);
            let normal = cross(add(p, q), r);
            let bound = size * norm1(r) * k + tiny;
            worst = worst.max(bound);
            *edge = planes(
                s,
                sound,
                [normal[0].flip(orient), normal[1].flip(orient), normal[2].flip(orient)],
                bound,
            );
        }
        let infinity = F8::splat(s, f32::INFINITY);
        Leaf {
            edges,
            depth,
            edge_doubt: sound.select(worst + worst, infinity),
            depth_doubt: sound.select(bound + bound, infinity),
        }
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
fn corners<S: Simd>(s: S, block: &TriBlock, frame: &Frame) -> [[F8<S>; 3]; 3] {
    let [iu, iv, iz] = frame.axes;
    let org = [F8::splat(s, frame.org[0]), F8::splat(s, frame.org[1]), F8::splat(s, frame.org[2])];
    let flip = I32::splat(s, frame.flip);
    let mut corners = [org; 3];
    for (corner, v) in corners.iter_mut().zip(&block.v) {
        corner[0] = F8::load(s, &v[iu]) - org[0];
        corner[1] = F8::load(s, &v[iv]) - org[1];
        corner[2] = (F8::load(s, &v[iz]) - org[2]).flip(flip);
    }
    corners
}

/// The corners of one triangle relative to the origin, in permuted axes: the same numbers as in [`Leaf::new`].
#[inline(always)]
pub(crate) fn triangle(block: &TriBlock, lane: usize, frame: &Frame) -> [[f32; 3]; 3] {
    block.v.each_ref().map(|v| {
        let relative = |k: usize| v[frame.axes[k]][lane] - frame.org[k];
        [relative(0), relative(1), f32::from_bits(relative(2).to_bits() ^ frame.flip)]
    })
}
