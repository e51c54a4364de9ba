//! Walking the tree: which children anyone has to visit, nearest first.

use super::{
    SEEDS, State, rays,
    scratch::LeafCache,
    triangles::{FEW, list, work_off},
};
use crate::{
    generic::stack::Stack,
    node::{BvhView, EMPTY_NODE, Node, NodeRef},
    packet::TilePacket,
    simd::Simd,
    visibility::Policy,
};

/// Work of a step beside that of its triangles.
const NODE_WORK: u32 = 8;

/// A subtree that some sub-packets still have to visit.
#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    subs: u32,
    /// Nearest depth of its box.
    near: f32,
}

/// Walks the tree from `root`.
#[inline(always)]
pub(super) fn traverse<S: Simd, V: Policy, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    leaves: &mut LeafCache,
    root: NodeRef,
) {
    if root == EMPTY_NODE || state.live_subs == 0 {
        return;
    }
    let mut stack = Stack::new();
    stack.push(Entry { node: root, subs: state.live_subs, near: 0.0 });
    for at in 0..SEEDS {
        if let Some(node) = state.early.seed(bvh, at) {
            stack.push(Entry { node, subs: state.live_subs, near: 0.0 });
        }
    }
    loop {
        let entry = next(s, state, &mut stack);
        // Whether what is listed must be tested now.
        let mut now = !ANY;
        match entry {
            None => now = true,
            Some(entry) if entry.node.is_leaf() => {
                list::<S, V>(s, bvh, state, leaves, entry.node, entry.subs);
                now = true;
            }
            Some(entry) => now |= children::<S, V>(s, bvh, packet, state, leaves, &mut stack, entry),
        }
        if state.batch.is_empty() {
            leaves.release();
        } else if now || state.batch.is_enough() {
            work_off::<S, V, ANY>(s, bvh, packet, state, leaves);
            if ANY && state.live_subs == 0 {
                return;
            }
        }
        if entry.is_none() {
            return;
        }
        state.work = state.work.saturating_add(NODE_WORK);
        if state.work > state.budget && state.batch.is_empty() {
            state.gave_up = true;
            return;
        }
    }
}

/// The next subtree that anyone must visit.
#[inline(always)]
fn next<S: Simd>(s: S, state: &State, stack: &mut Stack<Entry>) -> Option<Entry> {
    loop {
        let mut entry = stack.pop()?;
        entry.subs = state.interested(s, entry.near, entry.subs);
        if entry.subs != 0 {
            return Some(entry);
        }
    }
}

/// Tests a node's children: lists the triangles of leaves, pushes inner nodes, the nearest last. True if a leaf had
/// to be pushed, because its set-up would replace one that is still needed.
#[inline(always)]
fn children<S: Simd, V: Policy>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    leaves: &mut LeafCache,
    stack: &mut Stack<Entry>,
    entry: Entry,
) -> bool {
    let node = &bvh.nodes[entry.node.index()];
    let left = state.project::<S, V>(s, node);
    let is_leaf = node.leaves(s);
    let mut left_leaves = left & is_leaf;
    let mut left_nodes = left & !is_leaf;
    fetch_blocks(s, bvh, leaves, node, left_leaves);
    let bottom = stack.len();
    while left_nodes != 0 {
        let child = (left_nodes.trailing_zeros() & 7) as usize;
        left_nodes &= left_nodes - 1;
        let wanted = state.subs_meet(s, child) & entry.subs;
        if wanted != 0 {
            let near = state.boxes.near(child);
            fetch(s, bvh, node.child[child]);
            stack.insert(bottom, Entry { node: node.child[child], subs: wanted, near }, |e| e.near < near);
        }
    }
    let mut pushed = false;
    while left_leaves != 0 {
        let child = (left_leaves.trailing_zeros() & 7) as usize;
        left_leaves &= left_leaves - 1;
        let mut subs = state.subs_meet(s, child) & entry.subs;
        if subs.count_ones() <= FEW && state.early.bound {
            subs = pierced(s, packet, state, child, subs);
        }
        if subs == 0 {
            continue;
        }
        let node = node.child[child];
        if leaves.is_in_the_way(node.block()) {
            stack.push(Entry { node, subs, near: state.boxes.near(child) });
            pushed = true;
        } else {
            list::<S, V>(s, bvh, state, leaves, node, subs);
        }
    }
    pushed
}

/// Those of a few sub-packets that have a ray through box `child`.
#[inline(always)]
fn pierced<S: Simd>(s: S, packet: &TilePacket, state: &State, child: usize, mut subs: u32) -> u32 {
    let (u, v) = (rays(&packet.u), rays(&packet.v));
    let mut pierced = 0;
    while subs != 0 {
        let sub = (subs.trailing_zeros() & 15) as usize;
        subs &= subs - 1;
        pierced |= u32::from(state.rays_meet(s, child, sub, u, v) != 0) << sub;
    }
    pierced
}

/// Asks for an inner node, because it will be visited.
#[inline(always)]
fn fetch<S: Simd>(s: S, bvh: &BvhView, child: NodeRef) {
    s.prefetch(&bvh.nodes[child.index()]);
}

/// Asks for the triangles of leaves that are not set up.
#[inline(always)]
fn fetch_blocks<S: Simd>(s: S, bvh: &BvhView, leaves: &LeafCache, node: &Node, mut children: u32) {
    while children != 0 {
        let block = node.child[(children.trailing_zeros() & 7) as usize].block();
        children &= children - 1;
        if !leaves.has(block) {
            s.prefetch(&bvh.blocks[block]);
        }
    }
}
