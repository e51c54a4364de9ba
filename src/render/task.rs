//! What a worker does with a tile.

use super::{
    RayTally, RenderOptions,
    seeds::{HitSeeds, NONE},
};
use crate::{
    bvh::Bvh,
    camera::{Camera, PACKET_SIDE, pixel_of},
    film::Film,
    kernels::{Kernels, NodeRef, SEEDS, TILE_RAYS, TileEarly, TileHits, TilePacket, TileScratch},
    scene::{Light, Scene},
    schedule::{FilmMode, TileTask},
    shade::{LightRays, SurfaceTable, Surfaces, add_light, light_rays},
    tile::Tile,
    trace::{EarlyTermination, NO_OCCLUDER, PointShadows, ShadowRays, Traced, Traversal},
};
use std::time::{Duration, Instant};

/// Everything that stays the same over many frames.
pub(super) struct RenderTask<'a> {
    scene: &'a Scene,
    table: &'a SurfaceTable,
    traversal: Traversal<'a>,
    early: EarlyTermination,
    hit_seeds: HitSeeds,
}

/// What belongs to one frame.
pub(super) struct Frame {
    pub(super) camera: Camera,
    pub(super) film: Film,
    pub(super) mode: FilmMode,
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
    pub(super) fn add(&mut self, other: &TileReport) {
        self.rays.primary += other.rays.primary;
        self.rays.shadow += other.rays.shadow;
        self.doubts.primary += other.doubts.primary;
        self.doubts.shadow += other.doubts.shadow;
        self.trace += other.trace;
        self.shade += other.shade;
    }
}

/// Buffers of one worker.
pub(super) struct Scratch {
    packets: Box<[TilePacket; 6]>,
    hits: Box<TileHits>,
    tile_scratch: TileScratch,
    /// What the packet before has hit.
    hit_last: [NodeRef; SEEDS],
    surfaces: Surfaces,
    light_rays: LightRays,
    shadows: PointShadows,
    /// The last occluder of each light.
    seeds: Vec<NodeRef>,
    pixels: [Vec<f32>; 3],
}

impl<'a> RenderTask<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        bvh: &'a Bvh,
        table: &'a SurfaceTable,
        kernels: Kernels,
        options: &RenderOptions,
    ) -> RenderTask<'a> {
        let RenderOptions { kernel, early, size, .. } = *options;
        let hit_seeds = HitSeeds::new(early, size);
        RenderTask { scene, table, traversal: Traversal::new(bvh, kernels, kernel), early, hit_seeds }
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
            tile_scratch: TileScratch::new(),
            hit_last: NONE,
            surfaces: Surfaces::default(),
            light_rays: LightRays::default(),
            shadows,
            seeds: vec![NO_OCCLUDER; self.scene.lights.len()],
            pixels: [Vec::new(), Vec::new(), Vec::new()],
        }
    }

    fn run(&self, frame: &Frame, tile: Tile, scratch: &mut Scratch, report: &mut TileReport) {
        let mut clock = Clock::start();
        self.see(frame, tile, scratch, &mut clock);
        scratch.surfaces.finish(self.traversal.kernels());
        for (index, light) in self.scene.lights.iter().enumerate() {
            self.light(light, index, scratch, &mut clock);
        }
        in_pixel_order(tile, scratch);
        match frame.mode {
            FilmMode::Shared => {
                let [r, g, b] = &scratch.pixels;
                frame.film.write_tile(tile, r, g, b);
            }
            // The old buffers come back with the next message.
            FilmMode::Messages => std::mem::swap(&mut report.pixels, &mut scratch.pixels),
        }
        clock.shade();
        clock.report(report);
    }
}

