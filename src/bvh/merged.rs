//! The slow tree: merged from the leaves up (PLOC), then improved by moving nodes to where they cost least (Meister,
//! Bittner 2017), both by obvhs.

use super::{
    baseline,
    binary::{Binary, Grain, Link, Tree},
    choice::Choice,
    reference::Bounds,
};
use crate::{kernels::MAX_DEPTH, scene::TriangleMesh};
use obvhs::bvh2::Bvh2;

/// obvhs' best tree over a mesh that is not empty; `None` if it is too deep.
pub(super) fn merged(mesh: &TriangleMesh) -> Option<Tree> {
    let binary = baseline::binary(mesh);
    (depth(&binary) <= MAX_DEPTH).then(|| adopt(binary))
}

/// Nodes on the longest path.
fn depth(binary: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0, 1)];
    while let Some((index, depth)) = stack.pop() {
        let node = &binary.nodes[index as usize];
        deepest = deepest.max(depth);
        if node.prim_count == 0 {
            stack.extend([(node.first_index, depth + 1), (node.first_index + 1, depth + 1)]);
        }
    }
    deepest
}

/// A tree of one grain.
fn adopt(binary: Bvh2) -> Tree {
    let mut order = Vec::with_capacity(binary.nodes.len());
    let mut stack = vec![0u32];
    while let Some(index) = stack.pop() {
        order.push(index);
        let node = &binary.nodes[index as usize];
        if node.prim_count == 0 {
            stack.extend([node.first_index, node.first_index + 1]);
        }
    }
    let mut nodes = vec![Binary::NONE; binary.nodes.len()];
    for &index in order.iter().rev() {
        let node = &binary.nodes[index as usize];
        let bounds = Bounds { lo: node.aabb().min.extend(0.0), hi: node.aabb().max.extend(0.0) };
        let area = bounds.half_area();
        let (link, choice) = if node.prim_count > 0 {
            let link = Link::Leaf { first: node.first_index, count: node.prim_count };
            (link, Choice::leaf(area, node.prim_count))
        } else {
            let [left, right] = [0, 1].map(|i| &nodes[node.first_index as usize + i].choice);
            (Link::Pair(node.first_index), Choice::inner(area, left, right))
        };
        nodes[index as usize] = Binary::new(&bounds, link, choice);
    }
    let top = vec![Binary { link: Link::Grain(0), ..nodes[0] }];
    Tree { top, grains: vec![Grain { nodes, prims: binary.primitive_indices }] }
}
