//! A leaf's triangles against a beam: set up at once, culled against sub-packets, then tested against rays.
//!
//! With vertices p and q of an edge relative to the reference point, e = q - p and m = p x q, the line x = a + u z,
//! y = b + v z passes the edge on the side given by the sign of
//!
//! ```text
//!   f = m . (u, v, 1) + e . (b, -a, w)        w = a v - b u
//! ```
//!
//! and it meets the plane n . x = d at the depth z = (d - nx a - ny b) / (nx u + ny v + nz).
//!
//! # Error bounds
//!
//! Let e = 2^-24, L the triangle's greatest coordinate relative to the reference point, O the `extent` of the origins.
//! What counts is the triangle with vertices fl(x - o), o the ray's own origin, and the ray's own direction; what is
//! computed is about vertices fl(x - c) and rounded lines.
//!
//! *The two pictures differ* by moving each vertex across the line (seen along it) by at most 8 e (L + O) in x and y:
//! rounding of x - o and x - c, seen along a slope up to 1, 2 e (L + O) + 2 e L; the rounded slope over the distance
//! from the origin, e (L + O); the crossing, 8 e O (see `prepare`). In depth they differ by 2 e (L + O).
//!
//! *Edges.* As points seen along the line, let the line be farther than B / |E| outside the line through an edge of
//! length |E|: then no triangle with vertices moved by less contains it. Let it be farther than that inside all three:
//! then every such triangle contains it. Hence f beyond B decides, with B = 12 e (L + O) S for the moved vertices,
//! S = |ex| + |ey| + 2 |ez| >= |E|. Evaluating f is off by 11 e of the sum of its terms' magnitudes, which is at most
//! 2 (L + O) S. `EDGE` = 40 e covers both.
//!
//! *Depth.* An exact hit is a mean of the moved vertices, so that n . x differs from d there by 8 e (L + O) P, where P
//! is the sum of n's *permanent*: its products made positive. d - nx a - ny b is off by 12 e P (L + 2 O), the
//! denominator by 8 e P, which moves a depth of at most L by 8 e P L over the denominator; the division adds 2 e L.
//! `HALF` = 48 e times P (L + O), over the denominator, covers all. This holds for any denominator but zero.
//!
//! [`TINY`] covers underflow. Where anything overflows, NaN decides nothing, so that the exact test does. Without
//! exactness all bounds are zero, and NaN is a miss.

use super::{
    E, State,
    rays::{Pair, test},
};
use crate::{
    generic::{
        F8, F16,
        leaf::{TINY, corners},
    },
    node::{BvhView, NodeRef, TriBlock},
    packet::{Pick, RayBlock, SUBS},
    simd::Simd,
    vector::{I32, Mask},
    visibility::Policy,
};

const EDGE: f32 = 40.0 * E;
const HALF: f32 = 48.0 * E;

/// Coefficients of the triangles that survive the beam's test, in memory so that they can be broadcast.
///
/// Triangles that all lines of the beam meet on the same side are oriented: inside is positive, and so is the plane's
/// denominator.
#[repr(C, align(64))]
pub(super) struct Coefficients {
    /// Edge functions: factors of u, v, a, b, w, and the constant.
    edges: [[[f32; 8]; 6]; 3],
    /// Magnitudes of those factors.
    sizes: [[[f32; 8]; 5]; 3],
    /// The plane: n, d.
    plane: [[f32; 8]; 4],
    /// |nx|, |ny|
    tilt: [[f32; 8]; 2],
    /// B, the error bound of edge functions.
    pub(super) edge_doubt: [f32; 8],
    /// The error bound of depths, times the denominator.
    pub(super) depth_doubt: [f32; 8],
    /// Least and greatest depth.
    depth: [[f32; 8]; 2],
    /// Bit = the triangle is oriented.
    oriented: u32,
}

