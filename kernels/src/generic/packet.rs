//! Sixteen rays that fly about the same way: one walk through the tree for all.
//!
//! ```text
//!   node --(lane = child)--> children that the rays' interval may touch
//!     each --(lane = ray)--> rays that touch it
//!       many: go on together    few: one ray at a time    leaf: rays x triangles, whichever is wider in lanes
//! ```
//!
//! The interval encloses all origins and all reciprocal directions (interval culling as in Boulos 2006). Rays of a
//! packet share face and signs, their *class*; those that do not belong to the class of the first are traced alone.

use super::{
    F8, F16, Frame,
    doubt::NO_SLOT,
    shear::sheared,
    single,
    single::{Best, GROW, SHRINK, TravRay},
    stack::Stack,
};
use crate::{
    node::{BvhView, EMPTY_NODE, Node, NodeRef},
    packet::{Face, Hit, MISS, PACKET_RAYS, Ray},
    simd::Simd,
    vector::{I32, Mask},
};

/// With so few rays left in a subtree they go on one by one (measured: see `benches/LOG.md`).
const FEW_IN_TREE: u32 = 6;
/// In a leaf, testing eight triangles at once for so few rays beats testing sixteen rays for each triangle.
const FEW_IN_LEAF: u32 = 5;

/// A subtree that some rays still have to visit.
#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    rays: u32,
    /// At most the depth of its box along any ray.
    near: f32,
}

/// What is known of the rays, in the order of lanes.
#[repr(C, align(64))]
struct State {
    org: [[f32; 16]; 3],
    dir: [[f32; 16]; 3],
    rdir: [[f32; 16]; 3],
    slopes: [[f32; 16]; 2],
    /// 1 / the greatest component of the direction.
    scale: [f32; 16],
    tnear: [f32; 16],
    tfar: [f32; 16],
    skip: [u32; 16],
    /// Least depth that counts, rounded up: along the dominant axis, like `lo` and `hi`.
    start: [f32; 16],
    /// The best hits so far, as in [`Best`]; below any depth for lanes that take no part.
    lo: [f32; 16],
    hi: [f32; 16],
    slot: [u32; 16],
    /// At least the ray parameter of the best hit.
    reach: [f32; 16],
    interval: Interval,
    /// Greatest `reach` of the packet.
    packet_reach: f32,
    /// Least `tnear` of the packet.
    packet_start: f32,
}

/// Encloses origins and reciprocal directions, by axis, arranged by what bounds near and far planes.
#[derive(Clone, Copy)]
struct Interval {
    negative: [bool; 3],
    /// The origin farthest along the direction, and the one least far.
    ahead: [f32; 3],
    behind: [f32; 3],
    /// The reciprocals of least and greatest magnitude.
    small: [f32; 3],
    large: [f32; 3],
    /// Common to all rays, but for the origin.
    frame: Frame,
}

/// First hits of up to sixteen rays; the rest of `hits` is left as it is.
#[inline(always)]
pub(crate) fn intersect<S: Simd>(s: S, bvh: &BvhView, rays: &[Ray], hits: &mut [Hit]) {
    let (mut state, together) = State::new(s, rays);
    if together != 0 {
        traverse::<S, false>(s, bvh, &mut state, together);
    }
    for (lane, (ray, hit)) in rays.iter().zip(hits).enumerate().take(PACKET_RAYS) {
        *hit = if together >> lane & 1 != 0 {
            state.best(lane).hit(bvh, &state.ray(lane))
        } else {
            single::intersect(s, bvh, ray)
        };
    }
}

/// Which of up to sixteen rays hit anything, bit = ray.
#[inline(always)]
pub(crate) fn occluded<S: Simd>(s: S, bvh: &BvhView, rays: &[Ray]) -> u32 {
    let (mut state, together) = State::new(s, rays);
    if together != 0 {
        traverse::<S, true>(s, bvh, &mut state, together);
    }
    let mut blocked = 0;
    for (lane, ray) in rays.iter().enumerate().take(PACKET_RAYS) {
        let hit = if together >> lane & 1 != 0 {
            state.slot[lane] != NO_SLOT
        } else {
            single::occluded(s, bvh, ray)
        };
        blocked |= u32::from(hit) << lane;
    }
    blocked
}

