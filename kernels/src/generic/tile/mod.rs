//! The common-origin tile kernel: 256 rays against the tree, closest hit and occlusion.
//!
//! The structure is that of multi-level culling (Reshetov 2005; Wald 2007; Boulos 2006) with the arithmetic of
//! edge functions over slopes (Davidovic 2012, "3D rasterization"): see the crate's documentation for the picture.
//!
//! * `walk`: the tree; boxes against the tile's frustum (lane = child), then against its sub-packets' (lane =
//!   sub-packet).
//! * `block`: a leaf's triangles set up for the origin (lane = triangle), remembered by `scratch` from packet to
//!   packet.
//! * `triangles`: each against the tile (lane = triangle), the sub-packets (lane = sub-packet), and only where that
//!   leaves doubt against rays (lane = ray).
//! * `doubts`: rays that this cannot decide, sixteen of a sub-packet at a time in f64, then exactly.
//!
//! # Why culling never loses a hit
//!
//! Vertices relative to the origin are rounded once, fl(v - o); box planes likewise, and since rounding is monotonic
//! fl(box - o) still encloses every fl(v - o). An exact hit lies within the rounded triangle, hence within the
//! rounded box. The comparisons below are products of floats against floats: if a real product is <= x then so is
//! the rounded one, so none of them can reject what real arithmetic would keep. Depth is compared as
//! z0 * inverse_depth <= 1, where the inverse depth is a lower bound of the best hit's: the same argument holds.

mod block;
mod boxes;
mod doubts;
mod early;
pub mod micro;
mod scratch;
mod triangles;
mod walk;

pub use early::{SEEDS, TileEarly};
pub use scratch::TileScratch;

use super::{F16, Frame, doubt::NO_SLOT, finish};
use crate::{
    node::{BvhView, EMPTY_NODE, NodeRef},
    packet::{SUBS, TileHits, TilePacket},
    simd::Simd,
    vector::{I32, Mask},
    visibility::Policy,
};
use boxes::Boxes;
use doubts::Contenders;
use triangles::Batch;

/// Sixteen floats for each sub-packet: one per ray.
type Rays = [[f32; 16]; SUBS];

/// What a packet knows while it is traced.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
struct State {
    /// Interval of the best inverse depth so far; infinite for rays that take no part. Like `slot`, meaningless for
    /// sub-packets without rays.
    lo: Rays,
    hi: Rays,
    /// The best triangle so far.
    slot: [[u32; 16]; SUBS],
    /// Slope rectangle of each sub-packet: `[least, greatest]`.
    u: [[f32; SUBS]; 2],
    v: [[f32; SUBS]; 2],
    /// Least `lo` of each sub-packet: no ray of it needs anything farther.
    reach: [f32; SUBS],
    /// Working space of `walk` and `triangles`.
    boxes: Boxes,
    batch: Batch,
    /// Stands for tree, origin and face; see `scratch`.
    epoch: u32,
    contenders: Contenders,
    /// Slot of the triangle that decided a ray last.
    last: u32,
    /// Rays still to be decided.
    live: [u16; SUBS],
    /// Sub-packets with such rays.
    live_subs: u32,
    /// Slope rectangle and reach of the whole tile.
    tile_u: [f32; 2],
    tile_v: [f32; 2],
    tile_reach: f32,
    frame: Frame,
    /// Pairs of a ray and a triangle that were decided exactly.
    doubts: u64,
    early: TileEarly,
    /// Work done for the packet, see [`TileScratch::set_budget`], and beyond what amount it is given up.
    work: u32,
    budget: u32,
    gave_up: bool,
}

/// First hits of all active rays, unless the packet is given up. Returns how many pairs of a ray and a triangle were decided
/// exactly.
#[inline(always)]
pub(crate) fn intersect<S: Simd, V: Policy>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    scratch: &mut TileScratch,
    hits: &mut TileHits,
) -> u64 {
    let TileScratch { state, leaves, planes } = scratch;
    state.begin::<S, V>(s, packet);
    leaves.begin::<V>(bvh, packet);
    state.epoch = leaves.epoch();
    walk::traverse::<S, V, false>(s, bvh, packet, state, leaves, bvh.root);
    if state.gave_up {
        return state.doubts;
    }
    finish::hits(s, bvh, packet, &state.frame, planes, leaves.epoch(), &state.slot, hits);
    state.doubts
}

/// The rays that something blocks between the origin and `tfar`, as bits like [`TilePacket::active`].
///
/// `seed` is a leaf to try first, typically what blocked the previous packet; it is replaced by the triangle that blocked
/// a ray last. It changes the time, never the answer. Returns what [`intersect`] does.
#[inline(always)]
pub(crate) fn occluded<S: Simd, V: Policy>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    scratch: &mut TileScratch,
    seed: &mut NodeRef,
    blocked: &mut [u16; SUBS],
) -> u64 {
    let TileScratch { state, leaves, .. } = scratch;
    state.begin::<S, V>(s, packet);
    leaves.begin::<V>(bvh, packet);
    state.epoch = leaves.epoch();
    let started = state.live;
    if seed.is_leaf() && seed.block() < bvh.blocks.len() {
        let subs = state.live_subs;
        triangles::list::<S, V>(s, bvh, state, leaves, *seed, subs);
        triangles::work_off::<S, V, true>(s, bvh, packet, state, leaves);
    }
    walk::traverse::<S, V, true>(s, bvh, packet, state, leaves, bvh.root);
    *seed = if state.last == NO_SLOT { EMPTY_NODE } else { NodeRef::triangle(state.last) };
    for sub in 0..SUBS {
        blocked[sub] = started[sub] & !state.live[sub];
    }
    state.doubts
}

