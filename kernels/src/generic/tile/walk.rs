//! Walking the tree: which children anyone has to visit, nearest first.

use super::{State, scratch::LeafCache, triangles::{list, work_off}};
use crate::{
    generic::{F8, F16, stack::Stack},
    node::{BvhView, EMPTY_NODE, Node, NodeRef},
    packet::TilePacket,
    simd::Simd,
    vector::I32,
};

/// A subtree that some sub-packets still have to visit.
#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    subs: u32,
    /// Nearest depth of its box.
    near: f32,
}

/// Box planes of a node's children relative to the origin, in permuted axes; depth cut off at zero. In memory so
/// that they can be broadcast.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Planes {
    x: [[f32; 8]; 2],
    y: [[f32; 8]; 2],
    z: [[f32; 8]; 2],
}

impl Planes {
    pub(super) const EMPTY: Planes = Planes { x: [[0.0; 8]; 2], y: [[0.0; 8]; 2], z: [[0.0; 8]; 2] };
}

/// Walks the tree from `root`.
#[inline(always)]
pub(super) fn traverse<S: Simd, const ANY: bool>(
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
    loop {
        let entry = next(s, state, &mut stack);
        // Whether what is listed must be tested now.
        let mut now = !ANY;
        match entry {
            None => now = true,
            Some(entry) if entry.node.is_leaf() => {
                list(s, bvh, state, leaves, entry.node, entry.subs);
                now = true;
            }
            Some(entry) => now |= children(s, bvh, state, leaves, &mut stack, entry),
        }
        if state.batch.is_empty() {
            leaves.release();
        } else if now || state.batch.is_enough() {
            work_off::<S, ANY>(s, bvh, packet, state, leaves);
            if ANY && state.live_subs == 0 {
                return;
            }
        }
        if entry.is_none() {
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
fn children<S: Simd>(
    s: S,
    bvh: &BvhView,
    state: &mut State,
    leaves: &mut LeafCache,
    stack: &mut Stack<Entry>,
    entry: Entry,
) -> bool {
    let node = &bvh.nodes[entry.node.index()];
    let left = tile_test(s, node, state);
    let is_leaf = node.leaves(s);
    let mut left_leaves = left & is_leaf;
    let mut left_nodes = left & !is_leaf;
    fetch_blocks(s, bvh, leaves, node, left_leaves);
    let bottom = stack.len();
    while left_nodes != 0 {
        let child = (left_nodes.trailing_zeros() & 7) as usize;
        left_nodes &= left_nodes - 1;
        let wanted = sub_test(s, child, state) & entry.subs;
        if wanted != 0 {
            let near = state.planes.z[0][child];
            fetch(s, bvh, node.child[child]);
            stack.insert(bottom, Entry { node: node.child[child], subs: wanted, near }, |e| e.near < near);
        }
    }
    let mut pushed = false;
    while left_leaves != 0 {
        let child = (left_leaves.trailing_zeros() & 7) as usize;
        left_leaves &= left_leaves - 1;
        let (node, subs) = (node.child[child], sub_test(s, child, state) & entry.subs);
        if subs == 0 {
            continue;
        }
        if leaves.is_in_the_way(node.block()) {
            stack.push(Entry { node, subs, near: state.planes.z[0][child] });
            pushed = true;
        } else {
            list(s, bvh, state, leaves, node, subs);
        }
    }
    pushed
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

/// Which children the tile's frustum may touch, lane = child.
#[inline(always)]
fn tile_test<S: Simd>(s: S, node: &Node, state: &mut State) -> u32 {
    let frame = &state.frame;
    let [iu, iv, iz] = frame.axes.map(|axis| axis % 3);
    let negative = usize::from(frame.flip != 0);
    let flip = I32::splat(s, frame.flip);
    let zero = F8::splat(s, 0.0);
    let org = [F8::splat(s, frame.org[0]), F8::splat(s, frame.org[1]), F8::splat(s, frame.org[2])];
    let x0 = F8::load(s, &node.bounds[2 * iu]) - org[0];
    let x1 = F8::load(s, &node.bounds[2 * iu + 1]) - org[0];
    let y0 = F8::load(s, &node.bounds[2 * iv]) - org[1];
    let y1 = F8::load(s, &node.bounds[2 * iv + 1]) - org[1];
    let z0 = (F8::load(s, &node.bounds[2 * iz + negative]) - org[2]).flip(flip).max(zero);
    let z1 = (F8::load(s, &node.bounds[2 * iz + 1 - negative]) - org[2]).flip(flip);
    let planes = &mut state.planes;
    x0.store(&mut planes.x[0]);
    x1.store(&mut planes.x[1]);
    y0.store(&mut planes.y[0]);
    y1.store(&mut planes.y[1]);
    z0.store(&mut planes.z[0]);
    z1.store(&mut planes.z[1]);

    let (u0, u1) = (F8::splat(s, state.tile_u[0]), F8::splat(s, state.tile_u[1]));
    let (v0, v1) = (F8::splat(s, state.tile_v[0]), F8::splat(s, state.tile_v[1]));
    let across = (u0 * z0).min(u0 * z1).le(x1) & x0.le((u1 * z0).max(u1 * z1));
    let along = (v0 * z0).min(v0 * z1).le(y1) & y0.le((v1 * z0).max(v1 * z1));
    let depth = zero.le(z1) & (z0 * F8::splat(s, state.tile_reach)).le(F8::splat(s, 1.0));
    (across & along & depth).bits()
}

/// Which sub-packets may touch one child, lane = sub-packet.
#[inline(always)]
fn sub_test<S: Simd>(s: S, child: usize, state: &State) -> u32 {
    let Planes { x, y, z } = &state.planes;
    let (z0, z1) = (F16::splat(s, z[0][child]), F16::splat(s, z[1][child]));
    let (x0, x1) = (F16::splat(s, x[0][child]), F16::splat(s, x[1][child]));
    let (y0, y1) = (F16::splat(s, y[0][child]), F16::splat(s, y[1][child]));
    let (u0, u1) = (F16::load(s, &state.u[0]), F16::load(s, &state.u[1]));
    let (v0, v1) = (F16::load(s, &state.v[0]), F16::load(s, &state.v[1]));
    let across = (u0 * z0).min(u0 * z1).le(x1) & x0.le((u1 * z0).max(u1 * z1));
    let along = (v0 * z0).min(v0 * z1).le(y1) & y0.le((v1 * z0).max(v1 * z1));
    let depth = (z0 * F16::load(s, &state.reach)).le(F16::splat(s, 1.0));
    (across & along & depth).bits()
}
