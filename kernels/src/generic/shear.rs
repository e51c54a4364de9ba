//! Rays against triangles without a common origin: vertices sheared along the ray.
//!
//! Vertices are sheared along the ray onto the plane of its frame's first two axes; there the edge functions are 2x2
//! determinants (Woop, Benthin, Wald 2013), and the depth is the mean of the corners' depths weighted by them.
//!
//! # Error bounds
//!
//! With e = 2^-24, fused or not: a sheared coordinate x is off by 3 e Mx, where Mx is at least the sum of magnitudes
//! |x| + |z| of the vertex, and a determinant of sheared coordinates up to X and Y by 10 e (X My + Y Mx). That is at
//! most 20 e (X + Y) M with M the greatest magnitude of any component. `bound` is 32 e of it, and large enough where X
//! or Y is lost in rounding. Where all three determinants have one sign beyond doubt, errors in the weights move the
//! depth by at most 3 `bound` (z1 - z0) / |det| between the least and greatest corner depth, and rounding by 6 e times
//! the greatest magnitude of those; 8 e is allowed. Without exactness all bounds are zero.

use super::leaf::TINY;
use crate::{simd::Lanes, vector::F32, visibility::Policy};

/// Pairs of a ray and a triangle, one per lane.
pub(super) struct Sheared<S: Lanes<W>, const W: usize> {
    /// Bit = the ray may pass through the triangle, at some depth that is not negative.
    pub(super) maybe: u32,
    /// Bit = it does beyond doubt.
    pub(super) sure: u32,
    edges: [F32<S, W>; 3],
    bound: F32<S, W>,
    nearest: F32<S, W>,
    farthest: F32<S, W>,
}

/// `corners` are relative to the rays' origins in their frame; `slopes` are those of the direction along the first two
/// axes; hits farther than `far` along the third do not count.
#[inline(always)]
pub(super) fn sheared<S: Lanes<W>, V: Policy, const W: usize>(
    s: S,
    corners: &[[F32<S, W>; 3]; 3],
    slopes: [F32<S, W>; 2],
    far: F32<S, W>,
) -> Sheared<S, W> {
    let zero = F32::splat(s, 0.0);
    let (mut xs, mut ys, mut most) = ([zero; 3], [zero; 3], [zero; 3]);
    for i in 0..3 {
        let [x, y, z] = corners[i];
        xs[i] = z.mul_add(-slopes[0], x);
        ys[i] = z.mul_add(-slopes[1], y);
        most[i] = x.max_abs(y).max_abs(z);
    }
    let e0 = xs[1].mul_add(ys[2], -(ys[1] * xs[2]));
    let e1 = xs[2].mul_add(ys[0], -(ys[2] * xs[0]));
    let e2 = xs[0].mul_add(ys[1], -(ys[0] * xs[1]));
    let bound = if V::EXACT {
        let most = most[0].max(most[1]).max(most[2]);
        let size = xs[0].max_abs(xs[1]).max_abs(xs[2]) + ys[0].max_abs(ys[1]).max_abs(ys[2]);
        let size = most.mul_add(F32::splat(s, 4.0 * f32::EPSILON), size);
        (size * most).mul_add(F32::splat(s, 16.0 * f32::EPSILON), F32::splat(s, TINY))
    } else {
        zero
    };
    let (least, most) = (e0.min(e1).min(e2), e0.max(e1).max(e2));
    let outside = least.lt(-bound) & bound.lt(most);
    let [z0, z1, z2] = [corners[0][2], corners[1][2], corners[2][2]];
    let (nearest, farthest) = (z0.min(z1).min(z2), z0.max(z1).max(z2));
    let maybe = !(outside | farthest.lt(zero) | far.lt(nearest)).bits();

    let sure = if V::EXACT { (bound.lt(least) | most.lt(-bound)).bits() } else { maybe };
    Sheared { maybe, sure, edges: [e0, e1, e2], bound, nearest, farthest }
}

impl<S: Lanes<W>, const W: usize> Sheared<S, W> {
    /// Encloses the depths of the sure lanes: least and greatest.
    #[inline(always)]
    pub(super) fn depths<V: Policy>(&self, s: S, corners: &[[F32<S, W>; 3]; 3]) -> [F32<S, W>; 2] {
        let [e0, e1, e2] = self.edges;
        let inverse = F32::splat(s, 1.0) / (e0 + e1 + e2);
        // Weights before depths: products of three coordinates may overflow, and then pass for a depth far away.
        let [w0, w1, w2] = [e0 * inverse, e1 * inverse, e2 * inverse];
        let depth = w0 * corners[0][2] + w1 * corners[1][2] + w2 * corners[2][2];
        if !V::EXACT {
            return [depth, depth];
        }
        let weights = F32::splat(s, 3.0) * self.bound * (self.farthest - self.nearest) * inverse.abs();
        let size = self.nearest.abs().max(self.farthest.abs());
        let error = weights + F32::splat(s, 4.0 * f32::EPSILON) * size;
        [depth - error, depth + error]
    }
}
