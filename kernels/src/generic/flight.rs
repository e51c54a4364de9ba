//! Many rays that have nothing in common, a step of each in turn.
//!
//! A single ray waits most of the time: for the node that the previous one led to, for the order of its children, for
//! branches that went the other way. Here [`FLIGHT`] rays are on their way at once, and what one waits for overlaps
//! with the work of the others.
//!
//! ```text
//!   inner: rays whose next node is inner --boxes, push, pop--> inner, or
//!   leafs: rays whose next node is a leaf --triangles, pop--> inner, leafs, or
//!   done:  rays whose stack is empty --hit--> the next ray of the list
//! ```
//!
//! A step through an inner node has no branch that depends on the ray: children lie in the order that suits the ray's
//! octant ([`Node::order`]), so that compressing those that are hit onto the stack leaves the nearest on top. Entries
//! behind the best hit are removed when that changes, not when they are popped.

use super::{
    F8,
    doubt::NO_SLOT,
    single::{Best, TravRay, leaf},
};
use crate::{
    node::{BvhView, EMPTY_NODE, Node, NodeRef, STACK},
    packet::{Hit, HitBlock, Pick, Ray, RayBlock, SUB},
    simd::Simd,
    vector::I32,
    visibility::Policy,
};

/// Rays on their way at once. With more, branches at the ends of loops are mispredicted less often; with many more,
/// their stacks crowd the cache.
const FLIGHT: usize = 32;
/// Entries that may be written above the last one.
const SLACK: usize = 8;
/// Cache lines of what is visited next that are fetched ahead.
const LINES: usize = 5;
/// Covers the rounding of differences, reciprocals, products and of this factor itself, generously.
const WIDEN: f32 = 1.0 + 8.0 * f32::EPSILON;

/// First hits of the active rays of the blocks that `picks` names, by block; the others keep what was there. Returns how
/// many pairs of a ray and a triangle were decided exactly.
#[inline(always)]
pub(crate) fn intersect<S: Simd, V: Policy>(
    s: S,
    bvh: &BvhView,
    blocks: &[RayBlock],
    picks: &[Pick],
    flight: &mut Flight,
    hits: &mut [HitBlock],
) -> u64 {
    fly::<S, V, false>(s, bvh, Queue::new(blocks, picks), flight, &mut Hits(hits))
}

/// Which active rays of the blocks that `picks` names hit anything: bits like [`RayBlock::active`], by block.
/// Returns what [`intersect`] does.
#[inline(always)]
pub(crate) fn occluded<S: Simd, V: Policy>(
    s: S,
    bvh: &BvhView,
    blocks: &[RayBlock],
    picks: &[Pick],
    flight: &mut Flight,
    blocked: &mut [u16],
) -> u64 {
    fly::<S, V, true>(s, bvh, Queue::new(blocks, picks), flight, &mut Blocked(blocked))
}

/// The rays that wait to be put on their way.
struct Queue<'a> {
    blocks: &'a [RayBlock],
    picks: std::slice::Iter<'a, Pick>,
    block: usize,
    /// Of that block: bit = ray.
    left: u32,
}

impl<'a> Queue<'a> {
    #[inline(always)]
    fn new(blocks: &'a [RayBlock], picks: &'a [Pick]) -> Queue<'a> {
        Queue { blocks, picks: picks.iter(), block: 0, left: 0 }
    }

    /// The next ray and its number: block * 16 + lane.
    #[inline(always)]
    fn next(&mut self) -> Option<(usize, Ray)> {
        while self.left == 0 {
            let pick = self.picks.next()?;
            self.block = pick.block as usize;
            self.left = u32::from(pick.active & self.blocks[self.block].active);
        }
        let lane = self.left.trailing_zeros() as usize % SUB;
        self.left &= self.left - 1;
        Some((self.block * SUB + lane, self.blocks[self.block].ray(lane)))
    }
}

/// Where results go.
trait Landing {
    fn land(&mut self, bvh: &BvhView, number: usize, ray: &TravRay, best: &Best);
    fn land_invalid(&mut self, number: usize);
}

/// First hits.
struct Hits<'a>(&'a mut [HitBlock]);

impl Landing for Hits<'_> {
    #[inline(always)]
    fn land(&mut self, bvh: &BvhView, number: usize, ray: &TravRay, best: &Best) {
        self.0[number / SUB].set(number % SUB, best.hit(bvh, ray));
    }
    #[inline(always)]
    fn land_invalid(&mut self, number: usize) {
        self.0[number / SUB].set(number % SUB, Hit::MISS);
    }
}

/// Whether there is a hit.
struct Blocked<'a>(&'a mut [u16]);

impl Blocked<'_> {
    #[inline(always)]
    fn set(&mut self, number: usize, hit: bool) {
        let bits = &mut self.0[number / SUB];
        *bits = *bits & !(1 << (number % SUB)) | u16::from(hit) << (number % SUB);
    }
}

