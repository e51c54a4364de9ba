//! Light of all sources, with their shadows.

use super::{
    Integrator, PathScratch, Sample,
    bright::Aim,
    draw::{Draw, DrawLines, DrawSquares},
    random::{Purpose, Samples, mix},
    sky,
    source::{Around, Arrive, Chosen, Connect, Source},
    table::PathTable,
};
use crate::{
    effects::Effect,
    kernels::{MISS, RayBlock, SUB},
    scene::{AreaLight, Light},
    shade::{add_light, add_tinted_light, light_rays_to},
    trace::{Traced, rays_in},
};
use glam::Vec3;

impl Integrator<'_> {
    /// Two numbers for each surface: sample `index` of `count`, for each sample of the pixel.
    pub(super) fn squares(&self, sample: &mut Sample, purpose: u32, index: u32, count: u32) {
        let PathScratch { states, squares, .. } = &mut *sample.scratch;
        squares.iter_mut().for_each(|plane| plane.resize(states.len(), 0.0));
        let samples = Samples::new(count * sample.samples, purpose);
        self.traversal.kernels().run(DrawSquares(Draw { states, samples, index, count }, squares));
    }

    /// Adds a light without extent.
    pub(super) fn light(&self, sample: &mut Sample, index: usize) {
        let light = &self.paths.scene.lights[index];
        let kernels = self.traversal.kernels();
        let Sample { surfaces, scratch, shadows, seeds, meter, .. } = sample;
        let PathScratch { ground, light_rays: rays, blocks, blocked, stream, filter, .. } = &mut **scratch;
        light_rays_to(kernels, self.table, surfaces, [&ground.end, &ground.horizon], light, rays);
        meter.shade();
        let shadowed = self.paths.set.has(Effect::HardShadows);
        let tinted = shadowed && self.paths.filters;
        let traced = match *light {
            _ if !shadowed => Traced::default(),
            Light::Point { position, .. } | Light::Spot { position, .. } if !self.paths.filters => {
                rays.trace_from(&self.traversal, position, shadows, &mut seeds[index])
            }
            _ => {
                rays.towards(light, surfaces, [&ground.end, &ground.out], blocks);
                rays.trace_blocks(blocks, blocked, |blocks, blocked| match tinted {
                    true => filter.trace(self.paths, &self.traversal, stream, blocks, blocked),
                    false => stream.occluded(&self.traversal, blocks, blocked),
                })
            }
        };
        meter.rays.shadow += traced.rays;
        meter.doubts.shadow += traced.doubts;
        meter.trace();
        match tinted {
            true => add_tinted_light(kernels, light, rays, &filter.tint, surfaces),
            false => add_light(kernels, light, rays, surfaces),
        }
    }

    /// Adds all lights with an extent, the emitting triangles and the sky.
    pub(super) fn extended_lights(&self, sample: &mut Sample) {
        let scene = self.paths.scene;
        let count = scene.settings.light_samples;
        let soft = self.paths.set.has(Effect::SoftShadows);
        for (index, light) in scene.area_lights.iter().enumerate().filter(|_| soft) {
            for i in 0..count {
                self.squares(sample, Purpose::Light as u32 + index as u32, i, count);
                self.connect(sample, Some(light), count);
            }
        }
        if !self.paths.shining.is_empty() {
            for i in 0..count {
                self.squares(sample, Purpose::Emitter as u32, i, count);
                self.choose(sample, i, count);
                self.connect(sample, None, count);
            }
        }
        if self.paths.set.has(Effect::EnvironmentLight) {
            for i in 0..count {
                self.sky_light(sample, i, count);
            }
        }
    }

    /// Adds one sample of an area light, or of the chosen triangles.
    fn connect(&self, sample: &mut Sample, light: Option<&AreaLight>, count: u32) {
        let Sample { surfaces, scratch, .. } = sample;
        let PathScratch { ground, squares, blocks, arriving, chosen, .. } = &mut **scratch;
        blocks.resize(surfaces.len() / SUB, RayBlock::EMPTY);
        arriving.iter_mut().for_each(|plane| plane.resize(surfaces.len(), 0.0));
        let source = light.map_or(Source::Triangles(chosen), |&light| Source::Area(light));
        self.traversal.kernels().run(Connect {
            surfaces,
            ground,
            source,
            squares,
            error: self.table.point_error,
            share: 1.0 / count as f32,
            blocks,
            arriving,
        });
        self.arrive::<true>(sample, light.is_none());
    }

    /// One sample of the light of the sky.
    fn sky_light(&self, sample: &mut Sample, index: u32, count: u32) {
        self.squares(sample, Purpose::Sky as u32, index, count);
        let Sample { surfaces, scratch, .. } = sample;
        let PathScratch { ground, squares, places, blocks, arriving, .. } = &mut **scratch;
        blocks.resize(surfaces.len() / SUB, RayBlock::EMPTY);
        let kernels = self.traversal.kernels();
        let bright = self.paths.bright.as_ref();
        if let Some(bright) = bright {
            bright.aim(squares, surfaces, places);
            kernels.run(Aim { surfaces, ground, squares, share: bright.share, places, blocks });
        } else {
            kernels.run(Around { surfaces, ground, squares, reach: f32::INFINITY, blocks });
        }
        arriving.iter_mut().for_each(|plane| plane.resize(surfaces.len(), 0.0));
        let share = 1.0 / count as f32;
        for (index, block) in blocks.iter().enumerate() {
            for lane in (0..SUB).filter(|lane| block.active >> lane & 1 != 0) {
                let dir = Vec3::from(block.ray(lane).dir);
                let mut radiance = share * sky::radiance(self.paths.scene, dir);
                if let Some(bright) = bright {
                    let normal = Vec3::from([0, 1, 2].map(|k| surfaces.ns[k][index * SUB + lane]));
                    radiance *= bright.weight(dir, normal);
                }
                for k in 0..3 {
                    arriving[k][index * SUB + lane] = radiance[k];
                }
            }
        }
        self.arrive::<false>(sample, false);
    }

    /// Traces the shadow rays and adds what arrives.
    fn arrive<const LAMBERT: bool>(&self, sample: &mut Sample, seen: bool) {
        let Sample { surfaces, scratch, meter, .. } = sample;
        let PathScratch { ground, blocks, blocked, arriving, stream, filter, .. } = &mut **scratch;
        blocked.clear();
        blocked.resize(blocks.len(), 0);
        meter.rays.shadow += rays_in(blocks);
        meter.shade();
        meter.doubts.shadow += if self.paths.filters {
            filter.trace(self.paths, &self.traversal, stream, blocks, blocked)
        } else {
            stream.occluded(&self.traversal, blocks, blocked)
        };
        meter.trace();
        self.traversal.kernels().run(Arrive::<LAMBERT> {
            surfaces,
            highlight: seen.then_some(&ground.highlight),
            blocks,
            blocked,
            arriving,
            tint: self.paths.filters.then_some(&filter.tint),
        });
    }

    /// Chooses a point of an emitting triangle for each surface.
    fn choose(&self, sample: &mut Sample, index: u32, count: u32) {
        let PathScratch { states, squares, lines, chosen, .. } = &mut *sample.scratch;
        lines.resize(states.len(), 0.0);
        let samples = Samples::new(count * sample.samples, mix(Purpose::Choice as u32, 0));
        self.traversal.kernels().run(DrawLines(Draw { states, samples, index, count }, lines));
        chosen.resize(states.len());
        for ray in 0..states.len() {
            if sample.surfaces.prim[ray] != MISS {
                chosen.set(ray, self.paths, lines[ray], [squares[0][ray], squares[1][ray]]);
            }
        }
    }
}

impl Chosen {
    /// A point of the triangle that `chance` chooses, uniform by `square`.
    fn set(&mut self, ray: usize, table: &PathTable, chance: f32, [u, v]: [f32; 2]) {
        let at = table.chances.partition_point(|&sum| sum <= chance).min(table.shining.len() - 1);
        let light = &table.shining[at];
        let root = u.sqrt();
        let (b1, b2) = (root * (1.0 - v), root * v);
        let point = light.corner + b1 * light.edges[0] + b2 * light.edges[1];
        let mut value = light.value;
        let optics = table.optics(light.prim);
        if let (Some(map), Some(chart)) = (optics.map_ke, table.charts.get(light.prim as usize)) {
            let texture = table.scene.textures[map as usize].sample(chart.at(b1, b2), 0.0);
            value *= Vec3::new(texture[0], texture[1], texture[2]);
        }
        for k in 0..3 {
            self.point[k][ray] = point[k];
            self.normal[k][ray] = light.normal[k];
            self.value[k][ray] = value[k];
        }
    }
}