impl State {
    /// The rays that can be traced together, as bits, and what is known of them.
    #[inline(always)]
    fn new<S: Simd>(s: S, rays: &[Ray]) -> (State, u32) {
        let mut state = State {
            org: [[0.0; 16]; 3],
            dir: [[0.0; 16]; 3],
            rdir: [[0.0; 16]; 3],
            slopes: [[0.0; 16]; 2],
            scale: [0.0; 16],
            tnear: [0.0; 16],
            tfar: [-1.0; 16],
            skip: [MISS; 16],
            start: [0.0; 16],
            lo: [-1.0; 16],
            hi: [-1.0; 16],
            slot: [NO_SLOT; 16],
            reach: [-1.0; 16],
            interval: Interval::NOTHING,
            packet_reach: -1.0,
            packet_start: 0.0,
        };
        for (lane, ray) in rays.iter().enumerate().take(PACKET_RAYS) {
            for axis in 0..3 {
                state.org[axis][lane] = ray.org[axis];
                state.dir[axis][lane] = ray.dir[axis];
            }
            state.tnear[lane] = ray.tnear;
            state.tfar[lane] = ray.tfar;
            state.skip[lane] = ray.skip;
        }
        let together = state.prepare(s, rays);
        (state, together)
    }

    /// Works out everything that follows from the rays; returns those that can be traced together.
    #[inline(always)]
    fn prepare<S: Simd>(&mut self, s: S, rays: &[Ray]) -> u32 {
        let valid = self.valid(s);
        if valid == 0 {
            return 0;
        }
        let first = rays[valid.trailing_zeros() as usize];
        let [x, y, z] = first.dir;
        let face = Face::of(first.dir);
        let [iu, iv, iz] = face.axes();
        let together = valid & self.of_class(s, first.dir, face);
        let mask = Mask::from_bits(s, together);
        let (zero, one) = (F16::splat(s, 0.0), F16::splat(s, 1.0));
        for axis in 0..3 {
            (one / F16::load(s, &self.dir[axis])).store(&mut self.rdir[axis]);
        }
        let dz = F16::load(s, &self.dir[iz]).abs();
        (one / dz).store(&mut self.scale);
        (F16::load(s, &self.dir[iu]) / dz).store(&mut self.slopes[0]);
        (F16::load(s, &self.dir[iv]) / dz).store(&mut self.slopes[1]);
        let tnear = zero.max(F16::load(s, &self.tnear));
        tnear.store(&mut self.tnear);
        (tnear * dz * F16::splat(s, GROW)).store(&mut self.start);
        let nowhere = F16::splat(s, -1.0);
        let far = F16::load(s, &self.tfar) * dz;
        mask.select(far * F16::splat(s, SHRINK), nowhere).store(&mut self.lo);
        mask.select(far * F16::splat(s, GROW), nowhere).store(&mut self.hi);

        self.interval.negative = [x.is_sign_negative(), y.is_sign_negative(), z.is_sign_negative()];
        self.interval.frame = Frame::new([0.0; 3], face);
        self.interval.enclose(s, &self.org, &self.rdir, mask);
        self.packet_start = mask.select(tnear, F16::splat(s, f32::INFINITY)).reduce_min();
        self.pull_in(s);
        together
    }

    /// Rays that do not miss by definition: the rule of [`TravRay::new`].
    #[inline(always)]
    fn valid<S: Simd>(&self, s: S) -> u32 {
        let zero = F16::splat(s, 0.0);
        let infinity = F16::splat(s, f32::INFINITY);
        let tnear = F16::load(s, &self.tnear);
        // NaN fails every comparison.
        let mut valid = tnear.le(tnear) & zero.max(tnear).le(F16::load(s, &self.tfar));
        let mut greatest = zero;
        for axis in 0..3 {
            let size = F16::load(s, &self.dir[axis]).abs();
            valid = valid & F16::load(s, &self.org[axis]).abs().lt(infinity) & size.lt(infinity);
            greatest = greatest.max(size);
        }
        (valid & zero.lt(greatest)).bits()
    }

