//! Packets of rays from one origin: by the tile kernel while their rays have enough in common, else as a flight of single
//! rays.
//!
//! The tile kernel counts its work. A packet that takes more than its rays would take one by one is given up and flies
//! apart: about twice the better of both, where the rate below is right. Its neighbours are likely to be no better. So the
//! next ones fly apart at once, more of them each time that one is given up in a row.
//!
//! ```text
//!   packet --tile kernel--> done in time
//!             \ too much work: flight of single rays; so is the next packet, then 3, 7, 15
//! ```
//!
//! All of that starts again with each tile of the image, so that what is done never depends on who renders what. Which
//! way a packet goes never changes what its rays hit (exact visibility), or depends on nothing but the tile (fast).

use super::{KernelChoice, Traversal};
use crate::kernels::{
    Flight, HitBlock, NodeRef, Pick, RayBlock, SUB, SUBS, TileEarly, TileHits, TilePacket, TileScratch,
    Visibility,
};

/// Working memory for tracing packets: one for each thread.
#[derive(Clone, Debug, Default)]
pub struct PacketScratch {
    tile: TileScratch,
    apart: Option<Box<Apart>>,
    pace: Pace,
}

/// Packets as blocks of rays that need have nothing in common.
#[derive(Clone, Debug)]
struct Apart {
    blocks: [RayBlock; SUBS],
    hits: [HitBlock; SUBS],
    picks: Vec<Pick>,
    flight: Flight,
}

/// Which packets are worth trying as such.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Pace {
    /// So many packets to come fly apart.
    left: u32,
    /// So many did so, or do, after the last one that was given up; 0 if the last one that was tried stayed together.
    skips: u32,
}

impl Pace {
    /// Whether the next packet flies apart at once.
    fn flies_apart(&mut self) -> bool {
        let flies = self.left > 0;
        self.left -= u32::from(flies);
        flies
    }

    /// What became of a packet that was tried.
    fn tell(&mut self, gave_up: bool) {
        self.skips = if gave_up { (2 * self.skips + 1).min(MOST) } else { 0 };
        self.left = self.skips;
    }
}

/// Units of the tile kernel's work that a ray of a packet is worth. A ray of a flight takes as long as 4 to 22 units where
/// packets are coherent and 33 to 45 where they are not; 24 costs scenes for which the tile kernel is best 1 or 2 % at
/// 1024x1024, up to 4 % at 192x192 (`benches/LOG.md`).
const WORTH: u32 = 24;
/// Most packets that fly apart untried.
const MOST: u32 = 15;

impl PacketScratch {
    /// Nothing remembered.
    pub fn new() -> PacketScratch {
        PacketScratch::default()
    }

    /// As [`TileScratch::set_early`]; rays that fly apart end as early as they can.
    pub fn set_early(&mut self, early: TileEarly) {
        self.tile.set_early(early);
    }

    /// As [`TileScratch::hit_seeds`].
    pub fn hit_seeds(&self, packet: &TilePacket) -> [NodeRef; crate::kernels::SEEDS] {
        self.tile.hit_seeds(packet)
    }

    /// The packets to come have nothing to do with those before.
    pub fn begin(&mut self) {
        self.pace = Pace::default();
    }
}

impl Traversal<'_> {
    /// First hits of the active rays of a packet; hits of other rays are left as they are. Like all functions for many
    /// rays, it returns how many pairs of a ray and a triangle exact arithmetic had to decide.
    pub fn intersect(&self, packet: &TilePacket, scratch: &mut PacketScratch, hits: &mut TileHits) -> u64 {
        let PacketScratch { tile, apart, pace } = scratch;
        let mut fly = || apart.get_or_insert_default().intersect(self, packet, hits);
        match self.choice {
            KernelChoice::Single => return fly(),
            KernelChoice::Auto if pace.flies_apart() => return fly(),
            KernelChoice::Auto => tile.set_budget(worth(packet)),
            KernelChoice::Tile => tile.set_budget(u32::MAX),
        }
        let doubts = self.kernels.tile_intersect(&self.view, packet, tile, hits);
        pace.tell(tile.gave_up());
        if !tile.gave_up() {
            return doubts;
        }
        doubts + apart.get_or_insert_default().intersect(self, packet, hits)
    }

    /// Which active rays of a packet are blocked within `tfar`, as bits like [`TilePacket::active`]. `seed` as in
    /// [`Kernels::tile_occluded`](crate::kernels::Kernels::tile_occluded).
    pub fn occluded(
        &self,
        packet: &TilePacket,
        scratch: &mut PacketScratch,
        seed: &mut NodeRef,
        blocked: &mut [u16; SUBS],
    ) -> u64 {
        let PacketScratch { tile, apart, pace } = scratch;
        match self.choice {
            KernelChoice::Auto if !pace.flies_apart() => tile.set_budget(worth(packet)),
            KernelChoice::Tile => tile.set_budget(u32::MAX),
            KernelChoice::Single | KernelChoice::Auto => {
                *blocked = [0; SUBS];
                return apart.get_or_insert_default().occluded(self, packet, blocked);
            }
        }
        let doubts = self.kernels.tile_occluded(&self.view, packet, tile, seed, blocked);
        pace.tell(tile.gave_up());
        if !tile.gave_up() {
            return doubts;
        }
        // Those that are known to be blocked are not traced again.
        doubts + apart.get_or_insert_default().occluded(self, packet, blocked)
    }

    /// Whether what is known from packets before can decide which way a packet goes, and that what its rays hit: what others
    /// than this tile's rays have left must be forgotten then.
    pub(super) fn depends_on_order(&self) -> bool {
        self.choice == KernelChoice::Auto && self.kernels.visibility() == Visibility::Fast
    }
}

