//! What a tree looks like: the figures of `irt inspect` and of the render summary.

use super::{
    Bvh,
    choice::{LEAF_COST, NODE_COST, TRIANGLE_COST},
};
use crate::{
    kernels::{EMPTY_NODE, NodeKind, NodeRef},
    math::Aabb,
};
use glam::Vec3;

/// Statistics of a tree.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct TreeReport {
    /// Inner nodes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Triangles.
    pub triangles: usize,
    /// Nodes on the longest path, a leaf counting as one.
    pub depth: usize,
    /// Expected cost of a random ray by the surface area heuristic; visiting one node costs 1.
    pub sah_cost: f64,
    /// Used child slots per node, of 8.
    pub children_per_node: f64,
    /// Triangles per leaf, at most 8.
    pub triangles_per_leaf: f64,
    /// Used fraction of the triangle blocks' lanes.
    pub block_fill: f64,
    /// Bytes of nodes and triangle blocks.
    pub bytes: usize,
    /// `bytes` per triangle.
    pub bytes_per_triangle: f64,
}

impl Bvh {
    /// Statistics of the tree.
    pub fn report(&self) -> TreeReport {
        let mut report = TreeReport { bytes: self.bytes(), ..TreeReport::default() };
        let mut children = 0usize;
        let mut stack = vec![(self.root, 1usize)];
        while let Some((node, depth)) = stack.pop() {
            match node.kind() {
                NodeKind::Empty => continue,
                NodeKind::Inner(index) => {
                    report.nodes += 1;
                    for &child in self.nodes[index].child.iter().filter(|child| **child != EMPTY_NODE) {
                        children += 1;
                        stack.push((child, depth + 1));
                    }
                }
                NodeKind::Leaf { count, .. } => {
                    report.leaves += 1;
                    report.triangles += count as usize;
                }
            }
            report.depth = report.depth.max(depth);
        }
        let per = |a: f64, b: usize| if b == 0 { 0.0 } else { a / b as f64 };
        report.sah_cost = self.sah_cost();
        report.children_per_node = per(children as f64, report.nodes);
        report.triangles_per_leaf = per(report.triangles as f64, report.leaves);
        report.block_fill = per(report.triangles as f64, 8 * self.blocks.len());
        report.bytes_per_triangle = per(report.bytes as f64, report.triangles);
        report
    }

    /// Expected cost of a random ray that meets the root, by the surface area heuristic; visiting one node costs 1.
    pub fn sah_cost(&self) -> f64 {
        let root_area = f64::from(self.root_bounds().half_area());
        let cost = |node: NodeRef| match node.kind() {
            NodeKind::Empty => 0.0,
            NodeKind::Inner(_) => f64::from(NODE_COST),
            NodeKind::Leaf { count, .. } => f64::from(LEAF_COST + TRIANGLE_COST * count as f32),
        };
        let mut sum = root_area * cost(self.root);
        for (index, node) in self.nodes.iter().enumerate() {
            for (slot, &child) in node.child.iter().enumerate().filter(|(_, child)| **child != EMPTY_NODE) {
                sum += f64::from(self.child_bounds(index, slot).half_area()) * cost(child);
            }
        }
        if root_area > 0.0 { sum / root_area } else { 0.0 }
    }

    /// Nodes on the longest path, a leaf counting as one.
    pub(super) fn depth(&self) -> usize {
        let mut deepest = 0;
        let mut stack = vec![(self.root, 1)];
        while let Some((node, depth)) = stack.pop() {
            deepest = deepest.max(depth);
            if let NodeKind::Inner(index) = node.kind() {
                let inner = |child: &&NodeRef| child.kind() != NodeKind::Empty;
                stack.extend(self.nodes[index].child.iter().filter(inner).map(|&child| (child, depth + 1)));
            }
        }
        deepest
    }

    /// Box of one child of a node.
    pub(super) fn child_bounds(&self, index: usize, slot: usize) -> Aabb {
        let bounds = &self.nodes[index].bounds;
        let side =
            |side: usize| Vec3::new(bounds[side][slot], bounds[2 + side][slot], bounds[4 + side][slot]);
        Aabb { min: side(0), max: side(1) }
    }

    fn root_bounds(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        match self.root.kind() {
            NodeKind::Inner(index) => (0..8).for_each(|slot| bounds.union(&self.child_bounds(index, slot))),
            NodeKind::Leaf { block, first, count } => {
                for lane in first..first + count {
                    for corner in self.corners(block, lane as usize) {
                        bounds.grow(corner);
                    }
                }
            }
            NodeKind::Empty => {}
        }
        bounds
    }

    /// Corners of the triangle in one lane of a block.
    pub(super) fn corners(&self, block: usize, lane: usize) -> [Vec3; 3] {
        self.blocks[block].v.map(|corner| Vec3::new(corner[0][lane], corner[1][lane], corner[2][lane]))
    }
}
