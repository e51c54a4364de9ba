//! Triangles against a packet.
//!
//! ```text
//!   leaf --(lane = triangle)--> triangles that the tile may meet: a list
//!     each --(lane = sub-packet)--> pairs of a triangle and a sub-packet that may meet it: a list
//!       each --(lane = ray)--> rays it misses | hits | doubtful: decided in f64, then exactly
//! ```
//!
//! The lists are why the processor seldom guesses wrong and seldom waits: entries are appended without branches, and
//! each step runs over its list in one loop whose iterations do not depend on each other. Lists are worked off
//! when the leaves of a node have been listed, for occlusion, where no order is better than another, less often.

use super::{
    State,
    block::{BlockPlanes, DEPTH},
    doubts::Settle,
    rays,
    scratch::LeafCache,
};
use crate::{
    generic::F16,
    node::{BvhView, NodeRef},
    packet::{SUBS, TilePacket},
    simd::Simd,
    vector::{I32, Mask},
    visibility::Policy,
};

/// With so many triangles listed, an occlusion query works the list off.
const ENOUGH: usize = 16;
/// Room for that, another eight leaves, and one more, because appending writes eight at once, whatever counts of them.
const TRIANGLES: usize = ENOUGH + 8 * 8 + 8;
/// Room for pairs: of those triangles with all sub-packets, and of leaves that few sub-packets reached.
const PAIRS: usize = (TRIANGLES + 1) * SUBS + 4 * ENOUGH + 8 * 8 * FEW as usize;
/// So few sub-packets are tested against a leaf's triangles one by one, lane = triangle.
pub(super) const FEW: u32 = 4;

/// Triangles to be tested, and pairs of a triangle and a sub-packet.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Batch {
    /// Slots of triangles.
    slots: [u32; TRIANGLES],
    /// The sub-packets that reached the leaf of each.
    subs: [u32; TRIANGLES],
    len: usize,
    /// Slot * 16 + sub-packet.
    pairs: [u32; PAIRS],
    paired: usize,
}

impl Batch {
    pub(super) const NONE: Batch =
        Batch { slots: [0; TRIANGLES], subs: [0; TRIANGLES], len: 0, pairs: [0; PAIRS], paired: 0 };

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.len + self.paired == 0
    }

    #[inline(always)]
    pub(super) fn is_enough(&self) -> bool {
        self.len + self.paired / 4 >= ENOUGH
    }

    /// The triangles `lanes` of block `index`, reached by `subs`.
    #[inline(always)]
    fn append<S: Simd>(&mut self, s: S, index: usize, lanes: u32, subs: u32) {
        const LANES: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];
        let at = self.len.min(TRIANGLES - 8);
        let slots = I32::<S, 8>::load(s, &LANES) + I32::splat(s, (index * 8) as u32);
        if let Some((room, _)) = self.slots[at..].split_first_chunk_mut() {
            slots.compress(lanes, room);
        }
        if let Some((room, _)) = self.subs[at..].split_first_chunk_mut() {
            I32::<S, 8>::splat(s, subs).store(room);
        }
        self.len = at + lanes.count_ones() as usize;
    }

    /// The triangles `lanes` of block `index`, each with `sub`.
    #[inline(always)]
    fn pair<S: Simd>(&mut self, s: S, index: usize, lanes: u32, sub: usize) {
        const LANES: [u32; 8] = [0, 16, 32, 48, 64, 80, 96, 112];
        let pairs = I32::<S, 8>::load(s, &LANES) + I32::splat(s, (index * 8 * SUBS + sub) as u32);
        if let Some((room, _)) = self.pairs[self.paired..].split_first_chunk_mut() {
            pairs.compress(lanes, room);
        }
        self.paired += lanes.count_ones() as usize;
    }
}

/// Lists the triangles of a leaf that the tile may meet. The leaf is not in the way of another (see [`LeafCache`]).
#[inline(always)]
pub(super) fn list<S: Simd, V: Policy>(
    s: S,
    bvh: &BvhView,
    state: &mut State,
    leaves: &mut LeafCache,
    node: NodeRef,
    subs: u32,
) {
    let index = node.block();
    let planes = leaves.get::<S, V>(s, bvh, &state.frame, index);
    if subs.count_ones() > FEW {
        let lanes = planes.within(s, state.tile_u, state.tile_v, state.tile_reach) & node.lanes();
        state.batch.append(s, index, lanes, subs);
        return;
    }
    let mut left = subs;
    while left != 0 {
        let sub = (left.trailing_zeros() & 15) as usize;
        left &= left - 1;
        let (u, v) = ([state.u[0][sub], state.u[1][sub]], [state.v[0][sub], state.v[1][sub]]);
        let lanes = planes.within(s, u, v, state.reach[sub]) & node.lanes();
        state.batch.pair(s, index, lanes, sub);
    }
}