impl Coefficients {
    pub(super) const EMPTY: Coefficients = Coefficients {
        edges: [[[0.0; 8]; 6]; 3],
        sizes: [[[0.0; 8]; 5]; 3],
        plane: [[0.0; 8]; 4],
        tilt: [[0.0; 8]; 2],
        edge_doubt: [0.0; 8],
        depth_doubt: [0.0; 8],
        depth: [[0.0; 8]; 2],
        oriented: 0,
    };
}

/// Tests a run of triangles; returns `node` if it decided a ray, else `last`.
#[inline(always)]
pub(super) fn leaf<S: Simd, V: Policy, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    blocks: &[RayBlock],
    picks: &[Pick],
    state: &mut State,
    node: NodeRef,
    subs: u32,
    last: NodeRef,
) -> NodeRef {
    let block_index = node.block();
    let mut left = set_up::<S, V>(s, &bvh.blocks[block_index], state, node.lanes());
    // Pairs are listed first, so that one loop without unforeseeable branches tests all of them.
    const SUB_NUMBERS: [u32; SUBS] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    let numbers = I32::<S, 16>::load(s, &SUB_NUMBERS);
    let mut pairs = 0;
    while left != 0 {
        let lane = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        let wanted = sub_packets::<S, V>(s, lane, state, subs & state.live_subs);
        if let Some((room, _)) = state.pairs[pairs..].split_first_chunk_mut() {
            (numbers + I32::splat(s, (lane * SUBS) as u32)).compress(wanted, room);
        }
        pairs += wanted.count_ones() as usize;
    }
    let mut touched = 0;
    for at in 0..pairs {
        let pair = state.pairs[at] as usize;
        let (lane, sub) = (pair / SUBS % 8, pair % SUBS);
        let rays = &blocks[picks[sub].block as usize];
        let pair = Pair { lane, sub, slot: (block_index * 8 + lane) as u32, rays };
        touched |= u32::from(test::<S, V, ANY>(s, bvh, state, &pair)) << sub;
    }
    if touched == 0 {
        return last;
    }
    refresh::<S, ANY>(s, state, touched);
    node
}

#[inline(always)]
fn dot<S: Simd, const N: usize>(factors: [F8<S>; N], of: [f32; N], s: S, rest: F8<S>) -> F8<S> {
    let mut sum = rest;
    for i in 0..N {
        sum = factors[i].mul_add(F8::splat(s, of[i]), sum);
    }
    sum
}

#[inline(always)]
fn cross<S: Simd>(a: [F8<S>; 3], b: [F8<S>; 3]) -> [[F8<S>; 2]; 3] {
    [[a[1] * b[2], a[2] * b[1]], [a[2] * b[0], a[0] * b[2]], [a[0] * b[1], a[1] * b[0]]]
}

#[inline(always)]
fn differences<S: Simd>([x, y, z]: [[F8<S>; 2]; 3]) -> [F8<S>; 3] {
    [x[0] - x[1], y[0] - y[1], z[0] - z[1]]
}

