//! One way over the picture: all primary rays, or all shadow rays, one by one in order.
//!
//! The two need not be interleaved: the caches of primary rays know nothing of shadow rays, and each light has its own.
//! So a technique is a pair of passes, and what it takes is the sum of theirs.

use super::{
    cache::{Cache, MOST, Place, Shape},
    shot::Shot,
};
use crate::kernels::{
    Hit,
    probe::{Blocked, Closest, Counter, Counts, NO_TRIANGLE, ProbeScratch},
};

/// A counter that passes can be made with.
pub(super) trait Count: Counter + Default + Into<Counts> {}

impl<C: Counter + Default + Into<Counts>> Count for C {}

/// How primary rays are traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PrimaryMode {
    /// PET, first half: the nearest hit so far bounds the search.
    pub bound: bool,
    /// PET, second half: begin with what such a cache remembers.
    pub seed: Option<Shape>,
}

/// How shadow rays are traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowMode {
    /// SET: stop at the first occluder.
    pub stop: bool,
    /// OCC: begin with what such a cache remembers; one cache for each light.
    pub seed: Option<Shape>,
    /// End rays at the light, as any of today's ray tracers does; the thesis' do not know where it is until they are
    /// traced.
    pub end_at_light: bool,
}

impl ShadowMode {
    /// The quickest way without a cache.
    pub const STOP: ShadowMode = ShadowMode { stop: true, seed: None, end_at_light: true };
}

/// What a pass over rays of one kind found, all by pixel (shadow rays: and light).
#[derive(Clone, Debug, Default)]
pub struct Pass {
    /// Rays traced.
    pub rays: u64,
    /// Rays that met one of their seeds.
    pub seeded: u64,
    /// Rays for which the tree was entered.
    pub traversals: u64,
    /// What the traversals did.
    pub counts: Counts,
    /// First hits (primary rays).
    pub hits: Vec<Hit>,
    /// The triangle hit, or the one that blocks the ray, as the tree numbers them.
    pub slots: Vec<u32>,
    /// Per pixel: shadow rays that met a seed.
    pub successes: Vec<u16>,
}

impl Pass {
    /// Shadow rays that are blocked, by pixel, then light.
    pub fn blocked(&self) -> Vec<bool> {
        self.slots.iter().map(|&slot| slot != NO_TRIANGLE).collect()
    }

    /// Boxes and triangles tested, per ray.
    pub fn tests_per_ray(&self) -> f64 {
        (self.counts.boxes + self.counts.triangles) as f64 / self.rays.max(1) as f64
    }
}

/// Traces the primary rays of `pixels`, in that order. `before`: as in [`Cache::new`].
pub(super) fn primary<C: Count>(
    shot: &Shot,
    pixels: &[(u32, u32)],
    mode: PrimaryMode,
    before: Option<&[u32]>,
) -> Pass {
    let mut cache = mode.seed.map(|shape| Cache::new(shape, shot.size, before));
    let (mut scratch, mut counter) = (ProbeScratch::default(), C::default());
    let mut pass = Pass {
        hits: vec![Hit::MISS; shot.pixels()],
        slots: vec![NO_TRIANGLE; shot.pixels()],
        ..Pass::default()
    };
    for &(x, y) in pixels {
        let pixel = (y * shot.size[0] + x) as usize;
        let ray = &shot.primary[pixel];
        let place = Place { pixel: [x, y], ray, from_light: false };
        let found = shot.kernels.run(Closest {
            bvh: &shot.tree,
            ray,
            bound: mode.bound,
            seeds: cache.as_ref().map_or(&[], |cache| cache.seeds(place)),
            scratch: &mut scratch,
            counter: &mut counter,
        });
        pass.rays += 1;
        pass.traversals += 1;
        pass.seeded += u64::from(found.seeded);
        (pass.hits[pixel], pass.slots[pixel]) = (found.hit, found.slot);
        if let Some(cache) = &mut cache {
            cache.put(place, found.slot);
        }
    }
    pass.counts = counter.into();
    pass
}

/// Traces the shadow rays of `pixels`, in that order, for each pixel those of all `lights` in theirs. `before`: as in
/// [`Pass::slots`].
pub(super) fn shadow<C: Count>(
    shot: &Shot,
    pixels: &[(u32, u32)],
    lights: &[usize],
    mode: ShadowMode,
    before: Option<&[u32]>,
) -> Pass {
    let count = shot.lights();
    let mut caches: Vec<Option<Cache>> = (0..count)
        .map(|light| {
            let before: Option<Vec<u32>> =
                before.map(|slots| slots.iter().skip(light).step_by(count).copied().collect());
            mode.seed.map(|shape| Cache::new(shape, shot.size, before.as_deref()))
        })
        .collect();
    let (mut scratch, mut counter) = (ProbeScratch::default(), C::default());
    let mut pass = Pass {
        slots: vec![NO_TRIANGLE; shot.pixels() * count],
        successes: vec![0; shot.pixels()],
        ..Pass::default()
    };
    for &(x, y) in pixels {
        let pixel = (y * shot.size[0] + x) as usize;
        for &light in lights {
            let Some(ray) = shot.shadow_ray(pixel, light) else { continue };
            let place = Place { pixel: [x, y], ray: &ray, from_light: !shot.from_surface(light) };
            // The cache changes while its entries are in use.
            let mut seeds = [NO_TRIANGLE; MOST];
            let cache = &mut caches[light];
            if let Some(cache) = cache {
                let known = cache.seeds(place);
                seeds[..known.len()].copy_from_slice(known);
            }
            let found = shot.kernels.run(Blocked {
                bvh: &shot.tree,
                ray: &ray,
                from_surface: shot.from_surface(light),
                stop: mode.stop,
                beyond: !mode.end_at_light,
                seeds: &seeds,
                scratch: &mut scratch,
                counter: &mut counter,
            });
            pass.rays += 1;
            pass.seeded += u64::from(found.seeded);
            pass.traversals += u64::from(!found.seeded);
            pass.successes[pixel] += u16::from(found.seeded);
            pass.slots[pixel * count + light] = found.slot;
            if let Some(cache) = cache {
                cache.put(place, found.slot);
            }
        }
    }
    pass.counts = counter.into();
    pass
}
