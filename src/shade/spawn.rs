//! Rays that start on a surface: where exactly, so that they neither meet it again nor miss its neighbour.
//!
//! A spawned ray leaves out the primitive it starts on ([`crate::kernels::Ray`]'s `skip`) and starts at the hit point moved
//! along the triangle's normal by no more than what rounding can amount to: the normal towards the viewer for
//! a reflection, away from the viewer for a refraction. No length here is in units of the scene.
//!
//! # Error bound of the hit point
//!
//! Let e = 2^-24, a, b, c the corners and (u, v) the hit's barycentric coordinates as they were rounded. The point
//! P = a + u (b - a) + v (c - a) of exact arithmetic lies in the triangle's plane *whatever u and v are*, so their errors
//! move it along the surface and never off it. What is computed, axis by axis, is fl(a + fl(fl(u fl(b - a)) + fl(v fl(c - a)))).
//! Each product is off by (1 + e)^2 - 1, their sum by another e, so that the sum is off by at most
//! 3.01 e (u |b - a| + v |c - a|), and the last addition adds e |p|:
//!
//! ```text
//!   |p - P| <= e |p| + 4 e (u |b - a| + v |c - a|) + tiny            per axis
//! ```
//!
//! where 4 in place of 3.01 also covers the rounding of the bound itself, and *tiny* covers underflow.
//!
//! # The start
//!
//! Let N be the plane's exact unit normal and n the rounded one, o = fl(p + d n). Then with w = |p - P| per axis
//!
//! ```text
//!   N . (o - P) >= d (N . n) - sum |N_k| (w_k + e |o_k|)
//! ```
//!
//! The kernel sees vertices as fl(x - o), off by e |x - o|, which for the triangle and what shares a corner with the hit's
//! surroundings is at most e times its extent |b - a| + |c - a| plus d. So d = 5/4 sum |n_k| (w_k + e |p_k| + e extent_k)
//! keeps the start on the side that n points to, exactly and as the kernel sees it; the quarter covers |n - N|, which
//! f64 keeps below 2^-22 unless the triangle is a sliver of more than 1 to 2^16, and the rounding of d.
//!
//! # The terminator of smooth normals
//!
//! A coarse mesh with smooth normals is shaded as the curved surface it stands for, but shadowed as flat triangles, whose
//! edges show where light grazes. [`bulge`] moves the hit point onto that surface: J. Hanika, "Hacking the Shadow
//! Terminator", Ray Tracing Gems II (2021), chapter 4. It points away from the triangle, so that the start stays on
//! its side. From there light is seen above the tangent plane of the curved surface, also where that is below the
//! triangle's: a triangle that faces away as a whole would otherwise be dark up to its edges. It may be in the way then,
//! and is not left out.

use crate::kernels::{F32, Lanes};

/// 2^-24: half a unit in the last place of 1.
const E: f32 = 0.5 * f32::EPSILON;
/// Above what underflow can hide in a few operations.
const TINY: f32 = 1.0e-37;

/// Three coordinates, lane = ray.
pub type Triple<S, const W: usize> = [F32<S, W>; 3];

/// Hit points with what is known of their errors.
#[derive(Clone, Copy)]
pub struct Footing<S: Lanes<W>, const W: usize> {
    /// The hit points.
    pub point: Triple<S, W>,
    /// Greatest distance of the hit points from the planes of their triangles along each axis.
    pub error: Triple<S, W>,
    /// Sum of the magnitudes of two edges.
    extent: Triple<S, W>,
}

impl<S: Lanes<W>, const W: usize> Footing<S, W> {
    /// The points (u, v) of triangles; `u` and `v` are in [0, 1] like those of a [`crate::kernels::Hit`].
    #[inline(always)]
    pub fn new(s: S, corners: &[Triple<S, W>; 3], [u, v]: [F32<S, W>; 2]) -> Footing<S, W> {
        let [a, b, c] = corners;
        let (mut point, mut error, mut extent) = (*a, *a, *a);
        for k in 0..3 {
            let (ab, ac) = (b[k] - a[k], c[k] - a[k]);
            point[k] = a[k] + (u * ab + v * ac);
            let moved = u * ab.abs() + v * ac.abs();
            error[k] =
                F32::splat(s, E) * point[k].abs() + F32::splat(s, 4.0 * E) * moved + F32::splat(s, TINY);
            extent[k] = ab.abs() + ac.abs();
        }
        Footing { point, error, extent }
    }

    /// Moves the points along `by`, which leads away from their triangles on the side where rays are to start: see
    /// [`bulge`].
    #[inline(always)]
    pub fn moved(mut self, s: S, by: &Triple<S, W>) -> Footing<S, W> {
        for k in 0..3 {
            self.point[k] = self.point[k] + by[k];
            let rounding = F32::splat(s, E) * self.point[k].abs() + F32::splat(s, 8.0 * E) * by[k].abs();
            self.error[k] = self.error[k] + rounding;
        }
        self
    }

    /// Where rays start that leave the triangles to the side that the unit normals `n` point to.
    #[inline(always)]
    pub fn start(&self, s: S, n: &Triple<S, W>) -> Triple<S, W> {
        let mut distance = F32::splat(s, TINY);
        for k in 0..3 {
            let rounding = F32::splat(s, E) * (self.point[k].abs() + self.extent[k]);
            distance = distance + n[k].abs() * (self.error[k] + rounding);
        }
        let distance = F32::splat(s, 1.25) * distance;
        let mut start = self.point;
        for k in 0..3 {
            start[k] = self.point[k] + n[k] * distance;
        }
        start
    }
}

/// How far the surface that smooth normals stand for lies above its triangles at `point`, by Hanika's construction: the
/// point's projections onto the tangent planes of the corners below which it lies, weighted by the barycentric
/// coordinates. Zero where the normals are the triangle's own.
///
/// `normals` are unit normals of the corners and `ng` that of the triangle, all on the side where rays start; corners whose
/// normals point to the other side do not count.
#[inline(always)]
pub fn bulge<S: Lanes<W>, const W: usize>(
    s: S,
    corners: &[Triple<S, W>; 3],
    normals: &[Triple<S, W>; 3],
    ng: &Triple<S, W>,
    point: &Triple<S, W>,
    [u, v]: [F32<S, W>; 2],
) -> Triple<S, W> {
    let (zero, one) = (F32::splat(s, 0.0), F32::splat(s, 1.0));
    let weights = [(one - u - v).max(zero), u, v];
    let mut sum = [zero; 3];
    for i in 0..3 {
        let (corner, n) = (&corners[i], &normals[i]);
        let from = [point[0] - corner[0], point[1] - corner[1], point[2] - corner[2]];
        let above = dot(&from, n).min(zero);
        let outward = zero.lt(dot(n, ng));
        let up = outward.select(-above * weights[i], zero);
        for k in 0..3 {
            sum[k] = sum[k] + up * n[k];
        }
    }
    sum
}

#[inline(always)]
fn dot<S: Lanes<W>, const W: usize>(a: &Triple<S, W>, b: &Triple<S, W>) -> F32<S, W> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
