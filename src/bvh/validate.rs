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
    /// Checks that all references are in range, every box encloses the vertices below it, every node orders all of its
    /// children for each octant, every triangle of the mesh is in exactly one leaf with its exact vertices, and no path
    /// is too long.
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
                    ensure(self.nodes[index].order.iter().all(|&order| names_each_slot(order)), || {
                        format!("node {index} leaves out a child in some octant")
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

/// True if eight numbers of three bits are 0 to 7.
fn names_each_slot(order: u32) -> bool {
    (0..8).fold(0, |seen, place| seen | 1u32 << (order >> (3 * place) & 7)) == 0xff
}

fn ensure(holds: bool, violation: impl FnOnce() -> String) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation(violation())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bvh::BuildPreset,
        kernels::{EMPTY_NODE, MISS, Node},
    };
    use glam::Vec3;

    /// Sixty triangles in a row.
    fn mesh() -> TriangleMesh {
        let at = |i: u32| Vec3::new(i as f32, (i % 3) as f32, (i % 5) as f32);
        let positions = (0..60).flat_map(|i| [at(i), at(i) + Vec3::X, at(i) + Vec3::Y]).collect();
        let triangles = (0..60).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        TriangleMesh { positions, triangles, materials: vec![0; 60], ..TriangleMesh::default() }
    }

    /// The first child that is a leaf: its node and slot, block and lane.
    fn leaf(bvh: &Bvh) -> (usize, usize, usize, usize) {
        let children = bvh.nodes.iter().enumerate().flat_map(|(index, node)| {
            node.child.iter().enumerate().map(move |(slot, child)| (index, slot, child.kind()))
        });
        let leaf = |(index, slot, kind)| match kind {
            NodeKind::Leaf { block, first, .. } => Some((index, slot, block, first as usize)),
            NodeKind::Inner(_) | NodeKind::Empty => None,
        };
        children.filter_map(leaf).next().expect("a leaf")
    }

    /// What is found if a good tree is spoiled.
    fn found(spoil: impl FnOnce(&mut Bvh)) -> String {
        let mesh = mesh();
        let mut bvh = Bvh::build(&mesh, BuildPreset::Fast).expect("builds");
        assert_eq!(bvh.validate(&mesh), Ok(()));
        spoil(&mut bvh);
        bvh.validate(&mesh).expect_err("something is wrong").to_string()
    }

    #[test]
    fn references_that_lead_nowhere_or_twice_to_one_place_are_found() {
        let replaced = |by: fn(&Bvh) -> NodeRef| {
            found(|bvh| {
                let (index, slot, ..) = leaf(bvh);
                bvh.nodes[index].child[slot] = by(bvh);
            })
        };
        assert!(replaced(|bvh| NodeRef::leaf(bvh.blocks.len(), 0, 1)).ends_with("is out of range"));
        assert!(replaced(|bvh| NodeRef::inner(bvh.nodes.len())).ends_with("is out of range"));
        assert!(replaced(|_| NodeRef::inner(0)).ends_with("has two parents"));
        assert!(replaced(|_| EMPTY_NODE).ends_with("has a box"));
        assert_eq!(found(|bvh| bvh.root = EMPTY_NODE), "a node is unreachable");
        assert_eq!(found(|bvh| bvh.nodes.push(Node::EMPTY)), "a node is unreachable");
        let removed = found(|bvh| {
            let (index, slot, ..) = leaf(bvh);
            bvh.nodes[index].child[slot] = EMPTY_NODE;
            for (side, bounds) in bvh.nodes[index].bounds.iter_mut().enumerate() {
                bounds[slot] = if side % 2 == 0 { f32::INFINITY } else { f32::NEG_INFINITY };
            }
        });
        assert_eq!(removed, "a triangle is in no leaf");
        let deep = found(|bvh| {
            for _ in 0..=MAX_DEPTH {
                let mut node = Node::EMPTY;
                node.child[0] = bvh.root;
                for (side, bounds) in node.bounds.iter_mut().enumerate() {
                    bounds[0] = if side % 2 == 0 { f32::NEG_INFINITY } else { f32::INFINITY };
                }
                bvh.root = NodeRef::inner(bvh.nodes.len());
                bvh.nodes.push(node);
            }
        });
        assert!(deep.starts_with("a path is longer than"), "{deep}");
    }

    #[test]
    fn wrong_boxes_orders_and_triangles_are_found() {
        for side in 0..6 {
            let inwards = if side % 2 == 0 { f32::next_up } else { f32::next_down };
            let shrunk = found(|bvh| {
                let (index, slot, ..) = leaf(bvh);
                let bound = &mut bvh.nodes[index].bounds[side][slot];
                *bound = inwards(*bound);
            });
            assert!(shrunk.ends_with("leaves a box above it"), "side {side}: {shrunk}");
        }
        for octant in 0..8 {
            let order = found(|bvh| bvh.nodes[0].order[octant] ^= 1 << (3 * octant));
            assert!(order.ends_with("leaves out a child in some octant"), "octant {octant}: {order}");
        }
        let moved = |to: fn(u32) -> u32| {
            found(|bvh| {
                let (.., block, lane) = leaf(bvh);
                let prim = &mut bvh.blocks[block].prim[lane];
                *prim = to(*prim);
            })
        };
        assert!(moved(|_| 60).ends_with("names triangle 60, which does not exist"));
        assert!(moved(|_| MISS).ends_with("which does not exist"));
        // Either the corners differ, or the other leaf comes first.
        let twice = moved(|prim| (prim + 1) % 60);
        assert!(
            twice.ends_with("other corners than the mesh") || twice.ends_with("in two leaves"),
            "{twice}"
        );
        let bent = found(|bvh| {
            let (.., block, lane) = leaf(bvh);
            let x = &mut bvh.blocks[block].v[1][0][lane];
            *x = x.next_down();
        });
        assert!(bent.ends_with("has other corners than the mesh"), "{bent}");
    }
}
