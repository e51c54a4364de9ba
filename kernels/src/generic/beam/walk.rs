//! Walking the tree: which children anyone has to visit, nearest first.

use super::{Bounds, E, State, triangles::leaf};
use crate::{
    generic::{F8, F16, stack::Stack},
    node::{BvhView, EMPTY_NODE, Node, NodeRef},
    packet::{Pick, RayBlock, SUBS},
    simd::{Lanes, Simd},
    vector::{F32, I32, Mask},
    visibility::Policy,
};

/// For so few sub-packets at a leaf, looking at each ray first pays.
const FEW: u32 = 6;

/// A subtree that some sub-packets still have to visit.
#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    subs: u32,
    /// Nearest depth of its box.
    near: f32,
}

/// Box planes of a node's children relative to the reference point, in permuted axes. In memory so that they can be
/// broadcast.
#[repr(C, align(64))]
pub(super) struct Planes {
    x: [[f32; 8]; 2],
    y: [[f32; 8]; 2],
    z: [[f32; 8]; 2],
}

impl Planes {
    pub(super) const EMPTY: Planes = Planes { x: [[0.0; 8]; 2], y: [[0.0; 8]; 2], z: [[0.0; 8]; 2] };
}

/// Walks the tree; returns the leaf that decided a ray last ([`EMPTY_NODE`] if none did).
#[inline(always)]
pub(super) fn traverse<S: Simd, V: Policy, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    blocks: &[RayBlock],
    picks: &[Pick],
    state: &mut State,
) -> NodeRef {
    let mut last = EMPTY_NODE;
    if bvh.root == EMPTY_NODE || state.live_subs == 0 {
        return last;
    }
    let mut stack = Stack::new();
    let mut entry = Entry { node: bvh.root, subs: state.live_subs, near: 0.0 };
    loop {
        if entry.node.is_leaf() {
            last = leaf::<S, V, ANY>(s, bvh, blocks, picks, state, entry.node, entry.subs, last);
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
            let wanted = F16::splat(s, entry.near).le(F16::load(s, &state.bounds.reach));
            entry.subs &= wanted.bits() & state.live_subs;
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
    let mut left = beam_test(s, node, state);
    let bottom = stack.len();
    while left != 0 {
        let child = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        let mut wanted = sub_test(s, child, state) & subs;
        if node.child[child].is_leaf() && wanted.count_ones() <= FEW {
            wanted = pierced(s, child, state, wanted);
        }
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

/// Those of a few sub-packets that have a ray through box `child`.
#[inline(always)]
fn pierced<S: Simd>(s: S, child: usize, state: &State, mut subs: u32) -> u32 {
    let Planes { x, y, z } = &state.planes;
    let (x, y, z) = (splat(s, x, child), splat(s, y, child), splat(s, z, child));
    // As much as the bounds of sub-packets are widened by.
    let slope = F16::splat(s, 16.0 * E);
    let crossing = F16::splat(s, 16.0 * E * state.extent);
    let mut pierced = 0;
    while subs != 0 {
        let sub = (subs.trailing_zeros() & 15) as usize;
        subs &= subs - 1;
        let [u, v, a, b, _] = &state.lines[sub];
        let (u, v) = (F16::load(s, u), F16::load(s, v));
        let (a, b) = (F16::load(s, a), F16::load(s, b));
        let lines = Bounds {
            u: [u - slope, u + slope],
            v: [v - slope, v + slope],
            a: [a - crossing, a + crossing],
            b: [b - crossing, b + crossing],
            start: F16::load(s, &state.start[0][sub]),
            reach: F16::load(s, &state.hi[sub]),
        };
        let rays = !misses(&lines, x, y, z).bits() & u32::from(state.live[sub]);
        pierced |= u32::from(rays != 0) << sub;
    }
    pierced
}

/// Lanes in which a box misses the lines: see `prepare` for why none that is hit is among them. Written so that NaN
/// misses nothing.
#[inline(always)]
fn misses<S: Lanes<W>, const W: usize>(
    lines: &Bounds<F32<S, W>>,
    x: [F32<S, W>; 2],
    y: [F32<S, W>; 2],
    z: [F32<S, W>; 2],
) -> Mask<S, W> {
    let near = z[0].max(lines.start);
    let far = z[1].min(lines.reach);
    let [u0, u1] = lines.u;
    let [v0, v1] = lines.v;
    let x0 = u0.mul_add(near, lines.a[0]).min(u0.mul_add(far, lines.a[0]));
    let x1 = u1.mul_add(near, lines.a[1]).max(u1.mul_add(far, lines.a[1]));
    let y0 = v0.mul_add(near, lines.b[0]).min(v0.mul_add(far, lines.b[0]));
    let y1 = v1.mul_add(near, lines.b[1]).max(v1.mul_add(far, lines.b[1]));
    far.lt(near) | x[1].lt(x0) | x1.lt(x[0]) | y[1].lt(y0) | y1.lt(y[0])
}

/// Which children the beam may touch, lane = child.
#[inline(always)]
fn beam_test<S: Simd>(s: S, node: &Node, state: &mut State) -> u32 {
    let frame = &state.frame;
    let [iu, iv, iz] = frame.axes.map(|axis| axis % 3);
    let negative = usize::from(frame.flip != 0);
    let flip = I32::splat(s, frame.flip);
    let org = [F8::splat(s, frame.org[0]), F8::splat(s, frame.org[1]), F8::splat(s, frame.org[2])];
    let x = [F8::load(s, &node.bounds[2 * iu]) - org[0], F8::load(s, &node.bounds[2 * iu + 1]) - org[0]];
    let y = [F8::load(s, &node.bounds[2 * iv]) - org[1], F8::load(s, &node.bounds[2 * iv + 1]) - org[1]];
    let z = [
        (F8::load(s, &node.bounds[2 * iz + negative]) - org[2]).flip(flip),
        (F8::load(s, &node.bounds[2 * iz + 1 - negative]) - org[2]).flip(flip),
    ];
    let planes = &mut state.planes;
    for side in 0..2 {
        x[side].store(&mut planes.x[side]);
        y[side].store(&mut planes.y[side]);
        z[side].store(&mut planes.z[side]);
    }
    let beam = &state.beam;
    let lines = Bounds {
        u: [F8::splat(s, beam.u[0]), F8::splat(s, beam.u[1])],
        v: [F8::splat(s, beam.v[0]), F8::splat(s, beam.v[1])],
        a: [F8::splat(s, beam.a[0]), F8::splat(s, beam.a[1])],
        b: [F8::splat(s, beam.b[0]), F8::splat(s, beam.b[1])],
        start: F8::splat(s, beam.start),
        reach: F8::splat(s, beam.reach),
    };
    !misses(&lines, x, y, z).bits() & 0xff
}

/// Which sub-packets may touch one child, lane = sub-packet.
#[inline(always)]
fn sub_test<S: Simd>(s: S, child: usize, state: &State) -> u32 {
    let Planes { x, y, z } = &state.planes;
    let bounds = &state.bounds;
    let lines = Bounds {
        u: load(s, &bounds.u),
        v: load(s, &bounds.v),
        a: load(s, &bounds.a),
        b: load(s, &bounds.b),
        start: F16::load(s, &bounds.start),
        reach: F16::load(s, &bounds.reach),
    };
    !misses(&lines, splat(s, x, child), splat(s, y, child), splat(s, z, child)).bits()
}

#[inline(always)]
fn load<S: Simd>(s: S, pair: &[[f32; SUBS]; 2]) -> [F16<S>; 2] {
    [F16::load(s, &pair[0]), F16::load(s, &pair[1])]
}

#[inline(always)]
fn splat<S: Simd>(s: S, planes: &[[f32; 8]; 2], child: usize) -> [F16<S>; 2] {
    [F16::splat(s, planes[0][child]), F16::splat(s, planes[1][child])]
}
