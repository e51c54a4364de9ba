//! The 8-wide tree as the kernels see it.

use crate::{simd::Simd, vector::I32};
use std::sync::atomic::{AtomicU64, Ordering};

/// Tree depth (root = 1) that traversal stacks are sized for.
pub const MAX_DEPTH: usize = 64;

/// Most stack entries a traversal can hold: each level leaves at most seven siblings behind.
pub(crate) const STACK: usize = 1 + 7 * MAX_DEPTH;

/// A reference to an inner node or to a run of triangles in one block.
///
/// ```text
///   inner   0 nnnnnnnnnnnnnnnnnnnnnnnnnnnnnnn            node index (31 bits)
///   leaf    1 bbbbbbbbbbbbbbbbbbbbbbbbb fff ccc          block (25), first lane (3), triangles - 1 (3)
///   empty   0 1111111111111111111111111111111
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct NodeRef(u32);

/// The child slot that holds nothing.
pub const EMPTY_NODE: NodeRef = NodeRef(0x7fff_ffff);

/// What a [`NodeRef`] refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// Nothing.
    Empty,
    /// The inner node of this index.
    Inner(usize),
    /// `count` triangles (1 to 8) of block `block`, starting at lane `first`; `first + count <= 8`.
    Leaf {
        /// Index of the block.
        block: usize,
        /// First lane.
        first: u32,
        /// Number of triangles.
        count: u32,
    },
}

impl NodeRef {
    /// Reference to inner node `index`.
    ///
    /// # Panics
    /// If the index needs more than 31 bits.
    pub fn inner(index: usize) -> NodeRef {
        assert!(index < 0x7fff_ffff, "too many nodes for a 31-bit index");
        NodeRef(index as u32)
    }

    /// Reference to `count` triangles of a block.
    ///
    /// # Panics
    /// If the lanes are not within the block or the block index needs more than 25 bits.
    pub fn leaf(block: usize, first: usize, count: usize) -> NodeRef {
        assert!(block < 1 << 25 && (1..=8).contains(&count) && first + count <= 8, "leaf outside its block");
        NodeRef(1 << 31 | (block as u32) << 6 | (first as u32) << 3 | (count as u32 - 1))
    }

    /// True for a run of triangles.
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 >> 31 != 0
    }

    /// What it refers to.
    pub fn kind(self) -> NodeKind {
        if self == EMPTY_NODE {
            NodeKind::Empty
        } else if self.is_leaf() {
            NodeKind::Leaf { block: self.block(), first: self.0 >> 3 & 7, count: (self.0 & 7) + 1 }
        } else {
            NodeKind::Inner(self.index())
        }
    }

    /// As a number.
    #[inline(always)]
    pub(crate) fn raw(self) -> u32 {
        self.0
    }

    /// From [`NodeRef::raw`].
    #[inline(always)]
    pub(crate) fn from_raw(raw: u32) -> NodeRef {
        NodeRef(raw)
    }

    /// Index of the inner node.
    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }

    /// Index of the leaf's block.
    #[inline(always)]
    pub(crate) fn block(self) -> usize {
        (self.0 << 1 >> 7) as usize
    }

    /// Reference to one triangle: that of a slot, block index * 8 + lane.
    #[inline(always)]
    pub(crate) fn triangle(slot: u32) -> NodeRef {
        NodeRef(1 << 31 | slot >> 3 << 6 | (slot & 7) << 3)
    }

    /// The leaf's lanes within its block, as bits.
    #[inline(always)]
    pub(crate) fn lanes(self) -> u32 {
        (2u32 << (self.0 & 7)).wrapping_sub(1) << (self.0 >> 3 & 7)
    }
}

/// An inner node: eight child boxes side by side (lane = child) and where they lead. 256 bytes, four cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node {
    /// `bounds[2 * axis]` = minima, `bounds[2 * axis + 1]` = maxima; +inf and -inf for an empty child.
    pub bounds: [[f32; 8]; 6], // 192 bytes
    /// The children; [`EMPTY_NODE`] where there is none.
    pub child: [NodeRef; 8], // 32 bytes
    /// For the directions of each octant (bit `axis` = negative), the slots of all children, far ones first: three bits
    /// each, the first in the lowest. [`Node::sort`] finds it; it affects time only, as long as each slot is there.
    pub order: [u32; 8], // 32 bytes
}

impl Node {
    /// Which children are leaves, as bits.
    #[inline(always)]
    pub(crate) fn leaves<S: Simd>(&self, s: S) -> u32 {
        let mut refs = [0; 8];
        for i in 0..8 {
            refs[i] = self.child[i].0;
        }
        let sign = I32::<S, 8>::splat(s, 1 << 31);
        (I32::load(s, &refs) & sign).eq(sign).bits()
    }

    /// A node without children.
    pub const EMPTY: Node = Node {
        bounds: [
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
        ],
        child: [EMPTY_NODE; 8],
        // Slots 7 to 0.
        order: [0o01234567; 8],
    };

    /// Orders the children for each octant: by a point of their box, two thirds of the way from the corner that rays
    /// of the octant reach first to the opposite one (of several points this one led to the fewest visits).
    pub fn sort(&mut self) {
        for octant in 0..8 {
            let mut keys = [0.0f32; 8];
            for (axis, planes) in self.bounds.as_chunks::<2>().0.iter().enumerate() {
                let negative = octant >> axis & 1 != 0;
                for ((key, min), max) in keys.iter_mut().zip(planes[0]).zip(planes[1]) {
                    *key += if negative { -max - 2.0 * min } else { min + 2.0 * max };
                }
            }
            // Those of empty children are NaN: let them be infinitely far.
            let keys = keys.map(|key| if key.is_nan() { f32::INFINITY } else { key });
            self.order[octant] = 0;
            for (slot, key) in keys.iter().enumerate() {
                let before = |&(other, than): &(usize, &f32)| than > key || (than == key && other < slot);
                let rank = keys.iter().enumerate().filter(before).count();
                self.order[octant] |= (slot << (3 * rank)) as u32;
            }
        }
    }
}

/// Up to eight triangles side by side (lane = triangle); several leaves may share a block. 320 bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct TriBlock {
    /// `v[corner][axis][lane]`: vertex positions in world space.
    pub v: [[[f32; 8]; 3]; 3], // 288 bytes
    /// Primitive ids; [`crate::MISS`] in unused lanes.
    pub prim: [u32; 8], // 32 bytes
}

impl TriBlock {
    /// A block without triangles: all corners at the world's origin.
    pub const EMPTY: TriBlock = TriBlock { v: [[[0.0; 8]; 3]; 3], prim: [u32::MAX; 8] };
}

/// A borrowed tree.
///
/// Whoever builds one guarantees that every box encloses its subtree's vertices, that every reference is in range, that
/// every [`Node::order`] names each slot, and that no path is longer than [`MAX_DEPTH`] nodes. Breaking that gives wrong
/// hits or a panic, never undefined behaviour: the kernels index with bounds checks.
#[derive(Clone, Copy, Debug)]
pub struct BvhView<'a> {
    /// Tells this tree from all others that are or were in this process: kernels remember parts of a tree by it. See
    /// [`BvhView::fresh_id`].
    pub id: u64,
    /// Inner nodes.
    pub nodes: &'a [Node],
    /// Triangles.
    pub blocks: &'a [TriBlock],
    /// Where traversal starts; [`EMPTY_NODE`] for a scene without triangles.
    pub root: NodeRef,
}

impl BvhView<'_> {
    /// An id that no tree has yet.
    pub fn fresh_id() -> u64 {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        NEXT.fetch_add(1, Ordering::Relaxed)
    }
}
