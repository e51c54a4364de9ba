//! Filling blocks of eight triangles.

use crate::{
    kernels::{MISS, NodeRef, TriBlock},
    scene::TriangleMesh,
};

/// Fills blocks, keeping a few of them open so that small leaves find room near their neighbours.
#[derive(Default)]
pub(super) struct Packer {
    pub(super) blocks: Vec<TriBlock>,
    /// Open blocks, oldest first: index and used lanes.
    open: Vec<(usize, usize)>,
}

impl Packer {
    const OPEN: usize = 4;

    /// A leaf of up to eight triangles.
    pub(super) fn pack(&mut self, mesh: &TriangleMesh, prims: &[u32]) -> NodeRef {
        let fitting = self.open.iter().enumerate().filter(|(_, (_, used))| used + prims.len() <= 8);
        let best = fitting.max_by_key(|(_, (_, used))| *used).map(|(at, _)| at);
        let at = best.unwrap_or_else(|| {
            if self.open.len() == Self::OPEN {
                self.open.remove(0);
            }
            self.blocks.push(TriBlock::EMPTY);
            self.open.push((self.blocks.len() - 1, 0));
            self.open.len() - 1
        });
        let (index, used) = self.open[at];
        let block = &mut self.blocks[index];
        for (lane, &prim) in (used..).zip(prims) {
            debug_assert_eq!(block.prim[lane], MISS);
            block.prim[lane] = prim;
            for (corner, position) in mesh.corners(prim as usize).into_iter().enumerate() {
                for axis in 0..3 {
                    block.v[corner][axis][lane] = position[axis];
                }
            }
        }
        let filled = used + prims.len();
        if filled == 8 {
            self.open.remove(at);
        } else {
            self.open[at].1 = filled;
        }
        NodeRef::leaf(index, used, prims.len())
    }
}
