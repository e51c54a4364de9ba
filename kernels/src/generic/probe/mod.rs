//! One ray at a time, with each early termination as a switch, and everything countable: the kernel of the coherence
//! study. It answers what the other kernels answer, bit by bit, whatever the switches.
//!
//! ```text
//!   closest hit    all: every triangle on the ray, then the nearest     bound: nothing beyond the nearest so far
//!   occlusion      all: every triangle on the ray, then the first       stop: the first one found
//!                  from the surface
//!   both           seeds: triangles that are tested before the tree is entered
//! ```
//!
//! Shadow rays of a point light start at the light, as in the other kernels, so that all agree to the bit; they are
//! searched from their far end, the surface, as if they had started there: nodes near the surface come first, and of
//! several occluders the one nearest to the surface is told.
//!
//! Counts: a *step* is a node or leaf visited; each child box of a visited node is a *box test*, each triangle of a
//! visited leaf a *triangle test*, however many of them one instruction does. A seed is a triangle test.

mod walk;

use super::{
    doubt::{NO_SLOT, nearer},
    single::{Best, TravRay, consider, leaf},
};
use crate::{
    node::{BvhView, NodeRef},
    packet::{Hit, Ray},
    simd::{Kernel, Simd},
    visibility::Exact,
};
use walk::{All, First, Nearest, traverse};

/// A slot (block of the tree * 8 + lane) that names no triangle.
pub const NO_TRIANGLE: u32 = NO_SLOT;

/// Is told what a traversal does.
pub trait Counter {
    /// False if nothing is counted: then counting costs nothing.
    const COUNTS: bool;
    /// A node or leaf is visited.
    fn step(&mut self);
    /// Boxes are tested.
    fn boxes(&mut self, number: u32);
    /// Triangles are tested.
    fn triangles(&mut self, number: u32);
}

/// Counts nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Uncounted;

impl Counter for Uncounted {
    const COUNTS: bool = false;
    #[inline(always)]
    fn step(&mut self) {}
    #[inline(always)]
    fn boxes(&mut self, _: u32) {}
    #[inline(always)]
    fn triangles(&mut self, _: u32) {}
}

/// What traversals did, all together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Nodes and leaves visited.
    pub steps: u64,
    /// Boxes tested.
    pub boxes: u64,
    /// Triangles tested.
    pub triangles: u64,
}

impl Counter for Counts {
    const COUNTS: bool = true;
    #[inline(always)]
    fn step(&mut self) {
        self.steps += 1;
    }
    #[inline(always)]
    fn boxes(&mut self, number: u32) {
        self.boxes += u64::from(number);
    }
    #[inline(always)]
    fn triangles(&mut self, number: u32) {
        self.triangles += u64::from(number);
    }
}

impl From<Uncounted> for Counts {
    fn from(_: Uncounted) -> Counts {
        Counts::default()
    }
}

/// Working memory: the triangles that a ray passes through, if all are to be found.
#[derive(Clone, Debug, Default)]
pub struct ProbeScratch {
    candidates: Vec<Candidate>,
}

/// A triangle that a ray passes through, or nearly so.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    slot: u32,
    /// Encloses the depth along the frame's third axis, if the ray passes through beyond doubt.
    depth: Option<(f32, f32)>,
}

/// The first hit of a ray.
pub struct Closest<'a, C> {
    /// The tree.
    pub bvh: &'a BvhView<'a>,
    /// The ray.
    pub ray: &'a Ray,
    /// Skip what lies beyond the nearest hit so far, instead of finding all hits first.
    pub bound: bool,
    /// Slots of triangles to test first; [`NO_TRIANGLE`] is passed over, and so is what the tree has not.
    pub seeds: &'a [u32],
    /// Working memory.
    pub scratch: &'a mut ProbeScratch,
    /// Is told what happens.
    pub counter: &'a mut C,
}

/// What [`Closest`] finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The first hit.
    pub hit: Hit,
    /// The slot of its triangle, or [`NO_TRIANGLE`].
    pub slot: u32,
    /// True if the ray hits one of the seeds.
    pub seeded: bool,
}

impl<C: Counter> Kernel for Closest<'_, C> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Found {
        let Closest { bvh, ray, bound, seeds, scratch, counter } = self;
        let Some(ray) = TravRay::new(ray) else {
            return Found { hit: Hit::MISS, slot: NO_SLOT, seeded: false };
        };
        let mut best = Best::none(&ray);
        for &slot in seeds {
            if is_triangle(bvh, slot) {
                counter.triangles(1);
                leaf::<S, Exact>(s, bvh, &ray, NodeRef::triangle(slot), &mut best);
            }
        }
        let seeded = best.slot != NO_SLOT;
        if bound {
            traverse(s, bvh, &ray, ray.tnear, &mut Nearest { best: &mut best }, counter);
        } else {
            scratch.candidates.clear();
            let mut all = All { list: &mut scratch.candidates, tfar: ray.tfar };
            traverse(s, bvh, &ray, ray.tnear, &mut all, counter);
            for candidate in &scratch.candidates {
                consider::<Exact>(bvh, candidate.slot, candidate.depth, &ray, &mut best);
            }
        }
        Found { hit: best.hit(bvh, &ray), slot: best.slot, seeded }
    }
}