/// The work that a packet is worth.
fn worth(packet: &TilePacket) -> u32 {
    packet.active.iter().map(|active| active.count_ones()).sum::<u32>() * WORTH
}

impl Default for Apart {
    fn default() -> Apart {
        Apart {
            blocks: [RayBlock::EMPTY; SUBS],
            hits: [HitBlock::MISS; SUBS],
            picks: vec![],
            flight: Flight::default(),
        }
    }
}

impl Apart {
    fn intersect(&mut self, traversal: &Traversal, packet: &TilePacket, hits: &mut TileHits) -> u64 {
        self.take(packet, &[0; SUBS]);
        let Apart { blocks, hits: found, picks, flight } = self;
        let doubts = traversal.intersect_each(blocks, picks, flight, found);
        for &Pick { block, active } in picks.iter() {
            let (found, first) = (&found[block as usize], block as usize * SUB);
            for lane in (0..SUB).filter(|lane| active >> lane & 1 != 0) {
                hits.set(first + lane, found.get(lane));
            }
        }
        doubts
    }

    /// Adds to `blocked`, whose rays are not traced.
    fn occluded(&mut self, traversal: &Traversal, packet: &TilePacket, blocked: &mut [u16; SUBS]) -> u64 {
        self.take(packet, blocked);
        let mut found = *blocked;
        let doubts = traversal.occluded_each(&self.blocks, &self.picks, &mut self.flight, &mut found);
        blocked.iter_mut().zip(found).for_each(|(blocked, found)| *blocked |= found);
        doubts
    }

