//! `irt stability`: is visibility exact, on every kernel and instruction set, wherever the scene stands?
//!
//! ```text
//!   leaks    closed meshes, rays aimed at vertices, edges and beside them     must hit; the same bits from all kernels
//!   fuzz     all kinds of meshes, sizes and rays                              the same bits, and right by the oracle
//!   spawn    rays that start or end on a surface                              no self-hit, no neighbour lost
//!   images   kernels x threads x orders x schedules x tiles x trees           one hash
//! ```
//!
//! The kernels under test come as handles that carry everything about them, so that other accuracies of theirs are
//! tested by handing in other handles. What is random depends on the seed alone, never on the number of threads.

mod accuracy;
mod aim;
pub(super) mod double;
mod fuzz;
mod images;
mod kernel;
mod leaks;
pub mod mesh;
mod oracle;
mod peers;
mod random;
mod spawn;
mod tally;

pub use accuracy::{Accuracy, Errors};
pub use aim::{Form, direction};
pub use fuzz::{Fuzz, FuzzCell, is_finite, random_mesh, random_rays};
pub use images::{ImageCell, Images};
pub use kernel::{Answers, Batch, Kernel, Tracer, same};
pub use leaks::Leaks;
pub use peers::PeerCell;
pub use random::Random;
pub use spawn::{Offset, Spawn, SpawnCell};
pub use tally::{Cell, First, Place, Tally};

use super::bench::Engine;
use crate::{
    error::{Error, Result},
    kernels::Kernels,
};
use std::sync::atomic::{AtomicUsize, Ordering};

/// What to test, and how long.
#[derive(Clone, Debug)]
pub struct StabilityOptions {
    /// The kernels' handles, one for each instruction set; not empty.
    pub kernels: Vec<Kernels>,
    /// Ways to trace rays; not empty. One ray at a time is always among them, as the reference.
    pub ways: Vec<Kernel>,
    /// Engines beside irt at the closed meshes.
    pub engines: Vec<Engine>,
    /// Rays aimed at vertices and edges, over all cells.
    pub rays: u64,
    /// Meshes of the fuzzer.
    pub meshes: u64,
    /// Spawned rays, over all cells.
    pub spawned: u64,
    /// Images of each scene.
    pub images: u64,
    /// Threads.
    pub threads: usize,
    /// Seed of everything that is random.
    pub seed: u64,
}

impl StabilityOptions {
    /// The large battery: more than 10^8 aimed rays.
    pub const FULL: Amounts = Amounts { rays: 100_000_000, meshes: 30_000, spawned: 30_000_000, images: 300 };
    /// The small one, for every change.
    pub const QUICK: Amounts = Amounts { rays: 2_000_000, meshes: 600, spawned: 600_000, images: 100 };
}

/// How much of everything.
#[derive(Clone, Copy, Debug)]
pub struct Amounts {
    /// As [`StabilityOptions::rays`].
    pub rays: u64,
    /// As [`StabilityOptions::meshes`].
    pub meshes: u64,
    /// As [`StabilityOptions::spawned`].
    pub spawned: u64,
    /// As [`StabilityOptions::images`].
    pub images: u64,
}

/// What is being tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// What is done of it.
    pub done: u64,
    /// What there is to do.
    pub of: u64,
}

/// Everything found.
#[derive(Clone, Debug)]
pub struct Report {
    /// Closed meshes.
    pub leaks: Leaks,
    /// Meshes of all kinds.
    pub fuzz: Fuzz,
    /// Rays that start or end on surfaces.
    pub spawn: Spawn,
    /// The equality matrix.
    pub images: Images,
}

/// What all parts of the battery share.
struct Setup<'a> {
    kernels: Vec<Kernels>,
    ways: Vec<Kernel>,
    engines: Vec<Engine>,
    threads: usize,
    seed: u64,
    stopped: &'a (dyn Fn() -> bool + Sync),
}

/// Runs the battery. `tell` hears how far it is, `stopped` is asked now and then whether to give up.
///
/// # Errors
/// [`Error::Flag`] for an engine that cannot be had, [`Error::Interrupted`], [`Error::Failed`] if a tree cannot be
/// built.
pub fn run(
    options: &StabilityOptions,
    tell: &dyn Fn(Stage),
    stopped: &(dyn Fn() -> bool + Sync),
) -> Result<Report> {
    let mut ways = vec![Kernel::ALL[0]];
    ways.extend(options.ways.iter().filter(|&&kernel| kernel != Kernel::ALL[0]));
    let StabilityOptions { kernels, engines, threads, seed, .. } = options.clone();
    let setup = Setup { kernels, ways, engines, threads: threads.max(1), seed, stopped };
    let stage = |name, of| move |done| tell(Stage { name, done, of });
    Ok(Report {
        images: images::run(&setup, options.images, &stage("images", 2 * options.images))?,
        spawn: spawn::run(&setup, options.spawned, &stage("spawned rays", options.spawned))?,
        fuzz: fuzz::run(&setup, options.meshes, &stage("random meshes", options.meshes))?,
        leaks: leaks::run(&setup, options.rays, &stage("aimed rays", options.rays))?,
    })
}

