//! From slots to hits: primitive, depth and barycentric coordinates by the canonical formula, lane = ray.
//!
//! Each ray has its own origin, so that nothing is shared between rays of a triangle, but all sixteen rays of a
//! sub-packet go through the formula side by side in f64. The operations per ray are those of [`Canonical::hit`] in the
//! same order, so it does not matter for the result which way a ray goes.

use super::State;
use crate::{
    exact::{Canonical, wide},
    generic::doubt::{NO_SLOT, block_of},
    node::BvhView,
    packet::{Hit, MISS, RayBlock, SUB},
};

/// Writes the hits of the rays of a sub-packet that were traced together.
#[inline(always)]
pub(super) fn hits(
    bvh: &BvhView,
    rays: &RayBlock,
    active: u16,
    state: &State,
    sub: usize,
    hits: &mut [Hit; SUB],
) {
    let wanted = u32::from(rays.active & active & !state.alone[sub]);
    let slots = &state.slot[sub];
    let axes = state.frame.axes;
    // `corners[corner][axis][lane]`, in the axes of the frame, not yet relative to the origin.
    let mut corners = [[[0.0; SUB]; 3]; 3];
    let mut prims = [MISS; SUB];
    let mut any = false;
    for lane in 0..SUB {
        if slots[lane] != NO_SLOT {
            any = true;
            let (block, at) = block_of(bvh, slots[lane]);
            prims[lane] = block.prim[at];
            for corner in 0..3 {
                for k in 0..3 {
                    corners[corner][k][lane] = block.v[corner][axes[k]][at];
                }
            }
        }
    }
    let mut found = [[f32::INFINITY, 0.0, 0.0]; SUB];
    if any {
        let sign = if state.frame.flip != 0 { -1.0 } else { 1.0 };
        let [iu, iv, iz] = axes;
        let org = [&rays.org[iu], &rays.org[iv], &rays.org[iz]];
        let dir = [&rays.dir[iu], &rays.dir[iv], &rays.dir[iz]];
        for lane in 0..SUB {
            let mut own = [[0.0; 3]; 3];
            for corner in 0..3 {
                for k in 0..3 {
                    own[corner][k] = corners[corner][k][lane] - org[k][lane];
                }
                own[corner][2] *= sign;
            }
            let d = wide([dir[0][lane], dir[1][lane], dir[2][lane].abs()]);
            found[lane] = Canonical::new(own[0], own[1], own[2]).hit(d);
        }
    }
    let mut left = wanted;
    while left != 0 {
        let lane = (left.trailing_zeros() & 15) as usize;
        left &= left - 1;
        let [t, u, v] = found[lane];
        let hit = Hit { prim: prims[lane], t, u, v };
        hits[lane] = if prims[lane] == MISS { Hit::MISS } else { hit };
    }
}
