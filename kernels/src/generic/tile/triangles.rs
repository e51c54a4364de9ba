//! A leaf's triangles against a packet: set up at once, culled against sub-packets, then tested against rays.
//!
//! ```text
//!   block of 8 triangles --(lane = triangle)--> those that the tile may meet
//!     each --(lane = sub-packet)--> sub-packets it misses | covers | may meet
//!       each that it may meet --(lane = ray)--> rays it misses | hits | doubtful: decided exactly
//! ```
//!
//! A sub-packet is *covered* when every edge function is positive beyond doubt over its whole slope rectangle: no ray
//! needs the edges, and for occlusion, where the depth that counts does not change, all rays are decided at once.

use super::{State, rays};
use crate::{
    generic::{
        F8, F16,
        doubt::{inverse_interval, nearer},
        leaf::Leaf,
    },
    node::{BvhView, NodeRef, TriBlock},
    packet::{SUB, SUBS, TilePacket},
    simd::Simd,
    vector::{I32, Mask},
};

/// Coefficients of the triangles that survive the tile test, in memory so that they can be broadcast.
#[repr(C, align(64))]
pub(super) struct Coefficients {
    /// Three edge functions and the inverse depth: `x * u + y * v + z`.
    f: [[[f32; 8]; 3]; 4],
    /// Bit = triangle: each function is greatest at the greatest slope.
    high: [[u32; 2]; 4],
    edge_doubt: [f32; 8],
    depth_doubt: [f32; 8],
}

/// Index of the inverse depth among the functions.
const DEPTH: usize = 3;

impl Coefficients {
    pub(super) const EMPTY: Coefficients = Coefficients {
        f: [[[0.0; 8]; 3]; 4],
        high: [[0; 2]; 4],
        edge_doubt: [0.0; 8],
        depth_doubt: [0.0; 8],
    };

    /// Function `i` of triangle `lane` at slopes (u, v).
    #[inline(always)]
    fn value<S: Simd>(&self, s: S, i: usize, lane: usize, u: F16<S>, v: F16<S>) -> F16<S> {
        let [x, y, z] = &self.f[i];
        let inner = F16::splat(s, y[lane]).mul_add(v, F16::splat(s, z[lane]));
        F16::splat(s, x[lane]).mul_add(u, inner)
    }

    /// Greatest (`side` 0) or least (`side` 1) value of function `i` of triangle `lane` over the slope rectangles,
    /// lane = sub-packet.
    #[inline(always)]
    fn extreme<S: Simd>(&self, s: S, i: usize, lane: usize, side: usize, u: &Slopes, v: &Slopes) -> F16<S> {
        let u = F16::load(s, &u[(self.high[i][0] >> lane & 1) as usize ^ side]);
        let v = F16::load(s, &v[(self.high[i][1] >> lane & 1) as usize ^ side]);
        self.value(s, i, lane, u, v)
    }
}

/// Least and greatest slopes by sub-packet.
type Slopes = [[f32; SUBS]; 2];

/// Tests a run of triangles; returns `node` if it decided a ray, else `last`.
#[inline(always)]
pub(super) fn leaf<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    node: NodeRef,
    subs: u32,
    last: NodeRef,
) -> NodeRef {
    let block_index = node.block();
    let mut left = set_up(s, &bvh.blocks[block_index], state, node.lanes());
    let mut touched = 0;
    while left != 0 {
        let lane = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        let slot = (block_index * 8 + lane) as u32;
        let prim = bvh.blocks[block_index].prim[lane];
        let (mut wanted, mut covered) = sub_packets::<S, ANY>(s, lane, state, subs);
        while covered != 0 {
            let sub = (covered.trailing_zeros() & 15) as usize;
            covered &= covered - 1;
            if cover::<S, ANY>(s, packet, state, lane, sub, slot, prim) {
                touched |= 1 << sub;
            } else {
                wanted |= 1 << sub;
            }
        }
        while wanted != 0 {
            let sub = (wanted.trailing_zeros() & 15) as usize;
            wanted &= wanted - 1;
            if test::<S, ANY>(s, bvh, packet, state, lane, sub, slot, prim) {
                touched |= 1 << sub;
            }
        }
    }
    if touched == 0 {
        return last;
    }
    refresh::<S, ANY>(s, state, touched);
    node
}

