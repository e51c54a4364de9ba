//! The thesis' study of coherence: what consecutive rays have in common, and what remembering it saves.
//!
//! ```text
//!   scene, size -> shot: all rays, known hits
//!     order x (primary mode, shadow mode) -> passes: one ray after the other, counted, and timed without counting
//!       -> tables 1, 6 to 8 (what is the same), 9 and 10 (what it saves), caches for areas
//! ```
//!
//! `README.md` beside this file tells what came out. Every pass must find the hits of the tile kernel and block the rays
//! that the first pass blocked, so that all give one image: a difference is an error, not a footnote.

mod cache;
mod findings;
mod fit;
mod maps;
mod pass;
mod runs;
mod shot;
mod sweep;
mod tally;
mod thesis;
mod voorhies;

pub use cache::{Area, GRID, Shape, TILE};
pub use findings::{Finding, LIGHTS, LIKENESS, OCCLUDED, TRIANGLE_SIZE, findings};
pub use fit::Line;
pub use maps::{primary_map, shadow_map};
pub use pass::{Pass, PrimaryMode, ShadowMode};
pub use shot::{ShadowRays, Shot};
pub use sweep::{Point, Tests, sweep};
pub use tally::{PrimaryTally, ROWS, ShadowTally, gain, likeness};
pub use thesis::{
    counterpart, frames_per_second, primary as thesis_primary, shadow as thesis_shadow, technique_gain,
};
pub use voorhies::{Entries, entries_per_disc};

use crate::{
    bvh::{BuildPreset, Bvh},
    error::Result,
    kernels::{Isa, probe::Counts},
    render::choose_kernels,
    scene::Scene,
    shade::SurfaceTable,
    tile::{Order, pixels},
};
use runs::Runs;

/// What to measure.
#[derive(Clone, Debug)]
pub struct CoherenceOptions {
    /// Instruction set; `None` takes the widest one of this machine.
    pub isa: Option<Isa>,
    /// Quality of the tree.
    pub build: BuildPreset,
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// Orders to compare.
    pub orders: Vec<Order>,
    /// Walk the image tile by tile, so many pixels square, pixels of a tile in the same order as the tiles.
    pub tile: Option<u32>,
    /// Timed rounds; 0 counts only.
    pub rounds: u32,
    /// Which shadow rays there are.
    pub shadow_rays: ShadowRays,
    /// As [`ShadowMode::end_at_light`].
    pub end_at_light: bool,
    /// Compare caches for areas too.
    pub caches: bool,
}

/// A combination of early terminations as the thesis names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Technique {
    /// Its name.
    pub name: &'static str,
    /// Bound and seed.
    pub pet: bool,
    /// Stop at the first occluder.
    pub set: bool,
    /// Remember the occluder.
    pub occ: bool,
}

/// Those of the thesis (tables 9 and 10), and the one that it left out.
pub const TECHNIQUES: [Technique; 7] = [
    Technique { name: "base", pet: false, set: false, occ: false },
    Technique { name: "SET", pet: false, set: true, occ: false },
    Technique { name: "OCC", pet: false, set: false, occ: true },
    Technique { name: "PET", pet: true, set: false, occ: false },
    Technique { name: "SET-OCC", pet: false, set: true, occ: true },
    Technique { name: "OCC-PET", pet: true, set: false, occ: true },
    Technique { name: "SET-OCC-PET", pet: true, set: true, occ: true },
];

impl Technique {
    /// How it traces primary and shadow rays, with such a cache.
    pub fn modes(self, shape: Shape, end_at_light: bool) -> (PrimaryMode, ShadowMode) {
        let primary = PrimaryMode { bound: self.pet, seed: self.pet.then_some(shape) };
        (primary, ShadowMode { stop: self.set, seed: self.occ.then_some(shape), end_at_light })
    }
}

/// What passes over rays of one kind took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    /// Rays.
    pub rays: u64,
    /// Rays that met a seed.
    pub seeded: u64,
    /// Rays that entered the tree.
    pub traversals: u64,
    /// What they did there, and with seeds.
    pub counts: Counts,
    /// Seconds of each timed round.
    pub seconds: Vec<f64>,
}

