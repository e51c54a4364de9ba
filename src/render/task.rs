//! What a worker does with a tile.

use super::{
    RenderOptions,
    adaptive::Differences,
    follow::Follow,
    passes::Pass,
    scatter::Sums,
    seeds::{HitSeeds, NONE},
};
use crate::{
    bvh::Bvh,
    camera::{Camera, PACKET_SIDE, pixel_of},
    film::Film,
    kernels::{Kernels, NodeRef, RayBlock, SEEDS, TILE_RAYS, TileEarly, TileHits, TilePacket},
    scene::{Light, Scene},
    schedule::{FilmMode, TileTask},
    shade::{
        LightRays, Meter, PathScratch, PathTable, RayTally, Shot, SurfaceTable, Surfaces, add_light,
        light_rays,
    },
    tile::Tile,
    trace::{EarlyTermination, KernelChoice, NO_OCCLUDER, PacketScratch, PointShadows, RayStream, Traversal},
};
use std::time::Duration;

/// Everything that stays the same over many frames.
pub(super) struct RenderTask<'a> {
    scene: &'a Scene,
    table: &'a SurfaceTable,
    pub(super) traversal: Traversal<'a>,
    early: EarlyTermination,
    hit_seeds: HitSeeds,
    /// Where light is followed further than to the first surfaces.
    pub(super) follow: Option<Follow<'a>>,
    /// One sample of a pixel does without `follow`.
    plain_once: bool,
}

/// What belongs to one frame.
pub(super) struct Frame {
    pub(super) camera: Camera,
    pub(super) film: Film,
    pub(super) mode: FilmMode,
    pub(super) pass: Pass,
}

impl Frame {
    /// Master: adds a tile's report to `sum`, and its pixels to the film unless they are there.
    pub(super) fn collect(&self, tile: Tile, report: &TileReport, sum: &mut TileReport) {
        sum.add(report);
        if self.mode == FilmMode::Messages {
            let [r, g, b] = &report.pixels;
            self.film.write_tile(tile, r, g, b);
        }
    }
}

/// What a tile took, and its pixels.
#[derive(Clone, Debug, Default)]
pub(super) struct TileReport {
    pub(super) rays: RayTally,
    pub(super) doubts: RayTally,
    pub(super) trace: Duration,
    pub(super) shade: Duration,
    /// Red, green and blue, row by row, if they travel as a message.
    pixels: [Vec<f32>; 3],
}

impl TileReport {
    /// Takes the meter's figures instead of its own.
    pub(super) fn read(&mut self, meter: &Meter) {
        let Meter { rays, doubts, trace, shade, .. } = *meter;
        (self.rays, self.doubts, self.trace, self.shade) = (rays, doubts, trace, shade);
    }

    pub(super) fn add(&mut self, other: &TileReport) {
        self.rays.add(&other.rays);
        self.doubts.add(&other.doubts);
        self.trace += other.trace;
        self.shade += other.shade;
    }
}

/// Buffers of one worker.
pub(super) struct Scratch {
    pub(super) packets: Box<[TilePacket; 6]>,
    hits: Box<TileHits>,
    tile_scratch: PacketScratch,
    /// What the packet before has hit.
    hit_last: [NodeRef; SEEDS],
    pub(super) surfaces: Surfaces,
    light_rays: LightRays,
    pub(super) shadows: PointShadows,
    /// The last occluder of each light.
    pub(super) seeds: Vec<NodeRef>,
    /// Shadow rays of directional lights.
    blocks: Vec<RayBlock>,
    blocked: Vec<u16>,
    stream: RayStream,
    /// Where rays go on from the first surfaces.
    pub(super) path: PathScratch,
    pub(super) shots: Vec<Shot>,
    pub(super) differences: Differences,
    pub(super) sums: Sums,
    pub(super) pixels: [Vec<f32>; 3],
}

impl<'a> RenderTask<'a> {
    /// `paths` are followed for so many samples per pixel.
    pub(super) fn new(
        scene: &'a Scene,
        bvh: &'a Bvh,
        table: &'a SurfaceTable,
        paths: Option<(&'a PathTable<'a>, u32)>,
        plain_once: bool,
        kernels: Kernels,
        options: &RenderOptions,
    ) -> RenderTask<'a> {
        let RenderOptions { kernel, early, size, .. } = *options;
        // What is switched is the tile kernel.
        let switched = kernel == KernelChoice::Auto && early != EarlyTermination::default();
        let kernel = if switched { KernelChoice::Tile } else { kernel };
        let hit_seeds = HitSeeds::new(early, size);
        let traversal = Traversal::new(bvh, kernels, kernel);
        let follow =
            paths.map(|(paths, samples)| Follow::new(scene, table, paths, traversal, samples, options));
        RenderTask { scene, table, traversal, early, hit_seeds, follow, plain_once }
    }
}

