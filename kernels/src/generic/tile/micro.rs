//! The tile kernel's steps one by one, to be timed: each repeats the very functions that the kernel is made of, on
//! what one packet meets in a tree.
//!
//! What a packet meets is found once, portably, so that every instruction set gets the same work. The steps leave their
//! results in the [`Meeting`]: since those are there already, [`Meeting::checksum`] must not change. Visibility is exact.

use super::{
    Rays, State,
    block::{BlockPlanes, set_up},
    scratch::TileScratch,
    triangles,
};
use crate::{
    arch::Scalar,
    dispatch::Kernels,
    generic::{
        F16,
        doubt::NO_SLOT,
        finish::{self, Planes},
    },
    node::{BvhView, EMPTY_NODE, NodeRef},
    packet::{MISS, SUBS, TileHits, TilePacket},
    simd::{Kernel, Simd},
    vector::I32,
    visibility::Exact,
};

/// A packet, and the parts of a tree that it has to look at even if it knows its hits in advance.
#[derive(Clone, Debug)]
pub struct Meeting<'a> {
    bvh: BvhView<'a>,
    packet: TilePacket,
    /// As after the traversal.
    state: Box<State>,
    /// `lo` and `hi` as before the traversal.
    start: Box<[Rays; 2]>,
    nodes: Vec<usize>,
    blocks: Vec<usize>,
    /// Set-up of each of `blocks`.
    leaves: Vec<BlockPlanes>,
    pairs: Vec<Pair>,
    planes: Box<Planes>,
    hits: TileHits,
    /// Depends on the outcome of all box tests.
    met: u64,
}

/// A triangle, and a sub-packet that may meet it.
#[derive(Clone, Copy, Debug)]
struct Pair {
    /// Place of its block in `blocks`.
    leaf: usize,
    slot: u32,
    sub: usize,
}

