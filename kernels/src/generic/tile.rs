//! The common-origin tile kernel: 256 rays against the tree, closest hit and occlusion.
//!
//! The structure is that of multi-level culling (Reshetov 2005; Wald 2007; Boulos 2006) with the arithmetic of
//! edge functions over slopes (Davidovic 2012, "3D rasterization"): see the crate's documentation for the picture.
//!
//! # Why culling never loses a hit
//!
//! Vertices relative to the origin are rounded once, fl(v - o); box planes likewise, and since rounding is monotonic
//! fl(box - o) still encloses every fl(v - o). An exact hit lies within the rounded triangle, hence within the
//! rounded box. The comparisons below are products of floats against floats: if a real product is <= x then so is
//! the rounded one, so none of them can reject what real arithmetic would keep. Depth is compared as
//! z0 * inverse_depth <= 1, where the inverse depth is a lower bound of the best hit's: the same argument holds.

use super::{
    F8, F16, Frame,
    doubt::{NO_SLOT, inverse_interval, nearer},
    finish,
    leaf::Leaf,
    stack::Stack,
};
use crate::{
    node::{BvhView, EMPTY_NODE, Node, NodeRef, TriBlock},
    packet::{SUB, SUBS, TILE_RAYS, TileHits, TilePacket},
    simd::Simd,
    vector::{I32, Mask},
};

/// What a packet knows while it is traced.
#[repr(C, align(64))]
struct State {
    /// Interval of the best inverse depth so far; infinite for rays that take no part.
    lo: [f32; TILE_RAYS],
    hi: [f32; TILE_RAYS],
    /// The best triangle so far.
    slot: [u32; TILE_RAYS],
    /// Slope rectangle of each sub-packet: `[least, greatest]`.
    u: [[f32; SUBS]; 2],
    v: [[f32; SUBS]; 2],
    /// Least `lo` of each sub-packet: no ray of it needs anything farther.
    reach: [f32; SUBS],
    /// Rays still to be decided.
    live: [u16; SUBS],
    /// Sub-packets with such rays.
    live_subs: u32,
    /// Slope rectangle and reach of the whole tile.
    tile_u: [f32; 2],
    tile_v: [f32; 2],
    tile_reach: f32,
    frame: Frame,
}

/// A subtree that some sub-packets still have to visit.
#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    subs: u32,
    /// Nearest depth of its box.
    near: f32,
}

/// First hits of all active rays.
#[inline(always)]
pub(crate) fn intersect<S: Simd>(s: S, bvh: &BvhView, packet: &TilePacket, hits: &mut TileHits) {
    let mut state = State::new(s, packet);
    traverse::<S, false>(s, bvh, packet, &mut state, bvh.root);
    finish::hits(s, bvh, packet, &state.frame, &state.slot, hits);
}

/// The rays that something blocks between the origin and `tfar`, as bits like [`TilePacket::active`].
///
/// `seed` is a subtree to try first, typically the leaf that blocked the previous packet; it is replaced by the leaf
/// that blocked a ray last. It changes the time, never the answer.
#[inline(always)]
pub(crate) fn occluded<S: Simd>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    seed: &mut NodeRef,
    blocked: &mut [u16; SUBS],
) {
    let mut state = State::new(s, packet);
    let mut last = EMPTY_NODE;
    if *seed != EMPTY_NODE && seed.block() < bvh.blocks.len() {
        let subs = state.live_subs;
        last = leaf::<S, true>(s, bvh, packet, &mut state, *seed, subs, last);
    }
    if state.live_subs != 0 {
        let found = traverse::<S, true>(s, bvh, packet, &mut state, bvh.root);
        last = if found == EMPTY_NODE { last } else { found };
    }
    *seed = last;
    for sub in 0..SUBS {
        blocked[sub] = packet.active[sub] & !state.live[sub];
    }
}

