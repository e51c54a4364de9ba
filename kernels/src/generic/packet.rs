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
    F8, F16, Frame, single,
    single::{Best, GROW, SHRINK, TravRay},
    stack::Stack,
};
use crate::{
    node::{BvhView, EMPTY_NODE, Node, NodeRef},
    packet::{Hit, MISS, PACKET_RAYS, Ray},
    simd::Simd,
    vector::I32,
};

/// With so few rays left in a subtree they go on one by one (measured: see `benches/LOG.md`).
const FEW_IN_TREE: u32 = 3;
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
    rdir: [[f32; 16]; 3],
    shear: [[f32; 16]; 2],
    /// Greatest component of the direction.
    dz: [f32; 16],
    tnear: [f32; 16],
    /// Nothing deeper counts; below any depth for lanes that take no part.
    tfar: [f32; 16],
    rays: [TravRay; 16],
    best: [Best; 16],
    interval: Interval,
    /// Greatest `tfar` of the packet.
    reach: f32,
    /// Least `tnear` of the packet.
    start: f32,
}

/// Encloses origins and reciprocal directions, by axis, arranged by what bounds near and far planes.
#[derive(Clone, Copy)]
struct Interval {
    negative: [usize; 3],
    /// The origin farthest along the direction, and the one least far.
    ahead: [f32; 3],
    behind: [f32; 3],
    /// The reciprocals of least and greatest magnitude.
    small: [f32; 3],
    large: [f32; 3],
    frame: Frame,
}

/// First hits of up to sixteen rays; the rest of `hits` is left as it is.
#[inline(always)]
pub(crate) fn intersect<S: Simd>(s: S, bvh: &BvhView, rays: &[Ray], hits: &mut [Hit]) {
    let (mut state, together) = State::new(rays);
    if together != 0 {
        traverse::<S, false>(s, bvh, &mut state, together);
    }
    for (lane, (ray, hit)) in rays.iter().zip(hits).enumerate().take(PACKET_RAYS) {
        *hit = if together >> lane & 1 != 0 {
            state.best[lane].hit(bvh, &state.rays[lane])
        } else {
            single::intersect(s, bvh, ray)
        };
    }
}

