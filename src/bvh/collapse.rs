//! From the binary tree to 8-wide nodes.
//!
//! Which binary nodes become wide nodes, leaves, or vanish is chosen by dynamic programming over the surface area
//! heuristic (Ylitie, Karras, Laine 2017, section 3.1): `cost(n, i)` is the least expected cost of the subtree under
//! `n` when it may appear as up to `i` children of some wide node.
//!
//! Leaves are packed into blocks of eight triangles; small leaves share a block, so that few lanes stay empty.

use crate::{
    kernels::{EMPTY_NODE, MISS, Node, NodeRef, TriBlock},
    scene::TriangleMesh,
};
use obvhs::bvh2::Bvh2;

/// Cost of visiting a wide node; the unit of the others.
pub(super) const NODE_COST: f32 = 1.0;
/// Cost of setting up a block.
pub(super) const LEAF_COST: f32 = 0.9;
/// Cost of each triangle in it.
pub(super) const TRIANGLE_COST: f32 = 0.12;
/// Triangles a leaf may hold.
const LEAF_MAX: u32 = 8;

/// The best way to present a binary node as up to 1..=7 children (index 0 = one child).
#[derive(Clone, Copy)]
struct Choice {
    cost: [f32; 7],
    /// For up to `i + 1` children: how many go to the left; 0 = fewer children are as good. `split[0]` is unused.
    split: [u8; 7],
    /// For a wide node made here: how many of its eight children go to the left.
    inner_split: u8,
    /// As one child: true if a leaf is best.
    leaf: bool,
    triangles: u32,
}

/// The wide tree: nodes, triangle blocks, root.
pub(super) fn collapse(binary: &Bvh2, mesh: &TriangleMesh) -> (Vec<Node>, Vec<TriBlock>, NodeRef) {
    if mesh.is_empty() || binary.nodes.is_empty() {
        return (Vec::new(), Vec::new(), EMPTY_NODE);
    }
    let choices = choose(binary);
    let mut wide =
        Wide { binary, mesh, choices, nodes: Vec::new(), packer: Packer::default(), stack: Vec::new() };
    let root = wide.build();
    (wide.nodes, wide.packer.blocks, root)
}

/// Children before parents.
fn postorder(binary: &Bvh2) -> Vec<u32> {
    let mut order = Vec::with_capacity(binary.nodes.len());
    let mut stack = vec![0u32];
    while let Some(index) = stack.pop() {
        order.push(index);
        let node = &binary.nodes[index as usize];
        if node.prim_count == 0 {
            stack.extend([node.first_index, node.first_index + 1]);
        }
    }
    order.reverse();
    order
}

fn choose(binary: &Bvh2) -> Vec<Choice> {
    let none = Choice { cost: [0.0; 7], split: [0; 7], inner_split: 0, leaf: true, triangles: 0 };
    let mut choices = vec![none; binary.nodes.len()];
    for index in postorder(binary) {
        let node = &binary.nodes[index as usize];
        let area = node.aabb().half_area();
        choices[index as usize] = if node.prim_count > 0 {
            let cost = area * (LEAF_COST + TRIANGLE_COST * node.prim_count as f32);
            Choice { cost: [cost; 7], triangles: node.prim_count, ..none }
        } else {
            let left = choices[node.first_index as usize];
            let right = choices[node.first_index as usize + 1];
            combine(area, &left, &right)
        };
    }
    choices
}

