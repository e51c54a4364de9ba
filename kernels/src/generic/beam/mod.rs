//! The beam kernel: up to 256 general rays that fly about the same way, closest hit and occlusion.
//!
//! The structure is that of the common-origin kernel in [`super::tile`], without the common origin. All rays of a beam
//! share a face; depth counts from a *reference point* c, which lies behind the origins of all of them. A ray is the
//! line x = a + u z, y = b + v z, where (a, b) is where it crosses the plane z = 0 through c.
//!
//! * `prepare`: lines, and for each sub-packet and the whole beam the intervals that enclose them.
//! * `walk`: the tree; boxes against the beam (lane = child), then against sub-packets (lane = sub-packet).
//! * `triangles`: a leaf's triangles set up at once (lane = triangle), each against the sub-packets (lane =
//!   sub-packet).
//! * `rays`: only where that leaves doubt, against rays (lane = ray).
//! * `finish`: hits by the canonical formula, each with the ray's own origin.
//!
//! Rays that do not fit (another face, a sub-packet whose rays fly apart) are traced one by one.

mod finish;
mod prepare;
mod rays;
mod triangles;
mod walk;

use super::{Frame, single};
use crate::{
    node::{BvhView, EMPTY_NODE, NodeRef},
    packet::{HitBlock, Pick, RayBlock, SUB, SUBS},
    simd::Simd,
    visibility::Policy,
};
use triangles::Coefficients;
use walk::Planes;

/// Sixteen floats for each sub-packet: one per ray.
type Rays = [[f32; SUB]; SUBS];

/// 2^-24: half a unit in the last place of 1, the greatest relative error of one operation.
const E: f32 = 0.5 * f32::EPSILON;

/// What a beam knows while it is traced. Depths are along the third axis of the frame, from the reference point.
#[repr(C, align(64))]
struct State {
    /// Lines: `[u, v, a, b, a v - b u]`.
    lines: [[[f32; SUB]; 5]; SUBS],
    /// Interval that the least depth that counts lies in.
    start: [Rays; 2],
    /// Interval of the best depth so far; -1 for rays that take no part.
    lo: Rays,
    hi: Rays,
    /// The best triangle so far.
    slot: [[u32; SUB]; SUBS],
    /// The sub-packets' bounds.
    bounds: Bounds<[f32; SUBS]>,
    /// Middle and half the width of the intervals of `lines`, by sub-packet.
    middle: [[f32; SUBS]; 5],
    radius: [[f32; SUBS]; 5],
    /// The same for the whole beam.
    beam: Bounds<f32>,
    beam_middle: [f32; 5],
    beam_radius: [f32; 5],
    /// Working space of `walk` and `triangles`.
    planes: Planes,
    triangles: Coefficients,
    /// Triangle (lane of its block) * 16 + sub-packet; appending writes 16 at once, whatever counts of them.
    pairs: [u32; 9 * SUBS],
    /// Rays still to be decided.
    live: [u16; SUBS],
    /// Sub-packets with such rays.
    live_subs: u32,
    /// Rays that are traced one by one.
    alone: [u16; SUBS],
    /// Greatest distance of an origin from the reference point along any axis.
    extent: f32,
    /// Of the reference point.
    frame: Frame,
    /// Pairs of a ray and a triangle that were decided exactly.
    doubts: u64,
}

/// Encloses lines and the depths of interest; widened so that box tests need not care for rounding.
#[derive(Clone, Copy)]
struct Bounds<T> {
    /// `[least, greatest]`
    u: [T; 2],
    v: [T; 2],
    a: [T; 2],
    b: [T; 2],
    /// No ray needs anything nearer.
    start: T,
    /// No ray needs anything farther.
    reach: T,
}

/// First hits of the active rays of the blocks that `picks` names, by block; the others keep what was there. Returns how
/// many pairs of a ray and a triangle were decided exactly.
#[inline(always)]
pub(crate) fn intersect<S: Simd, V: Policy>(
    s: S,
    bvh: &BvhView,
    blocks: &[RayBlock],
    picks: &[Pick],
    hits: &mut [HitBlock],
) -> u64 {
    let mut state = State::new(s, blocks, picks);
    walk::traverse::<S, V, false>(s, bvh, blocks, picks, &mut state);
    for (sub, &pick) in picks.iter().enumerate().take(SUBS) {
        let block = &blocks[pick.block as usize];
        let hits = &mut hits[pick.block as usize];
        finish::hits(s, bvh, block, pick.active, &state, sub, hits);
        let mut left = u32::from(state.alone[sub]);
        while left != 0 {
            let lane = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            hits.set(lane, single::intersect::<S, V>(s, bvh, &block.ray(lane), &mut state.doubts));
        }
    }
    state.doubts
}

/// Which active rays of the blocks that `picks` names anything blocks: bits like [`RayBlock::active`], by block.
///
/// `seed` is a leaf to try first, typically the one that blocked the previous beam; it is replaced by the leaf
/// that blocked a ray last. It changes the time, never the answer. Returns what [`intersect`] does.
#[inline(always)]
pub(crate) fn occluded<S: Simd, V: Policy>(
    s: S,
    bvh: &BvhView,
    blocks: &[RayBlock],
    picks: &[Pick],
    seed: &mut NodeRef,
    blocked: &mut [u16],
) -> u64 {
    let mut state = State::new(s, blocks, picks);
    let together = state.live;
    let mut last = EMPTY_NODE;
    if seed.is_leaf() && seed.block() < bvh.blocks.len() {
        let subs = state.live_subs;
        last = triangles::leaf::<S, V, true>(s, bvh, blocks, picks, &mut state, *seed, subs, last);
    }
    let found = walk::traverse::<S, V, true>(s, bvh, blocks, picks, &mut state);
    *seed = if found == EMPTY_NODE { last } else { found };
    for (sub, &pick) in picks.iter().enumerate().take(SUBS) {
        let mut bits = together[sub] & !state.live[sub];
        let mut left = u32::from(state.alone[sub]);
        while left != 0 {
            let lane = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            let ray = blocks[pick.block as usize].ray(lane);
            bits |= u16::from(single::occluded::<S, V>(s, bvh, &ray, &mut state.doubts)) << lane;
        }
        let blocked = &mut blocked[pick.block as usize];
        *blocked = *blocked & !(pick.active & blocks[pick.block as usize].active) | bits;
    }
    state.doubts
}
