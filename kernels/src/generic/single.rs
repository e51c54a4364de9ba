//! One ray over the 8-wide tree, for rays that have nothing in common with others.
//!
//! Boxes: near and far planes are loaded by the ray's octant (Embree's scheme), subtract first, then multiply by the
//! reciprocal; the interval is widened by the rounding of two operations, so that no true hit's box is rejected
//! (Ize 2013). Where 0 * infinity gives NaN, the axis does not restrict: `max` and `min` return their second operand.
//!
//! Triangles: lane = triangle, sheared along the ray; hits too close to call are ordered by their canonical depth.

use super::{
    F8, Frame,
    doubt::{NO_SLOT, block_of, nearer},
    leaf::{corners, triangle},
    shear::sheared,
    stack::Stack,
};
use crate::{
    exact::{Canonical, wide},
    node::{BvhView, EMPTY_NODE, Node, NodeRef},
    packet::{Face, Hit, MISS, Ray},
    simd::Simd,
    visibility::Policy,
};

/// Rounding of a reciprocal, a product, and this factor itself, generously.
pub(super) const SHRINK: f32 = 1.0 - 4.0 * f32::EPSILON;
pub(super) const GROW: f32 = 1.0 + 4.0 * f32::EPSILON;

/// A ray prepared for traversal.
#[derive(Clone, Copy, Debug)]
pub(super) struct TravRay {
    pub(super) org: [f32; 3],
    pub(super) rdir: [f32; 3],
    /// 0 where the direction's component is positive, 1 where it is negative.
    pub(super) negative: [usize; 3],
    pub(super) frame: Frame,
    /// Direction in the frame: the last component is the largest and positive.
    pub(super) d: [f32; 3],
    /// The first two components divided by the last, rounded.
    pub(super) slopes: [f32; 2],
    /// 1 / the last component, rounded.
    pub(super) scale: f32,
    pub(super) tnear: f32,
    pub(super) tfar: f32,
    pub(super) skip: u32,
}

impl TravRay {
    /// Hits nothing.
    pub(super) const NONE: TravRay = TravRay {
        org: [0.0; 3],
        rdir: [0.0; 3],
        negative: [0; 3],
        frame: Frame { org: [0.0; 3], axes: [0, 1, 2], flip: 0 },
        d: [0.0; 3],
        slopes: [0.0; 2],
        scale: 0.0,
        tnear: 0.0,
        tfar: -1.0,
        skip: MISS,
    };

    /// `None` for a ray that hits nothing by definition. Without branches or copies of the ray, which would wait for
    /// each other.
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Option<TravRay> {
        const MAGNITUDE: u32 = 0x7fff_ffff;
        let (org, dir) = (&ray.org, &ray.dir);
        // Magnitudes compare like their bits; those of NaN and infinity are the greatest.
        let [x, y, z] = [0, 1, 2].map(|axis| dir[axis].to_bits() & MAGNITUDE);
        let [ox, oy, oz] = [0, 1, 2].map(|axis| org[axis].to_bits() & MAGNITUDE);
        let most = x.max(y).max(z);
        let finite = most.max(ox).max(oy).max(oz) < f32::INFINITY.to_bits();
        // As `Face::of`.
        let axis = if x == most { 0 } else { 1 + usize::from(y < z) };
        let [iu, iv, iz] = Face { axis, negative: false }.axes();
        let flip = dir[iz].to_bits() & !MAGNITUDE;
        let frame = Frame { org: [org[iu], org[iv], org[iz]], axes: [iu, iv, iz], flip };
        let d = [dir[iu], dir[iv], f32::from_bits(most)];
        // Written so that NaN fails.
        let tnear = if ray.tnear > 0.0 { ray.tnear } else { 0.0 };
        if !(finite & (most != 0) & (tnear <= ray.tfar) & !ray.tnear.is_nan()) {
            return None;
        }
        let scale = 1.0 / d[2];
        Some(TravRay {
            org: *org,
            rdir: [1.0 / dir[0], 1.0 / dir[1], 1.0 / dir[2]],
            negative: [0, 1, 2].map(|axis| (dir[axis].to_bits() >> 31) as usize),
            frame,
            d,
            slopes: [d[0] / d[2], d[1] / d[2]],
            scale,
            tnear,
            tfar: ray.tfar,
            skip: ray.skip,
        })
    }
}

