//! Our own kernels as modes.

use super::{Engine, RaySet, timer::Mode};
use crate::{
    bvh::Bvh,
    kernels::{Flight, Hit, Kernels, MISS, NodeRef, SUB, SUBS, TILE_RAYS, TileHits, TilePacket, TileScratch},
    study::bench::rays::{Kind, Stream},
    trace::{KernelChoice, NO_OCCLUDER, PointShadows, RayStream, Traversal},
};

/// Rays in a unit of single rays.
const UNIT: usize = 4096;
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
        let mut scratch = TileScratch::new();
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

/// Rays sorted by direction.
struct Sorted<'a>(Common<'a>);

impl Mode for Sorted<'_> {
    fn engine(&self) -> Engine {
        Engine::Irt
    }

    fn isa(&self) -> String {
        self.0.isa()
    }

    fn kernel(&self) -> String {
        "stream".into()
    }

    fn width(&self) -> usize {
        1
    }

    fn units(&self) -> usize {
        self.0.set.len().div_ceil(UNIT)
    }

    fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
        let occlusion = self.0.set.kind().occlusion();
        let mut stream = RayStream::default();
        let mut hits = vec![Hit::MISS; UNIT];
        let mut blocked = vec![false; UNIT];
        Box::new(move |unit| {
            let rays = self.0.set.rays().chunks(UNIT).nth(unit).unwrap_or_default();
            if occlusion {
                let blocked = &mut blocked[..rays.len()];
                stream.occluded(&self.0.traversal, rays, blocked);
                return blocked.iter().filter(|&&blocked| blocked).count() as u64;
            }
            let hits = &mut hits[..rays.len()];
            stream.intersect(&self.0.traversal, rays, hits);
            hits.iter().filter(|hit| hit.prim != MISS).count() as u64
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

    fn kernel(&self) -> String {
        "flight".into()
    }

    fn width(&self) -> usize {
        1
    }

    fn units(&self) -> usize {
        self.0.set.len().div_ceil(UNIT)
    }

    fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
        let occlusion = self.0.set.kind().occlusion();
        let mut flight = Flight::default();
        let mut hits = vec![Hit::MISS; UNIT];
        let mut blocked = vec![false; UNIT];
        Box::new(move |unit| {
            let rays = self.0.set.rays().chunks(UNIT).nth(unit).unwrap_or_default();
            if occlusion {
                let blocked = &mut blocked[..rays.len()];
                self.0.traversal.occluded_each(rays, &mut flight, blocked);
                return blocked.iter().filter(|&&blocked| blocked).count() as u64;
            }
            let hits = &mut hits[..rays.len()];
            self.0.traversal.intersect_each(rays, &mut flight, hits);
            hits.iter().filter(|hit| hit.prim != MISS).count() as u64
        })
    }
}