impl Figures {
    /// Boxes and triangles tested.
    pub fn tests(&self) -> u64 {
        self.counts.boxes + self.counts.triangles
    }
}

/// A technique in one order with one kind of cache.
#[derive(Clone, Debug)]
pub struct Row {
    /// The technique.
    pub technique: Technique,
    /// Its cache.
    pub shape: Shape,
    /// Primary rays.
    pub primary: Figures,
    /// Shadow rays.
    pub shadow: Figures,
}

impl Row {
    /// Boxes and triangles tested for the whole image.
    pub fn tests(&self) -> u64 {
        self.primary.tests() + self.shadow.tests()
    }

    /// Seconds for the whole image, by round.
    pub fn seconds(&self) -> Vec<f64> {
        self.primary.seconds.iter().zip(&self.shadow.seconds).map(|(a, b)| a + b).collect()
    }

    /// All rays.
    pub fn rays(&self) -> u64 {
        self.primary.rays + self.shadow.rays
    }
}

/// One scene in one order.
#[derive(Clone, Debug)]
pub struct Walk {
    /// The order.
    pub order: Order,
    /// Table 1.
    pub primary: PrimaryTally,
    /// Tables 6 to 8.
    pub shadow: ShadowTally,
    /// The map of tables 6 to 8: lights by pixel, row by row.
    pub map: Vec<u16>,
    /// By technique.
    pub techniques: Vec<Row>,
    /// SET-OCC-PET by kind of cache.
    pub caches: Vec<Row>,
    /// Entries into discs.
    pub discs: Vec<Entries>,
}

/// One scene.
#[derive(Clone, Debug)]
pub struct SceneCoherence {
    /// Its name.
    pub scene: String,
    /// Triangles in it.
    pub triangles: usize,
    /// Its lights.
    pub lights: usize,
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// Shadow rays.
    pub shadow_rays: u64,
    /// Those blocked.
    pub blocked: u64,
    /// As [`likeness`].
    pub likeness: [f64; 2],
    /// Hash of the image that every pass gives.
    pub image_sha256: String,
    /// By order.
    pub walks: Vec<Walk>,
}

/// Measures a scene; `progress` is told what is done next.
///
/// # Errors
/// [`crate::error::Error::Flag`] for an instruction set that this machine lacks, [`crate::error::Error::Failed`] if the
/// tree cannot be built or a pass gives another image.
pub fn coherence(
    scene: &Scene,
    options: &CoherenceOptions,
    progress: impl Fn(&str),
) -> Result<SceneCoherence> {
    let kernels = choose_kernels(options.isa)?;
    scene.check()?;
    let bvh = Bvh::build(&scene.mesh, options.build)?;
    let table = SurfaceTable::new(scene);
    let shot = Shot::new(scene, &scene.camera, &bvh, &table, kernels, options.size, options.shadow_rays);
    let before = options.caches.then(|| {
        let camera = runs::a_moment_ago(&scene.camera);
        Shot::new(scene, &camera, &bvh, &table, kernels, options.size, options.shadow_rays)
    });
    let [width, height] = options.size;
    let orders: Vec<_> =
        options.orders.iter().map(|&order| (order, pixels(width, height, order, options.tile))).collect();
    let mut runs = Runs::new(&shot, before.as_ref(), options, &orders);
    let mut walks = (0..orders.len())
        .map(|index| {
            progress(&format!("{} order", orders[index].0));
            runs.walk(index)
        })
        .collect::<Result<Vec<Walk>>>()?;
    if options.rounds > 0 {
        progress("times");
        runs.time(&mut walks);
    }
    let base = &walks[0].techniques[0].shadow;
    Ok(SceneCoherence {
        scene: scene.name.clone(),
        triangles: scene.mesh.len(),
        lights: scene.lights.len(),
        size: options.size,
        shadow_rays: base.rays,
        blocked: runs.blocked(),
        likeness: likeness(&shot.hits, options.size[0]),
        image_sha256: runs.hash().into(),
        walks,
    })
}
