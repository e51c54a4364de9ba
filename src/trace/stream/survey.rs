//! The blocks of 16 rays that a stream comes in: which of their rays fly together.

use super::{ENOUGH, Group, RayStream};
use crate::kernels::{F32, I32, Kernel, Lanes, Mask, Pick, RayBlock, SUB, Simd};

/// Rays fly about the same way if their slopes differ by no more than this from those of one of them.
const NEAR: f32 = 0.1;
/// Bits of a cell of directions in a key; the face stands above them.
pub(super) const CELL_BITS: u32 = 6;

/// One in so many blocks is measured.
const SAMPLE: usize = 4;

/// Finds out how far apart the origins of the active rays of some blocks are.
pub(super) struct Measure<'a> {
    pub(super) blocks: &'a [RayBlock],
    pub(super) sizes: &'a mut Vec<f32>,
}

/// Finds the groups in one block of every `STEP`, with origins no farther apart than `limit` from that of one of the
/// rays.
pub(super) struct Survey<'a, const STEP: usize> {
    pub(super) limit: f32,
    pub(super) blocks: &'a [RayBlock],
    pub(super) stream: &'a mut RayStream,
}

impl Kernel for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let infinity = F32::<S, SUB>::splat(s, f32::INFINITY);
        for block in self.blocks.iter().step_by(SAMPLE) {
            let active = Mask::from_bits(s, u32::from(block.active));
            let mut size = 0.0f32;
            for org in &block.org {
                let org = F32::load(s, org);
                let least = active.select(org, infinity).reduce_min();
                size = size.max(active.select(org, -infinity).reduce_max() - least);
            }
            self.sizes.push(size);
        }
    }
}

/// The faces of sixteen rays, and the slopes of their directions.
struct Ways<S: Lanes<SUB>> {
    /// As [`crate::kernels::Face::index`].
    face: I32<S, SUB>,
    u: F32<S, SUB>,
    v: F32<S, SUB>,
    keys: [u32; SUB],
}

impl<const STEP: usize> Kernel for Survey<'_, STEP> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let stream = self.stream;
        for index in (0..self.blocks.len()).step_by(STEP) {
            let block = &self.blocks[index];
            let ways = Ways::new(s, block);
            let mut alone = 0;
            let mut left = u32::from(block.active);
            while left != 0 {
                let lane = (left.trailing_zeros() & 15) as usize;
                let together = ways.near(s, block, self.limit, lane) & left;
                left &= !together;
                if together.count_ones() >= ENOUGH {
                    stream.groups.push(Group::new(ways.keys[lane], index, together as u16));
                } else {
                    alone |= together as u16;
                }
            }
            if alone != 0 {
                stream.single.push(Pick { block: index as u32, active: alone });
            }
        }
    }
}

impl<S: Simd> Ways<S> {
    /// Faces by the rule of [`crate::kernels::Face::of`]; anything for directions without a meaning.
    #[inline(always)]
    fn new(s: S, block: &RayBlock) -> Ways<S> {
        let [x, y, z] = &block.dir;
        let (x, y, z) = (F32::load(s, x), F32::load(s, y), F32::load(s, z));
        let is_x = y.abs().le(x.abs()) & z.abs().le(x.abs());
        let is_y = z.abs().le(y.abs());
        let depth = is_x.select(x, is_y.select(y, z));
        let axis = is_x.iselect(I32::splat(s, 0), is_y.iselect(I32::splat(s, 2), I32::splat(s, 4)));
        let face = axis | depth.sign().shr::<31>();
        let inverse = F32::splat(s, 1.0) / depth.abs();
        let u = is_x.select(y, is_y.select(z, x)) * inverse;
        let v = is_x.select(z, is_y.select(x, y)) * inverse;
        let mut keys = [0; SUB];
        (face.shl::<{ CELL_BITS as i32 }>() | cell(s, u) | cell(s, v).shl::<1>()).store(&mut keys);
        Ways { face, u, v, keys }
    }

    /// Rays that fly about the way of one, which itself is among them.
    #[inline(always)]
    fn near(&self, s: S, block: &RayBlock, limit: f32, lane: usize) -> u32 {
        let mut faces = [0; SUB];
        self.face.store(&mut faces);
        let (u, v) = (self.u.to_array()[lane], self.v.to_array()[lane]);
        let near = F32::splat(s, NEAR);
        let mut close = (self.u - F32::splat(s, u)).abs().le(near)
            & (self.v - F32::splat(s, v)).abs().le(near)
            & self.face.eq(I32::splat(s, faces[lane]));
        for org in &block.org {
            let distance = (F32::load(s, org) - F32::splat(s, org[lane])).abs();
            close = close & distance.le(F32::splat(s, limit));
        }
        close.bits() | 1 << lane
    }
}

/// Which of eight cells a slope in [-1, 1] is in, its bits moved apart.
#[inline(always)]
fn cell<S: Simd>(s: S, slope: F32<S, SUB>) -> I32<S, SUB> {
    let one = F32::splat(s, 1.0);
    // NaN becomes -1.
    let cell = ((slope.min(one).max(-one) + one) * F32::splat(s, 3.999)).trunc();
    let cell = (cell | cell.shl::<2>()) & I32::splat(s, 0x13);
    (cell | cell.shl::<1>()) & I32::splat(s, 0x15)
}