impl TileTask for RenderTask<'_> {
    type Frame = Frame;
    type Scratch = Scratch;
    type Output = TileReport;

    fn scratch(&self, _worker: usize) -> Scratch {
        let mut shadows = PointShadows::default();
        shadows.set_early(self.early);
        Scratch {
            packets: Box::new(std::array::from_fn(|_| TilePacket::new())),
            hits: Box::new(TileHits::new()),
            tile_scratch: PacketScratch::new(),
            hit_last: NONE,
            surfaces: Surfaces::default(),
            light_rays: LightRays::default(),
            shadows,
            seeds: vec![NO_OCCLUDER; self.scene.lights.len()],
            blocks: Vec::new(),
            blocked: Vec::new(),
            stream: RayStream::default(),
            path: PathScratch::default(),
            shots: Vec::new(),
            differences: Differences::default(),
            sums: Sums::default(),
            pixels: [Vec::new(), Vec::new(), Vec::new()],
        }
    }

    fn run(&self, frame: &Frame, tile: Tile, scratch: &mut Scratch, report: &mut TileReport) {
        let mut meter = Meter::start();
        self.run_pass(&frame.pass, &frame.camera, tile, scratch, &mut meter);
        match frame.mode {
            FilmMode::Shared => {
                let [r, g, b] = &scratch.pixels;
                frame.film.write_tile(tile, r, g, b);
            }
            // The old buffers come back with the next message.
            FilmMode::Messages => std::mem::swap(&mut report.pixels, &mut scratch.pixels),
        }
        meter.shade();
        report.read(&meter);
    }
}

