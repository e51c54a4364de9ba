//! From the binary tree to 8-wide nodes and blocks of eight triangles, as [`Choice`](super::choice::Choice) says.
//!
//! Subtrees are emitted in parallel, each into memory of its own, and put one behind the other.

use super::{
    binary::{Binary, Link, Tree},
    choice::LEAF_MAX,
    pack::Packer,
};
use crate::{
    kernels::{EMPTY_NODE, Node, NodeKind, NodeRef, TriBlock},
    scene::TriangleMesh,
};
use rayon::prelude::*;

/// Subtrees of so many references are emitted by one task.
const GRAIN: u32 = 8192;

/// The nodes and blocks of a subtree.
#[derive(Default)]
struct Piece {
    nodes: Vec<Node>,
    packer: Packer,
}

/// The wide tree.
pub(super) struct Wide {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<TriBlock>,
    pub(super) root: NodeRef,
    /// Where the nodes of each piece start, the top first, and the end. Children are in their parent's piece and behind it,
    /// or, of the top, anywhere behind.
    pub(super) pieces: Vec<usize>,
}

/// The wide tree for a binary one.
pub(super) fn collapse(tree: &Tree, mesh: &TriangleMesh) -> Wide {
    let mut top = Emitter::new(tree, mesh, GRAIN);
    let root = top.emit(Place { grain: TOP, index: 0 });
    let later = std::mem::take(&mut top.later);
    let emit = |&(_, _, place): &(usize, usize, Place)| {
        let mut wide = Emitter::new(tree, mesh, 0);
        wide.emit(place);
        wide.piece
    };
    let below: Vec<Piece> = later.par_iter().map(emit).collect();
    let mut pieces = vec![top.piece];
    pieces.extend(below);
    let starts = Starts {
        nodes: starts(&pieces, |p| p.nodes.len()),
        blocks: starts(&pieces, |p| p.packer.blocks.len()),
    };
    for ((node, slot, _), start) in later.into_iter().zip(&starts.nodes[1..]) {
        pieces[0].nodes[node].child[slot] = NodeRef::inner(*start);
    }
    let nodes = (0..starts.nodes[pieces.len()]).into_par_iter().with_min_len(1024).map(|i| {
        let (piece, at) = find(&starts.nodes, i);
        let mut node = pieces[piece].nodes[at];
        // The first piece starts at zero, and what was put into it is right already.
        if piece > 0 {
            node.child = node.child.map(|child| moved(child, starts.nodes[piece], starts.blocks[piece]));
        }
        node.sort();
        node
    });
    let blocks = (0..starts.blocks[pieces.len()]).into_par_iter().with_min_len(1024).map(|i| {
        let (piece, at) = find(&starts.blocks, i);
        pieces[piece].packer.blocks[at]
    });
    Wide { nodes: nodes.collect(), blocks: blocks.collect(), root, pieces: starts.nodes }
}

/// Where the nodes and blocks of each piece start when all are put one behind the other; the end is the last.
struct Starts {
    nodes: Vec<usize>,
    blocks: Vec<usize>,
}

fn starts(pieces: &[Piece], len: impl Fn(&Piece) -> usize) -> Vec<usize> {
    let mut starts = vec![0];
    for piece in pieces {
        starts.push(starts[starts.len() - 1] + len(piece));
    }
    starts
}

/// The piece that element `i` of all comes from, and its place there.
fn find(starts: &[usize], i: usize) -> (usize, usize) {
    let piece = starts.partition_point(|&start| start <= i) - 1;
    (piece, i - starts[piece])
}

/// A reference within a piece that now starts at these nodes and blocks.
fn moved(reference: NodeRef, nodes: usize, blocks: usize) -> NodeRef {
    match reference.kind() {
        NodeKind::Empty => EMPTY_NODE,
        NodeKind::Inner(index) => NodeRef::inner(index + nodes),
        NodeKind::Leaf { block, first, count } => {
            NodeRef::leaf(block + blocks, first as usize, count as usize)
        }
    }
}

/// `Place::grain` of the nodes at the top.
const TOP: u32 = u32::MAX;