/// The best hit so far: depths along the third axis of the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    /// Encloses the depth.
    pub(super) lo: f32,
    pub(super) hi: f32,
    /// At least the ray parameter.
    pub(super) reach: f32,
    /// [`NO_SLOT`] for none.
    pub(super) slot: u32,
    /// Triangles that were decided exactly so far.
    pub(super) doubts: u32,
}

impl Best {
    /// Nothing nearer than the end of the ray.
    #[inline(always)]
    pub(super) fn none(ray: &TravRay) -> Best {
        let far = ray.tfar * ray.d[2];
        Best { lo: far * SHRINK, hi: far * GROW, reach: ray.tfar, slot: NO_SLOT, doubts: 0 }
    }

    #[inline(always)]
    fn set(&mut self, lo: f32, hi: f32, slot: u32, ray: &TravRay) {
        let reach = hi * ray.scale * GROW;
        // Zero times infinity: depth 0 along a direction whose reciprocal overflows.
        self.reach = if reach.is_nan() { ray.tfar } else { reach };
        (self.lo, self.hi, self.slot) = (lo, hi, slot);
    }

    /// The hit by the canonical formula.
    #[inline(always)]
    pub(super) fn hit(&self, bvh: &BvhView, ray: &TravRay) -> Hit {
        if self.slot == NO_SLOT {
            return Hit::MISS;
        }
        let (block, lane) = block_of(bvh, self.slot);
        let [a, b, c] = triangle(block, lane, &ray.frame);
        let [t, u, v] = Canonical::new(a, b, c).hit(wide(ray.d));
        Hit { prim: block.prim[lane], t, u, v }
    }
}

/// The first hit. Triangles that are decided exactly are added to `doubts`.
#[inline(always)]
pub(crate) fn intersect<S: Simd, V: Policy>(s: S, bvh: &BvhView, ray: &Ray, doubts: &mut u64) -> Hit {
    let Some(ray) = TravRay::new(ray) else { return Hit::MISS };
    let mut best = Best::none(&ray);
    traverse::<S, V, false>(s, bvh, &ray, &mut best, bvh.root);
    *doubts += u64::from(best.doubts);
    best.hit(bvh, &ray)
}

/// True if anything is hit; otherwise as [`intersect`].
#[inline(always)]
pub(crate) fn occluded<S: Simd, V: Policy>(s: S, bvh: &BvhView, ray: &Ray, doubts: &mut u64) -> bool {
    let Some(ray) = TravRay::new(ray) else { return false };
    let mut best = Best::none(&ray);
    traverse::<S, V, true>(s, bvh, &ray, &mut best, bvh.root);
    *doubts += u64::from(best.doubts);
    best.slot != NO_SLOT
}

#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    near: f32,
}

/// Looks for something better than `best` below `root`.
#[inline(always)]
pub(super) fn traverse<S: Simd, V: Policy, const ANY: bool>(
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
            leaf::<S, V>(s, bvh, ray, entry.node, best);
            if ANY && best.slot != NO_SLOT {
                return;
            }
        } else if entry.node != EMPTY_NODE {
            let node = &bvh.nodes[entry.node.index()];
            if children::<S, V, ANY>(s, node, ray, best.reach, &mut stack, &mut entry) {
                continue;
            }
        }
        loop {
            match stack.pop() {
                None => return,
                Some(next) => entry = next,
            }
            if ANY || entry.near <= best.reach {
                break;
            }
        }
    }
}

