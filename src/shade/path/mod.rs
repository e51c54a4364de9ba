//! Light followed beyond the first surface, a generation of rays at a time.
//!
//! ```text
//!   surfaces of a tile --dress--> textures, normals --light--> lights, areas, sky, ambient --weight--> sum of each pixel
//!        ^                                                                                   |
//!        +---- hits <--stream-- queue of rays <---scatter: mirrored, refracted, through holes, diffuse
//! ```
//!
//! There is no recursion: all rays of a generation wait in a queue and are traced together as a [`RayStream`]. A ray knows
//! its pixel and what its colour counts there. The colours of a pixel are added in the order of its own rays, so that
//! nothing depends on how rays are grouped. Paths end by depth, by the number of diffuse reflections, and where a ray counts less
//! than [`crate::scene::RenderSettings::cutoff`].
//!
//! What an effect needs per ray is compiled in or left out: see [`Variant`].

mod ambient;
mod bright;
mod draw;
mod filter;
mod ground;
mod lights;
mod material;
mod medium;
mod meter;
mod queue;
mod random;
mod scatter;
mod sky;
mod source;
mod spread;
mod table;
mod variant;
mod wide;

pub(crate) use ground::Ground;
pub use meter::{Meter, RayTally};
use random::pixel_key;
pub(crate) use random::{Purpose, Samples, pixel_keys};
pub(crate) use source::Disc;
pub use table::PathTable;
pub use variant::{PLAIN, Variant};

use super::{LightRays, SurfaceTable, Surfaces, surface::Planes};
use crate::{
    camera::Camera,
    effects::{Effect, EffectSet},
    kernels::{HitBlock, MISS, Ray, RayBlock, SUB, TILE_RAYS, TileHits, TilePacket},
    trace::{PointShadows, RayStream, Traversal},
};
use filter::Filter;
use ground::Stand;
use queue::{Kind, Queue, State};
use scatter::Scattered;
use source::{Chosen, Squares};
use variant::Compiled;

/// A scene ready to have light followed.
#[derive(Clone, Copy, Debug)]
pub struct Integrator<'a> {
    /// What shading needs of triangles.
    pub table: &'a SurfaceTable,
    /// What following light needs.
    pub paths: &'a PathTable<'a>,
    /// The tree.
    pub traversal: Traversal<'a>,
    /// Seed of all samples.
    pub seed: u64,
}

/// Buffers of one worker.
#[derive(Clone, Debug, Default)]
pub struct PathScratch {
    /// The surfaces of this generation.
    pub(crate) ground: Ground,
    /// What is known of the rays that came.
    states: Vec<State>,
    weight: Planes,
    queue: Queue,
    hits: Vec<HitBlock>,
    stream: RayStream,
    squares: Squares,
    places: Squares,
    lines: Vec<f32>,
    scattered: Scattered,
    bounced: Planes,
    skip: Vec<u32>,
    blocks: Vec<RayBlock>,
    blocked: Vec<u16>,
    arriving: Planes,
    chosen: Chosen,
    filter: Filter,
    open: Vec<f32>,
    light_rays: LightRays,
    /// Colours by slot.
    sum: Planes,
}

impl PathScratch {
    /// Begins a sum of colours for `len` pixels.
    pub(crate) fn begin(&mut self, len: usize) {
        for plane in &mut self.sum {
            plane.clear();
            plane.resize(len, 0.0);
        }
    }

    /// Begins some camera rays.
    pub(crate) fn begin_rays(&mut self, camera: &Camera, shots: &[Shot], seed: u64) {
        self.states.clear();
        self.states.extend(shots.iter().map(|&Shot { pixel: [x, y], number, slot, .. }| State {
            kind: Kind::Camera,
            unlit: false,
            depth: 0,
            bounces: 0,
            layers: 0,
            medium: 0,
            pixel: slot,
            number,
            key: pixel_key(x, y, seed),
            width: 0.0,
            spread: camera.spread(),
        }));
        for plane in &mut self.weight {
            plane.clear();
            plane.resize(self.states.len(), 1.0);
        }
        self.ground.resize(self.states.len());
    }

