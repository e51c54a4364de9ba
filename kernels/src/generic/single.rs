//! One ray over the 8-wide tree, for rays that have nothing in common with others.
//!
//! Boxes: near and far planes are loaded by the ray's octant (Embree's scheme), subtract first, then multiply by the
//! reciprocal; the interval is widened by the rounding of two operations, so that no true hit's box is rejected
//! (Ize 2013). Where 0 * infinity gives NaN, the axis does not restrict: `max` and `min` return their second operand.
//!
//! Triangles: the same set-up as in the tile kernel, lane = triangle; the few candidates are ordered by their
//! canonical depth.

use super::{F8, Frame, leaf::Leaf, leaf::triangle, stack::Stack};
use crate::{
    exact::{Canonical, passes},
    node::{BvhView, EMPTY_NODE, Node, NodeRef},
    packet::{Face, Hit, MISS, Ray},
    simd::Simd,
};

/// Rounding of a reciprocal, a product, and this factor itself, generously.
const SHRINK: f32 = 1.0 - 4.0 * f32::EPSILON;
const GROW: f32 = 1.0 + 4.0 * f32::EPSILON;

/// A ray prepared for traversal.
struct TravRay {
    org: [f32; 3],
    rdir: [f32; 3],
    /// 0 where the direction's component is positive, 1 where it is negative.
    negative: [usize; 3],
    frame: Frame,
    /// Direction in the frame: the last component is the largest and positive.
    d: [f32; 3],
    tnear: f32,
    skip: u32,
}

impl TravRay {
    /// `None` for a ray that hits nothing by definition.
    #[inline(always)]
    fn new(ray: &Ray) -> Option<TravRay> {
        let finite = ray.org.iter().chain(&ray.dir).all(|x| x.is_finite());
        let face = Face::of(ray.dir);
        let frame = Frame::new(ray.org, face);
        let d = frame.axes.map(|axis| ray.dir[axis]);
        let d = [d[0], d[1], f32::from_bits(d[2].to_bits() ^ frame.flip)];
        // Written so that NaN bounds fail.
        let tnear = if ray.tnear > 0.0 { ray.tnear } else { 0.0 };
        if !(finite && d[2] > 0.0 && tnear <= ray.tfar && !ray.tnear.is_nan()) {
            return None;
        }
        let negative = ray.dir.map(|x| usize::from(x.is_sign_negative()));
        Some(TravRay {
            org: ray.org,
            rdir: ray.dir.map(|x| 1.0 / x),
            negative,
            frame,
            d,
            tnear,
            skip: ray.skip,
        })
    }
}

/// The best hit so far.
struct Best {
    t: f64,
    prim: u32,
    slot: u32,
    /// At least `t`.
    tfar: f32,
}

#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    near: f32,
}

/// The first hit.
#[inline(always)]
pub(crate) fn intersect<S: Simd>(s: S, bvh: &BvhView, ray: &Ray) -> Hit {
    let Some(trav) = TravRay::new(ray) else { return Hit::MISS };
    let mut best = Best { t: f64::from(ray.tfar), prim: MISS, slot: 0, tfar: ray.tfar };
    traverse::<S, false>(s, bvh, &trav, &mut best);
    if best.prim == MISS {
        return Hit::MISS;
    }
    let [a, b, c] = triangle(&bvh.blocks[best.slot as usize / 8], best.slot as usize % 8, &trav.frame);
    let [t, u, v] = Canonical::new(a, b, c).hit(trav.d.map(f64::from));
    Hit { prim: best.prim, t, u, v }
}

/// True if anything is hit.
#[inline(always)]
pub(crate) fn occluded<S: Simd>(s: S, bvh: &BvhView, ray: &Ray) -> bool {
    let Some(trav) = TravRay::new(ray) else { return false };
    let mut best = Best { t: f64::from(ray.tfar), prim: MISS, slot: 0, tfar: ray.tfar };
    traverse::<S, true>(s, bvh, &trav, &mut best);
    best.prim != MISS
}

