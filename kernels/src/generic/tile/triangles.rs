//! A leaf's triangles against a packet.
//!
//! ```text
//!   block of 8 triangles --(lane = triangle)--> those that the tile may meet
//!     each --(lane = sub-packet)--> pairs of a triangle and a sub-packet that may meet it: a list
//!       each pair --(lane = ray)--> rays it misses | hits | doubtful: decided exactly
//! ```
//!
//! The list is why the processor seldom guesses wrong: pairs are appended without branches, and one loop without
//! branches, but for the rare doubtful rays, runs over all of them.

use super::{
    State,
    block::{BlockPlanes, DEPTH},
    rays,
    scratch::LeafCache,
};
use crate::{
    generic::{
        F16,
        doubt::{inverse_interval, nearer},
    },
    node::{BvhView, NodeRef},
    packet::{SUB, SUBS, TilePacket},
    simd::Simd,
    vector::{I32, Mask},
};

/// Pairs of a triangle (lane of its block) and a sub-packet that may meet: `lane * 16 + sub`.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Pairs {
    /// Appending writes 16 at once, whatever counts of them.
    list: [u32; 8 * SUBS + SUBS],
    len: usize,
}

impl Pairs {
    pub(super) const NONE: Pairs = Pairs { list: [0; 8 * SUBS + SUBS], len: 0 };

    /// Triangle `lane` with each of `subs`.
    #[inline(always)]
    fn append<S: Simd>(&mut self, s: S, lane: usize, subs: u32) {
        const SUB_NUMBERS: [u32; SUBS] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        let pairs = I32::<S, 16>::load(s, &SUB_NUMBERS) + I32::splat(s, (lane * SUBS) as u32);
        let Some((room, _)) = self.list[self.len..].split_first_chunk_mut() else { return };
        pairs.compress(subs, room);
        self.len += subs.count_ones() as usize;
    }
}

/// Tests a run of triangles; returns `node` if it decided a ray, else `last`.
#[inline(always)]
pub(super) fn leaf<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    leaves: &mut LeafCache,
    node: NodeRef,
    subs: u32,
    last: NodeRef,
) -> NodeRef {
    let index = node.block();
    let planes = leaves.get(s, bvh, &state.frame, index);
    let mut left = planes.within(s, state.tile_u, state.tile_v, state.tile_reach) & node.lanes();
    state.pairs.len = 0;
    while left != 0 {
        let lane = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        let met = sub_packets(s, planes, lane, state) & subs;
        state.pairs.append(s, lane, met);
    }
    let mut touched = 0;
    for at in 0..state.pairs.len {
        let pair = state.pairs.list[at];
        let (lane, sub) = ((pair >> 4 & 7) as usize, (pair & 15) as usize);
        let decided = test::<S, ANY>(s, bvh, packet, state, planes, index, lane, sub);
        touched |= u32::from(decided) << sub;
    }
    if touched == 0 {
        return last;
    }
    refresh::<S, ANY>(s, state, touched);
    node
}

/// Sub-packets that triangle `lane` may meet; lane = sub-packet.
#[inline(always)]
fn sub_packets<S: Simd>(s: S, planes: &BlockPlanes, lane: usize, state: &State) -> u32 {
    let (u, v) = (&state.u, &state.v);
    let [[u_least, u_most], [v_least, v_most]] = &planes.extent;
    let mut inside = F16::splat(s, u_least[lane]).le(F16::load(s, &u[1]));
    inside = inside & F16::load(s, &u[0]).le(F16::splat(s, u_most[lane]));
    inside = inside & F16::splat(s, v_least[lane]).le(F16::load(s, &v[1]));
    inside = inside & F16::load(s, &v[0]).le(F16::splat(s, v_most[lane]));
    inside = inside & F16::load(s, &state.reach).le(planes.greatest(s, DEPTH, lane, u, v));
    for i in 0..DEPTH {
        inside = inside & F16::splat(s, 0.0).le(planes.greatest(s, i, lane, u, v));
    }
    inside.bits()
}

/// Tests the rays of a sub-packet against triangle `lane` of block `index`; true if any was decided.
#[inline(always)]
fn test<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    planes: &BlockPlanes,
    index: usize,
    lane: usize,
    sub: usize,
) -> bool {
    let u = F16::load(s, &rays(&packet.u)[sub]);
    let v = F16::load(s, &rays(&packet.v)[sub]);
    let e0 = planes.value(s, 0, lane, u, v);
    let inside = e0.min(planes.value(s, 1, lane, u, v)).min(planes.value(s, 2, lane, u, v));
    let w = planes.value(s, DEPTH, lane, u, v);
    let (lo, hi) = (F16::load(s, &state.lo[sub]), F16::load(s, &state.hi[sub]));
    let candidate = F16::splat(s, 0.0).le(inside) & lo.le(w);
    let w_lo = w - planes.depth_doubt(s, lane);
    let sure = candidate & planes.edge_doubt(s, lane).lt(inside) & hi.lt(w_lo);
    // Rays that are decided or take no part are not live.
    let mut candidates = candidate.bits() & u32::from(state.live[sub]);
    if packet.bounded {
        let prim = I32::splat(s, bvh.blocks[index].prim[lane]);
        candidates &= !I32::load(s, &rays(&packet.skip)[sub]).eq(prim).bits();
    }
    let sure = sure.bits() & candidates;
    if ANY {
        state.live[sub] &= !(sure as u16);
    } else {
        let sure = Mask::from_bits(s, sure);
        sure.select(w_lo, lo).store(&mut state.lo[sub]);
        sure.select(w, hi).store(&mut state.hi[sub]);
        let slot = I32::splat(s, (index * 8 + lane) as u32);
        sure.iselect(slot, I32::load(s, &state.slot[sub])).store(&mut state.slot[sub]);
    }
    let doubtful = candidates & !sure;
    let mut decided = sure != 0;
    if doubtful != 0 {
        decided |= settle::<ANY>(bvh, packet, state, doubtful, sub, (index * 8 + lane) as u32);
    }
    decided
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
        if let Some(t) = nearer(bvh, &state.frame, direction, [0.0, packet.tfar(ray)], slot, best) {
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
