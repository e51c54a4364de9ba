//! From slots to hits: primitive, depth and barycentric coordinates by the canonical formula.
//!
//! Neighbouring rays mostly hit the same triangle, so the work is shared: its plane once, then all rays of the
//! sub-packet at once in f64. The operations per ray are those of [`Canonical::hit`] in the same order, so it does
//! not matter for the result which way a ray goes.

use super::{
    Frame,
    doubt::{NO_SLOT, block_of},
    leaf::triangle,
};
use crate::{
    exact::Canonical,
    node::BvhView,
    packet::{MISS, SUB, SUBS, TileHits, TilePacket},
    simd::Simd,
    vector::I32,
};

/// Groups up to this size are evaluated ray by ray.
const FEW: u32 = 2;

/// Writes the hits of all active rays.
#[inline(always)]
pub(crate) fn hits<S: Simd>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    frame: &Frame,
    slots: &[[u32; SUB]; SUBS],
    hits: &mut TileHits,
) {
    for sub in 0..SUBS {
        let at = sub * SUB;
        let slots = &slots[sub];
        let slots_v = I32::<S, 16>::load(s, slots);
        let active = u32::from(packet.active[sub]);
        let missed = slots_v.eq(I32::splat(s, NO_SLOT)).bits() & active;
        each(missed, |i| {
            hits.prim[at + i] = MISS;
            hits.t[at + i] = f32::INFINITY;
            hits.u[at + i] = 0.0;
            hits.v[at + i] = 0.0;
        });
        let mut left = active & !missed;
        while left != 0 {
            let slot = slots[left.trailing_zeros() as usize];
            let group = slots_v.eq(I32::splat(s, slot)).bits() & left;
            left &= !group;
            let (block, lane) = block_of(bvh, slot);
            let [a, b, c] = triangle(block, lane, frame);
            let canonical = Canonical::new(a, b, c);
            let prim = block.prim[lane];
            if group.count_ones() <= FEW {
                each(group, |i| {
                    let d = [f64::from(packet.u[at + i]), f64::from(packet.v[at + i]), 1.0];
                    write(hits, at + i, prim, canonical.hit(d));
                });
            } else {
                many(packet, hits, &canonical, group, at, prim);
            }
        }
    }
}

/// All rays of a sub-packet at once; those of `group` are written.
#[inline(always)]
fn many(packet: &TilePacket, hits: &mut TileHits, canonical: &Canonical, group: u32, at: usize, prim: u32) {
    let us: &[f32; SUB] = packet.u[at..at + SUB].try_into().expect("16 lanes");
    let vs: &[f32; SUB] = packet.v[at..at + SUB].try_into().expect("16 lanes");
    let mut t = [0.0; SUB];
    let mut u = [0.0; SUB];
    let mut v = [0.0; SUB];
    for i in 0..SUB {
        [t[i], u[i], v[i]] = canonical.hit([f64::from(us[i]), f64::from(vs[i]), 1.0]);
    }
    if group == 0xffff {
        hits.prim[at..at + SUB].fill(prim);
        hits.t[at..at + SUB].copy_from_slice(&t);
        hits.u[at..at + SUB].copy_from_slice(&u);
        hits.v[at..at + SUB].copy_from_slice(&v);
    } else {
        each(group, |i| write(hits, at + i, prim, [t[i], u[i], v[i]]));
    }
}

#[inline(always)]
fn write(hits: &mut TileHits, ray: usize, prim: u32, [t, u, v]: [f32; 3]) {
    hits.prim[ray] = prim;
    hits.t[ray] = t;
    hits.u[ray] = u;
    hits.v[ray] = v;
}

/// Calls `f` with the index of every set bit.
#[inline(always)]
fn each(mut bits: u32, mut f: impl FnMut(usize)) {
    while bits != 0 {
        f(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}
