//! A tile whose light is followed further than to the first surfaces.

use super::{
    RenderOptions,
    task::{RenderTask, Scratch, packet_corners},
};
use crate::{
    camera::{Camera, pixel_of},
    effects::{Effect, EffectChoice, EffectSet},
    kernels::{SUB, TILE_RAYS},
    scene::{DepthOfField, Scene},
    shade::{Disc, Integrator, Meter, PathTable, Purpose, Sample, Samples, SurfaceTable, Variant, pixel_key},
    tile::Tile,
    trace::Traversal,
};

/// Effects of materials that send rays on, so that a tile may show materials that are nowhere in it.
const SENDS_ON: [Effect; 5] =
    [Effect::Mirror, Effect::Glossy, Effect::Refraction, Effect::AlphaCutout, Effect::IndirectLight];

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
        options: &RenderOptions,
    ) -> Follow<'a> {
        let set = paths.set();
        let general = options.effects == EffectChoice::All;
        Follow {
            integrator: Integrator { table, paths, traversal, seed: options.seed },
            set,
            variant: if general { Variant::General } else { Variant::least(set) },
            specialise: !general,
            samples: if set.has(Effect::Antialiasing) { scene.settings.samples } else { 1 },
            lens: scene.settings.depth_of_field.filter(|_| set.has(Effect::DepthOfField)),
        }
    }

    /// Adds up the samples of a tile, and returns how many there were.
    pub(super) fn run(
        &self,
        task: &RenderTask,
        camera: &Camera,
        tile: Tile,
        scratch: &mut Scratch,
        meter: &mut Meter,
    ) -> u32 {
        let packets = packet_corners(tile).count();
        scratch.path.begin(packets * TILE_RAYS);
        for number in 0..self.samples {
            let pixels = packet_corners(tile).flat_map(|[left, top]| {
                (0..TILE_RAYS).map(move |ray| {
                    let (x, y) = pixel_of(ray);
                    [tile.x + left + x, tile.y + top + y]
                })
            });
            let in_image = pixels.clone().map(|pixel| camera.image_pixel(pixel));
            scratch.path.begin_sample(camera, in_image, self.integrator.seed);
            match self.lens {
                None => self.see(task, camera, tile, scratch, meter, number),
                Some(lens) => self.look_through(lens, camera, tile, scratch, pixels, number),
            }
            let mut sample = sample(scratch, meter, number);
            if self.lens.is_some() {
                self.integrator.trace(&mut sample);
            }
            let variant = self.variant_of(&sample);
            self.integrator.follow(variant, &mut sample, self.lens.is_none());
        }
        self.samples
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
        tile: Tile,
        scratch: &mut Scratch,
        meter: &mut Meter,
        number: u32,
    ) {
        let kernels = self.integrator.traversal.kernels();
        let mut places = [[0.0; TILE_RAYS]; 2];
        task.see_with(tile, scratch, meter, |_, at, inside, packets| {
            for ray in 0..TILE_RAYS {
                let (x, y) = pixel_of(ray);
                let pixel = camera.image_pixel([at[0] + x, at[1] + y]);
                let moved = self.place(pixel, number);
                for axis in 0..2 {
                    // From the image's first pixel on: rounded alike in every packet, so that the image has one hash.
                    places[axis][ray] = pixel[axis] as f32 + moved[axis];
                }
            }
            camera.jittered_rays(kernels, [0; 2], inside, &places, packets)
        });
    }

    /// Where in its pixel a sample lies, from the centre.
    fn place(&self, [x, y]: [u32; 2], number: u32) -> [f32; 2] {
        if self.samples == 1 {
            return [0.0; 2];
        }
        let key = pixel_key(x, y, self.integrator.seed);
        Samples::new(self.samples, key, Purpose::Pixel as u32).get(number).map(|at| at - 0.5)
    }

    /// Rays through a lens go into the queue.
    fn look_through(
        &self,
        lens: DepthOfField,
        camera: &Camera,
        tile: Tile,
        scratch: &mut Scratch,
        pixels: impl Iterator<Item = [u32; 2]>,
        number: u32,
    ) {
        let mut pixels = pixels.enumerate();
        scratch.path.begin_queue();
        loop {
            let mut some = [(0, [0; 2]); SUB];
            let count = some.iter_mut().zip(&mut pixels).map(|(slot, next)| *slot = next).count();
            if count == 0 {
                break;
            }
            let mut squares = [[0.0; SUB]; 2];
            for (lane, &(_, pixel)) in some[..count].iter().enumerate() {
                let [x, y] = camera.image_pixel(pixel);
                let key = pixel_key(x, y, self.integrator.seed);
                let square = Samples::new(self.samples, key, Purpose::Lens as u32).get(number);
                [squares[0][lane], squares[1][lane]] = square;
            }
            let [across, up] = self.integrator.traversal.kernels().run(Disc(&squares));
            for (lane, (ray, [x, y])) in some.into_iter().take(count).enumerate() {
                if x >= tile.x + tile.width || y >= tile.y + tile.height {
                    continue;
                }
                let [x, y] = camera.image_pixel([x, y]);
                let [dx, dy] = self.place([x, y], number);
                let at = [x as f32 + dx, y as f32 + dy];
                let ray_through = camera.lens_ray(at, [across[lane], up[lane]], lens.aperture, lens.focus);
                scratch.path.push_camera_ray(ray, &ray_through);
            }
        }
    }
}

fn sample<'a>(scratch: &'a mut Scratch, meter: &'a mut Meter, number: u32) -> Sample<'a> {
    let Scratch { surfaces, path, shadows, seeds, .. } = scratch;
    Sample { surfaces, scratch: path, shadows, seeds, meter, number }
}