impl State {
    #[inline(always)]
    fn new<S: Simd>(s: S, packet: &TilePacket) -> State {
        let mut state = State {
            lo: [0.0; TILE_RAYS],
            hi: [0.0; TILE_RAYS],
            slot: [NO_SLOT; TILE_RAYS],
            u: [[0.0; SUBS]; 2],
            v: [[0.0; SUBS]; 2],
            reach: [f32::INFINITY; SUBS],
            live: packet.active,
            live_subs: 0,
            tile_u: [f32::INFINITY, f32::NEG_INFINITY],
            tile_v: [f32::INFINITY, f32::NEG_INFINITY],
            tile_reach: f32::INFINITY,
            frame: Frame::new(packet.org, packet.face),
        };
        let infinity = F16::splat(s, f32::INFINITY);
        let one = F16::splat(s, 1.0);
        for sub in 0..SUBS {
            let at = sub * SUB;
            let bits = u32::from(packet.active[sub]);
            if bits == 0 {
                continue;
            }
            state.live_subs |= 1 << sub;
            let active = Mask::from_bits(s, bits);
            // 1 / tfar is off by half a unit: these factors enclose it.
            let inverse = one / F16::load_at(s, &packet.tfar, at);
            let lo = active.select(inverse * F16::splat(s, 1.0 - 2.5e-7), infinity);
            let hi = active.select(inverse * F16::splat(s, 1.0 + 2.5e-7), infinity);
            lo.store_at(&mut state.lo, at);
            hi.store_at(&mut state.hi, at);
            state.reach[sub] = lo.reduce_min();
            for (slopes, range, tile) in
                [(&packet.u, &mut state.u, &mut state.tile_u), (&packet.v, &mut state.v, &mut state.tile_v)]
            {
                let slope = F16::load_at(s, slopes, at);
                let least = active.select(slope, infinity).reduce_min();
                let greatest = active.select(slope, -infinity).reduce_max();
                range[0][sub] = least;
                range[1][sub] = greatest;
                tile[0] = tile[0].min(least);
                tile[1] = tile[1].max(greatest);
            }
        }
        state.tile_reach = F16::load(s, &state.reach).reduce_min();
        state
    }

    /// Sub-packets of `subs` that are still looking for something as near as depth `near`.
    #[inline(always)]
    fn interested<S: Simd>(&self, s: S, near: f32, subs: u32) -> u32 {
        let near = F16::splat(s, near);
        let within = (near * F16::load(s, &self.reach)).le(F16::splat(s, 1.0));
        within.bits() & subs & self.live_subs
    }
}

