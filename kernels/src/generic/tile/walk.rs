//! Walking the tree: which children anyone has to visit, nearest first.

use super::{State, scratch::LeafCache, triangles::leaf};
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

/// Walks the tree from `root`; returns the leaf that decided a ray last ([`EMPTY_NODE`] if none did).
#[inline(always)]
pub(super) fn traverse<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    leaves: &mut LeafCache,
    root: NodeRef,
) -> NodeRef {
    let mut last = EMPTY_NODE;
    if root == EMPTY_NODE || state.live_subs == 0 {
        return last;
    }
    let mut stack = Stack::new();
    let mut entry = Entry { node: root, subs: state.live_subs, near: 0.0 };
    loop {
        if entry.node.is_leaf() {
            last = leaf::<S, ANY>(s, bvh, packet, state, leaves, entry.node, entry.subs, last);
            if ANY && state.live_subs == 0 {
                return last;
            }
        } else if children(s, &bvh.nodes[entry.node.index()], state, entry.subs, &mut stack, &mut entry) {
            continue;
        }
        loop {
            match stack.pop() {
                None => return last,
                Some(next) => entry = next,
            }
            entry.subs = state.interested(s, entry.near, entry.subs);
            if entry.subs != 0 {
                break;
            }
        }
    }
}

/// Tests a node's children; pushes all that anyone must visit but the nearest, which becomes `next`. False if there
/// is none.
#[inline(always)]
fn children<S: Simd>(
    s: S,
    node: &Node,
    state: &mut State,
    subs: u32,
    stack: &mut Stack<Entry>,
    next: &mut Entry,
) -> bool {
    let mut left = tile_test(s, node, state);
    let bottom = stack.len();
    while left != 0 {
        let child = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        let wanted = sub_test(s, child, state) & subs;
        if wanted != 0 {
            let near = state.planes.z[0][child];
            stack.insert(bottom, Entry { node: node.child[child], subs: wanted, near }, |e| e.near < near);
        }
    }
    if stack.len() == bottom {
        return false;
    }
    match stack.pop() {
        Some(nearest) => *next = nearest,
        None => return false,
    }
    true
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