    /// Rays with the dominant axis and the signs of `dir`, whose face is `face`.
    #[inline(always)]
    fn of_class<S: Simd>(&self, s: S, dir: [f32; 3], face: Face) -> u32 {
        let size = [0, 1, 2].map(|axis: usize| &self.dir[axis]);
        let (x, y, z) = (F16::load(s, size[0]), F16::load(s, size[1]), F16::load(s, size[2]));
        let signs = [(x, dir[0]), (y, dir[1]), (z, dir[2])];
        let (x, y, z) = (x.abs(), y.abs(), z.abs());
        // The rule of `Face::of`: the first axis of greatest magnitude.
        let is_x = (y.le(x) & z.le(x)).bits();
        let is_y = !is_x & z.le(y).bits();
        let mut class = [is_x, is_y, !is_x & !is_y][face.axis];
        for (component, like) in signs {
            let negative = component.sign().eq(I32::splat(s, 0x8000_0000)).bits();
            class &= if like.is_sign_negative() { negative } else { !negative };
        }
        class
    }

    /// One ray, for what is done ray by ray.
    #[inline(always)]
    fn ray(&self, lane: usize) -> TravRay {
        let org = [self.org[0][lane], self.org[1][lane], self.org[2][lane]];
        let [iu, iv, iz] = self.interval.frame.axes;
        TravRay {
            org,
            rdir: [self.rdir[0][lane], self.rdir[1][lane], self.rdir[2][lane]],
            negative: self.interval.negative.map(usize::from),
            frame: Frame { org: [org[iu], org[iv], org[iz]], ..self.interval.frame },
            d: [self.dir[iu][lane], self.dir[iv][lane], self.dir[iz][lane].abs()],
            slopes: [self.slopes[0][lane], self.slopes[1][lane]],
            scale: self.scale[lane],
            tnear: self.tnear[lane],
            tfar: self.tfar[lane],
            skip: self.skip[lane],
        }
    }

    /// The best hit of one ray.
    #[inline(always)]
    fn best(&self, lane: usize) -> Best {
        Best { lo: self.lo[lane], hi: self.hi[lane], reach: self.reach[lane], slot: self.slot[lane] }
    }

    /// Takes over what a ray has found alone.
    #[inline(always)]
    fn found(&mut self, lane: usize, best: Best) {
        (self.lo[lane], self.hi[lane], self.slot[lane]) = (best.lo, best.hi, best.slot);
    }

    /// Rays of `rays` for which something at depth `near` would count.
    #[inline(always)]
    fn interested<S: Simd>(&self, s: S, near: f32, rays: u32) -> u32 {
        F16::splat(s, near).le(F16::load(s, &self.reach)).bits() & rays
    }
}

impl Interval {
    const NOTHING: Interval = Interval {
        negative: [false; 3],
        ahead: [0.0; 3],
        behind: [0.0; 3],
        small: [0.0; 3],
        large: [0.0; 3],
        frame: Frame { org: [0.0; 3], axes: [1, 2, 0], flip: 0 },
    };

    /// Encloses the rays of `mask`, whose signs are known.
    #[inline(always)]
    fn enclose<S: Simd>(&mut self, s: S, org: &[[f32; 16]; 3], rdir: &[[f32; 16]; 3], mask: Mask<S, 16>) {
        let infinity = F16::splat(s, f32::INFINITY);
        for axis in 0..3 {
            let o = F16::load(s, &org[axis]);
            let least = mask.select(o, infinity).reduce_min();
            let most = mask.select(o, -infinity).reduce_max();
            let r = F16::load(s, &rdir[axis]).abs();
            let small = mask.select(r, infinity).reduce_min();
            let large = mask.select(r, F16::splat(s, 0.0)).reduce_max();
            let negative = self.negative[axis];
            (self.ahead[axis], self.behind[axis]) = if negative { (least, most) } else { (most, least) };
            (self.small[axis], self.large[axis]) = if negative { (-small, -large) } else { (small, large) };
        }
    }
}

