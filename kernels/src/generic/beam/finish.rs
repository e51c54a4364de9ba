//! From slots to hits: primitive, depth and barycentric coordinates by the canonical formula, lane = ray.
//!
//! Each ray has its own origin, so that rays of a triangle share no more than its corners, but all sixteen rays of a
//! sub-packet go through the formula side by side in f64, once for each triangle among their hits. The operations per
//! ray are those of [`Canonical::hit`] in the same order, so it does not matter for the result which way a ray goes.

use super::{State, rays::own};
use crate::{
    exact::{Canonical, wide},
    generic::{
        F16,
        doubt::{NO_SLOT, block_of},
        leaf::triangle,
    },
    node::BvhView,
    packet::{Hit, HitBlock, RayBlock, SUB},
    simd::Simd,
    vector::{I32, Mask},
};

/// So few rays of a triangle are evaluated one by one.
const FEW: u32 = 2;

/// Writes the hits of the rays of a sub-packet that were traced together.
#[inline(always)]
pub(super) fn hits<S: Simd>(
    s: S,
    bvh: &BvhView,
    rays: &RayBlock,
    active: u16,
    state: &State,
    sub: usize,
    hits: &mut HitBlock,
) {
    let slots = &state.slot[sub];
    let all = I32::<S, 16>::load(s, slots);
    let mut left = u32::from(rays.active & active & !state.alone[sub]);
    while left != 0 {
        let slot = slots[(left.trailing_zeros() & 15) as usize];
        let mut group = all.eq(I32::splat(s, slot)).bits() & left;
        left &= !group;
        if slot == NO_SLOT {
            write(s, hits, group, &HitBlock::MISS);
            continue;
        }
        let (block, at) = block_of(bvh, slot);
        let prim = block.prim[at];
        if group.count_ones() <= FEW {
            while group != 0 {
                let lane = (group.trailing_zeros() & 15) as usize;
                group &= group - 1;
                let (frame, d) = own(&state.frame, rays, lane);
                let [a, b, c] = triangle(block, at, &frame);
                let [t, u, v] = Canonical::new(a, b, c).hit(wide(d));
                hits.set(lane, Hit { prim, t, u, v });
            }
            continue;
        }
        let [t, u, v] = evaluate(state, rays, &block.v, at);
        write(s, hits, group, &HitBlock { prim: [prim; SUB], t, u, v });
    }
}

/// Hits of the rays in `group`; the others stay.
#[inline(always)]
fn write<S: Simd>(s: S, hits: &mut HitBlock, group: u32, from: &HitBlock) {
    let mask = Mask::<S, 16>::from_bits(s, group);
    mask.iselect(I32::load(s, &from.prim), I32::load(s, &hits.prim)).store(&mut hits.prim);
    mask.select(F16::load(s, &from.t), F16::load(s, &hits.t)).store(&mut hits.t);
    mask.select(F16::load(s, &from.u), F16::load(s, &hits.u)).store(&mut hits.u);
    mask.select(F16::load(s, &from.v), F16::load(s, &hits.v)).store(&mut hits.v);
}

/// t, u, v of all rays of a sub-packet on triangle `at` of a block.
#[inline(always)]
fn evaluate(state: &State, rays: &RayBlock, vertices: &[[[f32; 8]; 3]; 3], at: usize) -> [[f32; SUB]; 3] {
    let sign = if state.frame.flip != 0 { -1.0 } else { 1.0 };
    let [iu, iv, iz] = state.frame.axes.map(|axis| axis % 3);
    let (x, y, z) = (&rays.org[iu], &rays.org[iv], &rays.org[iz]);
    let (dx, dy, dz) = (&rays.dir[iu], &rays.dir[iv], &rays.dir[iz]);
    let mut corners = [[0.0; 3]; 3];
    for i in 0..3 {
        corners[i] = [vertices[i][iu][at & 7], vertices[i][iv][at & 7], vertices[i][iz][at & 7]];
    }
    let [a, b, c] = corners;
    let mut values = [[0.0; SUB]; 3];
    for i in 0..SUB {
        let own = Canonical::new(
            [a[0] - x[i], a[1] - y[i], (a[2] - z[i]) * sign],
            [b[0] - x[i], b[1] - y[i], (b[2] - z[i]) * sign],
            [c[0] - x[i], c[1] - y[i], (c[2] - z[i]) * sign],
        );
        [values[0][i], values[1][i], values[2][i]] = own.hit(wide([dx[i], dy[i], dz[i].abs()]));
    }
    values
}
