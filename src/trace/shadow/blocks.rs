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
        for ((u, v), faces) in us.iter().zip(vs).zip(rays.face.as_chunks::<SUB>().0) {
            let face = I32::load(s, faces);
            let mut active = 0;
            let mut common = 6;
            for f in 0..6 {
                let of_face = face.eq(I32::splat(s, f)).bits();
                if of_face != 0 {
                    common = if active == 0 { f } else { 6 };
                    active |= of_face;
                }
            }
            let mask = Mask::from_bits(s, active);
            let (u, v) = (F32::load(s, u), F32::load(s, v));
            self.blocks.push(Block {
                active: active as u16,
                face: common,
                min: [mask.select(u, infinity).reduce_min(), mask.select(v, infinity).reduce_min()],
                max: [mask.select(u, -infinity).reduce_max(), mask.select(v, -infinity).reduce_max()],
            });
        }
    }
}
