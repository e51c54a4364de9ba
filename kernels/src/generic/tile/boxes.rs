//! The boxes of a node's children as the origin sees them, against the tile, its sub-packets and its rays.
//!
//! A box [x0, x1] x [z0, z1] ahead of the origin is seen at slopes from min(x0 / z0, x0 / z1) to max(x1 / z0, x1 / z1),
//! and a rectangle of slopes misses it if and only if it lies beside that. So eight boxes are projected at once
//! (lane = child), and each test is four comparisons, whatever the lanes stand for.
//!
//! Rounding: reciprocals and products are off by 2^-24 each, and [`WIDEN`] allows four times that. Box planes are moved
//! outwards by [`TINY`] first, so that 0 / 0, a box that begins at the origin itself, becomes infinity: everything.
//! Without exactness neither is done.

use super::{Rays, State};
use crate::{
    generic::{F8, F16},
    node::Node,
    packet::SUBS,
    simd::Simd,
    vector::I32,
    visibility::Policy,
};

/// 8 * 2^-24.
const WIDEN: f32 = 4.0 * f32::EPSILON;
const TINY: f32 = 1.0e-37;

/// Eight boxes, in memory so that they can be broadcast.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Boxes {
    /// Least and greatest slope along u and along v.
    extent: [[[f32; 8]; 2]; 2],
    /// Nearest depths, cut off at zero.
    near: [f32; 8],
}

impl Boxes {
    pub(super) const NONE: Boxes = Boxes { extent: [[[0.0; 8]; 2]; 2], near: [0.0; 8] };

    /// Nearest depth of box `child`.
    #[inline(always)]
    pub(super) fn near(&self, child: usize) -> f32 {
        self.near[child & 7]
    }

    /// Which lanes' slopes, from `low` to `high` along u and v, may meet box `child` no farther than inverse depth
    /// `reach`.
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        s: S,
        child: usize,
        low: [&[f32; 16]; 2],
        high: [&[f32; 16]; 2],
        reach: &[f32; 16],
    ) -> u32 {
        let child = child & 7;
        let [[u_least, u_most], [v_least, v_most]] = &self.extent;
        let mut meet = F16::splat(s, u_least[child]).le(F16::load(s, high[0]));
        meet = meet & F16::load(s, low[0]).le(F16::splat(s, u_most[child]));
        meet = meet & F16::splat(s, v_least[child]).le(F16::load(s, high[1]));
        meet = meet & F16::load(s, low[1]).le(F16::splat(s, v_most[child]));
        let depth = F16::splat(s, self.near[child]) * F16::load(s, reach);
        (meet & depth.le(F16::splat(s, 1.0))).bits()
    }
}

impl State {
    /// Projects a node's boxes; which of them the tile may meet, lane = child.
    #[inline(always)]
    pub(super) fn project<S: Simd, V: Policy>(&mut self, s: S, node: &Node) -> u32 {
        let frame = &self.frame;
        let [iu, iv, iz] = frame.axes.map(|axis| axis % 3);
        let negative = usize::from(frame.flip != 0);
        let flip = I32::splat(s, frame.flip);
        let zero = F8::splat(s, 0.0);
        let one = F8::splat(s, 1.0);
        let org_z = F8::splat(s, frame.org[2]);
        let near = (F8::load(s, &node.bounds[2 * iz + negative]) - org_z).flip(flip).max(zero);
        let far = (F8::load(s, &node.bounds[2 * iz + 1 - negative]) - org_z).flip(flip);
        near.store(&mut self.boxes.near);
        let (r0, r1) = (one / near, one / far.max(zero));
        let reach = near * F8::splat(s, self.tile_reach);
        let mut meet = zero.le(far) & reach.le(one);
        for axis in 0..2 {
            let (world, tile) = if axis == 0 { (iu, self.tile_u) } else { (iv, self.tile_v) };
            let org = F8::splat(s, frame.org[axis]);
            let mut x0 = F8::load(s, &node.bounds[2 * world]) - org;
            let mut x1 = F8::load(s, &node.bounds[2 * world + 1]) - org;
            if V::EXACT {
                let tiny = F8::splat(s, TINY);
                (x0, x1) = (x0 - tiny, x1 + tiny);
            }
            let mut least = (x0 * r0).min(x0 * r1);
            let mut most = (x1 * r0).max(x1 * r1);
            if V::EXACT {
                let widen = F8::splat(s, WIDEN);
                least = least - least.abs() * widen;
                most = most + most.abs() * widen;
            }
            least.store(&mut self.boxes.extent[axis][0]);
            most.store(&mut self.boxes.extent[axis][1]);
            meet = meet & least.le(F8::splat(s, tile[1])) & F8::splat(s, tile[0]).le(most);
        }
        meet.bits()
    }

    /// Which sub-packets may meet box `child`.
    #[inline(always)]
    pub(super) fn subs_meet<S: Simd>(&self, s: S, child: usize) -> u32 {
        self.boxes.meet(s, child, [&self.u[0], &self.v[0]], [&self.u[1], &self.v[1]], &self.reach)
    }

    /// Which rays of sub-packet `sub` may meet box `child`.
    #[inline(always)]
    pub(super) fn rays_meet<S: Simd>(&self, s: S, child: usize, sub: usize, u: &Rays, v: &Rays) -> u32 {
        let (sub, slopes) = (sub % SUBS, [&u[sub % SUBS], &v[sub % SUBS]]);
        self.boxes.meet(s, child, slopes, slopes, &self.lo[sub])
    }
}
