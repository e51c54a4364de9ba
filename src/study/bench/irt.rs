//! Our own kernels as modes.

use super::{Engine, RaySet, timer::Mode};
use crate::{
    bvh::Bvh,
    kernels::{
        Flight, HitBlock, Kernels, MISS, NodeRef, Pick, RayBlock, SUB, SUBS, TILE_RAYS, TileHits, TilePacket,
        Visibility,
    },
    study::bench::rays::{Kind, Stream},
    trace::{KernelChoice, NO_OCCLUDER, PacketScratch, PointShadows, RayStream, Traversal},
};

/// Blocks in a unit of general rays.
const UNIT: usize = 256;
/// Packets in a unit of packets.
const PACKETS: usize = 16;

/// All modes for a set of rays.
pub(super) fn modes<'a>(bvh: &'a Bvh, kernels: Kernels, set: &'a RaySet) -> Vec<Box<dyn Mode + 'a>> {
    let tile = Traversal::new(bvh, kernels, KernelChoice::Tile);
    let common = Common { traversal: tile, set };
    let mut modes: Vec<Box<dyn Mode + 'a>> = Vec::new();
    match set.kind() {
        Kind::Primary => modes.push(Box::new(Tiles(common))),
        Kind::Shadow => modes.push(Box::new(Streams(common))),
        Kind::Mirror | Kind::Diffuse | Kind::CommonDirection => modes.push(Box::new(Sorted(common))),
    }
    modes.push(Box::new(Flights(common)));
    modes
}

#[derive(Clone, Copy)]
struct Common<'a> {
    traversal: Traversal<'a>,
    set: &'a RaySet,
}

impl Common<'_> {
    fn isa(&self) -> String {
        self.traversal.kernels().isa().name().into()
    }

    fn visibility(&self) -> Option<Visibility> {
        Some(self.traversal.kernels().visibility())
    }
}

/// Primary packets through the common-origin kernel.
struct Tiles<'a>(Common<'a>);

impl Mode for Tiles<'_> {
    fn engine(&self) -> Engine {
        Engine::Irt
    }

    fn isa(&self) -> String {
        self.0.isa()
    }

    fn visibility(&self) -> Option<Visibility> {
        self.0.visibility()
    }

    fn kernel(&self) -> String {
        "tile".into()
    }

    fn width(&self) -> usize {
        TILE_RAYS
    }

    fn units(&self) -> usize {
        self.0.set.packets().len().div_ceil(PACKETS)
    }

    fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
        let mut results = vec![TileHits::new(); PACKETS];
        let mut scratch = PacketScratch::new();
        Box::new(move |unit| {
            let packets = self.0.set.packets().chunks(PACKETS).nth(unit).unwrap_or_default();
            let mut hits = 0;
            for (index, (packet, result)) in packets.iter().zip(&mut results).enumerate() {
                if let Some(next) = packets.get(index + 1) {
                    self.0.traversal.fetch(next);
                }
                self.0.traversal.intersect(packet, &mut scratch, result);
                hits += hits_of(packet, result);
            }
            hits
        })
    }
}

/// The number of active rays that hit something.
fn hits_of(packet: &TilePacket, hits: &TileHits) -> u64 {
    if packet.active == [u16::MAX; SUBS] {
        return u64::from(hits.prim.iter().map(|&prim| u32::from(prim != MISS)).sum::<u32>());
    }
    let active = |ray: &usize| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0;
    (0..TILE_RAYS).filter(active).filter(|&ray| hits.prim[ray] != MISS).count() as u64
}

/// Shadow streams, regrouped in light space, through the common-origin kernel.
struct Streams<'a>(Common<'a>);

