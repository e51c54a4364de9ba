//! Checking every invariant that the kernels rely on.

use super::Bvh;
use crate::{
    kernels::{MAX_DEPTH, NodeKind, NodeRef},
    math::Aabb,
    scene::TriangleMesh,
};
use std::fmt;

/// An invariant that does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation(String);

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Bvh {
    /// Checks that all references are in range, every box encloses the vertices below it, every triangle of the mesh
    /// is in exactly one leaf with its exact vertices, and no path is too long.
    ///
    /// # Errors
    /// The first violation found.
    pub fn validate(&self, mesh: &TriangleMesh) -> Result<(), Violation> {
        let mut seen = vec![false; mesh.len()];
        let mut visited = vec![false; self.nodes.len()];
        let everything = Aabb { min: glam::Vec3::NEG_INFINITY, max: glam::Vec3::INFINITY };
        let mut stack = vec![(self.root, vec![everything])];
        while let Some((node, boxes)) = stack.pop() {
            ensure(boxes.len() <= MAX_DEPTH, || format!("a path is longer than {MAX_DEPTH} nodes"))?;
            match node.kind() {
                NodeKind::Empty => {}
                NodeKind::Inner(index) => {
                    ensure(index < self.nodes.len(), || format!("node {index} is out of range"))?;
                    ensure(!std::mem::replace(&mut visited[index], true), || {
                        format!("node {index} has two parents")
                    })?;
                    self.push_children(index, &boxes, &mut stack)?;
                }
                NodeKind::Leaf { block, first, count } => {
                    ensure(block < self.blocks.len(), || format!("block {block} is out of range"))?;
                    for lane in first..first + count {
                        self.check_triangle(mesh, block, lane as usize, &boxes, &mut seen)?;
                    }
                }
            }
        }
        ensure(visited.iter().all(|&v| v), || "a node is unreachable".into())?;
        ensure(seen.iter().all(|&s| s), || "a triangle is in no leaf".into())
    }

    fn push_children(
        &self,
        index: usize,
        boxes: &[Aabb],
        stack: &mut Vec<(NodeRef, Vec<Aabb>)>,
    ) -> Result<(), Violation> {
        for (slot, &child) in self.nodes[index].child.iter().enumerate() {
            let bounds = self.child_bounds(index, slot);
            if child.kind() == NodeKind::Empty {
                let inverted = bounds.min.cmpgt(bounds.max).all();
                ensure(inverted, || format!("empty child {slot} of node {index} has a box"))?;
            } else {
                let mut boxes = boxes.to_vec();
                boxes.push(bounds);
                stack.push((child, boxes));
            }
        }
        Ok(())
    }

    fn check_triangle(
        &self,
        mesh: &TriangleMesh,
        block: usize,
        lane: usize,
        boxes: &[Aabb],
        seen: &mut [bool],
    ) -> Result<(), Violation> {
        let prim = self.blocks[block].prim[lane] as usize;
        ensure(prim < mesh.len(), || format!("block {block} names triangle {prim}, which does not exist"))?;
        ensure(!std::mem::replace(&mut seen[prim], true), || format!("triangle {prim} is in two leaves"))?;
        let corners = self.corners(block, lane);
        ensure(corners == mesh.corners(prim), || format!("triangle {prim} has other corners than the mesh"))?;
        let inside =
            boxes.iter().all(|b| corners.iter().all(|&p| b.min.cmple(p).all() && p.cmple(b.max).all()));
        ensure(inside, || format!("triangle {prim} leaves a box above it"))
    }
}

fn ensure(holds: bool, violation: impl FnOnce() -> String) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation(violation())) }
}