/// Sets up the block and culls its triangles against the tile, lane = triangle.
#[inline(always)]
fn set_up<S: Simd>(s: S, block: &TriBlock, state: &mut State, lanes: u32) -> u32 {
    let leaf = Leaf::new(s, block, &state.frame);
    let zero = F8::splat(s, 0.0);
    let u = [F8::splat(s, state.tile_u[0]), F8::splat(s, state.tile_u[1])];
    let v = [F8::splat(s, state.tile_v[0]), F8::splat(s, state.tile_v[1])];
    let mut outside = greatest(&leaf.depth, u, v).lt(F8::splat(s, state.tile_reach));
    for edge in &leaf.edges {
        outside = outside | greatest(edge, u, v).lt(zero);
    }
    let left = !outside.bits() & lanes;
    if left != 0 {
        let k = &mut state.triangles;
        let [e0, e1, e2] = leaf.edges;
        for (i, f) in [e0, e1, e2, leaf.depth].into_iter().enumerate() {
            for j in 0..3 {
                f[j].store(&mut k.f[i][j]);
            }
            k.high[i] = [zero.le(f[0]).bits(), zero.le(f[1]).bits()];
        }
        leaf.edge_doubt.store(&mut k.edge_doubt);
        leaf.depth_doubt.store(&mut k.depth_doubt);
    }
    left
}

/// The greatest value of an affine function over a rectangle of slopes.
#[inline(always)]
fn greatest<S: Simd>(f: &[F8<S>; 3], u: [F8<S>; 2], v: [F8<S>; 2]) -> F8<S> {
    (f[0] * u[0]).max(f[0] * u[1]) + ((f[1] * v[0]).max(f[1] * v[1]) + f[2])
}

/// Which of `subs` one triangle may meet, and which others it covers; lane = sub-packet.
#[inline(always)]
fn sub_packets<S: Simd, const ANY: bool>(s: S, lane: usize, state: &State, subs: u32) -> (u32, u32) {
    let k = &state.triangles;
    let (u, v) = (&state.u, &state.v);
    let zero = F16::splat(s, 0.0);
    let mut outside = k.extreme(s, DEPTH, lane, 0, u, v).lt(F16::load(s, &state.reach));
    for i in 0..DEPTH {
        outside = outside | k.extreme(s, i, lane, 0, u, v).lt(zero);
    }
    let wanted = !outside.bits() & subs;
    if wanted == 0 {
        return (0, 0);
    }
    let doubt = F16::splat(s, k.edge_doubt[lane]);
    let mut covered = doubt.lt(k.extreme(s, 0, lane, 1, u, v));
    for i in 1..DEPTH {
        covered = covered & doubt.lt(k.extreme(s, i, lane, 1, u, v));
    }
    if ANY {
        let near = k.extreme(s, DEPTH, lane, 1, u, v) - F16::splat(s, k.depth_doubt[lane]);
        covered = covered & F16::load(s, &state.ceiling).lt(near);
    }
    let covered = covered.bits() & wanted;
    (wanted & !covered, covered)
}

/// The rays of a sub-packet that lies inside the triangle: it becomes the nearest hit of all of them if it is beyond
/// doubt; otherwise nothing changes.
#[inline(always)]
fn cover<S: Simd, const ANY: bool>(
    s: S,
    packet: &TilePacket,
    state: &mut State,
    lane: usize,
    sub: usize,
    slot: u32,
    prim: u32,
) -> bool {
    if skipping(s, packet, sub, prim) != 0 {
        return false;
    }
    if ANY {
        state.live[sub] = 0;
        return true;
    }
    let u = F16::load(s, &rays(&packet.u)[sub]);
    let v = F16::load(s, &rays(&packet.v)[sub]);
    let w = state.triangles.value(s, DEPTH, lane, u, v);
    let w_lo = w - F16::splat(s, state.triangles.depth_doubt[lane]);
    // Rays that take no part have hi = infinity.
    if F16::load(s, &state.hi[sub]).lt(w_lo).bits() != 0xffff {
        return false;
    }
    w.store(&mut state.hi[sub]);
    w_lo.store(&mut state.lo[sub]);
    I32::splat(s, slot).store(&mut state.slot[sub]);
    true
}

