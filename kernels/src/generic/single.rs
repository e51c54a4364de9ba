//! One ray over the 8-wide tree, for rays that have nothing in common with others.
//!
//! Boxes: near and far planes are loaded by the ray's octant (Embree's scheme), subtract first, then multiply by the
//! reciprocal; the interval is widened by the rounding of two operations, so that no true hit's box is rejected
//! (Ize 2013). Where 0 * infinity gives NaN, the axis does not restrict: `max` and `min` return their second operand.
//!
//! Triangles: lane = triangle, sheared along the ray; the few candidates are ordered by their canonical depth.

use super::{
    F8, Frame,
    doubt::block_of,
    leaf::{TINY, corners, triangle},
    stack::Stack,
};
use crate::{
    exact::{Canonical, passes, wide},
    node::{BvhView, EMPTY_NODE, Node, NodeRef, TriBlock},
    packet::{Face, Hit, MISS, Ray},
    simd::{Lanes, Simd},
    vector::F32,
};

/// Rounding of a reciprocal, a product, and this factor itself, generously.
pub(super) const SHRINK: f32 = 1.0 - 4.0 * f32::EPSILON;
pub(super) const GROW: f32 = 1.0 + 4.0 * f32::EPSILON;

/// A ray prepared for traversal.
#[derive(Clone, Copy)]
pub(super) struct TravRay {
    pub(super) org: [f32; 3],
    pub(super) rdir: [f32; 3],
    /// 0 where the direction's component is positive, 1 where it is negative.
    pub(super) negative: [usize; 3],
    pub(super) frame: Frame,
    /// Direction in the frame: the last component is the largest and positive.
    pub(super) d: [f32; 3],
    /// Slopes of the direction in the frame, rounded.
    pub(super) shear: [f32; 2],
    pub(super) tnear: f32,
    pub(super) skip: u32,
}

impl TravRay {
    /// `None` for a ray that hits nothing by definition.
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Option<TravRay> {
        let finite = ray.org.iter().chain(&ray.dir).all(|x| x.is_finite());
        let face = Face::of(ray.dir);
        let frame = Frame::new(ray.org, face);
        let [iu, iv, iz] = frame.axes;
        let d = [ray.dir[iu], ray.dir[iv], f32::from_bits(ray.dir[iz].to_bits() ^ frame.flip)];
        // Written so that NaN bounds fail.
        let tnear = if ray.tnear > 0.0 { ray.tnear } else { 0.0 };
        if !(finite && d[2] > 0.0 && tnear <= ray.tfar && !ray.tnear.is_nan()) {
            return None;
        }
        let [x, y, z] = ray.dir;
        let negative =
            [x.is_sign_negative().into(), y.is_sign_negative().into(), z.is_sign_negative().into()];
        Some(TravRay {
            org: ray.org,
            rdir: [1.0 / ray.dir[0], 1.0 / ray.dir[1], 1.0 / ray.dir[2]],
            negative,
            frame,
            d,
            shear: [d[0] / d[2], d[1] / d[2]],
            tnear,
            skip: ray.skip,
        })
    }
}

/// The best hit so far.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) t: f64,
    pub(super) prim: u32,
    slot: u32,
    /// At least `t`.
    pub(super) tfar: f32,
}

#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    near: f32,
}

impl Best {
    /// Nothing nearer than the end of the ray.
    #[inline(always)]
    pub(super) fn none(ray: &Ray) -> Best {
        Best { t: f64::from(ray.tfar), prim: MISS, slot: 0, tfar: ray.tfar }
    }

    /// The hit by the canonical formula.
    #[inline(always)]
    pub(super) fn hit(&self, bvh: &BvhView, ray: &TravRay) -> Hit {
        if self.prim == MISS {
            return Hit::MISS;
        }
        let (block, lane) = block_of(bvh, self.slot);
        let [a, b, c] = triangle(block, lane, &ray.frame);
        let [t, u, v] = Canonical::new(a, b, c).hit(wide(ray.d));
        Hit { prim: self.prim, t, u, v }
    }
}

