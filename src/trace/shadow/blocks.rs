//! The blocks of 16 rays that a stream comes in: how large each is as the light sees it.

use super::ShadowRays;
use crate::kernels::{F32, I32, Kernel, Kernels, Mask, SUB, Simd};

/// Sixteen consecutive rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Wanted rays.
    pub(super) active: u16,
    /// Their common face; 6 if they have none.
    pub(super) face: u32,
    /// Least slopes.
    pub(super) min: [f32; 2],
    /// Greatest slopes.
    pub(super) max: [f32; 2],
}

impl Block {
    /// The longer side of the slope rectangle.
    pub(super) fn size(&self) -> f32 {
        (self.max[0] - self.min[0]).max(self.max[1] - self.min[1])
    }

    /// The middle of the slope rectangle.
    pub(super) fn center(&self) -> [f32; 2] {
        [0.5 * (self.min[0] + self.max[0]), 0.5 * (self.min[1] + self.max[1])]
    }
}

/// Fills `blocks` with one entry for every 16 rays.
pub(super) fn survey(kernels: &Kernels, rays: &ShadowRays, blocks: &mut Vec<Block>) {
    blocks.clear();
    kernels.run(Survey { rays, blocks });
}

struct Survey<'a> {
    rays: &'a ShadowRays<'a>,
    blocks: &'a mut Vec<Block>,
}

impl Kernel for Survey<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let infinity = F32::<S, SUB>::splat(s, f32::INFINITY);
        let rays = self.rays;
        let (us, vs) = (rays.u.as_chunks::<SUB>().0, rays.v.as_chunks::<SUB>().0);
        let faces = rays.face.as_chunks::<SUB>().0;
        let (ends, skips) = (rays.tfar.as_chunks::<SUB>().0, rays.skip.as_chunks::<SUB>().0);
        for index in 0..faces.len() {
            // Packets will want these in another order, which no prefetcher can foresee.
            s.prefetch(&ends[index]);
            s.prefetch(&skips[index]);
            let (active, common) = faces_of(s, &faces[index]);
            let mask = Mask::from_bits(s, active);
            let (u, v) = (F32::load(s, &us[index]), F32::load(s, &vs[index]));
            self.blocks.push(Block {
                active: active as u16,
                face: common,
                min: [mask.select(u, infinity).reduce_min(), mask.select(v, infinity).reduce_min()],
                max: [mask.select(u, -infinity).reduce_max(), mask.select(v, -infinity).reduce_max()],
            });
        }
    }
}

/// The wanted rays of a block, as bits, and their common face, 6 if they have none.
#[inline(always)]
fn faces_of<S: Simd>(s: S, faces: &[u32; SUB]) -> (u32, u32) {
    let face = I32::<S, SUB>::load(s, faces);
    let first = faces[0];
    if face.eq(I32::splat(s, first)).bits() == 0xffff {
        return if first < 6 { (0xffff, first) } else { (0, 6) };
    }
    let (mut active, mut common) = (0, 6);
    for f in 0..6 {
        let of_face = face.eq(I32::splat(s, f)).bits();
        if of_face != 0 {
            common = if active == 0 { f } else { 6 };
            active |= of_face;
        }
    }
    (active, common)
}
