//! Ambient light, and what keeps it from surfaces.

use super::{Integrator, PathScratch, Sample, random::Purpose, source::Around};
use crate::{
    effects::Effect,
    kernels::{MISS, RayBlock, SUB},
    trace::rays_in,
};

impl Integrator<'_> {
    /// Colours become emission plus ambient light, as far as that gets to the surface.
    pub(super) fn ambient(&self, sample: &mut Sample) {
        let wanted = self.paths.scene.settings.ambient_occlusion;
        let wanted = wanted.filter(|_| self.paths.set.has(Effect::AmbientOcclusion));
        sample.scratch.open.clear();
        sample.scratch.open.resize(sample.surfaces.len(), 1.0);
        if let Some(of) = wanted {
            sample.scratch.open.fill(0.0);
            for index in 0..of.samples {
                self.look_around(sample, of.radius, index, of.samples);
            }
        }
        let Sample { surfaces, scratch, .. } = sample;
        let PathScratch { ground, open, .. } = &**scratch;
        for ray in 0..surfaces.len() {
            for k in (0..3).filter(|_| surfaces.prim[ray] != MISS) {
                surfaces.color[k][ray] = ground.ke[k][ray] + ground.ambient[k][ray] * open[ray];
            }
        }
    }

    /// One ray of each surface that looks whether something is near.
    fn look_around(&self, sample: &mut Sample, reach: f32, index: u32, count: u32) {
        self.squares(sample, Purpose::Ambient as u32, index, count);
        let Sample { surfaces, scratch, meter, .. } = sample;
        let PathScratch { ground, squares, blocks, blocked, stream, open, .. } = &mut **scratch;
        blocks.resize(surfaces.len() / SUB, RayBlock::EMPTY);
        let kernels = self.traversal.kernels();
        kernels.run(Around { surfaces, ground, squares, reach, blocks });
        meter.rays.ambient += rays_in(blocks);
        blocked.clear();
        blocked.resize(blocks.len(), 0);
        meter.shade();
        meter.doubts.ambient += stream.occluded(&self.traversal, blocks, blocked);
        meter.trace();
        let share = 1.0 / count as f32;
        for (index, (block, blocked)) in blocks.iter().zip(&*blocked).enumerate() {
            let free = block.active & !blocked;
            for lane in 0..SUB {
                open[index * SUB + lane] += share * f32::from(free >> lane & 1);
            }
        }
    }
}
