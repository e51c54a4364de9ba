//! A tile whose light is followed further than to the first surfaces.

use super::{
    RenderOptions,
    places::{LensPlaces, Places},
    scatter::{Series, Sums},
    task::{RenderTask, Scratch, packet_corners},
};
use crate::{
    camera::{Camera, pixel_of},
    effects::{Effect, EffectChoice, EffectSet},
    kernels::{SUB, SUBS, TILE_RAYS},
    scene::{DepthOfField, Scene},
    shade::{Disc, Integrator, Meter, PathTable, Sample, Shot, SurfaceTable, Variant},
    tile::Tile,
    trace::Traversal,
};

/// Effects of materials that send rays on, so that a tile may show materials that are nowhere in it.
const SENDS_ON: [Effect; 5] =
    [Effect::Mirror, Effect::Glossy, Effect::Refraction, Effect::AlphaCutout, Effect::IndirectLight];

/// Rays that are followed together where pixels are refined: many, so that shadow rays find others beside them.
const BATCH: usize = 16 * TILE_RAYS;

/// How light is followed, over all frames.
pub(super) struct Follow<'a> {
    integrator: Integrator<'a>,
    /// The effects that are simulated.
    set: EffectSet,
    /// For the whole image.
    variant: Variant,
    /// Tiles may do with less.
    specialise: bool,
    /// Camera rays per pixel.
    samples: u32,
    lens: Option<DepthOfField>,
}