/// The first hit.
#[inline(always)]
pub(crate) fn intersect<S: Simd>(s: S, bvh: &BvhView, ray: &Ray) -> Hit {
    let Some(trav) = TravRay::new(ray) else { return Hit::MISS };
    let mut best = Best::none(ray);
    traverse::<S, false>(s, bvh, &trav, &mut best, bvh.root);
    best.hit(bvh, &trav)
}

/// True if anything is hit.
#[inline(always)]
pub(crate) fn occluded<S: Simd>(s: S, bvh: &BvhView, ray: &Ray) -> bool {
    let Some(trav) = TravRay::new(ray) else { return false };
    let mut best = Best::none(ray);
    traverse::<S, true>(s, bvh, &trav, &mut best, bvh.root);
    best.prim != MISS
}

/// Looks for something better than `best` below `root`.
#[inline(always)]
pub(super) fn traverse<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    ray: &TravRay,
    best: &mut Best,
    root: NodeRef,
) {
    let mut stack = Stack::new();
    let mut entry = Entry { node: root, near: ray.tnear };
    loop {
        if entry.node.is_leaf() {
            leaf::<S>(s, bvh, ray, entry.node, best);
            if ANY && best.prim != MISS {
                return;
            }
        } else if entry.node != EMPTY_NODE {
            let node = &bvh.nodes[entry.node.index()];
            if children::<S, ANY>(s, node, ray, best.tfar, &mut stack, &mut entry) {
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

/// Tests a node's children; pushes all that must be visited but the nearest, which becomes `next`. False if there is
/// none.
#[inline(always)]
fn children<S: Simd, const ANY: bool>(
    s: S,
    node: &Node,
    ray: &TravRay,
    tfar: f32,
    stack: &mut Stack<Entry>,
    next: &mut Entry,
) -> bool {
    let mut near = F8::splat(s, ray.tnear);
    let mut far = F8::splat(s, tfar);
    for axis in 0..3 {
        let org = F8::splat(s, ray.org[axis]);
        let rdir = F8::splat(s, ray.rdir[axis]);
        let negative = ray.negative[axis] & 1;
        near = ((F8::load(s, &node.bounds[2 * axis + negative]) - org) * rdir).max(near);
        far = ((F8::load(s, &node.bounds[2 * axis + 1 - negative]) - org) * rdir).min(far);
    }
    // The signs of products are right, so widening by a factor suffices.
    let near = near * F8::splat(s, SHRINK);
    let mut left = near.le(far * F8::splat(s, GROW)).bits();
    if left == 0 {
        return false;
    }
    let near = near.to_array();
    let child = (left.trailing_zeros() & 7) as usize;
    left &= left - 1;
    *next = Entry { node: node.child[child], near: near[child] };
    if left == 0 {
        return true;
    }
    // Two children or more: the nearest so far is held back, the others are kept in order.
    let bottom = stack.len();
    while left != 0 {
        let child = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        let mut entry = Entry { node: node.child[child], near: near[child] };
        if !ANY && entry.near < next.near {
            std::mem::swap(&mut entry, next);
            stack.push(entry);
        } else if ANY {
            stack.push(entry);
        } else {
            let near = entry.near;
            stack.insert(bottom, entry, |above| above.near < near);
        }
    }
    true
}

/// Tests a run of triangles, lane = triangle.
#[inline(always)]
pub(super) fn leaf<S: Simd>(s: S, bvh: &BvhView, ray: &TravRay, node: NodeRef, best: &mut Best) {
    let block_index = node.block();
    let block = &bvh.blocks[block_index];
    let corners = corners(s, block, &ray.frame);
    let shear = [F8::splat(s, ray.shear[0]), F8::splat(s, ray.shear[1])];
    let far = F8::splat(s, best.tfar * ray.d[2] * GROW);
    let (maybe, sure) = sheared(s, corners, shear, far);
    let mut left = maybe & node.lanes();
    while left != 0 {
        let lane = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        consider(block, block_index, lane, sure >> lane & 1 != 0, ray, best);
    }
}

/// Which rays and triangles may meet and which meet beyond doubt, as bits; lanes pair rays with triangles in any way.
///
/// `corners` are relative to the rays' origins in their frame, where `shear` is the slope of the direction along the
/// first two axes; hits deeper than `far` along the third do not count.
///
/// Vertices are sheared along the ray onto the plane of its first two axes; there the edge functions are 2x2
/// determinants (Woop, Benthin, Wald 2013). With e = 2^-24, a sheared coordinate x is off by 3 e Mx, where Mx is at
/// least the sum of magnitudes |x| + |z| of the vertex, and a determinant of sheared coordinates up to X and Y by
/// 10 e (X My + Y Mx); the bound below is 16 e of that, and large enough where X or Y is lost in rounding.
#[inline(always)]
pub(super) fn sheared<S: Lanes<W>, const W: usize>(
    s: S,
    corners: [[F32<S, W>; 3]; 3],
    shear: [F32<S, W>; 2],
    far: F32<S, W>,
) -> (u32, u32) {
    let zero = F32::splat(s, 0.0);
    let (mut xs, mut ys) = ([zero; 3], [zero; 3]);
    let (mut most_x, mut most_y, mut size_x, mut size_y) = (zero, zero, zero, zero);
    for i in 0..3 {
        let [x, y, z] = corners[i];
        xs[i] = x - shear[0] * z;
        ys[i] = y - shear[1] * z;
        most_x = most_x.max(x.abs() + z.abs());
        most_y = most_y.max(y.abs() + z.abs());
        size_x = size_x.max(xs[i].abs());
        size_y = size_y.max(ys[i].abs());
    }
    let e0 = xs[1] * ys[2] - ys[1] * xs[2];
    let e1 = xs[2] * ys[0] - ys[2] * xs[0];
    let e2 = xs[0] * ys[1] - ys[0] * xs[1];
    let ulp = F32::splat(s, f32::EPSILON);
    let size_x = size_x + ulp * most_x;
    let size_y = size_y + ulp * most_y;
    let bound = F32::splat(s, 8.0) * ulp * (size_x * most_y + size_y * most_x) + F32::splat(s, TINY);
    let (least, most) = (e0.min(e1).min(e2), e0.max(e1).max(e2));
    let outside = least.lt(-bound) & bound.lt(most);
    let [z0, z1, z2] = [corners[0][2], corners[1][2], corners[2][2]];
    let behind = z0.max(z1).max(z2).lt(zero);
    let beyond = far.lt(z0.min(z1).min(z2));
    let maybe = !(outside | behind | beyond).bits();
    (maybe, (bound.lt(least) | most.lt(-bound)).bits())
}

/// Takes triangle `lane` of a block for the best hit if it is; `sure` if the ray passes through it beyond doubt.
#[inline(always)]
pub(super) fn consider(
    block: &TriBlock,
    block_index: usize,
    lane: usize,
    sure: bool,
    ray: &TravRay,
    best: &mut Best,
) {
    let prim = block.prim[lane];
    if prim == ray.skip {
        return;
    }
    let [a, b, c] = triangle(block, lane, &ray.frame);
    if !sure && !passes(a, b, c, ray.d) {
        return;
    }
    let t = Canonical::new(a, b, c).depth(wide(ray.d));
    // At t = tfar the interval is closed; equal depths go to the lower primitive.
    if t >= f64::from(ray.tnear) && (t < best.t || (t == best.t && prim < best.prim)) {
        *best = Best { t, prim, slot: (block_index * 8 + lane) as u32, tfar: next_up(t) };
    }
}

/// A float at least as large as `t`.
#[inline(always)]
fn next_up(t: f64) -> f32 {
    let rounded = t as f32;
    if f64::from(rounded) >= t { rounded } else { rounded.next_up() }
}
