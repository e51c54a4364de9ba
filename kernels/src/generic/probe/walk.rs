//! The walk of the probe kernel: one loop, three ways to search.

use super::{Candidate, Counter, blocks};
use crate::{
    generic::{
        F8,
        leaf::corners,
        shear::sheared,
        single::{self, Best, GROW, SHRINK, TravRay, slabs},
        stack::Stack,
    },
    node::{BvhView, EMPTY_NODE, Node, NodeRef},
    simd::Simd,
    visibility::Exact,
};

/// In which order children are visited.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    /// As they stand: all are visited anyway.
    Slot,
    /// Where the ray enters them first.
    Entry,
    /// Where the ray leaves them last: first from the surface, for a ray that ends there.
    Exit,
}

/// A way to search.
pub(super) trait Visit {
    const ORDER: By;
    /// Nothing beyond this ray parameter matters.
    fn reach(&self) -> f32;
    /// Tests a run of triangles; true if the search is over.
    fn leaf<S: Simd>(&mut self, s: S, bvh: &BvhView, ray: &TravRay, node: NodeRef) -> bool;
}

/// Lists every triangle on the ray.
pub(super) struct All<'a> {
    pub(super) list: &'a mut Vec<Candidate>,
    pub(super) tfar: f32,
}

/// Keeps the nearest hit.
pub(super) struct Nearest<'a> {
    pub(super) best: &'a mut Best,
}

/// Takes the first occluder that it comes upon, from the surface: where the ray starts, if `ENTRY`, or ends.
pub(super) struct First<const ENTRY: bool> {
    pub(super) slot: u32,
    pub(super) tfar: f32,
}

impl Visit for All<'_> {
    const ORDER: By = By::Slot;

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.tfar
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, s: S, bvh: &BvhView, ray: &TravRay, node: NodeRef) -> bool {
        let mut met = Met::new(s, bvh, ray, node);
        while let Some(candidate) = met.next(bvh, ray) {
            self.list.push(candidate);
        }
        false
    }
}

impl Visit for Nearest<'_> {
    const ORDER: By = By::Entry;

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.best.reach
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, s: S, bvh: &BvhView, ray: &TravRay, node: NodeRef) -> bool {
        single::leaf::<S, Exact>(s, bvh, ray, node, self.best);
        false
    }
}

impl<const ENTRY: bool> Visit for First<ENTRY> {
    const ORDER: By = if ENTRY { By::Entry } else { By::Exit };

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.tfar
    }

    #[inline(always)]
    fn leaf<S: Simd>(&mut self, s: S, bvh: &BvhView, ray: &TravRay, node: NodeRef) -> bool {
        let mut met = Met::new(s, bvh, ray, node);
        while let Some(Candidate { slot, depth }) = met.next(bvh, ray) {
            if blocks(bvh, ray, slot, depth).is_some() {
                self.slot = slot;
                return true;
            }
        }
        false
    }
}

/// The triangles of a leaf that a ray passes through, or nearly so, not beyond its end.
struct Met {
    block: usize,
    left: u32,
    sure: u32,
    lo: [f32; 8],
    hi: [f32; 8],
}

impl Met {
    #[inline(always)]
    fn new<S: Simd>(s: S, bvh: &BvhView, ray: &TravRay, node: NodeRef) -> Met {
        let block = node.block();
        let corners = corners(s, &bvh.blocks[block], &ray.frame);
        let slopes = [F8::splat(s, ray.slopes[0]), F8::splat(s, ray.slopes[1])];
        let tests = sheared::<S, Exact, 8>(s, &corners, slopes, F8::splat(s, ray.tfar * ray.d[2] * GROW));
        let left = tests.maybe & node.lanes();
        let (mut lo, mut hi) = ([0.0; 8], [0.0; 8]);
        if left != 0 {
            let depths = tests.depths::<Exact>(s, &corners);
            (lo, hi) = (depths[0].to_array(), depths[1].to_array());
        }
        Met { block, left, sure: tests.sure, lo, hi }
    }

    #[inline(always)]
    fn next(&mut self, bvh: &BvhView, ray: &TravRay) -> Option<Candidate> {
        while self.left != 0 {
            let lane = (self.left.trailing_zeros() & 7) as usize;
            self.left &= self.left - 1;
            if bvh.blocks[self.block].prim[lane] != ray.skip {
                let depth = (self.sure >> lane & 1 != 0).then_some((self.lo[lane], self.hi[lane]));
                return Some(Candidate { slot: (self.block * 8 + lane) as u32, depth });
            }
        }
        None
    }
}

#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    /// Lesser keys are visited first.
    key: f32,
}

/// Walks the tree along the ray from parameter `lower`.
#[inline(always)]
pub(super) fn traverse<S: Simd, V: Visit, C: Counter>(
    s: S,
    bvh: &BvhView,
    ray: &TravRay,
    lower: f32,
    visit: &mut V,
    counter: &mut C,
) {
    if bvh.root == EMPTY_NODE {
        return;
    }
    let mut stack = Stack::new();
    stack.push(Entry { node: bvh.root, key: f32::NEG_INFINITY });
    while let Some(Entry { node, key }) = stack.pop() {
        // Something nearer was found since it was pushed.
        if V::ORDER == By::Entry && key > visit.reach() {
            continue;
        }
        counter.step();
        if node.is_leaf() {
            counter.triangles(node.lanes().count_ones());
            if visit.leaf(s, bvh, ray, node) {
                return;
            }
        } else {
            let node = &bvh.nodes[node.index()];
            if C::COUNTS {
                let present = F8::load(s, &node.bounds[0]).le(F8::load(s, &node.bounds[1]));
                counter.boxes(present.bits().count_ones());
            }
            children::<S, V>(s, node, ray, [lower, visit.reach()], &mut stack);
        }
    }
}

/// Pushes the children that the ray meets within a range of parameters, the first to be visited last.
#[inline(always)]
fn children<S: Simd, V: Visit>(s: S, node: &Node, ray: &TravRay, range: [f32; 2], stack: &mut Stack<Entry>) {
    let [near, far] = slabs(s, node, ray, range);
    let near = near * F8::splat(s, SHRINK);
    let mut left = near.le(far * F8::splat(s, GROW)).bits();
    let keys = match V::ORDER {
        By::Exit => (-far).to_array(),
        By::Entry | By::Slot => near.to_array(),
    };
    let bottom = stack.len();
    while left != 0 {
        let child = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        let entry = Entry { node: node.child[child], key: keys[child] };
        if entry.node == EMPTY_NODE {
            continue;
        }
        if V::ORDER == By::Slot {
            stack.push(entry);
        } else {
            stack.insert(bottom, entry, |above| above.key < entry.key);
        }
    }
}