/// Where the ray enters and leaves a node's children between two parameters, lane = child; rounding is still to be
/// allowed for.
#[inline(always)]
pub(super) fn slabs<S: Simd>(s: S, node: &Node, ray: &TravRay, [lower, upper]: [f32; 2]) -> [F8<S>; 2] {
    let mut near = F8::splat(s, lower);
    let mut far = F8::splat(s, upper);
    for axis in 0..3 {
        let org = F8::splat(s, ray.org[axis]);
        let rdir = F8::splat(s, ray.rdir[axis]);
        let negative = ray.negative[axis] & 1;
        near = ((F8::load(s, &node.bounds[2 * axis + negative]) - org) * rdir).max(near);
        far = ((F8::load(s, &node.bounds[2 * axis + 1 - negative]) - org) * rdir).min(far);
    }
    [near, far]
}

/// Tests a node's children; pushes all that must be visited but the nearest, which becomes `next`. False if there is
/// none.
#[inline(always)]
fn children<S: Simd, V: Policy, const ANY: bool>(
    s: S,
    node: &Node,
    ray: &TravRay,
    tfar: f32,
    stack: &mut Stack<Entry>,
    next: &mut Entry,
) -> bool {
    let [mut near, mut far] = slabs(s, node, ray, [ray.tnear, tfar]);
    if V::EXACT {
        // The signs of products are right, so widening by a factor suffices.
        near = near * F8::splat(s, SHRINK);
        far = far * F8::splat(s, GROW);
    }
    let mut left = near.le(far).bits();
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
pub(super) fn leaf<S: Simd, V: Policy>(s: S, bvh: &BvhView, ray: &TravRay, node: NodeRef, best: &mut Best) {
    let block_index = node.block();
    let block = &bvh.blocks[block_index];
    let corners = corners(s, block, &ray.frame);
    let slopes = [F8::splat(s, ray.slopes[0]), F8::splat(s, ray.slopes[1])];
    let tests = sheared::<S, V, 8>(s, &corners, slopes, F8::splat(s, best.hi));
    let mut left = tests.maybe & node.lanes();
    if left == 0 {
        return;
    }
    let [lo, hi] = tests.depths::<V>(s, &corners);
    let (lo, hi) = (lo.to_array(), hi.to_array());
    while left != 0 {
        let lane = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        if block.prim[lane] != ray.skip {
            let sure = tests.sure >> lane & 1 != 0;
            let slot = (block_index * 8 + lane) as u32;
            consider::<V>(bvh, slot, sure.then_some((lo[lane], hi[lane])), ray, best);
        }
    }
}

/// Takes a triangle for the best hit if it is; `depth` encloses its depth if the ray passes through it beyond doubt.
#[inline(always)]
pub(super) fn consider<V: Policy>(
    bvh: &BvhView,
    slot: u32,
    depth: Option<(f32, f32)>,
    ray: &TravRay,
    best: &mut Best,
) {
    if let Some((lo, hi)) = depth {
        // The second case is common: the surface that a ray has just left lies across the line behind it.
        if lo > best.hi || hi < ray.tnear * ray.d[2] * SHRINK {
            return;
        }
        if hi < best.lo && lo > ray.tnear * ray.d[2] * GROW {
            best.set(lo, hi, slot, ray);
            return;
        }
    }
    if V::EXACT {
        *best = settle(bvh, slot, ray, *best);
    }
}

/// The better one of the best hit so far and a triangle, decided exactly.
#[cold]
#[inline(never)]
fn settle(bvh: &BvhView, slot: u32, ray: &TravRay, mut best: Best) -> Best {
    best.doubts += 1;
    if let Some(t) = nearer(bvh, &ray.frame, ray.d, [ray.tnear, ray.tfar], slot, best.slot) {
        let depth = t * f64::from(ray.d[2]);
        let (lo, hi) = ((depth * (1.0 - 5.0e-7)) as f32, (depth * (1.0 + 5.0e-7)) as f32);
        best.set(lo, hi, slot, ray);
    }
    best
}
