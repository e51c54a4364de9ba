//! The next generation: rays that go on from the surfaces, as far as they count.

use super::{
    Integrator, PathScratch, Sample,
    queue::{Kind, State},
    random::{Purpose, mix},
    scatter::{Bounce, Scatter},
    variant::Compiled,
};
use crate::{
    effects::Effect,
    kernels::{MISS, Ray},
    shade::surface::Planes,
};

/// Holes in a row after which rays end.
const LAYERS: u32 = 64;
/// Growth of a cone per unit of length after a diffuse reflection.
const DIFFUSE_SPREAD: f32 = 0.2;

impl Integrator<'_> {
    /// Puts the rays that go on into the queue: first those mirrored, then refracted, through holes, diffuse.
    pub(super) fn spread<V: Compiled>(&self, sample: &mut Sample) {
        if V::SCATTERS {
            self.scatter::<V>(sample);
        }
        if V::TEXTURES {
            self.go_through(sample);
        }
        if self.paths.set.has(Effect::IndirectLight) {
            self.bounce(sample);
        }
    }

    fn scatter<V: Compiled>(&self, sample: &mut Sample) {
        if V::GLOSSY {
            self.squares(sample, Purpose::Gloss as u32, 0, 1);
        }
        let Sample { surfaces, scratch, .. } = sample;
        let PathScratch { ground, squares, scattered: out, .. } = &mut **scratch;
        out.resize(surfaces.len());
        let (table, kernels) = (self.paths, self.traversal.kernels());
        match (V::GLOSSY, V::CLEAR) {
            (false, false) => kernels.run(Scatter::<false, false> { table, surfaces, ground, squares, out }),
            (false, true) => kernels.run(Scatter::<false, true> { table, surfaces, ground, squares, out }),
            (true, _) => kernels.run(Scatter::<true, true> { table, surfaces, ground, squares, out }),
        }
        self.push_scattered(sample, false);
        if V::CLEAR {
            self.push_scattered(sample, true);
        }
    }

    fn push_scattered(&self, sample: &mut Sample, refracted: bool) {
        let Sample { surfaces, scratch, .. } = sample;
        let PathScratch { ground, states, weight, queue, scattered, .. } = &mut **scratch;
        let settings = &self.paths.scene.settings;
        let (dirs, shares, starts) = match refracted {
            false => (&scattered.reflected, &scattered.reflectance, &ground.out),
            true => (&scattered.refracted, &scattered.transmittance, &ground.through),
        };
        for (ray, state) in states.iter().enumerate() {
            let prim = surfaces.prim[ray];
            if prim == MISS || state.depth >= settings.max_depth {
                continue;
            }
            let share = [0, 1, 2].map(|k| weight[k][ray] * ground.alpha[ray] * shares[k][ray]);
            if !counts(share, settings.cutoff) {
                continue;
            }
            let state = State { depth: state.depth + 1, ..onward(state, ground.distance[ray]) };
            let state = match refracted {
                false => State { kind: Kind::Reflection, unlit: false, key: mix(state.key, 1), ..state },
                true => State {
                    kind: Kind::Refraction,
                    key: mix(state.key, 2),
                    medium: match ground.side[ray] > 0.0 {
                        true => self.paths.scene.mesh.materials[prim as usize] + 1,
                        false => 0,
                    },
                    ..state
                },
            };
            queue.push(&ray_from(starts, dirs, ray, prim), state, share);
        }
    }

    /// Rays through holes go on as they came.
    fn go_through(&self, sample: &mut Sample) {
        let Sample { surfaces, scratch, .. } = sample;
        let PathScratch { ground, states, weight, queue, .. } = &mut **scratch;
        for (ray, state) in states.iter().enumerate() {
            let prim = surfaces.prim[ray];
            if prim == MISS || state.layers >= LAYERS {
                continue;
            }
            let share = [0, 1, 2].map(|k| weight[k][ray] * (1.0 - ground.alpha[ray]));
            if !counts(share, self.paths.scene.settings.cutoff) {
                continue;
            }
            let layers = state.layers + 1;
            let kind = if state.kind == Kind::Camera { Kind::Through } else { state.kind };
            let state = State { layers, kind, key: mix(state.key, 3), ..onward(state, ground.distance[ray]) };
            let mut through = ray_from(&ground.through, &surfaces.view, ray, prim);
            through.dir = through.dir.map(|x| -x);
            queue.push(&through, state, share);
        }
    }

    fn bounce(&self, sample: &mut Sample) {
        self.squares(sample, Purpose::Bounce as u32, 0, 1);
        let settings = &self.paths.scene.settings;
        let Sample { surfaces, scratch, .. } = sample;
        let PathScratch { ground, states, weight, queue, squares, bounced: dir, skip, .. } = &mut **scratch;
        dir.iter_mut().for_each(|plane| plane.resize(surfaces.len(), 0.0));
        skip.resize(surfaces.len(), MISS);
        self.traversal.kernels().run(Bounce { surfaces, ground, squares, dir, skip });
        for (ray, state) in states.iter().enumerate() {
            let prim = surfaces.prim[ray];
            if prim == MISS || state.bounces >= settings.bounces || (0..3).all(|k| dir[k][ray] == 0.0) {
                continue;
            }
            let share = [0, 1, 2].map(|k| weight[k][ray] * ground.alpha[ray] * surfaces.kd[k][ray]);
            if !counts(share, settings.cutoff) {
                continue;
            }
            let state = State {
                kind: Kind::Diffuse,
                unlit: true,
                depth: 0,
                bounces: state.bounces + 1,
                layers: 0,
                key: mix(state.key, 4),
                spread: DIFFUSE_SPREAD,
                ..onward(state, ground.distance[ray])
            };
            queue.push(&ray_from(&ground.out, dir, ray, skip[ray]), state, share);
        }
    }
}

/// Whether a ray that counts so much in its pixel is followed.
fn counts(share: [f32; 3], cutoff: f32) -> bool {
    let most = share[0].max(share[1]).max(share[2]);
    most > 0.0 && most >= cutoff
}

/// The state of a ray that starts where this one ended.
fn onward(state: &State, distance: f32) -> State {
    State { width: state.width + state.spread * distance, ..*state }
}

fn ray_from(starts: &Planes, dirs: &Planes, ray: usize, skip: u32) -> Ray {
    let of = |planes: &Planes| [planes[0][ray], planes[1][ray], planes[2][ray]];
    Ray { org: of(starts), dir: of(dirs), tnear: 0.0, tfar: f32::INFINITY, skip }
}