    /// Takes the rays of a packet but for those that are `known`.
    fn take(&mut self, packet: &TilePacket, known: &[u16; SUBS]) {
        self.picks.clear();
        for (sub, block) in self.blocks.iter_mut().enumerate() {
            let active = packet.active[sub] & !known[sub];
            if active == 0 {
                continue;
            }
            for lane in (0..SUB).filter(|lane| active >> lane & 1 != 0) {
                block.set(lane, &packet.ray(sub * SUB + lane));
            }
            block.active = active;
            self.picks.push(Pick { block: sub as u32, active });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{BuildPreset, Bvh};
    use crate::camera::Camera;
    use crate::kernels::{Isa, Kernels, MISS, TILE_RAYS};

    /// A tree, and a packet that sees all of the scene, or a small part of it.
    fn with_packet(name: &str, side: u32, body: impl Fn(&Bvh, &TilePacket)) {
        let scene = crate::scene::load(name).unwrap();
        let bvh = Bvh::build(&scene.mesh, BuildPreset::Fast).unwrap();
        let camera = Camera::new(&scene.camera, side, side);
        let mut six = Box::new(std::array::from_fn(|_| TilePacket::new()));
        let middle = (side - 16) / 2;
        assert_eq!(camera.rays(&Kernels::detect(), [middle; 2], [16; 2], &mut six), 1, "one face");
        body(&bvh, &six[0]);
    }

    /// With a mark where nothing may be written.
    fn untouched() -> TileHits {
        let mut hits = TileHits::new();
        hits.prim = [MISS - 1; TILE_RAYS];
        hits
    }

    /// Rays end alternately before and behind what they hit; every fifth takes no part.
    fn bounded(packet: &TilePacket, hits: &TileHits) -> TilePacket {
        let mut bounded = packet.clone();
        bounded.bounded = true;
        for ray in 0..TILE_RAYS {
            bounded.tfar[ray] = hits.t[ray] * if ray % 2 == 0 { 0.99 } else { 1.01 };
            bounded.skip[ray] = if ray % 7 == 0 { hits.prim[ray] } else { MISS };
            if ray % 5 == 0 {
                bounded.active[ray / SUB] &= !(1 << (ray % SUB));
            }
        }
        bounded
    }

    #[test]
    fn hits_are_the_same_whichever_way_a_packet_goes() {
        for (name, side) in [("hairball@0.3", 16), ("hairball@0.1", 600), ("atrium@0.2", 64)] {
            with_packet(name, side, |bvh, packet| {
                for isa in Isa::available() {
                    let kernels = Kernels::for_isa(isa).unwrap().with_visibility(Visibility::Exact);
                    let traced = KernelChoice::ALL.map(|choice| {
                        let traversal = Traversal::new(bvh, kernels, choice);
                        let (mut scratch, mut hits) = (PacketScratch::new(), untouched());
                        traversal.intersect(packet, &mut scratch, &mut hits);
                        let ends = bounded(packet, &hits);
                        let (mut blocked, mut some) = ([0; SUBS], untouched());
                        traversal.intersect(&ends, &mut scratch, &mut some);
                        traversal.occluded(
                            &ends,
                            &mut scratch,
                            &mut super::super::NO_OCCLUDER.clone(),
                            &mut blocked,
                        );
                        let bits = |hits: &TileHits| {
                            let floats = hits.t.iter().chain(&hits.u).chain(&hits.v).map(|x| x.to_bits());
                            hits.prim.iter().copied().chain(floats).collect::<Vec<u32>>()
                        };
                        (bits(&hits), bits(&some), blocked)
                    });
                    assert!(traced[0] == traced[1], "{name} {side} {isa}: auto and tile");
                    assert!(traced[1] == traced[2], "{name} {side} {isa}: tile and single");
                    let some = traced[0].2.iter().map(|bits| bits.count_ones()).sum::<u32>();
                    assert!(some > 8 && some < 200, "{name} {side}: {some} blocked");
                }
            });
        }
    }

    #[test]
    fn packets_that_see_a_thicket_fly_apart_and_others_stay_together() {
        for isa in Isa::available() {
            let kernels = Kernels::for_isa(isa).unwrap();
            let flown = |bvh: &Bvh, packet: &TilePacket| {
                let traversal = Traversal::new(bvh, kernels, KernelChoice::Auto);
                let (mut scratch, mut hits) = (PacketScratch::new(), TileHits::new());
                traversal.intersect(packet, &mut scratch, &mut hits);
                (scratch.tile.gave_up(), scratch.apart.is_some(), scratch.pace.left)
            };
            with_packet("hairball@0.3", 16, |bvh, packet| {
                assert_eq!(flown(bvh, packet), (true, true, 1), "{isa}");
            });
            // More than a unit for each ray, but less than they are worth.
            with_packet("atrium@0.2", 64, |bvh, packet| {
                assert_eq!(flown(bvh, packet), (false, false, 0), "{isa}");
                let mut tile = TileScratch::new();
                kernels.tile_intersect(&bvh.view(), packet, &mut tile, &mut TileHits::new());
                assert!(tile.work() > 2 * TILE_RAYS as u32, "{isa}: {}", tile.work());
            });
        }
    }

    #[test]
    fn what_is_given_up_is_left_as_it_was_and_what_is_told_as_blocked_is_blocked() {
        with_packet("hairball@0.1", 64, |bvh, packet| {
            let kernels = Kernels::detect();
            let (view, mut tile, mut whole) = (bvh.view(), TileScratch::new(), untouched());
            kernels.tile_intersect(&view, packet, &mut tile, &mut whole);
            let work = tile.work();
            assert!(!tile.gave_up() && work > 100, "{work}");
            let mut hits = untouched();
            tile.set_budget(work / 2);
            kernels.tile_intersect(&view, packet, &mut tile, &mut hits);
            assert!(tile.gave_up() && hits.prim == [MISS - 1; TILE_RAYS]);
            assert!(tile.work() > work / 2 && tile.work() < work, "{}", tile.work());
            tile.set_budget(work);
            kernels.tile_intersect(&view, packet, &mut tile, &mut hits);
            assert!(!tile.gave_up() && hits.prim == whole.prim, "just enough");
            let ends = bounded(packet, &whole);
            let mut occluded = |budget| {
                let mut blocked = [0; SUBS];
                tile.set_budget(budget);
                kernels.tile_occluded(
                    &view,
                    &ends,
                    &mut tile,
                    &mut super::super::NO_OCCLUDER.clone(),
                    &mut blocked,
                );
                (blocked, tile.gave_up(), tile.work())
            };
            let (all, gave_up, work) = occluded(u32::MAX);
            assert!(!gave_up);
            let (some, gave_up, _) = occluded(work / 2);
            assert!(gave_up && some != all && some.iter().zip(all).all(|(some, all)| some & !all == 0));
        });
    }

    #[test]
    fn a_tile_knows_nothing_of_the_one_before() {
        with_packet("hairball@0.3", 16, |bvh, packet| {
            let traversal = Traversal::new(bvh, Kernels::detect(), KernelChoice::Auto);
            let (mut scratch, mut hits) = (PacketScratch::new(), TileHits::new());
            traversal.intersect(packet, &mut scratch, &mut hits);
            assert_ne!(scratch.pace, Pace::default());
            scratch.begin();
            assert_eq!(scratch.pace, Pace::default());
        });
    }

    #[test]
    fn packets_fly_apart_at_once_after_some_were_given_up() {
        let mut pace = Pace::default();
        let mut tried = vec![];
        for packet in 0..60 {
            if !pace.flies_apart() {
                tried.push(packet);
                pace.tell(packet < 40);
            }
        }
        // Packet 46 stays together, and so do those behind it.
        let expected: Vec<u32> = [0, 2, 6, 14, 30].into_iter().chain(46..60).collect();
        assert_eq!(tried, expected);
        pace.tell(true);
        assert_eq!(pace, Pace { left: 1, skips: 1 }, "neighbours begin again");
    }
}