#[inline(always)]
fn from_to<S: Simd>(a: [F8<S>; 3], b: [F8<S>; 3]) -> [F8<S>; 3] {
    [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
}

/// Sets up the block and culls its triangles against the beam, lane = triangle.
#[inline(always)]
fn set_up<S: Simd, V: Policy>(s: S, block: &TriBlock, state: &mut State, lanes: u32) -> u32 {
    let p = corners(s, block, &state.frame);
    let mut e = [from_to(p[1], p[2]), from_to(p[2], p[0]), from_to(p[0], p[1])];
    let (zero, tiny, half) = (F8::splat(s, 0.0), F8::splat(s, TINY), F8::splat(s, 0.5));

    // Error bounds.
    let (mut size, mut span) = (zero, zero);
    for i in 0..3 {
        size = size.max(p[i][0].abs()).max(p[i][1].abs()).max(p[i][2].abs());
        span = span.max((e[i][0].abs() + e[i][1].abs()) + (e[i][2].abs() + e[i][2].abs()));
    }
    let size = size + F8::splat(s, state.extent);
    let products = cross(e[1], e[2]);
    let mut permanent = tiny;
    for [plus, minus] in products {
        permanent = permanent + (plus.abs() + minus.abs());
    }
    let (edge_doubt, depth_doubt) = if V::EXACT {
        // Where products may overflow, everything is in doubt. Written so that NaN is, too.
        let most = F8::splat(s, f32::MAX / 16.0);
        let sound = (size * span).lt(most) & (size * permanent).lt(most);
        let infinity = F8::splat(s, f32::INFINITY);
        let (edge, depth) = (F8::splat(s, EDGE) * size * span, F8::splat(s, HALF) * size * permanent);
        (sound.select(edge + tiny, infinity), sound.select(depth + tiny, infinity))
    } else {
        (zero, zero)
    };
    let least = p[0][2].min(p[1][2]).min(p[2][2]);
    let most = p[0][2].max(p[1][2]).max(p[2][2]);

    // The plane, oriented.
    let n = differences(products);
    let (middle, radius) = (state.beam_middle, state.beam_radius);
    let facing = dot([n[0], n[1]], [middle[0], middle[1]], s, n[2]);
    let turn = dot([n[0].abs(), n[1].abs()], [radius[0], radius[1]], s, F8::splat(s, 32.0 * E) * permanent);
    let oriented = turn.lt(facing.abs()).bits();
    let flip = facing.sign();
    let n = [n[0].flip(flip), n[1].flip(flip), n[2].flip(flip)];
    let d = n[0] * p[0][0] + n[1] * p[0][1] + n[2] * p[0][2];

    let mut outside = F8::splat(s, state.beam.reach).lt(least) | most.lt(F8::splat(s, state.beam.start));
    let mut across = zero.lt(zero);
    let two = edge_doubt + edge_doubt;
    let mut m = [[zero; 3]; 3];
    for i in 0..3 {
        e[i] = [e[i][0].flip(flip), e[i][1].flip(flip), e[i][2].flip(flip)];
        let (q, r) = (p[(i + 1) % 3], p[(i + 2) % 3]);
        let between = [half * (q[0] + r[0]), half * (q[1] + r[1]), half * (q[2] + r[2])];
        m[i] = differences(cross(between, e[i]));
        let factors = [m[i][0], m[i][1], -e[i][1], e[i][0], e[i][2]];
        let at = dot(factors, middle, s, m[i][2]);
        let mut by = two;
        for j in 0..5 {
            by = factors[j].abs().mul_add(F8::splat(s, radius[j]), by);
        }
        across = across | (at + by).lt(zero);
    }
    outside = outside | (across & Mask::from_bits(s, oriented));
    let left = !outside.bits() & lanes;
    if left != 0 {
        let k = &mut state.triangles;
        for i in 0..3 {
            let factors = [m[i][0], m[i][1], -e[i][1], e[i][0], e[i][2]];
            for j in 0..5 {
                factors[j].store(&mut k.edges[i][j]);
                factors[j].abs().store(&mut k.sizes[i][j]);
            }
            m[i][2].store(&mut k.edges[i][5]);
        }
        n[0].store(&mut k.plane[0]);
        n[1].store(&mut k.plane[1]);
        n[2].store(&mut k.plane[2]);
        d.store(&mut k.plane[3]);
        n[0].abs().store(&mut k.tilt[0]);
        n[1].abs().store(&mut k.tilt[1]);
        if V::EXACT {
            edge_doubt.store(&mut k.edge_doubt);
            depth_doubt.store(&mut k.depth_doubt);
        }
        least.store(&mut k.depth[0]);
        most.store(&mut k.depth[1]);
        k.oriented = oriented;
    }
    left
}

#[inline(always)]
pub(super) fn five<S: Simd>(s: S, from: &[[f32; 16]; 5]) -> [F16<S>; 5] {
    let [u, v, a, b, w] = from;
    [F16::load(s, u), F16::load(s, v), F16::load(s, a), F16::load(s, b), F16::load(s, w)]
}

/// Edge function `i` of triangle `lane`, of lines or of the middles of their intervals.
#[inline(always)]
pub(super) fn edge<S: Simd>(s: S, k: &Coefficients, i: usize, lane: usize, lines: &[F16<S>; 5]) -> F16<S> {
    let mut sum = F16::splat(s, k.edges[i][5][lane]);
    for j in 0..5 {
        sum = F16::splat(s, k.edges[i][j][lane]).mul_add(lines[j], sum);
    }
    sum
}

/// Numerator and denominator of the depth of triangle `lane`.
#[inline(always)]
pub(super) fn plane<S: Simd>(s: S, k: &Coefficients, lane: usize, lines: &[F16<S>; 5]) -> [F16<S>; 2] {
    let [nx, ny, nz, d] = &k.plane;
    let (nx, ny) = (F16::splat(s, nx[lane]), F16::splat(s, ny[lane]));
    let (nz, d) = (F16::splat(s, nz[lane]), F16::splat(s, d[lane]));
    let above = d - nx.mul_add(lines[2], ny * lines[3]);
    [above, nx.mul_add(lines[0], ny.mul_add(lines[1], nz))]
}

/// Which of `subs` one triangle may meet; lane = sub-packet.
#[inline(always)]
fn sub_packets<S: Simd, V: Policy>(s: S, lane: usize, state: &State, subs: u32) -> u32 {
    let k = &state.triangles;
    let (reach, start) = (F16::load(s, &state.bounds.reach), F16::load(s, &state.bounds.start));
    let mut outside = reach.lt(F16::splat(s, k.depth[0][lane])) | F16::splat(s, k.depth[1][lane]).lt(start);
    if k.oriented >> lane & 1 == 0 {
        return !outside.bits() & subs;
    }
    let (lines, widths) = (five(s, &state.middle), five(s, &state.radius));
    let zero = F16::splat(s, 0.0);
    let two = if V::EXACT { F16::splat(s, k.edge_doubt[lane] + k.edge_doubt[lane]) } else { zero };
    for i in 0..3 {
        let at = edge(s, k, i, lane, &lines);
        let mut by = two;
        for j in 0..5 {
            by = F16::splat(s, k.sizes[i][j][lane]).mul_add(widths[j], by);
        }
        outside = outside | (at + by).lt(zero);
    }
    // Farther than anything of interest, or nearer.
    let [above, facing] = plane(s, k, lane, &lines);
    let (tilt_x, tilt_y) = (F16::splat(s, k.tilt[0][lane]), F16::splat(s, k.tilt[1][lane]));
    let two = if V::EXACT { F16::splat(s, k.depth_doubt[lane] + k.depth_doubt[lane]) } else { zero };
    let by = tilt_x.mul_add(widths[2], tilt_y.mul_add(widths[3], two));
    let turn = tilt_x.mul_add(widths[0], tilt_y * widths[1]);
    let most = F16::splat(s, k.depth[1][lane]);
    let (low, high) = (facing - turn, facing + turn);
    let beyond = (reach.min(most) * high).lt(above - by);
    let before = (above + by).lt(start * low);
    !(outside | beyond | before).bits() & subs
}

/// Rays were decided: forgets sub-packets without live rays, or pulls in the reach of those concerned.
#[inline(always)]
fn refresh<S: Simd, const ANY: bool>(s: S, state: &mut State, mut touched: u32) {
    while touched != 0 {
        let sub = (touched.trailing_zeros() & 15) as usize;
        touched &= touched - 1;
        if ANY {
            state.live_subs &= !(u32::from(state.live[sub] == 0) << sub);
        } else {
            state.bounds.reach[sub] = F16::load(s, &state.hi[sub]).reduce_max();
        }
    }
    state.pull_in(s);
}
