//! From slots to hits: primitive, depth and barycentric coordinates by the canonical formula.
//!
//! Neighbouring rays mostly hit the same triangle, so the work is shared: its plane once, remembered for the next
//! sub-packets and packets, then all rays of the sub-packet at once in f64. The operations per ray are those of
//! [`Canonical::hit`] in the same order, so it does not matter for the result which way a ray goes.

use super::{
    F16, Frame,
    doubt::{NO_SLOT, block_of},
    leaf::triangle,
};
use crate::{
    exact::Canonical,
    node::BvhView,
    packet::{MISS, SUB, SUBS, TileHits, TilePacket},
    simd::Simd,
    vector::{I32, Mask},
};

/// Planes remembered.
const ENTRIES: usize = 64;

/// Canonical planes of the triangles hit last, by slot.
#[derive(Clone, Debug)]
pub(crate) struct Planes {
    /// Epoch (see the scratch of the tile kernel) and slot.
    tags: [u64; ENTRIES],
    planes: [(Canonical, u32); ENTRIES],
}

impl Planes {
    pub(crate) fn new() -> Planes {
        let plane = Canonical::new([0.0; 3], [0.0; 3], [0.0; 3]);
        Planes { tags: [0; ENTRIES], planes: [(plane, MISS); ENTRIES] }
    }

    /// The plane of a slot's triangle and its primitive id.
    #[inline(always)]
    fn get(&mut self, bvh: &BvhView, frame: &Frame, epoch: u32, slot: u32) -> &(Canonical, u32) {
        let at = slot as usize % ENTRIES;
        let tag = u64::from(epoch) << 32 | u64::from(slot);
        if self.tags[at] != tag {
            self.tags[at] = tag;
            let (block, lane) = block_of(bvh, slot);
            let [a, b, c] = triangle(block, lane, frame);
            self.planes[at] = (Canonical::new(a, b, c), block.prim[lane]);
        }
        &self.planes[at]
    }
}

/// Writes the hits of all active rays. `epoch` is never 0, and another one for another tree, origin or face.
#[inline(always)]
pub(crate) fn hits<S: Simd>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    frame: &Frame,
    planes: &mut Planes,
    epoch: u32,
    slots: &[[u32; SUB]; SUBS],
    hits: &mut TileHits,
) {
    for sub in 0..SUBS {
        let slots = &slots[sub];
        let active = u32::from(packet.active[sub]);
        if active == 0 {
            continue;
        }
        let slots_v = I32::<S, 16>::load(s, slots);
        let missed = slots_v.eq(I32::splat(s, NO_SLOT)).bits() & active;
        if missed != 0 {
            let zero = F16::splat(s, 0.0);
            write(s, hits, sub, missed, MISS, [F16::splat(s, f32::INFINITY), zero, zero]);
        }
        let mut left = active & !missed;
        while left != 0 {
            let slot = slots[(left.trailing_zeros() & 15) as usize];
            let group = slots_v.eq(I32::splat(s, slot)).bits() & left;
            left &= !group;
            let (canonical, prim) = planes.get(bvh, frame, epoch, slot);
            let at = sub * SUB;
            let mut values = [[0.0; SUB]; 3];
            for i in 0..SUB {
                let d = [f64::from(packet.u[at + i]), f64::from(packet.v[at + i]), 1.0];
                [values[0][i], values[1][i], values[2][i]] = canonical.hit(d);
            }
            let [t, u, v] = &values;
            write(s, hits, sub, group, *prim, [F16::load(s, t), F16::load(s, u), F16::load(s, v)]);
        }
    }
}

/// Hits of the rays in `group`; the others stay.
#[inline(always)]
fn write<S: Simd>(s: S, hits: &mut TileHits, sub: usize, group: u32, prim: u32, [t, u, v]: [F16<S>; 3]) {
    let at = sub * SUB;
    if group == 0xffff {
        t.store_at(&mut hits.t, at);
        u.store_at(&mut hits.u, at);
        v.store_at(&mut hits.v, at);
        I32::<S, 16>::splat(s, prim).store(&mut hits.prim.as_chunks_mut().0[sub]);
        return;
    }
    let mask = Mask::<S, 16>::from_bits(s, group);
    mask.select(t, F16::load_at(s, &hits.t, at)).store_at(&mut hits.t, at);
    mask.select(u, F16::load_at(s, &hits.u, at)).store_at(&mut hits.u, at);
    mask.select(v, F16::load_at(s, &hits.v, at)).store_at(&mut hits.v, at);
    let prims: &mut [u32; SUB] = &mut hits.prim.as_chunks_mut().0[sub];
    mask.iselect(I32::splat(s, prim), I32::load(s, prims)).store(prims);
}