/// Where a binary node is.
#[derive(Clone, Copy)]
struct Place {
    grain: u32,
    index: u32,
}

struct Emitter<'a> {
    tree: &'a Tree,
    mesh: &'a TriangleMesh,
    piece: Piece,
    /// Primitives of the leaf at hand.
    prims: Vec<u32>,
    /// Wide nodes still to be filled.
    stack: Vec<(usize, Place)>,
    /// Subtrees up to this size are left to others: node and slot that lead to them, and where they are.
    small: u32,
    later: Vec<(usize, usize, Place)>,
}

impl<'a> Emitter<'a> {
    fn new(tree: &'a Tree, mesh: &'a TriangleMesh, small: u32) -> Emitter<'a> {
        let (piece, prims) = (Piece::default(), Vec::with_capacity(LEAF_MAX as usize));
        Emitter { tree, mesh, piece, prims, stack: Vec::new(), small, later: Vec::new() }
    }

    /// Emits a subtree; returns the reference to its root, which is node 0 unless it is a leaf.
    fn emit(&mut self, place: Place) -> NodeRef {
        let root = self.reference(place);
        let mut children = Vec::with_capacity(8);
        while let Some((index, place)) = self.stack.pop() {
            children.clear();
            let left = self.binary(place).1.choice.inner_split;
            let [first, second] = self.pair(place);
            self.gather(first, left, &mut children);
            self.gather(second, 8 - left, &mut children);
            for (slot, &child) in children.iter().enumerate() {
                let binary = self.binary(child).1;
                let (lo, hi, choice) = (binary.lo, binary.hi, binary.choice);
                for axis in 0..3 {
                    self.piece.nodes[index].bounds[2 * axis][slot] = lo[axis];
                    self.piece.nodes[index].bounds[2 * axis + 1][slot] = hi[axis];
                }
                if !choice.leaf && choice.references <= self.small {
                    self.later.push((index, slot, child));
                } else {
                    self.piece.nodes[index].child[slot] = self.reference(child);
                }
            }
        }
        root
    }

    /// The node at a place, or the one that it stands for, and where that is.
    fn binary(&self, place: Place) -> (Place, &'a Binary) {
        if place.grain != TOP {
            return (place, &self.tree.grains[place.grain as usize].nodes[place.index as usize]);
        }
        let binary = &self.tree.top[place.index as usize];
        match binary.link {
            Link::Grain(grain) => (Place { grain, index: 0 }, &self.tree.grains[grain as usize].nodes[0]),
            _ => (place, binary),
        }
    }

    /// The children of an inner node.
    fn pair(&self, place: Place) -> [Place; 2] {
        let (place, binary) = self.binary(place);
        match binary.link {
            Link::Pair(index) => [Place { index, ..place }, Place { index: index + 1, ..place }],
            Link::Grain(_) | Link::Leaf { .. } => unreachable!("a choice never goes below a leaf"),
        }
    }

    /// Appends the binary nodes that present `place` as up to `limit` children.
    fn gather(&self, place: Place, limit: u8, children: &mut Vec<Place>) {
        match self.binary(place).1.choice.children(limit) {
            None => children.push(place),
            Some([left, right]) => {
                let [first, second] = self.pair(place);
                self.gather(first, left, children);
                self.gather(second, right, children);
            }
        }
    }

    /// A leaf or a new wide node for a binary node.
    fn reference(&mut self, place: Place) -> NodeRef {
        if self.binary(place).1.choice.leaf {
            self.prims.clear();
            self.collect(place);
            return self.piece.packer.pack(self.mesh, &self.prims);
        }
        let index = self.piece.nodes.len();
        self.piece.nodes.push(Node::EMPTY);
        self.stack.push((index, place));
        NodeRef::inner(index)
    }

    fn collect(&mut self, place: Place) {
        let (place, binary) = self.binary(place);
        if let Link::Leaf { first, count } = binary.link {
            let grain = &self.tree.grains[place.grain as usize];
            self.prims.extend(&grain.prims[first as usize..(first + count) as usize]);
        } else {
            for child in self.pair(place) {
                self.collect(child);
            }
        }
    }
}