#[inline(always)]
fn traverse<S: Simd, const ANY: bool>(s: S, bvh: &BvhView, state: &mut State, together: u32) {
    if bvh.root == EMPTY_NODE {
        return;
    }
    let mut live = together;
    let mut stack = Stack::new();
    let mut entry = Entry { node: bvh.root, rays: together, near: 0.0 };
    loop {
        if entry.node.is_leaf() {
            leaf::<S, ANY>(s, bvh, state, entry.node, entry.rays, &mut live);
            if ANY && live == 0 {
                return;
            }
        } else if entry.rays.count_ones() <= FEW_IN_TREE {
            alone::<S, ANY>(s, bvh, state, entry, &mut live);
            if ANY && live == 0 {
                return;
            }
        } else if children(s, &bvh.nodes[entry.node.index()], state, &mut stack, &mut entry) {
            continue;
        }
        loop {
            match stack.pop() {
                None => return,
                Some(next) => entry = next,
            }
            entry.rays = state.interested(s, entry.near, entry.rays & live);
            if entry.rays != 0 {
                break;
            }
        }
    }
}

/// A few rays go on through a subtree one by one.
#[inline(always)]
fn alone<S: Simd, const ANY: bool>(s: S, bvh: &BvhView, state: &mut State, entry: Entry, live: &mut u32) {
    let mut left = entry.rays;
    while left != 0 {
        let lane = (left.trailing_zeros() & 15) as usize;
        left &= left - 1;
        let mut best = state.best(lane);
        single::traverse::<S, ANY>(s, bvh, &state.ray(lane), &mut best, entry.node);
        state.found(lane, best);
    }
    state.settle::<S, ANY>(s, live);
}

