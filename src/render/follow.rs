//! A tile whose light is followed further than to the first surfaces.

use super::{
    RenderOptions,
    task::{RenderTask, Scratch, packet_corners},
};
use crate::{
    camera::{Camera, pixel_of},
    effects::{Effect, EffectChoice, EffectSet},
    kernels::{SUB, SUBS, TILE_RAYS},
    scene::{DepthOfField, Scene},
    shade::{
        Disc, Integrator, Meter, PathTable, Purpose, Sample, Samples, Shot, SurfaceTable, Variant, pixel_key,
    },
    tile::Tile,
    trace::Traversal,
};

/// Effects of materials that send rays on, so that a tile may show materials that are nowhere in it.
const SENDS_ON: [Effect; 5] =
    [Effect::Mirror, Effect::Glossy, Effect::Refraction, Effect::AlphaCutout, Effect::IndirectLight];

/// Rays that are followed together where pixels are refined: four packets.
const BATCH: usize = 4 * TILE_RAYS;

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
        for number in 0..samples {
            let shots = rays.clone().zip(0..).map(|([x, y], slot)| Shot {
                pixel: camera.image_pixel([tile.x + x, tile.y + y]),
                number,
                slot,
                wanted: x < tile.width && y < tile.height,
            });
            scratch.shots.clear();
            scratch.shots.extend(shots);
            self.shoot(task, camera, samples, scratch, meter);
        }
    }

    /// Adds up all samples of pixels of the image; their slots are their places in `pixels`. Those of one pixel fly
    /// together: nothing is as coherent.
    pub(super) fn refine(
        &self,
        task: &RenderTask,
        camera: &Camera,
        pixels: &[[u32; 2]],
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        scratch.path.begin(pixels.len() + 1);
        // Never two parts of a pixel's samples in one batch: they are added in one order, whoever is beside them.
        let numbers = (self.samples as usize).min(BATCH);
        let together = BATCH / numbers;
        let nowhere = Shot { pixel: [0; 2], number: 0, slot: pixels.len() as u32, wanted: false };
        for (batch, some) in pixels.chunks(together).enumerate() {
            for first in (0..self.samples).step_by(numbers) {
                let numbers = first..self.samples.min(first + numbers as u32);
                scratch.shots.clear();
                for (&pixel, slot) in some.iter().zip((batch * together) as u32..) {
                    let shot = |number| Shot { pixel, number, slot, wanted: true };
                    scratch.shots.extend(numbers.clone().map(shot));
                }
                let whole = scratch.shots.len().next_multiple_of(TILE_RAYS);
                scratch.shots.resize(whole, nowhere);
                self.shoot(task, camera, self.samples, scratch, meter);
            }
        }
    }

    /// Follows the camera rays of `scratch.shots`, whole packets, and adds their colours to their slots.
    fn shoot(
        &self,
        task: &RenderTask,
        camera: &Camera,
        samples: u32,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        scratch.path.begin_rays(camera, &scratch.shots, self.integrator.seed);
        match self.lens {
            None => self.see(task, camera, samples, scratch, meter),
            Some(lens) => self.look_through(lens, camera, samples, scratch),
        }
        let mut sample = sample(scratch, meter, samples);
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
        samples: u32,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) {
        let kernels = self.integrator.traversal.kernels();
        let shots = std::mem::take(&mut scratch.shots);
        let corners = shots.chunks(TILE_RAYS).map(|packet| packet[0].pixel);
        let mut places = [[0.0; TILE_RAYS]; 2];
        task.see_with(corners, scratch, meter, true, |index, _, packets| {
            let mut wanted = [0; SUBS];
            for (ray, shot) in shots[index * TILE_RAYS..][..TILE_RAYS].iter().enumerate() {
                wanted[ray / SUB] |= u16::from(shot.wanted) << (ray % SUB);
                // From the image's first pixel on: rounded alike in every packet, so that the image has one hash.
                [places[0][ray], places[1][ray]] = self.place(shot, samples);
            }
            camera.jittered_rays(kernels, [0; 2], wanted, &places, packets)
        });
        meter.rays.primary += shots.iter().filter(|shot| shot.wanted).count() as u64;
        scratch.shots = shots;
    }

    /// Where a ray goes through the image, in pixels from the centre of the first one.
    fn place(&self, &Shot { pixel: [x, y], number, .. }: &Shot, samples: u32) -> [f32; 2] {
        let centre = [x as f32, y as f32];
        if samples == 1 {
            return centre;
        }
        let key = pixel_key(x, y, self.integrator.seed);
        let moved = Samples::new(samples, key, Purpose::Pixel as u32).get(number);
        [0, 1].map(|axis| centre[axis] + (moved[axis] - 0.5))
    }

    /// Rays through a lens go into the queue.
    fn look_through(&self, lens: DepthOfField, camera: &Camera, samples: u32, scratch: &mut Scratch) {
        scratch.path.begin_queue();
        for (block, shots) in scratch.shots.as_chunks::<SUB>().0.iter().enumerate() {
            let mut squares = [[0.0; SUB]; 2];
            for (lane, shot) in shots.iter().enumerate() {
                let key = pixel_key(shot.pixel[0], shot.pixel[1], self.integrator.seed);
                let square = Samples::new(samples, key, Purpose::Lens as u32).get(shot.number);
                [squares[0][lane], squares[1][lane]] = square;
            }
            let [across, up] = self.integrator.traversal.kernels().run(Disc(&squares));
            for (lane, shot) in shots.iter().enumerate().filter(|(_, shot)| shot.wanted) {
                let at = self.place(shot, samples);
                let ray = camera.lens_ray(at, [across[lane], up[lane]], lens.aperture, lens.focus);
                scratch.path.push_camera_ray(block * SUB + lane, &ray);
            }
        }
    }
}

fn sample<'a>(scratch: &'a mut Scratch, meter: &'a mut Meter, samples: u32) -> Sample<'a> {
    let Scratch { surfaces, path, shadows, seeds, .. } = scratch;
    Sample { surfaces, scratch: path, shadows, seeds, meter, samples }
}