    /// Keeps what shading does not of packet number `index`: where rays hit within triangles, and where those fly that miss.
    pub(crate) fn keep(
        &mut self,
        surfaces: &mut Surfaces,
        index: usize,
        packet: &TilePacket,
        hits: &TileHits,
    ) {
        for ray in (0..TILE_RAYS).filter(|ray| packet.active[ray / SUB] >> (ray % SUB) & 1 != 0) {
            let (u, v) = (packet.u[ray], packet.v[ray]);
            let at = index * TILE_RAYS + ray;
            if hits.prim[ray] == MISS {
                let dir = packet.face.direction(u, v);
                surfaces.view.iter_mut().zip(dir).for_each(|(plane, dir)| plane[at] = dir);
            } else {
                let length = (1.0 + u * u + v * v).sqrt();
                self.ground.keep(at, [hits.u[ray], hits.v[ray]], hits.t[ray] * length);
            }
        }
    }

    /// Begins a queue of camera rays that are no packets.
    pub(crate) fn begin_queue(&mut self) {
        self.queue.clear();
    }

    /// Adds a ray to it: camera ray `index`.
    pub(crate) fn push_camera_ray(&mut self, index: usize, ray: &Ray) {
        self.queue.push(ray, self.states[index], [1.0; 3]);
    }

    /// What has been added up in some slots, by channel.
    pub(crate) fn sums(&self, slots: std::ops::Range<usize>) -> [&[f32]; 3] {
        let [r, g, b] = &self.sum;
        [&r[slots.clone()], &g[slots.clone()], &b[slots]]
    }

    /// The colours, with the mean over the samples taken.
    pub(crate) fn finish(&mut self, samples: u32) -> &Planes {
        if samples > 1 {
            let share = 1.0 / samples as f32;
            self.sum.iter_mut().flatten().for_each(|value| *value *= share);
        }
        &self.sum
    }
}

/// A camera ray to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shot {
    /// Where it goes through the image.
    pub(crate) pixel: [u32; 2],
    /// Which of the samples of its pixel it is.
    pub(crate) number: u32,
    /// Where its colour is added up.
    pub(crate) slot: u32,
    /// Others only fill up a packet.
    pub(crate) wanted: bool,
}

/// Camera rays while they are followed.
pub(crate) struct Sample<'a> {
    pub(crate) surfaces: &'a mut Surfaces,
    pub(crate) scratch: &'a mut PathScratch,
    pub(crate) shadows: &'a mut PointShadows,
    /// The last occluder of each light.
    pub(crate) seeds: &'a mut [crate::kernels::NodeRef],
    pub(crate) meter: &'a mut Meter,
    /// Camera rays per pixel.
    pub(crate) samples: u32,
}

