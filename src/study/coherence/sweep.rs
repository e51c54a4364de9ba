//! The thesis' two open questions as data: under which conditions does each order win, and does a memory that covers an
//! area favour the Hilbert curve?
//!
//! ```text
//!   scene (detail) x size  ->  size of triangles in pixels
//!     light by light       ->  occluded share; more lights are sums of single ones, for their caches are their own
//!       order x cache      ->  a point: what is met, what is tested
//!         findings         ->  lines through gains, where they cross zero, how often each order wins
//! ```
//!
//! Everything here is counted, nothing timed: points are the same on every machine.

use super::{
    Technique,
    cache::{Area, Shape},
    pass::{Pass, PrimaryMode, ShadowMode, primary, shadow},
    shot::{ShadowRays, Shot},
    tally::{PrimaryTally, likeness},
};
use crate::{
    bvh::{BuildPreset, Bvh},
    error::Result,
    kernels::{Isa, probe::Counts},
    render::choose_kernels,
    scene::Scene,
    shade::SurfaceTable,
    tile::{Order, pixels},
};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Caches that are compared.
pub(super) const SHAPES: [(Area, usize); 8] = [
    (Area::Ray, 1),
    (Area::Ray, 2),
    (Area::Ray, 4),
    (Area::Tile, 1),
    (Area::Tile, 2),
    (Area::Tile, 4),
    (Area::Light, 1),
    (Area::Light, 4),
];

/// Counts of one light, or of primary rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tests {
    /// Rays.
    pub rays: u64,
    /// Rays that met a seed.
    pub seeded: u64,
    /// Boxes and triangles tested.
    pub tests: u64,
    /// Rays that are blocked, or hit anything.
    pub hit: u64,
}

/// One scene at one size in one order with one cache: SET-OCC-PET.
#[derive(Clone, Debug)]
pub struct Point {
    /// The scene with its detail.
    pub scene: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Order of the pixels.
    pub order: Order,
    /// The cache.
    pub shape: Shape,
    /// Pixels per triangle that is seen.
    pub pixels_per_triangle: f64,
    /// As [`likeness`].
    pub likeness: [f64; 2],
    /// Table 1.
    pub same: u64,
    /// Primary rays with PET.
    pub primary: Tests,
    /// Primary rays without.
    pub primary_base: Tests,
    /// By light: with SET and OCC, with OCC alone (only with the thesis' cache), with SET alone, with neither.
    pub lights: Vec<[Tests; 4]>,
}

impl Point {
    /// Shadow rays of all lights.
    pub fn shadow(&self) -> Tests {
        self.lights.iter().fold(Tests::default(), |sum, light| sum.plus(light[0]))
    }

    /// All tests of all rays.
    pub fn tests(&self) -> f64 {
        (self.primary.tests + self.shadow().tests) as f64
    }

    /// All tests of a technique with the first `count` lights.
    pub fn tests_of(&self, technique: Technique, count: usize) -> f64 {
        let which = match (technique.set, technique.occ) {
            (true, true) => 0,
            (false, true) => 1,
            (true, false) => 2,
            (false, false) => 3,
        };
        let primary = if technique.pet { self.primary } else { self.primary_base };
        let shadow: u64 = self.lights.iter().take(count).map(|light| light[which].tests).sum();
        (primary.tests + shadow) as f64
    }
}

impl Tests {
    fn plus(self, other: Tests) -> Tests {
        Tests {
            rays: self.rays + other.rays,
            seeded: self.seeded + other.seeded,
            tests: self.tests + other.tests,
            hit: self.hit + other.hit,
        }
    }

    fn of(pass: &Pass, hit: u64) -> Tests {
        let tests = pass.counts.boxes + pass.counts.triangles;
        Tests { rays: pass.rays, seeded: pass.seeded, tests, hit }
    }
}

/// Measures a scene at one size.
///
/// # Errors
/// As [`super::coherence`].
pub fn sweep(
    scene: &Scene,
    name: &str,
    size: [u32; 2],
    isa: Option<Isa>,
    build: BuildPreset,
) -> Result<Vec<Point>> {
    let kernels = choose_kernels(isa)?;
    scene.check()?;
    let bvh = Bvh::build(&scene.mesh, build)?;
    let table = SurfaceTable::new(scene);
    let shot = Shot::new(scene, &scene.camera, &bvh, &table, kernels, size, ShadowRays::Every);
    let rows = pixels(size[0], size[1], Order::Scanline, None);
    let base = primary_tests(&shot, &rows, PrimaryMode::default());
    // Without a cache the order does not matter.
    let set = lights(&shot, &rows, ShadowMode { stop: true, ..ShadowMode::default() });
    let none = lights(&shot, &rows, ShadowMode::default());
    let alike = likeness(&shot.hits, size[0]);
    let orders = Order::ALL.map(|order| {
        let pixels = pixels(size[0], size[1], order, None);
        let tally = PrimaryTally::new(&pixels, size[0], &shot.hits);
        (order, pixels, tally)
    });
    let point = |job: usize| {
        let (order, pixels, tally) = &orders[job / SHAPES.len()];
        let (area, entries) = SHAPES[job % SHAPES.len()];
        let shape = Shape { area, entries };
        let mode = |stop| ShadowMode { stop, seed: Some(shape), end_at_light: false };
        let all = lights(&shot, pixels, mode(true));
        let thesis = shape == Shape::THESIS;
        let occ = if thesis { lights(&shot, pixels, mode(false)) } else { vec![Tests::default(); all.len()] };
        Point {
            scene: name.into(),
            size,
            order: *order,
            shape,
            pixels_per_triangle: tally.hit as f64 / tally.triangles.max(1) as f64,
            likeness: alike,
            same: tally.same,
            primary: primary_tests(&shot, pixels, PrimaryMode { bound: true, seed: Some(shape) }),
            primary_base: base,
            lights: (0..all.len()).map(|i| [all[i], occ[i], set[i], none[i]]).collect(),
        }
    };
    Ok(each(orders.len() * SHAPES.len(), point))
}

/// What `job` gives for 0 to `count` - 1, in this order, on all cores: counts do not mind company.
fn each<T: Send>(count: usize, job: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let work = || {
        let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&at| at < count);
        std::iter::from_fn(take).map(|at| (at, job(at))).collect::<Vec<_>>()
    };
    let threads = std::thread::available_parallelism().map_or(1, |threads| threads.get());
    let mut done: Vec<(usize, T)> = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut done = work();
        for other in others {
            match other.join() {
                Ok(theirs) => done.extend(theirs),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        done
    });
    done.sort_by_key(|(at, _)| *at);
    done.into_iter().map(|(_, value)| value).collect()
}

fn primary_tests(shot: &Shot, pixels: &[(u32, u32)], mode: PrimaryMode) -> Tests {
    let pass = primary::<Counts>(shot, pixels, mode, None);
    let hit = pass.blocked().iter().filter(|&&hit| hit).count();
    Tests::of(&pass, hit as u64)
}

fn lights(shot: &Shot, pixels: &[(u32, u32)], mode: ShadowMode) -> Vec<Tests> {
    let light = |light| {
        let pass = shadow::<Counts>(shot, pixels, &[light], mode, None);
        let hit = pass.blocked().iter().filter(|&&hit| hit).count();
        Tests::of(&pass, hit as u64)
    };
    (0..shot.lights()).map(light).collect()
}
