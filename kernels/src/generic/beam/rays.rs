//! The rays of a sub-packet against one triangle, lane = ray: the bounds of `triangles` decide, or leave in doubt what is
//! then decided exactly.

use super::{
    State,
    triangles::{edge, five, plane},
};
use crate::{
    generic::{F16, Frame, doubt::nearer},
    node::BvhView,
    packet::RayBlock,
    simd::Simd,
    vector::{I32, Mask},
    visibility::Policy,
};

/// A triangle and a sub-packet.
pub(super) struct Pair<'a> {
    pub(super) lane: usize,
    pub(super) sub: usize,
    pub(super) slot: u32,
    pub(super) rays: &'a RayBlock,
}

/// Tests the rays of a sub-packet against one triangle; true if any was decided.
#[inline(always)]
pub(super) fn test<S: Simd, V: Policy, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    state: &mut State,
    pair: &Pair,
) -> bool {
    let &Pair { lane, sub, slot, rays } = pair;
    let k = &state.triangles;
    let lines = five(s, &state.lines[sub]);
    let edges = [edge(s, k, 0, lane, &lines), edge(s, k, 1, lane, &lines), edge(s, k, 2, lane, &lines)];
    let least = edges[0].min(edges[1]).min(edges[2]);
    let most = edges[0].max(edges[1]).max(edges[2]);
    if !V::EXACT {
        return test_plain::<S, ANY>(s, bvh, state, pair, &lines, [least, most]);
    }
    let doubt = F16::splat(s, k.edge_doubt[lane]);
    let beside = least.lt(-doubt) & doubt.lt(most);
    let within = doubt.lt(least) | most.lt(-doubt);
    let [above, facing] = plane(s, k, lane, &lines);
    let inverse = F16::splat(s, 1.0) / facing;
    let (depth, doubt) = (above * inverse, F16::splat(s, k.depth_doubt[lane]) * inverse.abs());
    let (least, most) = (depth - doubt, depth + doubt);
    let (lo, hi) = (F16::load(s, &state.lo[sub]), F16::load(s, &state.hi[sub]));
    let start = [F16::load(s, &state.start[0][sub]), F16::load(s, &state.start[1][sub])];
    let prim = bvh.blocks[(slot >> 3) as usize].prim[lane];
    let skipped = I32::load(s, &rays.skip).eq(I32::<S, 16>::splat(s, prim));
    let not = beside | hi.lt(least) | most.lt(start[0]) | skipped;
    let candidates = !not.bits() & u32::from(state.live[sub]);
    let sure = (within & most.lt(lo) & start[1].lt(least)).bits() & candidates;
    if ANY {
        state.live[sub] &= !(sure as u16);
    } else {
        let mask = Mask::from_bits(s, sure);
        mask.select(least, lo).store(&mut state.lo[sub]);
        mask.select(most, hi).store(&mut state.hi[sub]);
        mask.iselect(I32::splat(s, slot), I32::load(s, &state.slot[sub])).store(&mut state.slot[sub]);
    }
    let doubtful = candidates & !sure;
    let mut decided = sure != 0;
    if doubtful != 0 {
        decided |= settle::<ANY>(bvh, state, pair, doubtful);
    }
    decided
}

/// The rest of [`test`] without error bounds: the least and greatest edge function have one sign, and the depth is less
/// than any before.
#[inline(always)]
fn test_plain<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    state: &mut State,
    pair: &Pair,
    lines: &[F16<S>; 5],
    [least, most]: [F16<S>; 2],
) -> bool {
    let &Pair { lane, sub, slot, rays } = pair;
    let zero = F16::splat(s, 0.0);
    let [above, facing] = plane(s, &state.triangles, lane, lines);
    let depth = above * (F16::splat(s, 1.0) / facing);
    let hi = F16::load(s, &state.hi[sub]);
    let nearer = F16::load(s, &state.start[0][sub]).lt(depth) & depth.lt(hi);
    let prim = bvh.blocks[(slot >> 3) as usize].prim[lane];
    let skipped = I32::load(s, &rays.skip).eq(I32::<S, 16>::splat(s, prim));
    let hit = nearer.bits() & !(least.lt(zero) & zero.lt(most)).bits() & !skipped.bits();
    let hit = hit & u32::from(state.live[sub]);
    if ANY {
        state.live[sub] &= !(hit as u16);
    } else {
        let mask = Mask::from_bits(s, hit);
        mask.select(depth, hi).store(&mut state.hi[sub]);
        mask.iselect(I32::splat(s, slot), I32::load(s, &state.slot[sub])).store(&mut state.slot[sub]);
    }
    hit != 0
}

/// Decides the doubtful rays of a sub-packet exactly; true if one hits.
#[cold]
#[inline(never)]
fn settle<const ANY: bool>(bvh: &BvhView, state: &mut State, pair: &Pair, mut doubtful: u32) -> bool {
    let &Pair { sub, slot, rays, .. } = pair;
    state.doubts += u64::from(doubtful.count_ones());
    let mut decided = false;
    while doubtful != 0 {
        let i = (doubtful.trailing_zeros() & 15) as usize;
        doubtful &= doubtful - 1;
        let (frame, d) = own(&state.frame, rays, i);
        let range = [rays.tnear[i].max(0.0), rays.tfar[i]];
        if let Some(t) = nearer(bvh, &frame, d, range, slot, state.slot[sub][i]) {
            decided = true;
            if ANY {
                state.live[sub] &= !(1 << i);
            } else {
                let behind = f64::from(frame.org[2]) - f64::from(state.frame.org[2]);
                let depth = t * f64::from(d[2]) + behind.abs();
                state.lo[sub][i] = (depth * (1.0 - 5.0e-7)) as f32;
                state.hi[sub][i] = (depth * (1.0 + 5.0e-7)) as f32;
                state.slot[sub][i] = slot;
            }
        }
    }
    decided
}

/// The frame of one ray's own origin, and its direction in it.
#[inline(always)]
pub(super) fn own(frame: &Frame, rays: &RayBlock, lane: usize) -> (Frame, [f32; 3]) {
    let [iu, iv, iz] = frame.axes;
    let org = [rays.org[iu][lane], rays.org[iv][lane], rays.org[iz][lane]];
    let d = [rays.dir[iu][lane], rays.dir[iv][lane], rays.dir[iz][lane].abs()];
    (Frame { org, ..*frame }, d)
}