/// Tests the rays of a sub-packet against one triangle; true if any was decided.
#[inline(always)]
fn test<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    lane: usize,
    sub: usize,
    slot: u32,
    prim: u32,
) -> bool {
    let k = &state.triangles;
    let u = F16::load(s, &rays(&packet.u)[sub]);
    let v = F16::load(s, &rays(&packet.v)[sub]);
    let inside = k.value(s, 0, lane, u, v).min(k.value(s, 1, lane, u, v)).min(k.value(s, 2, lane, u, v));
    let w = k.value(s, DEPTH, lane, u, v);
    let lo = F16::load(s, &state.lo[sub]);
    let candidate = F16::splat(s, 0.0).le(inside) & lo.le(w);
    let live = u32::from(state.live[sub]);
    let mut candidates = candidate.bits() & live;
    if candidates == 0 {
        return false;
    }
    candidates &= !skipping(s, packet, sub, prim);
    let hi = F16::load(s, &state.hi[sub]);
    let w_lo = w - F16::splat(s, k.depth_doubt[lane]);
    let sure = candidate & F16::splat(s, k.edge_doubt[lane]).lt(inside) & hi.lt(w_lo);
    let sure_bits = sure.bits() & candidates;
    if ANY {
        state.live[sub] &= !(sure_bits as u16);
    } else {
        let sure = Mask::from_bits(s, sure_bits);
        sure.select(w_lo, lo).store(&mut state.lo[sub]);
        sure.select(w, hi).store(&mut state.hi[sub]);
        let slots = I32::load(s, &state.slot[sub]);
        sure.iselect(I32::splat(s, slot), slots).store(&mut state.slot[sub]);
    }
    let doubtful = candidates & !sure_bits;
    let mut decided = sure_bits != 0;
    if doubtful != 0 {
        decided |= settle::<ANY>(bvh, packet, state, doubtful, sub, slot);
    }
    decided
}

/// The rays of a sub-packet for which a primitive does not count.
#[inline(always)]
fn skipping<S: Simd>(s: S, packet: &TilePacket, sub: usize, prim: u32) -> u32 {
    I32::load(s, &rays(&packet.skip)[sub]).eq(I32::<S, 16>::splat(s, prim)).bits()
}

/// Decides the doubtful rays of a sub-packet exactly; true if one hits.
#[cold]
#[inline(never)]
fn settle<const ANY: bool>(
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    mut doubtful: u32,
    sub: usize,
    slot: u32,
) -> bool {
    let mut decided = false;
    while doubtful != 0 {
        let i = doubtful.trailing_zeros() as usize;
        doubtful &= doubtful - 1;
        let ray = sub * SUB + i;
        let direction = [packet.u[ray], packet.v[ray], 1.0];
        let best = state.slot[sub][i];
        if let Some(t) = nearer(bvh, &state.frame, direction, [0.0, packet.tfar[ray]], slot, best) {
            decided = true;
            if ANY {
                state.live[sub] &= !(1 << i);
            } else {
                (state.lo[sub][i], state.hi[sub][i]) = inverse_interval(t);
                state.slot[sub][i] = slot;
            }
        }
    }
    decided
}

/// Rays were decided: forgets sub-packets without live rays, or pulls in the reach of those concerned.
#[inline(always)]
fn refresh<S: Simd, const ANY: bool>(s: S, state: &mut State, mut touched: u32) {
    while touched != 0 {
        let sub = (touched.trailing_zeros() & 15) as usize;
        touched &= touched - 1;
        if ANY {
            state.live_subs &= !(u32::from(state.live[sub] == 0) << sub);
        } else {
            state.reach[sub] = F16::load(s, &state.lo[sub]).reduce_min();
        }
    }
    if !ANY {
        state.tile_reach = F16::load(s, &state.reach).reduce_min();
    }
}