impl<'a> Follow<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        table: &'a SurfaceTable,
        paths: &'a PathTable<'a>,
        traversal: Traversal<'a>,
        samples: u32,
        options: &RenderOptions,
    ) -> Follow<'a> {
        let set = paths.set();
        let general = options.effects == EffectChoice::All;
        Follow {
            integrator: Integrator { table, paths, traversal, seed: options.seed },
            set,
            variant: if general { Variant::General } else { Variant::least(set) },
            specialise: !general,
            samples,
            lens: scene.settings.depth_of_field.filter(|_| set.has(Effect::DepthOfField)),
        }
    }

    /// Camera rays of a pixel.
    pub(super) fn samples(&self) -> u32 {
        self.samples
    }

    /// Adds up `samples` samples of each pixel of a tile.
    pub(super) fn run(
        &self,
        task: &RenderTask,
        camera: &Camera,
        tile: Tile,
        samples: u32,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        let rays = packet_corners(tile).flat_map(|[left, top]| {
            (0..TILE_RAYS).map(move |ray| {
                let (x, y) = pixel_of(ray);
                [left + x, top + y]
            })
        });
        scratch.path.begin(rays.clone().count());
        let series = Series { samples, seed: self.integrator.seed };
        for number in 0..samples {
            let shots = rays.clone().zip(0..).map(|([x, y], slot)| Shot {
                pixel: camera.image_pixel([tile.x + x, tile.y + y]),
                number,
                slot,
                wanted: x < tile.width && y < tile.height,
            });
            scratch.shots.clear();
            scratch.shots.extend(shots);
            self.shoot(task, camera, series, scratch, meter);
        }
    }

    /// Adds up samples of pixels of the image in `scratch.sums`: all of them where the first ones scatter by more than
    /// `least` allows, else only those.
    pub(super) fn refine(
        &self,
        task: &RenderTask,
        camera: &Camera,
        pixels: &[[u32; 2]],
        least: f32,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        let (first, rest) = Series::parts(self.samples, self.integrator.seed);
        let mut sums = std::mem::take(&mut scratch.sums);
        sums.begin(pixels.len());
        let mut left: Vec<u32> = (0..pixels.len() as u32).collect();
        self.gather(task, camera, first, pixels, &left, &mut sums, scratch, meter);
        if let Some(rest) = rest {
            left.retain(|&at| sums.scatters(at, least));
            self.gather(task, camera, rest, pixels, &left, &mut sums, scratch, meter);
        }
        scratch.sums = sums;
    }

    /// Adds the samples of a series to the sums of the `chosen` pixels. Those of one pixel fly together: nothing is as
    /// coherent.
    fn gather(
        &self,
        task: &RenderTask,
        camera: &Camera,
        series: Series,
        pixels: &[[u32; 2]],
        chosen: &[u32],
        sums: &mut Sums,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        // Never two parts of a pixel's samples in one batch: they are added in one order, whoever is beside them.
        let numbers = (series.samples as usize).min(BATCH);
        let nowhere = Shot { pixel: [0; 2], number: 0, slot: BATCH as u32, wanted: false };
        for some in chosen.chunks(BATCH / numbers) {
            for first in (0..series.samples).step_by(numbers) {
                let numbers = first..series.samples.min(first + numbers as u32);
                scratch.shots.clear();
                let shots = some.iter().flat_map(|&at| numbers.clone().map(move |number| (at, number)));
                scratch.shots.extend(shots.zip(0..).map(|((at, number), slot)| Shot {
                    pixel: pixels[at as usize],
                    number,
                    slot,
                    wanted: true,
                }));
                let whole = scratch.shots.len().next_multiple_of(TILE_RAYS);
                scratch.shots.resize(whole, nowhere);
                scratch.path.begin(BATCH + 1);
                self.shoot(task, camera, series, scratch, meter);
                for (samples, &at) in (0..).step_by(numbers.len()).zip(some) {
                    sums.add(at, scratch.path.sums(samples..samples + numbers.len()));
                }
            }
        }
    }

    /// Follows the camera rays of `scratch.shots`, whole packets, and adds their colours to their slots.
    fn shoot(
        &self,
        task: &RenderTask,
        camera: &Camera,
        series: Series,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        scratch.path.begin_rays(camera, &scratch.shots, series.seed);
        match self.lens {
            None => self.see(task, camera, series, scratch, meter),
            Some(lens) => self.look_through(lens, camera, series, scratch),
        }
        let mut sample = sample(scratch, meter, series.samples);
        if self.lens.is_some() {
            self.integrator.trace(&mut sample);
        }
        let variant = self.variant_of(&sample);
        self.integrator.follow(variant, &mut sample, self.lens.is_none());
    }

    /// The least variant that does for what is seen in the tile.
    fn variant_of(&self, sample: &Sample) -> Variant {
        if !self.specialise || self.variant == Variant::Lit || self.set.has(Effect::IndirectLight) {
            return self.variant;
        }
        let needs = self.integrator.needs(sample.surfaces);
        // Rays that go on may meet anything.
        if needs.has_any(&SENDS_ON) { self.variant } else { Variant::least(needs) }
    }

    /// Pinhole: packets, moved within their pixels if there are several samples.
    fn see(
        &self,
        task: &RenderTask,
        camera: &Camera,
        series: Series,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        let kernels = self.integrator.traversal.kernels();
        let shots = std::mem::take(&mut scratch.shots);
        let corners = shots.chunks(TILE_RAYS).map(|packet| packet[0].pixel);
        let mut places = [[0.0; TILE_RAYS]; 2];
        task.see_with(corners, scratch, meter, true, |index, _, packets| {
            let shots = &shots[index * TILE_RAYS..][..TILE_RAYS];
            let mut wanted = [0; SUBS];
            for (ray, shot) in shots.iter().enumerate() {
                wanted[ray / SUB] |= u16::from(shot.wanted) << (ray % SUB);
            }
            kernels.run(Places { shots, series, to: &mut places });
            camera.jittered_rays(kernels, [0; 2], wanted, &places, packets)
        });
        meter.rays.primary += shots.iter().filter(|shot| shot.wanted).count() as u64;
        scratch.shots = shots;
    }

    /// Rays through a lens go into the queue.
    fn look_through(&self, lens: DepthOfField, camera: &Camera, series: Series, scratch: &mut Scratch) {
        scratch.path.begin_queue();
        let kernels = self.integrator.traversal.kernels();
        for (block, shots) in scratch.shots.as_chunks::<SUB>().0.iter().enumerate() {
            let [[x, y], squares] = kernels.run(LensPlaces { shots, series });
            let [across, up] = kernels.run(Disc(&squares));
            for (lane, _) in shots.iter().enumerate().filter(|(_, shot)| shot.wanted) {
                let ray =
                    camera.lens_ray([x[lane], y[lane]], [across[lane], up[lane]], lens.aperture, lens.focus);
                scratch.path.push_camera_ray(block * SUB + lane, &ray);
            }
        }
    }
}

fn sample<'a>(scratch: &'a mut Scratch, meter: &'a mut Meter, samples: u32) -> Sample<'a> {
    let Scratch { surfaces, path, shadows, seeds, .. } = scratch;
    Sample { surfaces, scratch: path, shadows, seeds, meter, samples }
}