/// Whether a ray is blocked.
pub struct Blocked<'a, C> {
    /// The tree.
    pub bvh: &'a BvhView<'a>,
    /// The ray: from the light to the surface, unless `from_surface`.
    pub ray: &'a Ray,
    /// The ray starts at the surface.
    pub from_surface: bool,
    /// Stop at the first occluder, instead of finding all first.
    pub stop: bool,
    /// Search beyond the light too, as a ray from the surface does that does not know where it ends; for rays that
    /// start at the light.
    pub beyond: bool,
    /// As in [`Closest`]; if one of them blocks the ray, the tree is not entered.
    pub seeds: &'a [u32],
    /// Working memory.
    pub scratch: &'a mut ProbeScratch,
    /// Is told what happens.
    pub counter: &'a mut C,
}

/// What [`Blocked`] finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Occluder {
    /// The slot of the triangle that blocks the ray, or [`NO_TRIANGLE`].
    pub slot: u32,
    /// True if it is one of the seeds: the tree was not entered.
    pub seeded: bool,
}

impl<C: Counter> Kernel for Blocked<'_, C> {
    type Output = Occluder;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Occluder {
        let Blocked { bvh, ray, from_surface, stop, beyond, seeds, scratch, counter } = self;
        let Some(ray) = TravRay::new(ray) else { return Occluder { slot: NO_SLOT, seeded: false } };
        let mut first = First::<false> { slot: NO_SLOT, tfar: ray.tfar };
        for &slot in seeds {
            if is_triangle(bvh, slot) {
                counter.triangles(1);
                if walk::Visit::leaf(&mut first, s, bvh, &ray, NodeRef::triangle(slot)) {
                    return Occluder { slot, seeded: true };
                }
            }
        }
        let lower = if beyond && !from_surface { f32::NEG_INFINITY } else { ray.tnear };
        if stop && from_surface {
            let mut first = First::<true> { slot: NO_SLOT, tfar: ray.tfar };
            traverse(s, bvh, &ray, ray.tnear, &mut first, counter);
            return Occluder { slot: first.slot, seeded: false };
        }
        if stop {
            traverse(s, bvh, &ray, lower, &mut first, counter);
            return Occluder { slot: first.slot, seeded: false };
        }
        scratch.candidates.clear();
        traverse(s, bvh, &ray, lower, &mut All { list: &mut scratch.candidates, tfar: ray.tfar }, counter);
        Occluder { slot: nearest_to_surface(bvh, &ray, from_surface, &scratch.candidates), seeded: false }
    }
}

#[inline(always)]
fn is_triangle(bvh: &BvhView, slot: u32) -> bool {
    ((slot >> 3) as usize) < bvh.blocks.len()
}

/// Of those candidates that block the ray, the one nearest to its end at the surface; of equally near ones that of the
/// least primitive. Nothing here is wide.
#[inline(never)]
fn nearest_to_surface(bvh: &BvhView, ray: &TravRay, from_surface: bool, candidates: &[Candidate]) -> u32 {
    let mut last = (NO_SLOT, 0.0, 0.0);
    for &Candidate { slot, depth } in candidates {
        let Some((lo, hi)) = blocks(bvh, ray, slot, depth) else { continue };
        // Depths count from the surface.
        let (lo, hi) = if from_surface { (lo, hi) } else { (-hi, -lo) };
        if last.0 == NO_SLOT
            || hi < last.1
            || (lo <= last.2 && is_nearer(bvh, ray, from_surface, slot, last.0))
        {
            last = (slot, lo, hi);
        }
    }
    last.0
}

/// Whether the triangle in `slot` blocks the ray, and an interval around its depth; `depth` as in [`Candidate`].
#[inline(always)]
fn blocks(bvh: &BvhView, ray: &TravRay, slot: u32, depth: Option<(f32, f32)>) -> Option<(f32, f32)> {
    use super::single::{GROW, SHRINK};
    let (near, far) = (ray.tnear * ray.d[2], ray.tfar * ray.d[2]);
    if let Some((lo, hi)) = depth {
        if lo > far * GROW || hi < near * SHRINK {
            return None;
        }
        if lo > near * GROW && hi < far * SHRINK {
            return depth;
        }
    }
    let t = nearer(bvh, &ray.frame, ray.d, [ray.tnear, ray.tfar], slot, NO_SLOT)?;
    let depth = t * f64::from(ray.d[2]);
    Some(((depth * (1.0 - 5.0e-7)) as f32, (depth * (1.0 + 5.0e-7)) as f32))
}

/// Whether the triangle in `slot`, which blocks the ray, does so nearer to the surface than that in `other`, which does
/// so too.
#[cold]
fn is_nearer(bvh: &BvhView, ray: &TravRay, from_surface: bool, slot: u32, other: u32) -> bool {
    let key = |slot: u32| {
        let t = nearer(bvh, &ray.frame, ray.d, [ray.tnear, ray.tfar], slot, NO_SLOT).unwrap_or(f64::INFINITY);
        let prim = bvh.blocks[(slot >> 3) as usize].prim[(slot & 7) as usize];
        (if from_surface { t } else { -t }, prim)
    };
    key(slot) < key(other)
}
