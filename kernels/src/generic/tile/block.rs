//! A block of triangles set up for one origin, in memory so that coefficients can be broadcast to rays.
//!
//! Besides the coefficients of [`Leaf`] there is the rectangle of slopes that encloses each triangle as the origin
//! sees it: the edge functions alone cannot tell a small triangle from the corner of a large sub-packet.
//!
//! If all corners lie ahead of the origin (z > 0), a point of the triangle is seen at slopes between the least and
//! greatest x / z of the corners. The rounded quotients are off by one part in 2^24; twice that is allowed, nothing
//! without exactness.

use crate::{
    generic::{F8, F16, Frame, leaf::Leaf},
    node::TriBlock,
    simd::Simd,
    visibility::Policy,
};

/// Index of the inverse depth among the functions.
pub(super) const DEPTH: usize = 3;

/// Eight triangles as one origin sees them. 704 bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct BlockPlanes {
    /// Three edge functions and the inverse depth, `x * u + y * v + z`, each plus its error bound.
    f: [[[f32; 8]; 3]; 4],
    /// Least and greatest slope of the triangle along u and along v.
    pub(super) extent: [[[f32; 8]; 2]; 2],
    /// An edge function above this is positive beyond doubt.
    edge_doubt: [f32; 8],
    /// The inverse depth is below its value by at most this.
    depth_doubt: [f32; 8],
    /// Bit = triangle: the function is greatest at the greatest slope along u, along v.
    high: [[u32; 2]; 4],
}

impl BlockPlanes {
    pub(super) const EMPTY: BlockPlanes = BlockPlanes {
        f: [[[0.0; 8]; 3]; 4],
        extent: [[[0.0; 8]; 2]; 2],
        edge_doubt: [0.0; 8],
        depth_doubt: [0.0; 8],
        high: [[0; 2]; 4],
    };

    /// Function `i` of triangle `lane` at slopes (u, v).
    #[inline(always)]
    pub(super) fn value<S: Simd>(&self, s: S, i: usize, lane: usize, u: F16<S>, v: F16<S>) -> F16<S> {
        let [x, y, z] = &self.f[i];
        let inner = F16::splat(s, y[lane]).mul_add(v, F16::splat(s, z[lane]));
        F16::splat(s, x[lane]).mul_add(u, inner)
    }

    /// Greatest value of function `i` of triangle `lane` over rectangles of slopes.
    #[inline(always)]
    pub(super) fn greatest<S: Simd>(
        &self,
        s: S,
        i: usize,
        lane: usize,
        u: &[[f32; 16]; 2],
        v: &[[f32; 16]; 2],
    ) -> F16<S> {
        let u = F16::load(s, &u[(self.high[i][0] >> lane & 1) as usize]);
        let v = F16::load(s, &v[(self.high[i][1] >> lane & 1) as usize]);
        self.value(s, i, lane, u, v)
    }

    /// All coefficients, as bits.
    pub(super) fn bits(&self) -> impl Iterator<Item = u32> + '_ {
        let functions = self.f.as_flattened().as_flattened();
        let extents = self.extent.as_flattened().as_flattened();
        let doubts = self.edge_doubt.iter().chain(&self.depth_doubt);
        let floats = functions.iter().chain(extents).chain(doubts).map(|x| x.to_bits());
        floats.chain(self.high.as_flattened().iter().copied())
    }

    /// What an edge function of triangle `lane` must exceed to be positive beyond doubt.
    #[inline(always)]
    pub(super) fn edge_doubt<S: Simd>(&self, s: S, lane: usize) -> F16<S> {
        F16::splat(s, self.edge_doubt[lane])
    }

    /// How much the inverse depth of triangle `lane` may be less than its value.
    #[inline(always)]
    pub(super) fn depth_doubt<S: Simd>(&self, s: S, lane: usize) -> F16<S> {
        F16::splat(s, self.depth_doubt[lane])
    }

    /// The triangles that rays within a rectangle of slopes may meet no farther than inverse depth `reach`; lane =
    /// triangle.
    #[inline(always)]
    pub(super) fn within<S: Simd>(&self, s: S, u: [f32; 2], v: [f32; 2], reach: f32) -> u32 {
        let u = [F8::splat(s, u[0]), F8::splat(s, u[1])];
        let v = [F8::splat(s, v[0]), F8::splat(s, v[1])];
        let [[u_least, u_most], [v_least, v_most]] = &self.extent;
        let mut inside = F8::load(s, u_least).le(u[1]) & u[0].le(F8::load(s, u_most));
        inside = inside & F8::load(s, v_least).le(v[1]) & v[0].le(F8::load(s, v_most));
        for i in 0..4 {
            let [x, y, z] = &self.f[i];
            let (x, y, z) = (F8::load(s, x), F8::load(s, y), F8::load(s, z));
            let most = (x * u[0]).max(x * u[1]) + ((y * v[0]).max(y * v[1]) + z);
            let least = if i == DEPTH { reach } else { 0.0 };
            inside = inside & F8::splat(s, least).le(most);
        }
        inside.bits()
    }
}

/// Sets up a block.
#[inline(always)]
pub(super) fn set_up<S: Simd, V: Policy>(s: S, block: &TriBlock, frame: &Frame, to: &mut BlockPlanes) {
    let (leaf, corners) = Leaf::new::<V>(s, block, frame);
    let zero = F8::splat(s, 0.0);
    for i in 0..4 {
        let f = if i == DEPTH { leaf.depth } else { leaf.edges[i] };
        for j in 0..3 {
            f[j].store(&mut to.f[i][j]);
        }
        to.high[i] = [zero.le(f[0]).bits(), zero.le(f[1]).bits()];
    }
    if V::EXACT {
        leaf.edge_doubt.store(&mut to.edge_doubt);
        leaf.depth_doubt.store(&mut to.depth_doubt);
    }
    extent::<S, V>(s, &corners, to);
}

/// The rectangles of slopes; everything for triangles that are not entirely ahead.
#[inline(always)]
fn extent<S: Simd, V: Policy>(s: S, corners: &[[F8<S>; 3]; 3], to: &mut BlockPlanes) {
    let [a, b, c] = corners;
    let one = F8::splat(s, 1.0);
    let infinity = F8::splat(s, f32::INFINITY);
    let ahead = F8::splat(s, f32::MIN_POSITIVE).le(a[2].min(b[2]).min(c[2]));
    for axis in 0..2 {
        let (p, q, r) = (a[axis] / a[2], b[axis] / b[2], c[axis] / c[2]);
        let (mut least, mut most) = (p.min(q).min(r), p.max(q).max(r));
        if V::EXACT {
            let error = (least.abs().max(most.abs()) + one) * F8::splat(s, f32::EPSILON);
            (least, most) = (least - error, most + error);
        }
        ahead.select(least, -infinity).store(&mut to.extent[axis][0]);
        ahead.select(most, infinity).store(&mut to.extent[axis][1]);
    }
}