impl Landing for Blocked<'_> {
    #[inline(always)]
    fn land(&mut self, _: &BvhView, number: usize, _: &TravRay, best: &Best) {
        self.set(number, best.slot != NO_SLOT);
    }
    #[inline(always)]
    fn land_invalid(&mut self, number: usize) {
        self.set(number, false);
    }
}

/// A ray on its way.
#[derive(Clone, Debug)]
struct Flyer {
    ray: TravRay,
    /// Reciprocal directions, times [`widen`].
    far_rdir: [f32; 3],
    /// At least the ray parameter of the best hit.
    reach: f32,
    octant: usize,
    best: Best,
    /// Which ray of the [`Queue`] it is.
    number: usize,
    /// Entries on the stack.
    len: usize,
    /// What to visit: at the bottom [`EMPTY_NODE`].
    nodes: [u32; STACK + SLACK],
    /// Where the ray enters it, at least: the bits of a float.
    nears: [u32; STACK + SLACK],
}

/// Room for the rays that are on their way, to be reused from call to call.
#[derive(Clone, Debug)]
pub struct Flight {
    flyers: Vec<Flyer>,
}

impl Default for Flight {
    fn default() -> Flight {
        Flight { flyers: vec![Flyer::EMPTY; FLIGHT] }
    }
}

/// What the rays wait for, each a set: bit = flyer. Sets in registers, because a queue in memory would make each step
/// wait for the one before it.
#[derive(Default)]
struct Waiting {
    inner: u32,
    leafs: u32,
    done: u32,
}

impl Waiting {
    #[inline(always)]
    fn push(&mut self, flyer: usize, next: NodeRef) {
        let (leaf, done) = (u32::from(next.is_leaf()), u32::from(next == EMPTY_NODE));
        self.leafs |= leaf << flyer;
        self.done |= done << flyer;
        self.inner |= (1 ^ leaf ^ done) << flyer;
    }
}

/// Removes the lowest bit and returns its number.
#[inline(always)]
fn take_first(bits: &mut u32) -> usize {
    let first = bits.trailing_zeros() as usize % FLIGHT;
    *bits &= *bits - 1;
    first
}

/// Traces all rays.
#[inline(always)]
fn fly<S: Simd, V: Policy, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    mut queue: Queue,
    flight: &mut Flight,
    landing: &mut impl Landing,
) -> u64 {
    let mut doubts = 0;
    let flyers: &mut [Flyer; FLIGHT] = flight.flyers.as_mut_slice().try_into().expect("a flight is full");
    let mut waiting = Waiting::default();
    for (flyer, at) in flyers.iter_mut().enumerate() {
        if let Some(next) = at.start_next::<V>(bvh, &mut queue, landing) {
            waiting.push(flyer, next);
        }
    }
    while waiting.inner | waiting.leafs | waiting.done != 0 {
        let mut inner = std::mem::take(&mut waiting.inner);
        while inner != 0 {
            let flyer = take_first(&mut inner);
            waiting.push(flyer, flyers[flyer].inner(s, bvh));
        }
        if waiting.inner.count_ones() > (waiting.leafs | waiting.done).count_ones() {
            continue;
        }
        let mut leafs = std::mem::take(&mut waiting.leafs);
        while leafs != 0 {
            let flyer = take_first(&mut leafs);
            waiting.push(flyer, flyers[flyer].leaf::<S, V, ANY>(s, bvh));
        }
        let mut done = std::mem::take(&mut waiting.done);
        while done != 0 {
            let flyer = take_first(&mut done);
            let at = &mut flyers[flyer];
            landing.land(bvh, at.number, &at.ray, &at.best);
            doubts += u64::from(at.best.doubts);
            if let Some(next) = at.start_next::<V>(bvh, &mut queue, landing) {
                waiting.push(flyer, next);
            }
        }
    }
    doubts
}

/// [`WIDEN`], or 1 where nothing is padded.
#[inline(always)]
fn widen<V: Policy>() -> f32 {
    if V::EXACT { WIDEN } else { 1.0 }
}

impl Flyer {
    const EMPTY: Flyer = Flyer {
        ray: TravRay::NONE,
        far_rdir: [0.0; 3],
        reach: 0.0,
        octant: 0,
        best: Best { lo: 0.0, hi: 0.0, reach: 0.0, slot: NO_SLOT, doubts: 0 },
        number: 0,
        len: 0,
        nodes: [0; STACK + SLACK],
        nears: [0; STACK + SLACK],
    };

    /// Puts the next valid ray on its way, if there is one.
    #[inline(always)]
    fn start_next<V: Policy>(
        &mut self,
        bvh: &BvhView,
        queue: &mut Queue,
        landing: &mut impl Landing,
    ) -> Option<NodeRef> {
        loop {
            let (number, ray) = queue.next()?;
            match TravRay::new(&ray) {
                None => landing.land_invalid(number),
                Some(ray) => return Some(self.start::<V>(bvh, ray, number)),
            }
        }
    }