/// What aimed and spawned rays of one way to trace found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Aimed {
    /// Rays at closed meshes, most of them aimed at vertices and edges.
    pub rays: u64,
    /// Those that went through.
    pub leaks: u64,
    /// Rays that started on a surface or ended there.
    pub spawned: u64,
    /// Those that met that surface.
    pub self_hits: u64,
    /// NaN among depths and weights.
    pub nan: u64,
}

/// Aims `rays` rays at the closed meshes and spawns as many as `spawned`, for each of `ways` together, with these kernels.
///
/// # Errors
/// As [`run`].
pub fn aimed(
    kernels: Kernels,
    ways: &[Kernel],
    [rays, spawned]: [u64; 2],
    threads: usize,
    stopped: &(dyn Fn() -> bool + Sync),
) -> Result<Aimed> {
    let (kernels, ways) = (vec![kernels], ways.to_vec());
    let setup = Setup { kernels, ways, engines: vec![], threads: threads.max(1), seed: 0, stopped };
    let leaks = leaks::run(&setup, rays, &|_| {})?;
    let spawn = spawn::run(&setup, spawned, &|_| {})?;
    let mut sum = Aimed::default();
    for cell in &leaks.cells {
        sum.rays += cell.tally.rays;
        sum.leaks += cell.tally.leaks;
        sum.nan += cell.tally.nan;
    }
    for cell in &spawn.cells {
        sum.spawned += cell.rays;
        sum.self_hits += cell.self_hits;
    }
    Ok(sum)
}

/// Does `count` pieces of work on threads; returns what each thread gathered.
pub(super) fn share<T: Send>(
    threads: usize,
    count: usize,
    start: impl Fn() -> T + Sync,
    work: impl Fn(&mut T, usize) + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let run = || {
            let mut state = start();
            loop {
                match next.fetch_add(1, Ordering::Relaxed) {
                    piece if piece < count => work(&mut state, piece),
                    _ => return state,
                }
            }
        };
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(run)).collect();
        let join = |thread: std::thread::ScopedJoinHandle<T>| {
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        threads.into_iter().map(join).collect()
    })
}

impl Report {
    /// Promises broken, by name.
    pub fn broken(&self) -> Vec<(&'static str, u64)> {
        let mut rays = Tally::default();
        self.leaks.cells.iter().for_each(|cell| rays.add(&cell.tally));
        self.fuzz.cells.iter().for_each(|cell| rays.add(&cell.tally));
        let mut judged = self.leaks.accuracy.clone();
        self.fuzz.cells.iter().for_each(|cell| judged.merge(cell.accuracy.clone()));
        let spawned = |count: fn(&SpawnCell) -> u64| self.spawn.cells.iter().map(count).sum::<u64>();
        let mut all = vec![
            ("leaks", rays.leaks),
            ("false rejections", rays.rejected),
            ("hits that differ between kernels", rays.differ),
            ("NaN", rays.nan + self.images.nan),
            ("hits where nothing is", judged.imagined),
            ("missed surfaces", judged.missed),
            ("inaccurate hits", judged.inaccurate),
            ("self-hits", spawned(|cell| cell.self_hits)),
            ("hits of the other half of a facet", spawned(|cell| cell.facet)),
            ("lost neighbours", spawned(|cell| cell.lost)),
            ("images that differ", self.images.differ),
        ];
        all.retain(|(_, count)| *count > 0);
        all
    }

    /// The first ray or image that broke a promise, in words.
    pub fn first(&self) -> Option<&str> {
        let all = [&self.leaks.first, &self.fuzz.first, &self.spawn.first, &self.images.first];
        all.into_iter().find_map(First::text)
    }

    /// The error of a battery that broke a promise.
    ///
    /// # Errors
    /// [`Error::Failed`] if one was broken.
    pub fn verdict(&self) -> Result<()> {
        let broken = self.broken();
        if broken.is_empty() {
            return Ok(());
        }
        let list: Vec<String> = broken.iter().map(|(name, count)| format!("{count} {name}")).collect();
        let first = self.first().unwrap_or("none is on record");
        Err(Error::Failed(format!("visibility is not exact: {}; the first: {first}", list.join(", "))))
    }
}
