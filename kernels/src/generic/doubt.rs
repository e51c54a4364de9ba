//! Lanes that the filters cannot decide, decided exactly, one ray and one triangle at a time.

use super::{Frame, leaf::triangle};
use crate::{
    exact::{Canonical, passes, wide},
    node::{BvhView, TriBlock},
    packet::MISS,
};

/// Slot of "no triangle": a slot is block index * 8 + lane.
pub(crate) const NO_SLOT: u32 = u32::MAX;

/// The block and lane of a slot.
#[inline(always)]
pub(crate) fn block_of<'a>(bvh: &BvhView<'a>, slot: u32) -> (&'a TriBlock, usize) {
    (&bvh.blocks[(slot >> 3) as usize], (slot & 7) as usize)
}

/// Decides whether the triangle in `slot` is a nearer hit than the one in `best`, which may be [`NO_SLOT`]. Returns
/// its canonical depth if it is.
///
/// The order of hits is that of (canonical depth, primitive id); depths from `tnear` to `tfar`, both inclusive, count.
#[cold]
#[inline(never)]
pub(crate) fn nearer(
    bvh: &BvhView,
    frame: &Frame,
    d: [f32; 3],
    [tnear, tfar]: [f32; 2],
    slot: u32,
    best: u32,
) -> Option<f64> {
    let (block, lane) = block_of(bvh, slot);
    let prim = block.prim[lane];
    if prim == MISS {
        return None;
    }
    let [a, b, c] = triangle(block, lane, frame);
    let t = Canonical::new(a, b, c).depth(wide(d));
    // What is cheaper decides first.
    if !(t >= f64::from(tnear) && t <= f64::from(tfar)) {
        return None;
    }
    if best != NO_SLOT {
        let (block, lane) = block_of(bvh, best);
        let [a, b, c] = triangle(block, lane, frame);
        if (Canonical::new(a, b, c).depth(wide(d)), block.prim[lane]) <= (t, prim) {
            return None;
        }
    }
    passes(a, b, c, d).then_some(t)
}

/// An interval of inverse depths around canonical depth `t`, wide enough for its rounding.
///
/// Depth 0, or -0, is a hit like any other: its interval begins at the greatest float instead of infinity, so that
/// the product with the depth of a box that begins at the origin is 0, and others at that depth still compete.
#[inline(always)]
pub(crate) fn inverse_interval(t: f64) -> (f32, f32) {
    let w = 1.0 / t.abs();
    (((w * (1.0 - 5.0e-7)) as f32).min(f32::MAX), (w * (1.0 + 5.0e-7)) as f32)
}