fn combine(area: f32, left: &Choice, right: &Choice) -> Choice {
    // The cheapest way to share `children` among the two sides.
    let distribute = |children: usize| {
        let (mut best, mut split) = (f32::INFINITY, 0);
        for k in 1..children {
            if k > 7 || children - k > 7 {
                continue;
            }
            let cost = left.cost[k - 1] + right.cost[children - k - 1];
            if cost < best {
                (best, split) = (cost, k as u8);
            }
        }
        (best, split)
    };
    let triangles = left.triangles + right.triangles;
    let (inner, inner_split) = distribute(8);
    let inner_cost = inner + area * NODE_COST;
    let leaf_cost = if triangles <= LEAF_MAX {
        area * (LEAF_COST + TRIANGLE_COST * triangles as f32)
    } else {
        f32::INFINITY
    };
    // `<=` also for NaN-free degenerate areas of zero: prefer the leaf.
    let leaf = leaf_cost <= inner_cost;
    let mut choice = Choice { cost: [0.0; 7], split: [0; 7], inner_split, leaf, triangles };
    choice.cost[0] = leaf_cost.min(inner_cost);
    for children in 2..=7 {
        let (cost, split) = distribute(children);
        let fewer = choice.cost[children - 2];
        let better = cost < fewer;
        choice.cost[children - 1] = if better { cost } else { fewer };
        choice.split[children - 1] = if better { split } else { 0 };
    }
    choice
}

struct Wide<'a> {
    binary: &'a Bvh2,
    mesh: &'a TriangleMesh,
    choices: Vec<Choice>,
    nodes: Vec<Node>,
    packer: Packer,
    /// Wide nodes still to be filled: index and binary node.
    stack: Vec<(usize, u32)>,
}

impl Wide<'_> {
    fn build(&mut self) -> NodeRef {
        let root = self.reference(0);
        while let Some((index, binary)) = self.stack.pop() {
            let mut children = Vec::with_capacity(8);
            let first = self.binary.nodes[binary as usize].first_index;
            let left = self.choices[binary as usize].inner_split;
            self.gather(first, left, &mut children);
            self.gather(first + 1, 8 - left, &mut children);
            for (slot, child) in children.into_iter().enumerate() {
                let bounds = self.binary.nodes[child as usize].aabb();
                let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
                let reference = self.reference(child);
                let node = &mut self.nodes[index];
                for axis in 0..3 {
                    node.bounds[2 * axis][slot] = min[axis];
                    node.bounds[2 * axis + 1][slot] = max[axis];
                }
                node.child[slot] = reference;
            }
        }
        root
    }

    /// Appends the binary nodes that present `binary` as up to `limit` children.
    fn gather(&self, binary: u32, mut limit: u8, children: &mut Vec<u32>) {
        let choice = &self.choices[binary as usize];
        while limit > 1 && choice.split[limit as usize - 1] == 0 {
            limit -= 1;
        }
        if limit <= 1 {
            children.push(binary);
            return;
        }
        let left = choice.split[limit as usize - 1];
        let first = self.binary.nodes[binary as usize].first_index;
        self.gather(first, left, children);
        self.gather(first + 1, limit - left, children);
    }

    /// A leaf or a new wide node for a binary node.
    fn reference(&mut self, binary: u32) -> NodeRef {
        if self.choices[binary as usize].leaf {
            let mut prims = Vec::with_capacity(LEAF_MAX as usize);
            self.collect(binary, &mut prims);
            return self.packer.pack(self.mesh, &prims);
        }
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        self.stack.push((index, binary));
        NodeRef::inner(index)
    }

    fn collect(&self, binary: u32, prims: &mut Vec<u32>) {
        let node = &self.binary.nodes[binary as usize];
        if node.prim_count > 0 {
            let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
            prims.extend(&self.binary.primitive_indices[range]);
        } else {
            self.collect(node.first_index, prims);
            self.collect(node.first_index + 1, prims);
        }
    }
}

/// Fills blocks, keeping a few of them open so that small leaves find room near their neighbours.
#[derive(Default)]
struct Packer {
    blocks: Vec<TriBlock>,
    /// Open blocks, oldest first: index and used lanes.
    open: Vec<(usize, usize)>,
}

impl Packer {
    const OPEN: usize = 4;

    fn pack(&mut self, mesh: &TriangleMesh, prims: &[u32]) -> NodeRef {
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