impl Mode for Streams<'_> {
    fn engine(&self) -> Engine {
        Engine::Irt
    }

    fn isa(&self) -> String {
        self.0.isa()
    }

    fn visibility(&self) -> Option<Visibility> {
        self.0.visibility()
    }

    fn kernel(&self) -> String {
        "stream + tile".into()
    }

    fn width(&self) -> usize {
        TILE_RAYS
    }

    fn units(&self) -> usize {
        self.0.set.streams().len()
    }

    fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
        let mut shadows = PointShadows::default();
        let mut seeds: Vec<NodeRef> = Vec::new();
        let mut visible: Vec<f32> = Vec::new();
        Box::new(move |unit| {
            let stream: &Stream = &self.0.set.streams()[unit];
            if seeds.len() <= stream.light {
                seeds.resize(stream.light + 1, NO_OCCLUDER);
            }
            visible.clear();
            visible.resize(stream.len(), 1.0);
            let seed = &mut seeds[stream.light];
            shadows.trace(&self.0.traversal, stream.origin, &stream.view(), seed, &mut visible);
            visible.iter().filter(|&&visible| visible == 0.0).count() as u64
        })
    }
}

/// Rays in groups that fly together.
struct Sorted<'a>(Common<'a>);

impl Mode for Sorted<'_> {
    fn engine(&self) -> Engine {
        Engine::Irt
    }

    fn isa(&self) -> String {
        self.0.isa()
    }

    fn visibility(&self) -> Option<Visibility> {
        self.0.visibility()
    }

    fn kernel(&self) -> String {
        "stream".into()
    }

    fn width(&self) -> usize {
        SUB
    }

    fn units(&self) -> usize {
        self.0.set.blocks().len().div_ceil(UNIT)
    }

    fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
        let mut stream = RayStream::default();
        let Common { traversal, set } = self.0;
        general(set, move |blocks, results| {
            match results {
                Results::Hits(hits) => stream.intersect(&traversal, blocks, hits),
                Results::Blocked(blocked) => stream.occluded(&traversal, blocks, blocked),
            };
        })
    }
}

/// Rays that need have nothing in common.
struct Flights<'a>(Common<'a>);

impl Mode for Flights<'_> {
    fn engine(&self) -> Engine {
        Engine::Irt
    }

    fn isa(&self) -> String {
        self.0.isa()
    }

    fn visibility(&self) -> Option<Visibility> {
        self.0.visibility()
    }

    fn kernel(&self) -> String {
        "flight".into()
    }

    fn width(&self) -> usize {
        1
    }

    fn units(&self) -> usize {
        self.0.set.blocks().len().div_ceil(UNIT)
    }

    fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
        let mut flight = Flight::default();
        let Common { traversal, set } = self.0;
        let all: Vec<Pick> = (0..UNIT as u32).map(|block| Pick { block, active: u16::MAX }).collect();
        general(set, move |blocks, results| {
            let picks = &all[..blocks.len()];
            match results {
                Results::Hits(hits) => traversal.intersect_each(blocks, picks, &mut flight, hits),
                Results::Blocked(blocked) => traversal.occluded_each(blocks, picks, &mut flight, blocked),
            };
        })
    }
}

/// Where the results of general rays go.
enum Results<'a> {
    Hits(&'a mut [HitBlock]),
    Blocked(&'a mut [u16]),
}

/// Traces a unit of general rays with `trace` and counts those that hit.
fn general<'a>(
    set: &'a RaySet,
    mut trace: impl FnMut(&[RayBlock], Results) + 'a,
) -> Box<dyn FnMut(usize) -> u64 + 'a> {
    let occlusion = set.kind().occlusion();
    let mut hits = vec![HitBlock::MISS; UNIT];
    let mut blocked = vec![0; UNIT];
    Box::new(move |unit| {
        let blocks = set.blocks().chunks(UNIT).nth(unit).unwrap_or_default();
        if occlusion {
            let blocked = &mut blocked[..blocks.len()];
            blocked.fill(0);
            trace(blocks, Results::Blocked(blocked));
            return blocked.iter().map(|bits| u64::from(bits.count_ones())).sum();
        }
        let hits = &mut hits[..blocks.len()];
        trace(blocks, Results::Hits(hits));
        let count = |(block, hits): (&RayBlock, &HitBlock)| {
            let hit = |lane: usize| u32::from(hits.prim[lane] != MISS) << lane;
            let bits: u32 = (0..SUB).map(hit).sum();
            u64::from((bits & u32::from(block.active)).count_ones())
        };
        blocks.iter().zip(&*hits).map(count).sum()
    })
}
