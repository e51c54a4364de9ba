//! Streams of rays that share neither origin nor direction, cut into beams of rays that fly about the same way.
//!
//! Of sixteen consecutive rays, a block of 4x4 pixels perhaps, most leave one surface and fly about the same way. Such
//! rays form a *group*; those that find too little company in their block fly alone. Groups are sorted by
//! direction, and up to sixteen of one face make a beam.
//!
//! ```text
//!   blocks of 16 rays (256 at a time)
//!     some of a block fly about the same way --> groups --sort by direction--> beams of 16 groups
//!     few of a kind --> a flight of single rays
//! ```
//!
//! How rays are grouped never changes what a ray hits.

mod survey;

use super::{NO_OCCLUDER, Traversal};
use crate::kernels::{Flight, HitBlock, NodeRef, Pick, RayBlock, SUBS};
use std::ops::Range;
use survey::{Measure, Survey};

/// Blocks that are regrouped at a time.
const CHUNK: usize = 256;
/// After blocks without company, one of so many tells whether there is any.
const PROBE: usize = 16;
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

/// How many rays are active.
pub fn rays_in(blocks: &[RayBlock]) -> u64 {
    blocks.iter().map(|block| u64::from(block.active.count_ones())).sum()
}

/// Buffers for regrouping streams, reused from stream to stream.
#[derive(Clone, Debug, Default)]
pub struct RayStream {
    /// How far apart the origins in each block are.
    sizes: Vec<f32>,
    groups: Vec<Group>,
    /// The groups in the order in which they are cut into beams.
    picks: Vec<Pick>,
    /// Rays that fly alone.
    single: Vec<Pick>,
    /// No rays of the last blocks flew together: looking whether the next do is worth a glance only.
    strangers: bool,
    flight: Flight,
}

impl RayStream {
    /// First hits of all active rays, by block; hits of other rays are left as they are. Returns how many pairs of a ray
    /// and a triangle exact arithmetic decided.
    ///
    /// # Panics
    /// If there are not hits for each block.
    pub fn intersect(&mut self, traversal: &Traversal, blocks: &[RayBlock], hits: &mut [HitBlock]) -> u64 {
        assert_eq!(blocks.len(), hits.len(), "hits for each block");
        let mut doubts = 0;
        for (blocks, hits) in blocks.chunks(CHUNK).zip(hits.chunks_mut(CHUNK)) {
            self.regroup(traversal, blocks);
            doubts += traversal.intersect_each(blocks, &self.single, &mut self.flight, hits);
            let mut first = 0;
            while let Some(beam) = self.beam(first) {
                first = beam.end;
                doubts += traversal.intersect_beam(blocks, &self.picks[beam], hits);
            }
        }
        doubts
    }

    /// Whether anything blocks each active ray, by block: bits like [`RayBlock::active`]. Other bits are left as they
    /// are. Returns what [`RayStream::intersect`] does.
    ///
    /// # Panics
    /// If there are not answers for each block.
    pub fn occluded(&mut self, traversal: &Traversal, blocks: &[RayBlock], blocked: &mut [u16]) -> u64 {
        assert_eq!(blocks.len(), blocked.len(), "answers for each block");
        let mut doubts = 0;
        let mut seed: NodeRef = NO_OCCLUDER;
        for (blocks, blocked) in blocks.chunks(CHUNK).zip(blocked.chunks_mut(CHUNK)) {
            self.regroup(traversal, blocks);
            doubts += traversal.occluded_each(blocks, &self.single, &mut self.flight, blocked);
            let mut first = 0;
            while let Some(beam) = self.beam(first) {
                first = beam.end;
                doubts += traversal.occluded_beam(blocks, &self.picks[beam], &mut seed, blocked);
            }
        }
        doubts
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

    /// Finds `single` and `picks`, which it returns, in the order in which they are cut into beams. Every active ray gets
    /// into one. There are at most 2^16 blocks.
    pub(crate) fn regroup(&mut self, traversal: &Traversal, blocks: &[RayBlock]) -> &[Pick] {
        self.groups.clear();
        self.single.clear();
        self.sizes.clear();
        traversal.kernels().run(Measure { blocks, sizes: &mut self.sizes });
        let limit = SPREAD * self.median();
        if self.strangers {
            traversal.kernels().run(Survey::<PROBE> { limit, blocks, stream: self });
            self.strangers = self.groups.is_empty();
            self.groups.clear();
            self.single.clear();
        }
        if self.strangers {
            let alone = |(block, rays): (usize, &RayBlock)| Pick { block: block as u32, active: rays.active };
            self.single.extend(blocks.iter().enumerate().map(alone));
        } else {
            traversal.kernels().run(Survey::<1> { limit, blocks, stream: self });
            self.strangers = self.groups.is_empty();
        }
        self.groups.sort_unstable();
        self.picks.clear();
        self.picks.extend(self.groups.iter().map(|group| group.pick()));
        &self.picks
    }
}
