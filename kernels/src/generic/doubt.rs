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
    Duel::new(bvh, frame, slot).nearer(bvh, frame, d, [tnear, tfar], best, false)
}

/// A triangle against the ones that rays hit so far. Their planes are computed once for all rays of a packet.
pub(crate) struct Duel {
    corners: [[f32; 3]; 3],
    plane: Canonical,
    prim: u32,
    /// The latest opponent: its slot, plane and primitive.
    best: (u32, Canonical, u32),
}

impl Duel {
    #[inline(always)]
    pub(crate) fn new(bvh: &BvhView, frame: &Frame, slot: u32) -> Duel {
        let (block, lane) = block_of(bvh, slot);
        let corners = triangle(block, lane, frame);
        let [a, b, c] = corners;
        let plane = Canonical::new(a, b, c);
        Duel { corners, plane, prim: block.prim[lane], best: (NO_SLOT, plane, MISS) }
    }

    /// As [`nearer`]; `pierced` if the ray is known to pass through the triangle.
    #[inline(always)]
    pub(crate) fn nearer(
        &mut self,
        bvh: &BvhView,
        frame: &Frame,
        d: [f32; 3],
        [tnear, tfar]: [f32; 2],
        best: u32,
        pierced: bool,
    ) -> Option<f64> {
        if self.prim == MISS {
            return None;
        }
        let t = self.plane.depth(wide(d));
        // What is cheaper decides first.
        if !(t >= f64::from(tnear) && t <= f64::from(tfar)) {
            return None;
        }
        if best != NO_SLOT {
            if self.best.0 != best {
                let (block, lane) = block_of(bvh, best);
                let [a, b, c] = triangle(block, lane, frame);
                self.best = (best, Canonical::new(a, b, c), block.prim[lane]);
            }
            if (self.best.1.depth(wide(d)), self.best.2) <= (t, self.prim) {
                return None;
            }
        }
        let [a, b, c] = self.corners;
        (pierced || passes(a, b, c, d)).then_some(t)
    }
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