/// Which of up to sixteen rays hit anything, bit = ray.
#[inline(always)]
pub(crate) fn occluded<S: Simd>(s: S, bvh: &BvhView, rays: &[Ray]) -> u32 {
    let (mut state, together) = State::new(rays);
    if together != 0 {
        traverse::<S, true>(s, bvh, &mut state, together);
    }
    let mut blocked = 0;
    for (lane, ray) in rays.iter().enumerate().take(PACKET_RAYS) {
        let hit = if together >> lane & 1 != 0 {
            state.best[lane].prim != MISS
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
    fn new(rays: &[Ray]) -> (State, u32) {
        const NOWHERE: Ray = Ray { org: [0.0; 3], dir: [0.0, 0.0, 1.0], tnear: 0.0, tfar: 0.0, skip: MISS };
        let first = rays.iter().find_map(TravRay::new);
        let (first, mut together) = match first.or_else(|| TravRay::new(&NOWHERE)) {
            Some(ray) => (ray, 0),
            None => unreachable!("a constant ray"),
        };
        let mut state = State {
            org: [[0.0; 16]; 3],
            rdir: [[0.0; 16]; 3],
            shear: [[0.0; 16]; 2],
            dz: [1.0; 16],
            tnear: [0.0; 16],
            tfar: [-1.0; 16],
            rays: [first; 16],
            best: [Best::none(&NOWHERE); 16],
            interval: Interval::of(&first),
            reach: -1.0,
            start: f32::INFINITY,
        };
        for (lane, ray) in rays.iter().enumerate().take(PACKET_RAYS) {
            let Some(trav) = TravRay::new(ray) else { continue };
            if trav.negative != first.negative || trav.frame.axes != first.frame.axes {
                continue;
            }
            together |= 1 << lane;
            for axis in 0..3 {
                state.org[axis][lane] = trav.org[axis];
                state.rdir[axis][lane] = trav.rdir[axis];
            }
            state.shear[0][lane] = trav.shear[0];
            state.shear[1][lane] = trav.shear[1];
            state.dz[lane] = trav.d[2];
            state.tnear[lane] = trav.tnear;
            state.tfar[lane] = ray.tfar;
            state.rays[lane] = trav;
            state.best[lane] = Best::none(ray);
            state.interval.add(&trav);
            state.reach = state.reach.max(ray.tfar);
            state.start = state.start.min(trav.tnear);
        }
        (state, together)
    }

    /// Rays of `rays` for which something at depth `near` would count.
    #[inline(always)]
    fn interested<S: Simd>(&self, s: S, near: f32, rays: u32) -> u32 {
        F16::splat(s, near).le(F16::load(s, &self.tfar)).bits() & rays
    }
}

impl Interval {
    #[inline(always)]
    fn of(ray: &TravRay) -> Interval {
        Interval {
            negative: ray.negative,
            ahead: ray.org,
            behind: ray.org,
            small: ray.rdir,
            large: ray.rdir,
            frame: ray.frame,
        }
    }

    #[inline(always)]
    fn add(&mut self, ray: &TravRay) {
        for axis in 0..3 {
            let (o, r) = (ray.org[axis], ray.rdir[axis]);
            let (least, most) = (self.ahead[axis].min(o), self.ahead[axis].max(o));
            let (least_behind, most_behind) = (self.behind[axis].min(o), self.behind[axis].max(o));
            let negative = self.negative[axis] != 0;
            self.ahead[axis] = if negative { least } else { most };
            self.behind[axis] = if negative { most_behind } else { least_behind };
            if r.abs() < self.small[axis].abs() {
                self.small[axis] = r;
            }
            if r.abs() > self.large[axis].abs() {
                self.large[axis] = r;
            }
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
        single::traverse::<S, ANY>(s, bvh, &state.rays[lane], &mut state.best[lane], entry.node);
        state.decided::<ANY>(lane, live);
    }
    state.pull_in(s);
}

/// Tests a node's children; pushes all that a ray must visit but the nearest, which becomes `next`. False if there is
/// none.
#[inline(always)]
fn children<S: Simd>(s: S, node: &Node, state: &State, stack: &mut Stack<Entry>, next: &mut Entry) -> bool {
    let interval = &state.interval;
    let mut near = F8::splat(s, state.start);
    let mut far = F8::splat(s, state.reach);
    for axis in 0..3 {
        let negative = interval.negative[axis] & 1;
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
    let mut far = F16::load(s, &state.tfar);
    for axis in 0..3 {
        let negative = state.interval.negative[axis] & 1;
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
            single::leaf(s, bvh, &state.rays[lane], node, &mut state.best[lane]);
            state.decided::<ANY>(lane, live);
        }
    } else {
        let mut triangles = node.lanes();
        while triangles != 0 && rays & *live != 0 {
            let triangle = (triangles.trailing_zeros() & 7) as usize;
            triangles &= triangles - 1;
            triangle_test::<S, ANY>(s, bvh, state, node, triangle, rays & *live, live);
        }
    }
    state.pull_in(s);
}

/// Tests one triangle, lane = ray.
#[inline(always)]
fn triangle_test<S: Simd, const ANY: bool>(
    s: S,
    bvh: &BvhView,
    state: &mut State,
    node: NodeRef,
    triangle: usize,
    rays: u32,
    live: &mut u32,
) {
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
    let shear = [F16::load(s, &state.shear[0]), F16::load(s, &state.shear[1])];
    let far = F16::load(s, &state.tfar) * F16::load(s, &state.dz) * F16::splat(s, GROW);
    let (maybe, sure) = single::sheared(s, corners, shear, far);
    let mut left = maybe & rays;
    while left != 0 {
        let lane = (left.trailing_zeros() & 15) as usize;
        left &= left - 1;
        let sure = sure >> lane & 1 != 0;
        single::consider(block, block_index, triangle, sure, &state.rays[lane], &mut state.best[lane]);
        state.decided::<ANY>(lane, live);
    }
}

impl State {
    /// Takes over what a ray has found.
    #[inline(always)]
    fn decided<const ANY: bool>(&mut self, lane: usize, live: &mut u32) {
        if ANY {
            *live &= !(u32::from(self.best[lane].prim != MISS) << lane);
        }
        self.tfar[lane] = self.best[lane].tfar;
    }

    /// The rays got shorter.
    #[inline(always)]
    fn pull_in<S: Simd>(&mut self, s: S) {
        self.reach = F16::load(s, &self.tfar).reduce_max();
    }
}