/// Tests what has been listed.
#[inline(always)]
pub(super) fn work_off<S: Simd, V: Policy, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    leaves: &mut LeafCache,
) {
    const SUB_NUMBERS: [u32; SUBS] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    let numbers = I32::<S, 16>::load(s, &SUB_NUMBERS);
    let mut pairs = state.batch.paired;
    for at in 0..state.batch.len.min(TRIANGLES) {
        let slot = state.batch.slots[at];
        let met = sub_packets(s, leaves.at(slot), slot as usize & 7, state) & state.batch.subs[at];
        let numbers = numbers + I32::splat(s, slot * SUBS as u32);
        if let Some((room, _)) = state.batch.pairs[pairs..].split_first_chunk_mut() {
            numbers.compress(met, room);
        }
        pairs += met.count_ones() as usize;
    }
    state.work = state.work.saturating_add((state.batch.len + pairs) as u32);
    (state.batch.len, state.batch.paired) = (0, 0);
    leaves.release();
    let (mut touched, mut last) = (0, state.last);
    for at in 0..pairs {
        let pair = state.batch.pairs[at];
        let (slot, sub) = (pair / SUBS as u32, pair as usize % SUBS);
        let decided = test::<S, V, ANY>(s, bvh, packet, state, leaves.at(slot), slot, sub);
        touched |= u32::from(decided) << sub;
        last = if decided { slot } else { last };
    }
    state.last = last;
    if touched != 0 {
        refresh::<S, ANY>(s, state, touched);
    }
}

/// Sub-packets that triangle `lane` may meet; lane = sub-packet.
#[inline(always)]
pub(super) fn sub_packets<S: Simd>(s: S, planes: &BlockPlanes, lane: usize, state: &State) -> u32 {
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

/// Tests the rays of a sub-packet against the triangle in `slot`: true if any was decided.
#[inline(always)]
pub(super) fn test<S: Simd, V: Policy, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    planes: &BlockPlanes,
    slot: u32,
    sub: usize,
) -> bool {
    let lane = slot as usize & 7;
    let u = F16::load(s, &rays(&packet.u)[sub]);
    let v = F16::load(s, &rays(&packet.v)[sub]);
    let e0 = planes.value(s, 0, lane, u, v);
    let inside = e0.min(planes.value(s, 1, lane, u, v)).min(planes.value(s, 2, lane, u, v));
    let w = planes.value(s, DEPTH, lane, u, v);
    let (lo, hi) = (F16::load(s, &state.lo[sub]), F16::load(s, &state.hi[sub]));
    let candidate = F16::splat(s, 0.0).le(inside) & if V::EXACT { lo.le(w) } else { lo.lt(w) };
    let w_lo = if V::EXACT { w - planes.depth_doubt(s, lane) } else { w };
    let pierced = candidate & planes.edge_doubt(s, lane).lt(inside);
    let sure = if V::EXACT { pierced & hi.lt(w_lo) } else { candidate };
    // Rays that are decided or take no part are not live.
    let mut candidates = candidate.bits() & u32::from(state.live[sub]);
    if packet.bounded {
        let prim = I32::splat(s, bvh.blocks[slot as usize >> 3].prim[lane]);
        candidates &= !I32::load(s, &rays(&packet.skip)[sub]).eq(prim).bits();
    }
    let sure = sure.bits() & candidates;
    if ANY {
        state.live[sub] &= !(sure as u16);
    } else {
        let sure = Mask::from_bits(s, sure);
        sure.select(w_lo, lo).store(&mut state.lo[sub]);
        if V::EXACT {
            sure.select(w, hi).store(&mut state.hi[sub]);
        }
        sure.iselect(I32::splat(s, slot), I32::load(s, &state.slot[sub])).store(&mut state.slot[sub]);
    }
    let doubtful = candidates & !sure;
    let mut decided = sure != 0;
    if V::EXACT && doubtful != 0 {
        let (rays, pierced) = (doubtful, pierced.bits());
        decided |= s.apart(Settle::<ANY> { bvh, packet, state, slot, sub, rays, pierced });
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
            state.live_subs &= !(u32::from(state.live[sub] == 0 && state.early.stop) << sub);
        } else if state.early.bound {
            state.reach[sub] = F16::load(s, &state.lo[sub]).reduce_min();
        }
    }
    if !ANY {
        state.tile_reach = F16::load(s, &state.reach).reduce_min();
    }
}
