//! Streams of rays that share neither origin nor direction, cut into beams of rays that fly about the same way.
//!
//! Of sixteen consecutive rays, a block of 4x4 pixels perhaps, most leave one surface and fly about the same way. Such
//! rays form a *group*; those that find too little company in their block are traced one by one. Groups are sorted by
//! direction, and up to sixteen of one face make a beam.
//!
//! ```text
//!   rays (4096 at a time) --(wide)--> blocks of 16
//!     some of a block fly about the same way --> groups --sort by direction--> beams of 16 groups
//!     few of a kind --> one by one
//! ```
//!
//! How rays are grouped never changes what a ray hits.

mod survey;

use super::{NO_OCCLUDER, Traversal};
use crate::kernels::{Flight, Hit, NodeRef, Pick, Ray, RayBlock, SUB, SUBS};
use std::ops::Range;
use survey::{Cut, Survey};

/// Rays that are regrouped at a time.
const CHUNK: usize = 4096;
/// Fewer rays than this are no group: a beam tests sixteen rays at a time, whoever takes part.
const ENOUGH: u32 = 4;
/// Origins of a group are no farther from that of one of its rays than this many times the median size of a block.
const SPREAD: f32 = 4.0;

/// Rays of one block that fly together.
///
/// `face (3 bits) | cell of directions (6) | block (16) | rays (16)`: groups are sorted by face, then along a curve of
/// directions, then by place in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Group(u64);

impl Group {
    /// `key` is face and cell of one of the rays.
    #[inline(always)]
    fn new(key: u32, block: usize, active: u16) -> Group {
        Group(u64::from(key) << 32 | (block as u64) << 16 | u64::from(active))
    }

    fn face(self) -> u64 {
        self.0 >> (32 + survey::CELL_BITS)
    }

    fn pick(self) -> Pick {
        Pick { block: (self.0 >> 16) as u32 & 0xffff, active: self.0 as u16 }
    }
}

/// Buffers for regrouping streams, reused from stream to stream.
#[derive(Clone, Debug, Default)]
pub struct RayStream {
    blocks: Vec<RayBlock>,
    /// How far apart the origins in each block are.
    sizes: Vec<f32>,
    groups: Vec<Group>,
    picks: Vec<Pick>,
    /// Rays to be traced one by one: which, the rays, and what becomes of them.
    single: Vec<u32>,
    alone: Vec<Ray>,
    met: Vec<Hit>,
    stopped: Vec<bool>,
    flight: Flight,
}

impl RayStream {
    /// First hits of all rays.
    ///
    /// # Panics
    /// If there are not as many hits as rays.
    pub fn intersect(&mut self, traversal: &Traversal, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one hit for each ray");
        let mut found = [[Hit::MISS; SUB]; SUBS];
        for (rays, hits) in rays.chunks(CHUNK).zip(hits.chunks_mut(CHUNK)) {
            self.regroup(traversal, rays);
            self.alone.clear();
            self.alone.extend(self.single.iter().map(|&ray| rays[ray as usize]));
            self.met.resize(self.alone.len(), Hit::MISS);
            traversal.intersect_each(&self.alone, &mut self.flight, &mut self.met);
            for (&ray, hit) in self.single.iter().zip(&self.met) {
                hits[ray as usize] = *hit;
            }
            let mut first = 0;
            while let Some(beam) = self.beam(first) {
                first = beam.end;
                traversal.intersect_beam(&self.blocks, &self.picks[beam.clone()], &mut found);
                for (pick, found) in self.picks[beam].iter().zip(&found) {
                    each(pick, |lane, ray| hits[ray] = found[lane]);
                }
            }
        }
    }

    /// Whether anything blocks each ray.
    ///
    /// # Panics
    /// If there are not as many answers as rays.
    pub fn occluded(&mut self, traversal: &Traversal, rays: &[Ray], blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len(), "one answer for each ray");
        let mut seed: NodeRef = NO_OCCLUDER;
        let mut found = [0; SUBS];
        for (rays, blocked) in rays.chunks(CHUNK).zip(blocked.chunks_mut(CHUNK)) {
            self.regroup(traversal, rays);
            self.alone.clear();
            self.alone.extend(self.single.iter().map(|&ray| rays[ray as usize]));
            self.stopped.resize(self.alone.len(), false);
            traversal.occluded_each(&self.alone, &mut self.flight, &mut self.stopped);
            for (&ray, stopped) in self.single.iter().zip(&self.stopped) {
                blocked[ray as usize] = *stopped;
            }
            let mut first = 0;
            while let Some(beam) = self.beam(first) {
                first = beam.end;
                traversal.occluded_beam(&self.blocks, &self.picks[beam.clone()], &mut seed, &mut found);
                for (pick, &found) in self.picks[beam].iter().zip(&found) {
                    each(pick, |lane, ray| blocked[ray] = found >> lane & 1 != 0);
                }
            }
        }
    }

    /// The next groups of one face, at most as many as make a beam.
    fn beam(&self, first: usize) -> Option<Range<usize>> {
        let face = self.groups.get(first)?.face();
        let count = self.groups[first..].iter().take(SUBS).take_while(|group| group.face() == face).count();
        Some(first..first + count)
    }

    /// The median of `sizes`.
    fn median(&mut self) -> f32 {
        if self.sizes.is_empty() {
            return 0.0;
        }
        let middle = self.sizes.len() / 2;
        *self.sizes.select_nth_unstable_by(middle, f32::total_cmp).1
    }

    /// Fills `blocks`, `single`, and `picks`, which it returns, in the order in which they are cut into beams. Every ray
    /// gets into one. There are at most 2^20 rays.
    pub(crate) fn regroup(&mut self, traversal: &Traversal, rays: &[Ray]) -> &[Pick] {
        self.groups.clear();
        self.single.clear();
        self.sizes.clear();
        traversal.kernels().run(Cut { rays, stream: self });
        let limit = SPREAD * self.median();
        traversal.kernels().run(Survey { limit, stream: self });
        self.groups.sort_unstable();
        self.picks.clear();
        self.picks.extend(self.groups.iter().map(|group| group.pick()));
        &self.picks
    }
}

/// Calls `f` with lane and ray index of every ray of a pick.
#[inline(always)]
fn each(pick: &Pick, mut f: impl FnMut(usize, usize)) {
    let mut left = pick.active;
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        f(lane, pick.block as usize * SUB + lane);
    }
}