impl State {
    /// Nothing known of any packet.
    fn new() -> State {
        State {
            lo: [[0.0; 16]; SUBS],
            hi: [[0.0; 16]; SUBS],
            slot: [[NO_SLOT; 16]; SUBS],
            u: [[0.0; SUBS]; 2],
            v: [[0.0; SUBS]; 2],
            reach: [0.0; SUBS],
            boxes: Boxes::NONE,
            batch: Batch::NONE,
            epoch: 1,
            contenders: Contenders::new(),
            last: NO_SLOT,
            doubts: 0,
            live: [0; SUBS],
            live_subs: 0,
            tile_u: [0.0; 2],
            tile_v: [0.0; 2],
            tile_reach: 0.0,
            frame: Frame { org: [0.0; 3], axes: [1, 2, 0], flip: 0 },
            early: TileEarly::ALL,
            work: 0,
            budget: u32::MAX,
            gave_up: false,
        }
    }

    /// Forgets the previous packet.
    #[inline(always)]
    fn begin<S: Simd, V: Policy>(&mut self, s: S, packet: &TilePacket) {
        // Packets are large: ask for all of it before waiting for the first line.
        s.prefetch(&packet.u);
        s.prefetch(&packet.v);
        let infinity = F16::splat(s, f32::INFINITY);
        infinity.store(&mut self.u[0]);
        (-infinity).store(&mut self.u[1]);
        infinity.store(&mut self.v[0]);
        (-infinity).store(&mut self.v[1]);
        infinity.store(&mut self.reach);
        self.last = NO_SLOT;
        self.doubts = 0;
        (self.work, self.gave_up) = (0, false);
        self.live = packet.active;
        self.live_subs = 0;
        self.frame = Frame::new(packet.org, packet.face);
        for sub in 0..SUBS {
            if packet.active[sub] != 0 {
                self.sub_packet::<S, V>(s, packet, sub);
                self.live_subs |= u32::from(self.live[sub] != 0) << sub;
            }
        }
        self.tile_u = [F16::load(s, &self.u[0]).reduce_min(), F16::load(s, &self.u[1]).reduce_max()];
        self.tile_v = [F16::load(s, &self.v[0]).reduce_min(), F16::load(s, &self.v[1]).reduce_max()];
        self.tile_reach = F16::load(s, &self.reach).reduce_min();
    }

    /// Bounds of one sub-packet. Rays without a meaning are not among the live ones.
    #[inline(always)]
    fn sub_packet<S: Simd, V: Policy>(&mut self, s: S, packet: &TilePacket, sub: usize) {
        let infinity = F16::splat(s, f32::INFINITY);
        let u = F16::load(s, &rays(&packet.u)[sub]);
        let v = F16::load(s, &rays(&packet.v)[sub]);
        // NaN fails.
        let one = F16::splat(s, 1.0);
        let mut valid = u.abs().le(one) & v.abs().le(one);
        if packet.bounded {
            valid = valid & F16::splat(s, 0.0).lt(F16::load(s, &rays(&packet.tfar)[sub]));
        }
        self.live[sub] &= valid.bits() as u16;
        let active = Mask::from_bits(s, u32::from(self.live[sub]));
        let (mut lo, mut hi) = (F16::splat(s, 0.0), F16::splat(s, 0.0));
        if packet.bounded {
            // 1 / tfar is off by half a unit: these factors enclose it.
            let inverse = F16::splat(s, 1.0) / F16::load(s, &rays(&packet.tfar)[sub]);
            let error = if V::EXACT { 2.5e-7 } else { 0.0 };
            lo = inverse * F16::splat(s, 1.0 - error);
            hi = inverse * F16::splat(s, 1.0 + error);
        }
        let lo = active.select(lo, infinity);
        lo.store(&mut self.lo[sub]);
        active.select(hi, infinity).store(&mut self.hi[sub]);
        I32::splat(s, NO_SLOT).store(&mut self.slot[sub]);
        self.reach[sub] = if packet.bounded { lo.reduce_min() } else { 0.0 };
        let (u, v) = ([u, -u], [v, -v]);
        let (u0, u1) = (active.select(u[0], infinity), active.select(u[1], infinity));
        let (v0, v1) = (active.select(v[0], infinity), active.select(v[1], infinity));
        let [u0, u1, v0, v1] = F16::reduce_min4(s, [u0, u1, v0, v1]);
        (self.u[0][sub], self.u[1][sub]) = (u0, -u1);
        (self.v[0][sub], self.v[1][sub]) = (v0, -v1);
    }

    /// Sub-packets of `subs` that are still looking for something as near as depth `near`.
    #[inline(always)]
    fn interested<S: Simd>(&self, s: S, near: f32, subs: u32) -> u32 {
        let near = F16::splat(s, near);
        let within = (near * F16::load(s, &self.reach)).le(F16::splat(s, 1.0));
        within.bits() & subs & self.live_subs
    }
}

/// A packet's array by sub-packet.
#[inline(always)]
fn rays<T>(array: &[T; 256]) -> &[[T; 16]; SUBS] {
    const { assert!(SUBS * crate::packet::SUB == 256) };
    array.as_chunks::<16>().0.try_into().expect("16 x 16 rays")
}
