//! Trees over triangles that move: the same tree with new boxes, or a new one where that has become too bad.
//!
//! ```text
//!   mesh at another time --> triangles --> boxes, from the leaves up --> cost beyond WORN times that of the build?
//!                                                                         no: done    yes: built anew
//! ```
//!
//! Wald, Boulos, Shirley, "Ray tracing deformable scenes using dynamic bounding volume hierarchies" (2007), refits every
//! frame and builds anew when the tree has worn out. Here the cost by the surface area heuristic tells when.
//!
//! Boxes of a refitted tree are as tight as those of a built one, so that the kernels' proof holds for it alike. It counts
//! as another tree: what kernels remember of it has other corners now.

use super::{BuildPreset, Bvh};
use crate::{
    error::Result,
    kernels::{BvhView, MISS, Node, NodeKind, TriBlock},
    math::Aabb,
    scene::TriangleMesh,
};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// A refitted tree whose cost is more than this many times that of its build is built anew. `benches/LOG.md` tells what
/// that was chosen from.
pub const WORN: f64 = 1.2;

/// What was done to a tree when its triangles moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Update {
    /// Its boxes fit again.
    Refitted,
    /// It was built anew.
    Rebuilt,
}

impl Bvh {
    /// Lets the tree follow its triangles: refits it, and builds it anew by `preset` if its cost is [`WORN`] times that of
    /// its build then. On rayon's threads, as [`Bvh::build`].
    ///
    /// # Errors
    /// As [`Bvh::build`].
    ///
    /// # Panics
    /// As [`Bvh::refit`].
    pub fn follow(&mut self, mesh: &TriangleMesh, preset: BuildPreset) -> Result<Update> {
        let built = self.built_cost.unwrap_or_else(|| self.sah_cost());
        self.built_cost = Some(built);
        self.refit(mesh);
        if self.sah_cost() <= WORN * built {
            return Ok(Update::Refitted);
        }
        *self = Bvh::build(mesh, preset)?;
        Ok(Update::Rebuilt)
    }

    /// Fits the tree to new corners of the same triangles, on rayon's threads. Its leaves stay what they are.
    ///
    /// # Panics
    /// If `mesh` has fewer triangles than the one it was built over.
    pub fn refit(&mut self, mesh: &TriangleMesh) {
        self.blocks.par_iter_mut().with_min_len(256).for_each(|block| place(block, mesh));
        let blocks = &self.blocks[..];
        let top = self.pieces[1];
        let mut rest = &mut self.nodes[top..];
        let mut pieces = Vec::with_capacity(self.pieces.len());
        for ends in self.pieces[1..].windows(2) {
            let (piece, others) = rest.split_at_mut(ends[1] - ends[0]);
            pieces.push((ends[0], piece));
            rest = others;
        }
        pieces.into_par_iter().for_each(|(first, piece)| fit(piece, piece.len(), first, blocks));
        fit(&mut self.nodes, top, 0, blocks);
        self.id = BvhView::fresh_id();
    }
}

/// Gives the triangles of a block their corners.
fn place(block: &mut TriBlock, mesh: &TriangleMesh) {
    for lane in 0..8 {
        let prim = block.prim[lane];
        if prim != MISS {
            for (corner, position) in block.v.iter_mut().zip(mesh.corners(prim as usize)) {
                for axis in 0..3 {
                    corner[axis][lane] = position[axis];
                }
            }
        }
    }
}

/// Fits the boxes of the first `count` nodes, the last first: children come behind their parents. The first has the index
/// `first` in the tree.
fn fit(nodes: &mut [Node], count: usize, first: usize, blocks: &[TriBlock]) {
    for index in (0..count).rev() {
        for slot in 0..8 {
            let bounds = match nodes[index].child[slot].kind() {
                NodeKind::Empty => continue,
                NodeKind::Inner(child) => of_node(&nodes[child - first]),
                NodeKind::Leaf { block, first, count } => of_leaf(&blocks[block], first..first + count),
            };
            for axis in 0..3 {
                nodes[index].bounds[2 * axis][slot] = bounds.min[axis];
                nodes[index].bounds[2 * axis + 1][slot] = bounds.max[axis];
            }
        }
        nodes[index].sort();
    }
}

/// All of a node's boxes in one.
fn of_node(node: &Node) -> Aabb {
    let least = |planes: &[f32; 8]| planes.iter().copied().fold(f32::INFINITY, f32::min);
    let most = |planes: &[f32; 8]| planes.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let [x, x2, y, y2, z, z2] = &node.bounds;
    Aabb { min: Vec3::new(least(x), least(y), least(z)), max: Vec3::new(most(x2), most(y2), most(z2)) }
}

/// The box of some triangles of a block.
fn of_leaf(block: &TriBlock, lanes: Range<u32>) -> Aabb {
    let lanes = lanes.start as usize..lanes.end as usize;
    let mut bounds = Aabb::EMPTY;
    for corner in &block.v {
        for lane in lanes.clone() {
            bounds.grow(Vec3::new(corner[0][lane], corner[1][lane], corner[2][lane]));
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refitted_tree_is_another_tree_whose_children_are_in_order_again() {
        let mut mesh = crate::scene::load("atrium@0.1").unwrap().mesh;
        let mut bvh = Bvh::build(&mesh, BuildPreset::Fast).unwrap();
        let (id, before) = (bvh.id, bvh.nodes.clone());
        for (i, position) in mesh.positions.iter_mut().enumerate() {
            // All to the other side, and each a little elsewhere.
            *position = -*position + Vec3::splat((i % 7) as f32 * 0.1);
        }
        bvh.refit(&mesh);
        assert_ne!(bvh.id, id, "kernels remember corners by the tree");
        let orders = |nodes: &[Node]| nodes.iter().map(|node| node.order).collect::<Vec<_>>();
        assert_ne!(orders(&bvh.nodes), orders(&before));
        let mut sorted = bvh.nodes.clone();
        sorted.iter_mut().for_each(Node::sort);
        assert_eq!(orders(&bvh.nodes), orders(&sorted));
    }
}