/// Walks the tree from `root`; returns the leaf that decided a ray last ([`EMPTY_NODE`] if none did).
#[inline(always)]
fn traverse<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
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
            last = leaf::<S, ANY>(s, bvh, packet, state, entry.node, entry.subs, last);
            if ANY && state.live_subs == 0 {
                return last;
            }
        } else if let Some(nearest) =
            children(s, &bvh.nodes[entry.node.index()], state, entry.subs, &mut stack)
        {
            entry = nearest;
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

/// Box planes of a node's children relative to the origin, in permuted axes; depth cut off at zero.
#[repr(C, align(64))]
struct Planes {
    x0: [f32; 8],
    x1: [f32; 8],
    y0: [f32; 8],
    y1: [f32; 8],
    z0: [f32; 8],
    z1: [f32; 8],
}

/// Tests a node's children; pushes all that anyone must visit but the nearest, which it returns.
#[inline(always)]
fn children<S: Simd>(s: S, node: &Node, state: &State, subs: u32, stack: &mut Stack<Entry>) -> Option<Entry> {
    let mut planes =
        Planes { x0: [0.0; 8], x1: [0.0; 8], y0: [0.0; 8], y1: [0.0; 8], z0: [0.0; 8], z1: [0.0; 8] };
    let mut left = tile_test(s, node, state, &mut planes);

    // Farthest first; a node has at most eight children.
    let mut found = [Entry { node: EMPTY_NODE, subs: 0, near: 0.0 }; 8];
    let mut count = 0;
    while left != 0 {
        let child = left.trailing_zeros() as usize;
        left &= left - 1;
        let wanted = sub_test(s, &planes, child, state) & subs;
        if wanted == 0 {
            continue;
        }
        let near = planes.z0[child];
        let mut at = count;
        while at > 0 && found[at - 1].near < near {
            found[at] = found[at - 1];
            at -= 1;
        }
        found[at] = Entry { node: node.child[child], subs: wanted, near };
        count += 1;
    }
    let nearest = count.checked_sub(1)?;
    for entry in &found[..nearest] {
        stack.push(*entry);
    }
    Some(found[nearest])
}

/// Which children the tile's frustum may touch, lane = child.
#[inline(always)]
fn tile_test<S: Simd>(s: S, node: &Node, state: &State, planes: &mut Planes) -> u32 {
    let frame = &state.frame;
    let [iu, iv, iz] = frame.axes;
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
    x0.store(&mut planes.x0);
    x1.store(&mut planes.x1);
    y0.store(&mut planes.y0);
    y1.store(&mut planes.y1);
    z0.store(&mut planes.z0);
    z1.store(&mut planes.z1);

    let (u0, u1) = (F8::splat(s, state.tile_u[0]), F8::splat(s, state.tile_u[1]));
    let (v0, v1) = (F8::splat(s, state.tile_v[0]), F8::splat(s, state.tile_v[1]));
    let across = (u0 * z0).min(u0 * z1).le(x1) & x0.le((u1 * z0).max(u1 * z1));
    let along = (v0 * z0).min(v0 * z1).le(y1) & y0.le((v1 * z0).max(v1 * z1));
    let depth = zero.le(z1) & (z0 * F8::splat(s, state.tile_reach)).le(F8::splat(s, 1.0));
    (across & along & depth).bits()
}

/// Which sub-packets may touch one child, lane = sub-packet.
#[inline(always)]
fn sub_test<S: Simd>(s: S, planes: &Planes, child: usize, state: &State) -> u32 {
    let (z0, z1) = (F16::splat(s, planes.z0[child]), F16::splat(s, planes.z1[child]));
    let (x0, x1) = (F16::splat(s, planes.x0[child]), F16::splat(s, planes.x1[child]));
    let (y0, y1) = (F16::splat(s, planes.y0[child]), F16::splat(s, planes.y1[child]));
    let (u0, u1) = (F16::load(s, &state.u[0]), F16::load(s, &state.u[1]));
    let (v0, v1) = (F16::load(s, &state.v[0]), F16::load(s, &state.v[1]));
    let across = (u0 * z0).min(u0 * z1).le(x1) & x0.le((u1 * z0).max(u1 * z1));
    let along = (v0 * z0).min(v0 * z1).le(y1) & y0.le((v1 * z0).max(v1 * z1));
    let depth = (z0 * F16::load(s, &state.reach)).le(F16::splat(s, 1.0));
    (across & along & depth).bits()
}

/// Coefficients of the triangles that survive the tile test, in memory so that they can be broadcast.
#[repr(C, align(64))]
struct Coefficients {
    edges: [[[f32; 8]; 3]; 3],
    depth: [[f32; 8]; 3],
    edge_doubt: [f32; 8],
    depth_doubt: [f32; 8],
    /// Bit = triangle: where the function is greatest, at the least or the greatest slope.
    edge_high: [[u32; 2]; 3],
    depth_high: [u32; 2],
}

/// Tests a run of triangles; returns `node` if it decided a ray, else `last`.
#[inline(always)]
fn leaf<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    node: NodeRef,
    subs: u32,
    last: NodeRef,
) -> NodeRef {
    let block_index = node.block();
    let block = &bvh.blocks[block_index];
    let (mut left, k) = triangles(s, block, state, node.lanes());
    let mut touched = 0;
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        let mut wanted = triangle_test(s, &k, lane, state) & subs;
        while wanted != 0 {
            let sub = wanted.trailing_zeros() as usize;
            wanted &= wanted - 1;
            let slot = (block_index * 8 + lane) as u32;
            if rays::<S, ANY>(s, bvh, packet, state, &k, lane, sub, slot) {
                touched |= 1 << sub;
            }
        }
    }
    if touched == 0 {
        return last;
    }
    if ANY {
        for sub in 0..SUBS {
            if state.live[sub] == 0 {
                state.live_subs &= !(1 << sub);
            }
        }
    } else {
        refresh_reach(s, state, touched);
    }
    node
}