impl RenderTask<'_> {
    /// Leaves the colours of the tile's pixels in `scratch.pixels`, row by row, as far as a pass takes their samples.
    pub(super) fn run_pass(
        &self,
        pass: &Pass,
        camera: &Camera,
        tile: Tile,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        match pass {
            Pass::All => self.colour(camera, tile, scratch, meter),
            Pass::Corners => self.colour_once(&camera.of_corners(), tile, scratch, meter),
            Pass::Centres(_) => self.colour_once(camera, tile, scratch, meter),
            Pass::Refine(refining) => self.refine(camera, tile, refining, scratch, meter),
        }
    }

    /// Leaves the colours of the tile's pixels in `scratch.pixels`, row by row.
    pub(super) fn colour(&self, camera: &Camera, tile: Tile, scratch: &mut Scratch, meter: &mut Meter) {
        match &self.follow {
            Some(follow) => self.follow(follow, camera, tile, follow.samples(), scratch, meter),
            None => self.look(camera, tile, scratch, meter),
        }
    }

    /// The same by one sample through the centre of each pixel.
    pub(super) fn colour_once(&self, camera: &Camera, tile: Tile, scratch: &mut Scratch, meter: &mut Meter) {
        match &self.follow {
            Some(follow) if !self.plain_once => self.follow(follow, camera, tile, 1, scratch, meter),
            _ => self.look(camera, tile, scratch, meter),
        }
    }

    fn follow(
        &self,
        follow: &Follow,
        camera: &Camera,
        tile: Tile,
        samples: u32,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        follow.run(self, camera, tile, samples, scratch, meter);
        in_pixel_order(tile, scratch.path.finish(samples), &mut scratch.pixels);
    }

    /// The first surfaces and their lights, and nothing else.
    fn look(&self, camera: &Camera, tile: Tile, scratch: &mut Scratch, meter: &mut Meter) {
        self.see(camera, tile, scratch, meter);
        scratch.surfaces.finish(self.traversal.kernels());
        for (index, light) in self.scene.lights.iter().enumerate() {
            self.light(light, index, scratch, meter);
        }
        in_pixel_order(tile, &scratch.surfaces.color, &mut scratch.pixels);
    }

    /// Primary rays: fills the surfaces of the tile, packet by packet of 16x16 pixels.
    fn see(&self, camera: &Camera, tile: Tile, scratch: &mut Scratch, meter: &mut Meter) {
        let places = packet_corners(tile).map(|[x, y]| [tile.x + x, tile.y + y]);
        self.see_with(places, scratch, meter, false, |_, at, packets| {
            let inside = [tile.x + tile.width - at[0], tile.y + tile.height - at[1]];
            camera.rays(self.traversal.kernels(), at, inside, packets)
        });
        meter.rays.primary += tile.len() as u64;
    }

    /// The same for any packets: `rays` makes those of a packet, given its number and the pixel of `places` that is near
    /// them. To be followed, the hits have to be kept.
    pub(super) fn see_with(
        &self,
        places: impl Iterator<Item = [u32; 2]> + Clone,
        scratch: &mut Scratch,
        meter: &mut Meter,
        keep: bool,
        mut rays: impl FnMut(usize, [u32; 2], &mut [TilePacket; 6]) -> usize,
    ) {
        let Scratch { packets, hits, tile_scratch, hit_last, surfaces, path, .. } = scratch;
        let EarlyTermination { pet_bound: bound, pet_seed, area, .. } = self.early;
        tile_scratch.begin();
        tile_scratch.set_early(TileEarly { bound, ..TileEarly::ALL });
        surfaces.reset(places.clone().count(), self.scene.background.to_array());
        for (index, at) in places.enumerate() {
            let used = rays(index, at, packets);
            for packet in &packets[..used] {
                meter.shade();
                if pet_seed {
                    let seeds = if area > 0 { self.hit_seeds.get(at) } else { *hit_last };
                    tile_scratch.set_early(TileEarly { bound, seeds, ..TileEarly::ALL });
                }
                meter.doubts.primary += self.traversal.intersect(packet, tile_scratch, hits);
                if pet_seed {
                    *hit_last = tile_scratch.hit_seeds(packet);
                    self.hit_seeds.put(at, *hit_last);
                }
                meter.trace();
                surfaces.gather(self.traversal.kernels(), self.table, index, packet, hits);
                if keep {
                    path.keep(surfaces, index, packet, hits);
                }
            }
        }
    }

    /// Adds one light to the surfaces of the tile.
    fn light(&self, light: &Light, index: usize, scratch: &mut Scratch, meter: &mut Meter) {
        let Scratch { surfaces, light_rays: rays, shadows, seeds, blocks, blocked, stream, .. } = scratch;
        let kernels = self.traversal.kernels();
        light_rays(kernels, self.table, surfaces, light, rays);
        meter.shade();
        let traced = match *light {
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                rays.trace_from(&self.traversal, position, shadows, &mut seeds[index])
            }
            Light::Directional { direction, .. } => {
                rays.directional_blocks(surfaces, direction, blocks);
                let occluded =
                    |blocks: &_, blocked: &mut _| stream.occluded(&self.traversal, blocks, blocked);
                rays.trace_blocks(blocks, blocked, occluded)
            }
        };
        meter.rays.shadow += traced.rays;
        meter.doubts.shadow += traced.doubts;
        meter.trace();
        add_light(kernels, light, rays, surfaces);
    }
}

/// Corners of the 16x16-pixel packets of a tile, relative to the tile, row by row.
pub(super) fn packet_corners(tile: Tile) -> impl Iterator<Item = [u32; 2]> + Clone {
    let step = PACKET_SIDE as usize;
    let xs = move || (0..tile.width).step_by(step);
    (0..tile.height).step_by(step).flat_map(move |y| xs().map(move |x| [x, y]))
}

/// Rays of a packet that follow each other along a row of pixels: see [`pixel_of`].
const RUN: usize = 4;

/// Brings the colours from packet order into pixel order.
fn in_pixel_order(tile: Tile, colors: &[Vec<f32>; 3], pixels: &mut [Vec<f32>; 3]) {
    for (plane, colors) in pixels.iter_mut().zip(colors) {
        plane.resize(tile.len(), 0.0);
        for ([left, top], colors) in packet_corners(tile).zip(colors.chunks_exact(TILE_RAYS)) {
            // Four rays that follow each other are four pixels side by side.
            for (run, &colors) in colors.as_chunks::<RUN>().0.iter().enumerate() {
                let (x, y) = pixel_of(run * RUN);
                let (x, y) = (left + x, top + y);
                if y < tile.height && x < tile.width {
                    let at = (y * tile.width + x) as usize;
                    let count = RUN.min((tile.width - x) as usize);
                    match plane[at..at + count].as_mut_array() {
                        Some(whole) => *whole = colors,
                        None => plane[at..at + count].copy_from_slice(&colors[..count]),
                    }
                }
            }
        }
    }
}