impl Integrator<'_> {
    /// Effects that the materials of surfaces need.
    pub(crate) fn needs(&self, surfaces: &Surfaces) -> EffectSet {
        let mut last = MISS;
        let mut needs = EffectSet::EMPTY;
        for &prim in &surfaces.prim {
            if prim != last && prim != MISS {
                needs = needs.union(self.paths.optics(prim).needs);
                last = prim;
            }
        }
        needs
    }

    /// Follows the light of the camera rays whose hits `surfaces` and the ground hold (not finished yet), and adds it to the
    /// pixels. `points_given`: the surfaces have the hit points of packets.
    pub(crate) fn follow(&self, variant: Variant, sample: &mut Sample, points_given: bool) {
        match variant {
            Variant::Lit => self.generations::<variant::Lit>(sample, points_given),
            Variant::Textured => self.generations::<variant::Textured>(sample, points_given),
            Variant::Mirrors => self.generations::<variant::Mirrors>(sample, points_given),
            Variant::Glass => self.generations::<variant::Glass>(sample, points_given),
            Variant::General => self.generations::<variant::General>(sample, points_given),
        }
    }

    fn generations<V: Compiled>(&self, sample: &mut Sample, mut points_given: bool) {
        loop {
            self.shade::<V>(sample, points_given);
            self.collect(sample);
            sample.scratch.queue.clear();
            self.spread::<V>(sample);
            if sample.scratch.queue.len() == 0 {
                return;
            }
            self.trace(sample);
            points_given = false;
        }
    }

    /// Traces the queue: its hits become the surfaces.
    pub(crate) fn trace(&self, sample: &mut Sample) {
        let Sample { surfaces, scratch, meter, .. } = sample;
        let PathScratch { queue, hits, stream, states, weight, ground, .. } = &mut **scratch;
        hits.clear();
        hits.resize(queue.blocks.len(), HitBlock::MISS);
        for state in &queue.states {
            let count = match state.kind {
                Kind::Camera => &mut meter.rays.primary,
                Kind::Reflection => &mut meter.rays.reflection,
                Kind::Refraction | Kind::Through => &mut meter.rays.refraction,
                Kind::Diffuse => &mut meter.rays.indirect,
            };
            *count += 1;
        }
        meter.shade();
        let doubts = stream.intersect(&self.traversal, &queue.blocks, hits);
        meter.doubts.reflection += doubts;
        meter.trace();
        let len = queue.blocks.len() * SUB;
        std::mem::swap(states, &mut queue.states);
        std::mem::swap(weight, &mut queue.weight);
        // Lanes without a ray count nothing, and see nothing either: they have no direction, and 0 * NaN is NaN.
        if let Some(&last) = states.last() {
            states.resize(len, State { unlit: true, ..last });
        }
        weight.iter_mut().for_each(|plane| plane.resize(len, 0.0));
        surfaces.reset_len(len, self.paths.scene.background.to_array());
        ground.resize(len);
        surfaces.gather_blocks(self.traversal.kernels(), self.table, &queue.blocks, hits);
        ground.keep_blocks(hits);
    }

    /// All the light that leaves the surfaces towards where rays came from.
    fn shade<V: Compiled>(&self, sample: &mut Sample, points_given: bool) {
        let kernels = self.traversal.kernels();
        sample.surfaces.finish(kernels);
        self.stand(sample, points_given);
        if V::CLEAR {
            self.absorb(sample);
        }
        let sampled = !self.paths.shining.is_empty();
        let PathScratch { ground, states, .. } = &mut *sample.scratch;
        if V::TEXTURES {
            material::dress::<true>(self.paths, sample.surfaces, ground, states, sampled);
        } else {
            material::dress::<false>(self.paths, sample.surfaces, ground, states, sampled);
        }
        self.look_up(sample);
        self.ambient(sample);
        for index in 0..self.paths.scene.lights.len() {
            self.light(sample, index);
        }
        self.extended_lights(sample);
    }

    fn stand(&self, sample: &mut Sample, points_given: bool) {
        let Sample { surfaces, scratch, .. } = sample;
        let (table, paths, kernels) = (self.table, self.paths, self.traversal.kernels());
        let ground = &mut scratch.ground;
        let smooth = paths.scene.settings.smooth_terminator && paths.set.has(Effect::SmoothNormals);
        match (!points_given, smooth) {
            (false, false) => kernels.run(Stand::<false, false> { table, paths, surfaces, ground }),
            (false, true) => kernels.run(Stand::<false, true> { table, paths, surfaces, ground }),
            (true, false) => kernels.run(Stand::<true, false> { table, paths, surfaces, ground }),
            (true, true) => kernels.run(Stand::<true, true> { table, paths, surfaces, ground }),
        }
    }

    /// Colours of rays that hit nothing.
    fn look_up(&self, sample: &mut Sample) {
        let (set, scene) = (self.paths.set, self.paths.scene);
        let Sample { surfaces, scratch, .. } = sample;
        for (ray, state) in scratch.states.iter().enumerate() {
            if surfaces.prim[ray] != MISS || !(state.unlit || set.has(Effect::Sky)) {
                continue;
            }
            let dir = glam::Vec3::from([0, 1, 2].map(|k| -surfaces.view[k][ray]));
            let color = if state.unlit { glam::Vec3::ZERO } else { sky::radiance(scene, dir) };
            for k in 0..3 {
                surfaces.color[k][ray] = color[k];
            }
        }
    }

    /// Adds the colours to their pixels.
    fn collect(&self, sample: &mut Sample) {
        let Sample { surfaces, scratch, .. } = sample;
        let PathScratch { states, weight, ground, sum, .. } = &mut **scratch;
        for (ray, state) in states.iter().enumerate() {
            let alpha = if surfaces.prim[ray] == MISS { 1.0 } else { ground.alpha[ray] };
            for k in 0..3 {
                sum[k][state.pixel as usize] += weight[k][ray] * alpha * surfaces.color[k][ray];
            }
        }
    }
}