/// The nearest hits got nearer: pull in the reach of the sub-packets concerned.
#[inline(always)]
fn refresh_reach<S: Simd>(s: S, state: &mut State, mut touched: u32) {
    while touched != 0 {
        let sub = touched.trailing_zeros() as usize;
        touched &= touched - 1;
        state.reach[sub] = F16::load_at(s, &state.lo, sub * SUB).reduce_min();
    }
    state.tile_reach = F16::load(s, &state.reach).reduce_min();
}

/// Sets up the block and culls its triangles against the tile, lane = triangle.
#[inline(always)]
fn triangles<S: Simd>(s: S, block: &TriBlock, state: &State, lanes: u32) -> (u32, Coefficients) {
    let leaf = Leaf::new(s, block, &state.frame);
    let mut k = Coefficients {
        edges: [[[0.0; 8]; 3]; 3],
        depth: [[0.0; 8]; 3],
        edge_doubt: [0.0; 8],
        depth_doubt: [0.0; 8],
        edge_high: [[0; 2]; 3],
        depth_high: [0; 2],
    };
    let zero = F8::splat(s, 0.0);
    let (u0, u1) = (F8::splat(s, state.tile_u[0]), F8::splat(s, state.tile_u[1]));
    let (v0, v1) = (F8::splat(s, state.tile_v[0]), F8::splat(s, state.tile_v[1]));
    let mut outside = greatest(&leaf.depth, u0, u1, v0, v1).lt(F8::splat(s, state.tile_reach));
    for i in 0..3 {
        outside = outside | greatest(&leaf.edges[i], u0, u1, v0, v1).lt(zero);
    }
    let left = !outside.bits() & lanes;
    if left == 0 {
        return (0, k);
    }
    for i in 0..3 {
        for j in 0..3 {
            leaf.edges[i][j].store(&mut k.edges[i][j]);
        }
        leaf.depth[i].store(&mut k.depth[i]);
        for j in 0..2 {
            k.edge_high[i][j] = zero.le(leaf.edges[i][j]).bits();
        }
    }
    for j in 0..2 {
        k.depth_high[j] = zero.le(leaf.depth[j]).bits();
    }
    leaf.edge_doubt.store(&mut k.edge_doubt);
    leaf.depth_doubt.store(&mut k.depth_doubt);
    (left, k)
}

/// The greatest value of an affine function over a rectangle of slopes.
#[inline(always)]
fn greatest<S: Simd>(f: &[F8<S>; 3], u0: F8<S>, u1: F8<S>, v0: F8<S>, v1: F8<S>) -> F8<S> {
    (f[0] * u0).max(f[0] * u1) + ((f[1] * v0).max(f[1] * v1) + f[2])
}

/// The affine function of triangle `lane` at slopes (u, v).
#[inline(always)]
fn affine<S: Simd>(s: S, f: &[[f32; 8]; 3], lane: usize, u: F16<S>, v: F16<S>) -> F16<S> {
    let constant = F16::splat(s, f[2][lane]);
    F16::splat(s, f[0][lane]).mul_add(u, F16::splat(s, f[1][lane]).mul_add(v, constant))
}