    /// Puts a ray on its way.
    #[inline(always)]
    fn start<V: Policy>(&mut self, bvh: &BvhView, ray: TravRay, number: usize) -> NodeRef {
        self.far_rdir = ray.rdir.map(|x| x * widen::<V>());
        self.octant = ray.negative[0] | ray.negative[1] << 1 | ray.negative[2] << 2;
        self.best = Best::none(&ray);
        self.reach = self.best.reach * widen::<V>();
        self.ray = ray;
        self.number = number;
        self.nodes[0] = EMPTY_NODE.raw();
        self.nodes[1] = bvh.root.raw();
        self.nears[0] = 0;
        self.nears[1] = 0;
        self.len = if bvh.root == EMPTY_NODE { 1 } else { 2 };
        self.next()
    }

    /// What to visit next.
    #[inline(always)]
    fn next(&self) -> NodeRef {
        NodeRef::from_raw(self.nodes[self.len - 1])
    }

    /// What to visit next, asked for from memory.
    #[inline(always)]
    fn fetch_next<S: Simd>(&self, s: S, bvh: &BvhView) -> NodeRef {
        let next = self.next();
        let node = bvh.nodes.as_ptr().wrapping_add(next.index()).cast::<u8>();
        let block = bvh.blocks.as_ptr().wrapping_add(next.block()).cast::<u8>();
        let at = if next.is_leaf() { block } else { node };
        let at = if next == EMPTY_NODE { bvh.nodes.as_ptr().cast() } else { at };
        s.prefetch(at.cast::<[u8; 64 * LINES]>());
        next
    }

    /// Replaces the topmost entry, an inner node, by those of its children that the ray meets.
    #[inline(always)]
    fn inner<S: Simd>(&mut self, s: S, bvh: &BvhView) -> NodeRef {
        let node: &Node = &bvh.nodes[self.next().index()];
        let ray = &self.ray;
        let mut near = F8::splat(s, ray.tnear);
        let mut far = F8::splat(s, self.reach);
        for axis in 0..3 {
            let org = F8::splat(s, ray.org[axis]);
            let negative = ray.negative[axis] & 1;
            let (near_plane, far_plane) =
                (&node.bounds[2 * axis + negative], &node.bounds[2 * axis + 1 - negative]);
            near = ((F8::load(s, near_plane) - org) * F8::splat(s, ray.rdir[axis])).max(near);
            far = ((F8::load(s, far_plane) - org) * F8::splat(s, self.far_rdir[axis])).min(far);
        }
        let order =
            I32::splat(s, node.order[self.octant & 7]).shr_by(I32::load(s, &[0, 3, 6, 9, 12, 15, 18, 21]));
        let (near, far) = (near.bits().permute(order).floats(), far.bits().permute(order).floats());
        let hit = near.le(far).bits();
        let children = I32::load(s, &node.child.map(NodeRef::raw)).permute(order);
        let at = self.len - 1;
        let top: &mut [u32; 8] = (&mut self.nodes[at..at + 8]).try_into().expect("eight lanes");
        children.compress(hit, top);
        let top: &mut [u32; 8] = (&mut self.nears[at..at + 8]).try_into().expect("eight lanes");
        near.bits().compress(hit, top);
        self.len = at + hit.count_ones() as usize;
        self.fetch_next(s, bvh)
    }

    /// Tests the triangles of the topmost entry, a leaf, and removes it.
    #[inline(always)]
    fn leaf<S: Simd, V: Policy, const ANY: bool>(&mut self, s: S, bvh: &BvhView) -> NodeRef {
        let before = self.best.slot;
        leaf::<S, V>(s, bvh, &self.ray, self.next(), &mut self.best);
        self.len -= 1;
        if self.best.slot != before {
            if ANY {
                self.len = 1;
            } else {
                self.shorten::<S, V>(s);
            }
        }
        self.fetch_next(s, bvh)
    }

    /// Removes what lies behind the best hit.
    #[inline(always)]
    fn shorten<S: Simd, V: Policy>(&mut self, s: S) {
        self.reach = self.best.reach * widen::<V>();
        let reach = F8::splat(s, self.reach);
        let (mut from, mut to) = (1, 1);
        while from < self.len {
            let nodes: &[u32; 8] = self.nodes[from..from + 8].try_into().expect("eight lanes");
            let nears: &[u32; 8] = self.nears[from..from + 8].try_into().expect("eight lanes");
            let (nodes, nears) = (I32::load(s, nodes), I32::load(s, nears));
            let left = (self.len - from).min(8);
            let keep = nears.floats().le(reach).bits() & ((1 << left) - 1);
            let top: &mut [u32; 8] = (&mut self.nodes[to..to + 8]).try_into().expect("eight lanes");
            nodes.compress(keep, top);
            let top: &mut [u32; 8] = (&mut self.nears[to..to + 8]).try_into().expect("eight lanes");
            nears.compress(keep, top);
            from += 8;
            to += keep.count_ones() as usize;
        }
        self.len = to;
    }
}