#[inline(always)]
fn traverse<S: Simd, const ANY: bool>(s: S, bvh: &BvhView, ray: &TravRay, best: &mut Best) {
    let mut stack = Stack::new();
    let mut entry = Entry { node: bvh.root, near: ray.tnear };
    loop {
        if entry.node.is_leaf() {
            leaf::<S>(s, bvh, ray, entry.node, best);
            if ANY && best.prim != MISS {
                return;
            }
        } else if entry.node != EMPTY_NODE {
            let node = &bvh.nodes[entry.node.index()];
            if let Some(nearest) = children::<S, ANY>(s, node, ray, best.tfar, &mut stack) {
                entry = nearest;
                continue;
            }
        }
        loop {
            match stack.pop() {
                None => return,
                Some(next) => entry = next,
            }
            if ANY || entry.near <= best.tfar {
                break;
            }
        }
    }
}

/// Tests a node's children; pushes all that must be visited but the nearest, which it returns.
#[inline(always)]
fn children<S: Simd, const ANY: bool>(
    s: S,
    node: &Node,
    ray: &TravRay,
    tfar: f32,
    stack: &mut Stack<Entry>,
) -> Option<Entry> {
    let mut near = F8::splat(s, ray.tnear);
    let mut far = F8::splat(s, tfar);
    for axis in 0..3 {
        let org = F8::splat(s, ray.org[axis]);
        let rdir = F8::splat(s, ray.rdir[axis]);
        let n = (F8::load(s, &node.bounds[2 * axis + ray.negative[axis]]) - org) * rdir;
        let f = (F8::load(s, &node.bounds[2 * axis + 1 - ray.negative[axis]]) - org) * rdir;
        near = (n * F8::splat(s, SHRINK)).max(near);
        far = (f * F8::splat(s, GROW)).min(far);
    }
    let mut left = near.le(far).bits();
    let near = near.to_array();
    let mut found = [Entry { node: EMPTY_NODE, near: 0.0 }; 8];
    let mut count = 0;
    while left != 0 {
        let child = left.trailing_zeros() as usize;
        left &= left - 1;
        if node.child[child] == EMPTY_NODE {
            continue;
        }
        let mut at = count;
        while !ANY && at > 0 && found[at - 1].near < near[child] {
            found[at] = found[at - 1];
            at -= 1;
        }
        found[at] = Entry { node: node.child[child], near: near[child] };
        count += 1;
    }
    let nearest = count.checked_sub(1)?;
    for entry in &found[..nearest] {
        stack.push(*entry);
    }
    Some(found[nearest])
}

/// Tests a run of triangles, lane = triangle.
#[inline(always)]
fn leaf<S: Simd>(s: S, bvh: &BvhView, ray: &TravRay, node: NodeRef, best: &mut Best) {
    let block_index = node.block();
    let block = &bvh.blocks[block_index];
    let leaf = Leaf::new(s, block, &ray.frame);
    let d = [F8::splat(s, ray.d[0]), F8::splat(s, ray.d[1]), F8::splat(s, ray.d[2])];
    let [e0, e1, e2] = &leaf.edges;
    let inside = value(e0, &d).min(value(e1, &d)).min(value(e2, &d));
    // Inverse depth, with its bound, times depth: at least 1 if the hit may be as near as the best. The product is
    // off by another unit.
    let w = value(&leaf.depth, &d) * F8::splat(s, best.tfar);
    let mut left = !(inside.lt(F8::splat(s, 0.0)) | w.lt(F8::splat(s, SHRINK))).bits() & node.lanes();
    if left == 0 {
        return;
    }
    let sure = (leaf.edge_doubt * d[2]).lt(inside).bits();
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        let prim = block.prim[lane];
        if prim == ray.skip {
            continue;
        }
        let [a, b, c] = triangle(block, lane, &ray.frame);
        if sure >> lane & 1 == 0 && !passes(a, b, c, ray.d) {
            continue;
        }
        let t = Canonical::new(a, b, c).depth(ray.d.map(f64::from));
        // At t = tfar the interval is closed; equal depths go to the lower primitive.
        if t >= f64::from(ray.tnear) && (t < best.t || (t == best.t && prim < best.prim)) {
            *best = Best { t, prim, slot: (block_index * 8 + lane) as u32, tfar: next_up(t) };
        }
    }
}

#[inline(always)]
fn value<S: Simd>(f: &[F8<S>; 3], d: &[F8<S>; 3]) -> F8<S> {
    f[0] * d[0] + f[1] * d[1] + f[2] * d[2]
}

/// A float at least as large as `t`.
#[inline(always)]
fn next_up(t: f64) -> f32 {
    let rounded = t as f32;
    if f64::from(rounded) >= t { rounded } else { rounded.next_up() }
}