/// Which sub-packets may meet one triangle, lane = sub-packet.
#[inline(always)]
fn triangle_test<S: Simd>(s: S, k: &Coefficients, lane: usize, state: &State) -> u32 {
    let zero = F16::splat(s, 0.0);
    let [u, v] = highest(s, state, &k.depth_high, lane);
    let mut outside = affine(s, &k.depth, lane, u, v).lt(F16::load(s, &state.reach));
    for i in 0..3 {
        let [u, v] = highest(s, state, &k.edge_high[i], lane);
        outside = outside | affine(s, &k.edges[i], lane, u, v).lt(zero);
    }
    !outside.bits()
}

/// The corners of the sub-packets' slope rectangles where an affine function of triangle `lane` is greatest.
#[inline(always)]
fn highest<S: Simd>(s: S, state: &State, high: &[u32; 2], lane: usize) -> [F16<S>; 2] {
    [
        F16::load(s, &state.u[(high[0] >> lane & 1) as usize]),
        F16::load(s, &state.v[(high[1] >> lane & 1) as usize]),
    ]
}

/// Tests the sixteen rays of a sub-packet against one triangle; true if any was decided.
#[inline(always)]
fn rays<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    k: &Coefficients,
    lane: usize,
    sub: usize,
    slot: u32,
) -> bool {
    let at = sub * SUB;
    let u = F16::load_at(s, &packet.u, at);
    let v = F16::load_at(s, &packet.v, at);
    let [e0, e1, e2] = &k.edges;
    let inside = affine(s, e0, lane, u, v).min(affine(s, e1, lane, u, v)).min(affine(s, e2, lane, u, v));
    let w = affine(s, &k.depth, lane, u, v);
    let lo = F16::load_at(s, &state.lo, at);
    let candidate = F16::splat(s, 0.0).le(inside) & lo.le(w);
    let live = u32::from(state.live[sub]);
    let candidates = candidate.bits() & live;
    if candidates == 0 {
        return false;
    }
    let hi = F16::load_at(s, &state.hi, at);
    let w_lo = w - F16::splat(s, k.depth_doubt[lane]);
    let sure = candidate & F16::splat(s, k.edge_doubt[lane]).lt(inside) & hi.lt(w_lo);
    let sure_bits = sure.bits() & live;
    if ANY {
        state.live[sub] &= !(sure_bits as u16);
    } else {
        // Rays that take no part have hi = infinity, so they are never sure.
        sure.select(w_lo, lo).store_at(&mut state.lo, at);
        sure.select(w, hi).store_at(&mut state.hi, at);
        let slots: &mut [u32; SUB] = (&mut state.slot[at..at + SUB]).try_into().expect("16 lanes");
        sure.iselect(I32::splat(s, slot), I32::load(s, slots)).store(slots);
    }
    let doubtful = candidates & !sure_bits;
    let mut decided = sure_bits != 0;
    if doubtful != 0 {
        decided |= settle::<ANY>(bvh, packet, state, doubtful, at, slot);
    }
    decided
}

/// Decides the doubtful rays of a sub-packet exactly; true if one hits.
#[cold]
#[inline(never)]
fn settle<const ANY: bool>(
    bvh: &BvhView,
    packet: &TilePacket,
    state: &mut State,
    mut doubtful: u32,
    at: usize,
    slot: u32,
) -> bool {
    let mut decided = false;
    while doubtful != 0 {
        let i = doubtful.trailing_zeros() as usize;
        doubtful &= doubtful - 1;
        let ray = at + i;
        let direction = [packet.u[ray], packet.v[ray], 1.0];
        let best = state.slot[ray];
        if let Some(t) = nearer(bvh, &state.frame, direction, packet.tfar[ray], slot, best) {
            decided = true;
            if ANY {
                state.live[at / SUB] &= !(1 << i);
            } else {
                (state.lo[ray], state.hi[ray]) = inverse_interval(t);
                state.slot[ray] = slot;
            }
        }
    }
    decided
}
