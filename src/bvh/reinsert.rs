//! Improving a binary tree by moving nodes to where they cost least (Meister, Bittner 2017), by obvhs.

use super::{
    binary::{Binary, Grain, Link, Tree},
    choice::Choice,
    reference::Bounds,
};
use crate::kernels::MAX_DEPTH;
use glam::Vec3;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer},
};

/// The tree with nodes moved; the same tree if that made it too deep.
pub(super) fn reinserted(tree: Tree) -> Tree {
    let mut binary = adapt(&tree);
    // All nodes in the first round, ever fewer of them, the largest, in those that follow.
    ReinsertionOptimizer::default().run(&mut binary, 1.0, None);
    if depth(&binary) > MAX_DEPTH { tree } else { adopt(binary) }
}

/// The tree as obvhs has it.
fn adapt(tree: &Tree) -> Bvh2 {
    let mut binary = Bvh2::default();
    binary.nodes.push(Bvh2Node::default());
    // What stands at an index of the new tree: grain (none at the top) and index in the old one.
    let mut stack = vec![(0, None, 0)];
    while let Some((index, grain, old)) = stack.pop() {
        let nodes = grain.map_or(&tree.top, |grain: u32| &tree.grains[grain as usize].nodes);
        let node: &Binary = &nodes[old as usize];
        let aabb = Aabb::new(Vec3::from(node.lo).into(), Vec3::from(node.hi).into());
        match node.link {
            Link::Grain(grain) => stack.push((index, Some(grain), 0)),
            Link::Pair(first) => {
                let pair = binary.nodes.len();
                binary.nodes[index] = Bvh2Node::new(aabb, 0, pair as u32);
                binary.nodes.extend([Bvh2Node::default(); 2]);
                stack.extend([(pair, grain, first), (pair + 1, grain, first + 1)]);
            }
            Link::Leaf { first, count } => {
                let prims = &tree.grains[grain.unwrap_or(0) as usize].prims;
                let at = binary.primitive_indices.len() as u32;
                binary.primitive_indices.extend(&prims[first as usize..(first + count) as usize]);
                binary.nodes[index] = Bvh2Node::new(aabb, count, at);
            }
        }
    }
    binary
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