impl RenderTask<'_> {
    /// Primary rays: fills the surfaces of the tile, packet by packet of 16x16 pixels.
    fn see(&self, frame: &Frame, tile: Tile, scratch: &mut Scratch, clock: &mut Clock) {
        let Scratch { packets, hits, tile_scratch, hit_last, surfaces, .. } = scratch;
        let EarlyTermination { pet_bound: bound, pet_seed, area, .. } = self.early;
        tile_scratch.set_early(TileEarly { bound, ..TileEarly::ALL });
        let corners = packet_corners(tile);
        surfaces.reset(corners.clone().count(), self.scene.background.to_array());
        for (index, [x, y]) in corners.enumerate() {
            let inside = [tile.width - x, tile.height - y];
            let at = [tile.x + x, tile.y + y];
            let used = frame.camera.rays(self.traversal.kernels(), at, inside, packets);
            for packet in &packets[..used] {
                clock.shade();
                if pet_seed {
                    let seeds = if area > 0 { self.hit_seeds.get(at) } else { *hit_last };
                    tile_scratch.set_early(TileEarly { bound, seeds, ..TileEarly::ALL });
                }
                clock.doubts.primary += self.traversal.intersect(packet, tile_scratch, hits);
                if pet_seed {
                    *hit_last = tile_scratch.hit_seeds(packet);
                    self.hit_seeds.put(at, *hit_last);
                }
                clock.trace();
                surfaces.gather(self.traversal.kernels(), self.table, index, packet, hits);
            }
        }
        clock.rays.primary += tile.len() as u64;
    }

    /// Adds one light to the surfaces of the tile.
    fn light(&self, light: &Light, index: usize, scratch: &mut Scratch, clock: &mut Clock) {
        let Scratch { surfaces, light_rays: rays, shadows, seeds, .. } = scratch;
        let kernels = self.traversal.kernels();
        light_rays(kernels, self.table, surfaces, light, rays);
        clock.shade();
        let traced = match *light {
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                let stream = ShadowRays {
                    u: &rays.u,
                    v: &rays.v,
                    tfar: &rays.limit,
                    skip: &surfaces.prim,
                    face: &rays.face,
                };
                let origin = position.to_array();
                shadows.trace(&self.traversal, origin, &stream, &mut seeds[index], &mut rays.visible)
            }
            Light::Directional { direction, .. } => {
                let mut traced = Traced::default();
                for i in 0..rays.visible.len() {
                    if rays.visible[i] > 0.0 {
                        traced.rays += 1;
                        let ray = rays.directional_ray(surfaces, i, direction);
                        if self.traversal.occluded_ray(&ray, &mut traced.doubts) {
                            rays.visible[i] = 0.0;
                        }
                    }
                }
                traced
            }
        };
        clock.rays.shadow += traced.rays;
        clock.doubts.shadow += traced.doubts;
        clock.trace();
        add_light(kernels, light, rays, surfaces);
    }
}

/// Corners of the 16x16-pixel packets of a tile, relative to the tile, row by row.
fn packet_corners(tile: Tile) -> impl Iterator<Item = [u32; 2]> + Clone {
    let step = PACKET_SIDE as usize;
    let xs = move || (0..tile.width).step_by(step);
    (0..tile.height).step_by(step).flat_map(move |y| xs().map(move |x| [x, y]))
}

/// Rays of a packet that follow each other along a row of pixels: see [`pixel_of`].
const RUN: usize = 4;

/// Brings the colours from packet order into pixel order.
fn in_pixel_order(tile: Tile, scratch: &mut Scratch) {
    let Scratch { surfaces, pixels, .. } = scratch;
    for (plane, colors) in pixels.iter_mut().zip(&surfaces.color) {
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

/// Splits a tile's time into tracing and the rest.
struct Clock {
    rays: RayTally,
    doubts: RayTally,
    trace: Duration,
    shade: Duration,
    last: Instant,
}

impl Clock {
    fn start() -> Clock {
        let (rays, none) = (RayTally::default(), Duration::ZERO);
        Clock { rays, doubts: rays, trace: none, shade: none, last: Instant::now() }
    }

    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - std::mem::replace(&mut self.last, now)
    }

    /// What happened since the last call was tracing.
    fn trace(&mut self) {
        let lap = self.lap();
        self.trace += lap;
    }

    /// What happened since the last call was anything else.
    fn shade(&mut self) {
        let lap = self.lap();
        self.shade += lap;
    }

    /// Replaces the figures of `report`.
    fn report(self, report: &mut TileReport) {
        let Clock { rays, doubts, trace, shade, .. } = self;
        (report.rays, report.doubts, report.trace, report.shade) = (rays, doubts, trace, shade);
    }
}
