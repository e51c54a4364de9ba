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

mod areas;
mod blocks;
mod morton;
mod packets;

use super::{EarlyTermination, PacketScratch, Traversal};
use crate::kernels::{EMPTY_NODE, Face, NodeRef, SUB, SUBS, TileEarly, TilePacket};
use areas::Areas;
use blocks::{Block, survey};
use morton::{Grid, key};
use packets::{Cast, Clear, Fill};

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

/// What tracing a stream took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traced {
    /// Rays traced.
    pub rays: u64,
    /// Pairs of a ray and a triangle that exact arithmetic decided.
    pub doubts: u64,
}

/// The seed of a light that has not blocked anything yet.
pub const NO_OCCLUDER: NodeRef = EMPTY_NODE;

/// Sixteen rays that are traced as one sub-packet.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Block of the stream, or place of the first ray in `loose`.
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
    /// Sort key and index of each group.
    order: Vec<u64>,
    /// Sort key and index of each loose ray.
    loose: Vec<u64>,
    packet: TilePacket,
    scratch: PacketScratch,
    early: EarlyTermination,
    /// For OCC by areas.
    areas: Option<Areas>,
}

impl PointShadows {
    /// How searches end early: SET, OCC, and whether OCC remembers by areas.
    pub fn set_early(&mut self, early: EarlyTermination) {
        self.early = early;
        self.areas = (early.occ && early.area > 0).then(|| Areas::new(early.area));
        self.scratch.set_early(TileEarly { stop: early.set, ..TileEarly::ALL });
    }

    /// Traces the wanted rays from `origin` and clears `visible[i]` to 0 where ray i is blocked. `seed` carries the
    /// last occluder from stream to stream.
    pub fn trace(
        &mut self,
        traversal: &Traversal,
        origin: [f32; 3],
        rays: &ShadowRays,
        seed: &mut NodeRef,
        visible: &mut [f32],
    ) -> Traced {
        self.regroup(traversal, rays);
        self.packet.org = origin;
        self.scratch.begin();
        if traversal.depends_on_order() {
            *seed = NO_OCCLUDER;
        }
        let mut traced = Traced::default();
        let mut first = 0;
        while let Some(&group) = self.order.get(first) {
            let count = run_of_face(&self.order[first..], SUBS);
            let packet =
                self.trace_packet(traversal, rays, first..first + count, face_of(group), seed, visible);
            traced.rays += packet.rays;
            traced.doubts += packet.doubts;
            first += count;
        }
        traced
    }

    /// Fills `groups`, and `order` with the order in which they are cut into packets.
    fn regroup(&mut self, traversal: &Traversal, rays: &ShadowRays) {
        survey(traversal.kernels(), rays, &mut self.blocks);
        let limit = self.size_limit();
        let grids = Grid::around(&self.blocks);
        self.groups.clear();
        self.order.clear();
        self.loose.clear();
        for (index, block) in self.blocks.iter().enumerate().filter(|(_, block)| block.active != 0) {
            let whole = block.face < 6 && block.active.count_ones() >= 8 && block.size() <= limit;
            if whole {
                let [u, v] = block.center();
                let key = key(&grids, block.face, u, v);
                self.order.push(sortable(key, self.groups.len()));
                self.groups.push(Group { first: index as u32, loose: false, active: block.active });
            } else {
                let first = index * SUB;
                for i in (first..first + SUB).filter(|&i| rays.face[i] < 6) {
                    self.loose.push(sortable(key(&grids, rays.face[i], rays.u[i], rays.v[i]), i));
                }
            }
        }
        self.group_loose();
        self.order.sort_unstable();
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
        while let Some(&ray) = self.loose.get(first) {
            let count = run_of_face(&self.loose[first..], SUB);
            let active = ((1u32 << count) - 1) as u16;
            self.order.push(sortable((ray >> 32) as u32, self.groups.len()));
            self.groups.push(Group { first: first as u32, loose: true, active });
            first += count;
        }
    }

    fn trace_packet(
        &mut self,
        traversal: &Traversal,
        rays: &ShadowRays,
        range: std::ops::Range<usize>,
        face: usize,
        seed: &mut NodeRef,
        visible: &mut [f32],
    ) -> Traced {
        let PointShadows { groups, order, loose, packet, scratch, early, areas, .. } = self;
        packet.face = Face::ALL[face];
        packet.active = [0; SUBS];
        let kernels = traversal.kernels();
        let cast = Cast { groups, order: &order[range], loose };
        let rays = kernels.run(Fill { cast, rays, packet });
        let mut blocked = [0; SUBS];
        let place = areas.as_ref().map(|_| first_place(packet));
        if let Some((areas, place)) = areas.as_ref().zip(place) {
            scratch.set_early(TileEarly { stop: early.set, seeds: areas.seeds(place), ..TileEarly::ALL });
        }
        if !early.occ || areas.is_some() {
            *seed = NO_OCCLUDER;
        }
        let doubts = traversal.occluded(packet, scratch, seed, &mut blocked);
        if let Some((areas, place)) = areas.as_mut().zip(place).filter(|_| *seed != NO_OCCLUDER) {
            areas.put(place, *seed);
        }
        kernels.run(Clear { cast, blocked: &blocked, visible });
        Traced { rays, doubts }
    }
}

/// The place of a packet's first ray in the memory by areas.
fn first_place(packet: &TilePacket) -> usize {
    let sub = packet.active.iter().position(|&active| active != 0).unwrap_or(0);
    let ray = sub * SUB + packet.active[sub].trailing_zeros() as usize % SUB;
    Areas::place(packet.org, packet.face, packet.u[ray], packet.v[ray])
}

/// Sorts by key; the index makes it unique.
fn sortable(key: u32, index: usize) -> u64 {
    u64::from(key) << 32 | index as u64
}

/// The face that a sortable key belongs to.
fn face_of(sortable: u64) -> usize {
    (sortable >> 32 >> morton::BITS) as usize
}

/// How many of the first `most` have the face of the first.
fn run_of_face(sorted: &[u64], most: usize) -> usize {
    sorted.iter().take(most).take_while(|&&other| face_of(other) == face_of(sorted[0])).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{BuildPreset, Bvh};
    use crate::kernels::{Kernels, Visibility};
    use crate::trace::KernelChoice;

    #[test]
    fn the_last_occluder_is_forgotten_where_it_could_change_what_a_ray_hits() {
        let scene = crate::scene::load("atrium@0.1").unwrap();
        let bvh = Bvh::build(&scene.mesh, BuildPreset::Fast).unwrap();
        let none = ShadowRays { u: &[], v: &[], tfar: &[], skip: &[], face: &[] };
        for choice in KernelChoice::ALL {
            for visibility in [Visibility::Exact, Visibility::Fast] {
                let kernels = Kernels::detect().with_visibility(visibility);
                let traversal = Traversal::new(&bvh, kernels, choice);
                let mut seed = traversal.tree().root;
                PointShadows::default().trace(&traversal, [0.0; 3], &none, &mut seed, &mut []);
                let forgotten = choice == KernelChoice::Auto && visibility == Visibility::Fast;
                assert_eq!(seed == NO_OCCLUDER, forgotten, "{choice} {visibility}");
            }
        }
    }
}
