//! Shadow rays of a point light: a stream of rays from the light, regrouped by where the light sees them.
//!
//! Rays start at the light, so that they share their origin. The sixteen rays of a 4x4-pixel block mostly stay
//! neighbours as the light sees them: such a block is moved as a whole. A block that straddles a silhouette is far
//! apart in light space and would make a fat packet; its rays are *loose* and are sorted one by one.
//!
//! ```text
//!   stream (64x64 pixels) --(wide)--> slope rectangle of each block of 16
//!     small rectangle  -----------------------------> groups  --sort by Morton key--> packets of 16 groups
//!     large, sparse or mixed faces --> loose rays --sort--> groups of 16 --^
//! ```
//!
//! How rays are grouped never changes what a ray hits.

mod blocks;
mod morton;

use super::Traversal;
use crate::kernels::{EMPTY_NODE, Face, NodeRef, SUB, SUBS, TilePacket, TileScratch};
use blocks::{Block, survey};
use morton::{Grid, key};

/// Rays from one origin as structure of arrays, all slices of equal length, a multiple of 16.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRays<'a> {
    /// Slopes along the first axis of the face, in [-1, 1].
    pub u: &'a [f32],
    /// Slopes along the second axis of the face, in [-1, 1].
    pub v: &'a [f32],
    /// Greatest depth at which something blocks the ray.
    pub tfar: &'a [f32],
    /// The primitive that the ray ends on, which does not block it.
    pub skip: &'a [u32],
    /// [`Face::index`] of each ray; 6 or more for rays that are not wanted.
    pub face: &'a [u32],
}

/// The seed of a light that has not blocked anything yet.
pub const NO_OCCLUDER: NodeRef = EMPTY_NODE;

/// Sixteen rays that are traced as one sub-packet.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Sorts groups by face, then along a Morton curve.
    key: u32,
    /// First ray: of the stream, or of `order` for loose rays.
    first: u32,
    loose: bool,
    active: u16,
}

/// Buffers for tracing shadow rays, reused from stream to stream.
#[derive(Clone, Debug, Default)]
pub struct PointShadows {
    blocks: Vec<Block>,
    sizes: Vec<f32>,
    groups: Vec<Group>,
    /// Sort key and index of each loose ray.
    loose: Vec<(u32, u32)>,
    packet: TilePacket,
    scratch: TileScratch,
}

impl PointShadows {
    /// Traces the wanted rays from `origin` and clears `visible[i]` to 0 where ray i is blocked. `seed` carries the
    /// last occluder from stream to stream. Returns the number of rays traced.
    pub fn trace(
        &mut self,
        traversal: &Traversal,
        origin: [f32; 3],
        rays: &ShadowRays,
        seed: &mut NodeRef,
        visible: &mut [f32],
    ) -> u64 {
        self.regroup(traversal, rays);
        self.packet.org = origin;
        let mut traced = 0;
        let mut first = 0;
        while let Some(group) = self.groups.get(first) {
            let face = group.key >> morton::BITS;
            let same = |group: &&Group| group.key >> morton::BITS == face;
            let count = self.groups[first..].iter().take(SUBS).take_while(same).count();
            traced += self.trace_packet(traversal, rays, first..first + count, seed, visible);
            first += count;
        }
        traced
    }

    /// Fills `groups`, in the order in which they are cut into packets.
    fn regroup(&mut self, traversal: &Traversal, rays: &ShadowRays) {
        survey(traversal.kernels(), rays, &mut self.blocks);
        let limit = self.size_limit();
        let grids = Grid::around(&self.blocks);
        self.groups.clear();
        self.loose.clear();
        for (index, block) in self.blocks.iter().enumerate().filter(|(_, block)| block.active != 0) {
            let first = index * SUB;
            let whole = block.face < 6 && block.active.count_ones() >= 8 && block.size() <= limit;
            if whole {
                let [u, v] = block.center();
                let key = key(&grids, block.face, u, v);
                self.groups.push(Group { key, first: first as u32, loose: false, active: block.active });
            } else {
                for i in (first..first + SUB).filter(|&i| rays.face[i] < 6) {
                    self.loose.push((key(&grids, rays.face[i], rays.u[i], rays.v[i]), i as u32));
                }
            }
        }
        self.group_loose();
        self.groups.sort_unstable_by_key(|group| (group.key, group.first, group.loose));
    }

    /// Blocks larger than this are taken apart: a few times the size of a typical one.
    fn size_limit(&mut self) -> f32 {
        self.sizes.clear();
        self.sizes.extend(self.blocks.iter().filter(|block| block.face < 6).map(Block::size));
        if self.sizes.is_empty() {
            return 0.0;
        }
        let middle = self.sizes.len() / 2;
        let (_, median, _) = self.sizes.select_nth_unstable_by(middle, f32::total_cmp);
        4.0 * *median
    }

    /// Sorts the loose rays and cuts them into groups of one face each.
    fn group_loose(&mut self) {
        self.loose.sort_unstable();
        let mut first = 0;
        while let Some(&(key, _)) = self.loose.get(first) {
            let face = key >> morton::BITS;
            let same = |ray: &&(u32, u32)| ray.0 >> morton::BITS == face;
            let count = self.loose[first..].iter().take(SUB).take_while(same).count();
            let active = ((1u32 << count) - 1) as u16;
            self.groups.push(Group { key, first: first as u32, loose: true, active });
            first += count;
        }
    }

    fn trace_packet(
        &mut self,
        traversal: &Traversal,
        rays: &ShadowRays,
        range: std::ops::Range<usize>,
        seed: &mut NodeRef,
        visible: &mut [f32],
    ) -> u64 {
        let groups = &self.groups[range];
        let packet = &mut self.packet;
        packet.face = Face::ALL[(groups[0].key >> morton::BITS) as usize];
        packet.active = [0; SUBS];
        let mut traced = 0;
        for (sub, group) in groups.iter().enumerate() {
            let to = sub * SUB..sub * SUB + SUB;
            let first = group.first as usize;
            packet.active[sub] = group.active;
            traced += u64::from(group.active.count_ones());
            if group.loose {
                for (ray, &(_, i)) in to.zip(self.loose[first..].iter().take(SUB)) {
                    let i = i as usize;
                    packet.u[ray] = rays.u[i];
                    packet.v[ray] = rays.v[i];
                    packet.tfar[ray] = rays.tfar[i];
                    packet.skip[ray] = rays.skip[i];
                }
            } else {
                let from = first..first + SUB;
                packet.u[to.clone()].copy_from_slice(&rays.u[from.clone()]);
                packet.v[to.clone()].copy_from_slice(&rays.v[from.clone()]);
                packet.tfar[to.clone()].copy_from_slice(&rays.tfar[from.clone()]);
                packet.skip[to].copy_from_slice(&rays.skip[from]);
            }
        }
        let mut blocked = [0; SUBS];
        traversal.occluded(packet, &mut self.scratch, seed, &mut blocked);
        for (group, mut bits) in groups.iter().zip(blocked) {
            let first = group.first as usize;
            while bits != 0 {
                let i = first + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                visible[if group.loose { self.loose[i].1 as usize } else { i }] = 0.0;
            }
        }
        traced
    }
}