impl<'a> Meeting<'a> {
    /// Traces the packet and remembers what it meets.
    pub fn new(bvh: BvhView<'a>, packet: TilePacket) -> Meeting<'a> {
        let s = Scalar;
        let mut scratch = TileScratch::new();
        let mut hits = TileHits::new();
        super::intersect::<_, Exact>(s, &bvh, &packet, &mut scratch, &mut hits);
        let mut fresh = State::new();
        fresh.begin::<_, Exact>(s, &packet);
        let mut meeting = Meeting {
            bvh,
            packet,
            state: scratch.state,
            start: Box::new([fresh.lo, fresh.hi]),
            nodes: Vec::new(),
            blocks: Vec::new(),
            leaves: Vec::new(),
            pairs: Vec::new(),
            planes: Box::new(Planes::new()),
            hits,
            met: 0,
        };
        for (leaf, subs) in meeting.walk() {
            meeting.meet_leaf(leaf, subs);
        }
        BoxTest(&mut meeting).run(s);
        meeting
    }

    /// Collects the nodes; returns the leaves, each with the sub-packets that reach it.
    fn walk(&mut self) -> Vec<(NodeRef, u32)> {
        let (s, state) = (Scalar, &mut self.state);
        let mut leaves = Vec::new();
        let mut stack = vec![(self.bvh.root, state.live_subs)];
        while let Some((node, subs)) = stack.pop() {
            if node == EMPTY_NODE || subs == 0 {
                continue;
            }
            if node.is_leaf() {
                leaves.push((node, subs));
                continue;
            }
            self.nodes.push(node.index());
            let node = &self.bvh.nodes[node.index()];
            let left = state.project::<_, Exact>(s, node);
            for child in (0..8).filter(|child| left >> child & 1 != 0) {
                stack.push((node.child[child], subs & state.subs_meet(s, child)));
            }
        }
        leaves
    }

    /// Sets up a leaf's block and collects the pairs of its triangles and the sub-packets that may meet them.
    fn meet_leaf(&mut self, node: NodeRef, subs: u32) {
        let (s, block) = (Scalar, node.block());
        let leaf = self.blocks.iter().position(|&known| known == block).unwrap_or_else(|| {
            let mut planes = BlockPlanes::EMPTY;
            set_up::<_, Exact>(s, &self.bvh.blocks[block], &self.state.frame, &mut planes);
            self.leaves.push(planes);
            self.blocks.push(block);
            self.blocks.len() - 1
        });
        let (planes, state) = (&self.leaves[leaf], &self.state);
        let lanes = planes.within(s, state.tile_u, state.tile_v, state.tile_reach) & node.lanes();
        for lane in (0..8).filter(|lane| lanes >> lane & 1 != 0) {
            let met = triangles::sub_packets(s, planes, lane, state) & subs;
            let slot = (block * 8 + lane) as u32;
            let pair = |sub| Pair { leaf, slot, sub };
            self.pairs.extend((0..SUBS).filter(|sub| met >> sub & 1 != 0).map(pair));
        }
    }

    /// Boxes that [`Meeting::test_boxes`] tests: eight for each node.
    pub fn boxes(&self) -> u64 {
        8 * self.nodes.len() as u64
    }

    /// Projects the boxes of all nodes and tests them against the tile, those it meets against its sub-packets.
    pub fn test_boxes(&mut self, kernels: &Kernels) {
        kernels.run(BoxTest(self));
    }

    /// Triangles that [`Meeting::set_up_leaves`] sets up.
    pub fn triangles(&self) -> u64 {
        let blocks = self.blocks.iter().map(|&block| &self.bvh.blocks[block]);
        blocks.flat_map(|block| block.prim).filter(|&prim| prim != MISS).count() as u64
    }

    /// Sets up all blocks for the packet's origin.
    pub fn set_up_leaves(&mut self, kernels: &Kernels) {
        kernels.run(LeafSetUp(self));
    }

    /// Pairs of a ray and a triangle that [`Meeting::test_triangles`] tests.
    pub fn pairs(&self) -> u64 {
        self.pairs.iter().map(|pair| u64::from(self.packet.active[pair.sub].count_ones())).sum()
    }

    /// Tests all pairs of a triangle and the sixteen rays of a sub-packet, from no hit to the first ones; doubtful rays
    /// are decided exactly.
    pub fn test_triangles(&mut self, kernels: &Kernels) {
        kernels.run(TriangleTest(self));
    }

    /// Rays whose hits [`Meeting::finish`] writes.
    pub fn rays(&self) -> u64 {
        self.packet.active.iter().map(|active| u64::from(active.count_ones())).sum()
    }

    /// Writes the hits of the triangles found.
    pub fn finish(&mut self, kernels: &Kernels) {
        kernels.run(Finish(self));
    }

    /// Depends on every bit of what the steps find out.
    pub fn checksum(&self) -> u64 {
        let leaves = self.leaves.iter().flat_map(BlockPlanes::bits);
        let slots = self.state.slot.iter().flatten().copied();
        let hits = &self.hits;
        let numbers = [&hits.t, &hits.u, &hits.v].into_iter().flatten().map(|x| x.to_bits());
        leaves.chain(slots).chain(hits.prim).chain(numbers).fold(self.met, fold)
    }
}

/// A sum that depends on the order and on every bit of what is added.
#[inline(always)]
pub fn fold(sum: u64, word: u32) -> u64 {
    (sum.rotate_left(5) ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

/// The boxes of all nodes are projected and tested against the tile, those it meets against its sub-packets.
struct BoxTest<'a, 'b>(&'a mut Meeting<'b>);

impl Kernel for BoxTest<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Meeting { bvh, state, nodes, met, .. } = self.0;
        let mut sum = 0;
        for &node in &*nodes {
            let mut left = state.project::<S, Exact>(s, &bvh.nodes[node]);
            while left != 0 {
                let child = (left.trailing_zeros() & 7) as usize;
                left &= left - 1;
                sum = fold(sum, state.subs_meet(s, child) << 3 | child as u32);
            }
        }
        *met = sum;
    }
}

/// All blocks are set up for the packet's origin.
struct LeafSetUp<'a, 'b>(&'a mut Meeting<'b>);

impl Kernel for LeafSetUp<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Meeting { bvh, state, blocks, leaves, .. } = self.0;
        for (&block, to) in blocks.iter().zip(leaves) {
            set_up::<S, Exact>(s, &bvh.blocks[block], &state.frame, to);
        }
    }
}

/// All pairs are tested, lane = ray.
struct TriangleTest<'a, 'b>(&'a mut Meeting<'b>);

impl Kernel for TriangleTest<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Meeting { bvh, packet, state, start, leaves, pairs, .. } = self.0;
        for sub in 0..SUBS {
            F16::load(s, &start[0][sub]).store(&mut state.lo[sub]);
            F16::load(s, &start[1][sub]).store(&mut state.hi[sub]);
            I32::splat(s, NO_SLOT).store(&mut state.slot[sub]);
        }
        for pair in &*pairs {
            let planes = &leaves[pair.leaf];
            triangles::test::<S, Exact, false>(s, bvh, packet, state, planes, pair.slot, pair.sub);
        }
    }
}

/// Triangles become hits.
struct Finish<'a, 'b>(&'a mut Meeting<'b>);

impl Kernel for Finish<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Meeting { bvh, packet, state, planes, hits, .. } = self.0;
        finish::hits(s, bvh, packet, &state.frame, planes, 1, &state.slot, hits);
    }
}
