//! Light that weakens inside a material.

use super::{Integrator, Sample, queue::State, table::PathTable, wide};
use crate::{
    kernels::{F32, Kernel, MISS, SUB, Simd},
    shade::{surface::Planes, trig::decay},
};

impl Integrator<'_> {
    /// Weakens the rays that came through a material, by Beer's law.
    pub(super) fn absorb(&self, sample: &mut Sample) {
        let scratch = &mut *sample.scratch;
        let kernel = Absorb {
            table: self.paths,
            prims: &sample.surfaces.prim,
            states: &scratch.states,
            distance: &scratch.ground.distance,
            weight: &mut scratch.weight,
        };
        self.traversal.kernels().run(kernel);
    }
}

struct Absorb<'a> {
    table: &'a PathTable<'a>,
    prims: &'a [u32],
    states: &'a [State],
    distance: &'a [f32],
    weight: &'a mut Planes,
}

impl Kernel for Absorb<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Absorb { table, prims, states, distance, weight } = self;
        for at in (0..prims.len()).step_by(SUB) {
            let mut depth = [[0.0; SUB]; 3];
            let mut any = false;
            for lane in 0..SUB {
                let medium = states[at + lane].medium;
                if medium != 0 && prims[at + lane] != MISS {
                    any = true;
                    let absorption = table.optics[medium as usize - 1].absorption;
                    for k in 0..3 {
                        depth[k][lane] = absorption[k] * distance[at + lane];
                    }
                }
            }
            if any {
                let depth = wide::load(s, &depth);
                for k in 0..3 {
                    (F32::load_at(s, &weight[k], at) * decay(s, depth[k])).store_at(&mut weight[k], at);
                }
            }
        }
    }
}