/// Tests a node's children; pushes all that a ray must visit but the nearest, which becomes `next`. False if there is
/// none.
#[inline(always)]
fn children<S: Simd>(s: S, node: &Node, state: &State, stack: &mut Stack<Entry>, next: &mut Entry) -> bool {
    let interval = &state.interval;
    let mut near = F8::splat(s, state.packet_start);
    let mut far = F8::splat(s, state.packet_reach);
    for axis in 0..3 {
        let negative = usize::from(interval.negative[axis]);
        let (small, large) = (F8::splat(s, interval.small[axis]), F8::splat(s, interval.large[axis]));
        let n = F8::load(s, &node.bounds[2 * axis + negative]) - F8::splat(s, interval.ahead[axis]);
        let f = F8::load(s, &node.bounds[2 * axis + 1 - negative]) - F8::splat(s, interval.behind[axis]);
        // 0 * infinity, which only `large` can give, leaves the axis out: min and max return their second operand.
        near = (n * small).min(n * large).max(near);
        far = (f * small).max(f * large).min(far);
    }
    let near = near * F8::splat(s, SHRINK);
    let mut left = near.le(far * F8::splat(s, GROW)).bits();
    let near = near.to_array();
    let rays = next.rays;
    let bottom = stack.len();
    while left != 0 {
        let child = (left.trailing_zeros() & 7) as usize;
        left &= left - 1;
        let touching = ray_test(s, node, child, state) & rays;
        if touching != 0 {
            let near = near[child];
            stack.insert(bottom, Entry { node: node.child[child], rays: touching, near }, |e| e.near < near);
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

/// Which rays touch one child, lane = ray.
#[inline(always)]
fn ray_test<S: Simd>(s: S, node: &Node, child: usize, state: &State) -> u32 {
    let mut near = F16::load(s, &state.tnear);
    let mut far = F16::load(s, &state.reach);
    for axis in 0..3 {
        let negative = usize::from(state.interval.negative[axis]);
        let org = F16::load(s, &state.org[axis]);
        let rdir = F16::load(s, &state.rdir[axis]);
        near = ((F16::splat(s, node.bounds[2 * axis + negative][child]) - org) * rdir).max(near);
        far = ((F16::splat(s, node.bounds[2 * axis + 1 - negative][child]) - org) * rdir).min(far);
    }
    (near * F16::splat(s, SHRINK)).le(far * F16::splat(s, GROW)).bits()
}

/// Tests a run of triangles.
#[inline(always)]
fn leaf<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    state: &mut State,
    node: NodeRef,
    rays: u32,
    live: &mut u32,
) {
    if rays.count_ones() <= FEW_IN_LEAF {
        let mut left = rays;
        while left != 0 {
            let lane = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            let mut best = state.best(lane);
            single::leaf(s, bvh, &state.ray(lane), node, &mut best);
            state.found(lane, best);
        }
    } else {
        let mut triangles = node.lanes();
        while triangles != 0 {
            let triangle = (triangles.trailing_zeros() & 7) as usize;
            triangles &= triangles - 1;
            triangle_test(s, bvh, state, node, triangle, rays);
        }
    }
    state.settle::<S, ANY>(s, live);
}

/// Tests one triangle, lane = ray.
#[inline(always)]
fn triangle_test<S: Simd>(s: S, bvh: &BvhView, state: &mut State, node: NodeRef, triangle: usize, rays: u32) {
    let block_index = node.block();
    let block = &bvh.blocks[block_index];
    let [iu, iv, iz] = state.interval.frame.axes;
    let org = [F16::load(s, &state.org[iu]), F16::load(s, &state.org[iv]), F16::load(s, &state.org[iz])];
    let flip = I32::splat(s, state.interval.frame.flip);
    let mut corners = [org; 3];
    for (corner, v) in corners.iter_mut().zip(&block.v) {
        corner[0] = F16::splat(s, v[iu][triangle]) - org[0];
        corner[1] = F16::splat(s, v[iv][triangle]) - org[1];
        corner[2] = (F16::splat(s, v[iz][triangle]) - org[2]).flip(flip);
    }
    let slopes = [F16::load(s, &state.slopes[0]), F16::load(s, &state.slopes[1])];
    let (lo, hi) = (F16::load(s, &state.lo), F16::load(s, &state.hi));
    let tests = sheared(s, &corners, slopes, hi);
    let skipped = I32::load(s, &state.skip).eq(I32::splat(s, block.prim[triangle])).bits();
    let candidates = tests.maybe & rays & !skipped;
    if candidates == 0 {
        return;
    }
    let [least, most] = tests.depths(s, &corners);
    // `start` is rounded up; this much less, it is rounded down.
    let start = F16::load(s, &state.start);
    let before = most.lt(start * F16::splat(s, SHRINK * SHRINK));
    let apart = (hi.lt(least) | before).bits() & tests.sure;
    let nearer = (most.lt(lo) & start.lt(least)).bits() & tests.sure & candidates;
    let slot = (block_index * 8 + triangle) as u32;
    if nearer != 0 {
        let mask = Mask::from_bits(s, nearer);
        mask.select(least, lo).store(&mut state.lo);
        mask.select(most, hi).store(&mut state.hi);
        mask.iselect(I32::splat(s, slot), I32::load(s, &state.slot)).store(&mut state.slot);
    }
    let mut doubtful = candidates & !apart & !nearer;
    while doubtful != 0 {
        let lane = (doubtful.trailing_zeros() & 15) as usize;
        doubtful &= doubtful - 1;
        let mut best = state.best(lane);
        single::consider(bvh, slot, None, &state.ray(lane), &mut best);
        state.found(lane, best);
    }
}

impl State {
    /// Forgets rays that are decided, shortens the others.
    #[inline(always)]
    fn settle<S: Simd, const ANY: bool>(&mut self, s: S, live: &mut u32) {
        if ANY {
            *live &= I32::load(s, &self.slot).eq(I32::<S, 16>::splat(s, NO_SLOT)).bits();
        } else {
            self.pull_in(s);
        }
    }

    #[inline(always)]
    fn pull_in<S: Simd>(&mut self, s: S) {
        let reach = F16::load(s, &self.hi) * F16::load(s, &self.scale) * F16::splat(s, GROW);
        // Lanes that take no part have a negative `hi`, and a scale that may be anything: NaN loses.
        let reach = reach.max(F16::splat(s, -1.0));
        reach.store(&mut self.reach);
        self.packet_reach = reach.reduce_max();
    }
}
