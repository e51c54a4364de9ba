//! Traversal kernels side by side: the same rays, the same process, interleaved rounds.
//!
//! Only traversal is timed: rays lie ready in the form that each engine takes, and hits go to memory. What an engine
//! needs beyond that to be fast, such as sorting, counts as traversal. A mode is a way to use an engine (kernel,
//! width, flags); after the first round, modes that reached less than half of their engine's best are left out, so
//! that the rounds go to those that could be it.
//!
//! An engine whose number of hits differs by more than [`TOLERANCE`] of the rays is marked wrong.

mod builds;
mod irt;
pub mod micro;
pub(super) mod peers;
mod rays;
mod timer;

pub use builds::{BuildRow, builds};
pub use micro::{MicroRow, micro, micro_verdict};
pub use rays::{Kind, RaySet, Seen};

use crate::{
    bvh::{BuildPreset, Bvh},
    error::{Error, Result},
    kernels::{Isa, Visibility},
    render::choose_kernels,
    scene::Scene,
};
use std::{fmt, str::FromStr};
use timer::Mode;

/// Engines may disagree about this fraction of the rays: those that pass through edges, where the others are not
/// exact.
pub const TOLERANCE: f64 = 1.0e-4;

/// What traces the rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// This project.
    Irt,
    /// The traversal of the crate that builds our binary trees.
    Obvhs,
    /// Intel's library, opened at run time; needs the feature `embree`.
    Embree,
}

impl Engine {
    /// All engines.
    pub const ALL: [Engine; 3] = [Engine::Irt, Engine::Obvhs, Engine::Embree];

    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Engine::Irt => "irt",
            Engine::Obvhs => "obvhs",
            Engine::Embree => "embree",
        }
    }
}

impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Engine {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Engine, String> {
        Engine::ALL
            .into_iter()
            .find(|engine| engine.name() == text)
            .ok_or_else(|| format!("unknown engine '{text}'; use irt, obvhs or embree"))
    }
}

/// What to measure.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// Kinds of rays.
    pub kinds: Vec<Kind>,
    /// Engines.
    pub engines: Vec<Engine>,
    /// Instruction set that irt and Embree are restricted to; `None` takes the widest.
    pub isa: Option<Isa>,
    /// Ways in which irt decides hits, at least one; all are measured. The rays are always those of exact hits.
    pub visibility: Vec<Visibility>,
    /// Timed rounds after the warm-up, >= 1.
    pub rounds: u32,
    /// Threads that trace, >= 1.
    pub threads: usize,
    /// Pin each thread to a core.
    pub pin: bool,
    /// Size of the image whose rays are traced.
    pub size: [u32; 2],
    /// Quality of our tree.
    pub build: BuildPreset,
}

/// One mode of one engine on one kind of rays.
#[derive(Clone, Debug)]
pub struct Row {
    /// Scene.
    pub scene: String,
    /// Kind of rays.
    pub kind: Kind,
    /// Engine.
    pub engine: Engine,
    /// Instruction set.
    pub isa: String,
    /// Kernel or mode of the engine.
    pub kernel: String,
    /// How hits are decided; `None` for other engines than irt.
    pub visibility: Option<Visibility>,
    /// Rays per call.
    pub width: usize,
    /// Threads.
    pub threads: usize,
    /// Rays per round.
    pub rays: u64,
    /// Rays that hit something, or are blocked.
    pub hits: u64,
    /// Millions of rays per second, round by round.
    pub mrays_per_s: Vec<f64>,
    /// True if the number of hits agrees with irt's.
    pub agrees: bool,
}

/// Finds out early what [`bench`] would stumble over for every scene.
///
/// # Errors
/// [`Error::Flag`] for an engine or instruction set that this machine or build lacks.
pub fn check(options: &BenchOptions) -> Result<()> {
    choose_kernels(options.isa)?;
    check_engines(&options.engines)
}

/// Finds out whether all engines can be had.
///
/// # Errors
/// [`Error::Flag`] if one of them cannot.
pub fn check_engines(engines: &[Engine]) -> Result<()> {
    peers::check(engines)
}

/// Measures all kinds on one scene; `tell` hears of each kind before it is measured.
///
/// # Errors
/// As [`check`], and [`Error::Failed`] if the tree cannot be built.
pub fn bench(scene: &Scene, options: &BenchOptions, mut tell: impl FnMut(Kind)) -> Result<Vec<Row>> {
    let kernels = choose_kernels(options.isa)?;
    scene.check()?;
    let bvh = Bvh::build(&scene.mesh, options.build)?;
    let peers = peers::Peers::new(scene, options)?;
    let seen = Seen::new(scene, &bvh, kernels, options.size);
    let mut rows = Vec::new();
    for &kind in &options.kinds {
        let set = RaySet::new(kind, scene, &seen);
        if set.is_empty() {
            continue;
        }
        tell(kind);
        let mut modes = Vec::new();
        for engine in &options.engines {
            match engine {
                Engine::Irt => {
                    for &visibility in &options.visibility {
                        modes.extend(irt::modes(&bvh, kernels.with_visibility(visibility), &set));
                    }
                }
                Engine::Obvhs | Engine::Embree => modes.extend(peers.modes(*engine, &set)),
            }
        }
        rows.extend(measure(scene, &set, modes, options));
    }
    Ok(rows)
}

/// Interleaved rounds over all modes of one set of rays.
fn measure(
    scene: &Scene,
    set: &RaySet,
    mut modes: Vec<Box<dyn Mode + '_>>,
    options: &BenchOptions,
) -> Vec<Row> {
    let mut samples = vec![Vec::new(); modes.len()];
    let mut hits = vec![0; modes.len()];
    let mut running = vec![true; modes.len()];
    for round in 0..=options.rounds {
        for (index, mode) in modes.iter_mut().enumerate().filter(|(index, _)| running[*index]) {
            let (seconds, found) = timer::time(mode.as_mut(), options.threads, options.pin);
            hits[index] = found;
            // The first round warms up; its figures stay only for modes that are left out after it.
            if round == 1 {
                samples[index].clear();
            }
            samples[index].push(set.len() as f64 / seconds / 1.0e6);
        }
        if round == 0 {
            for (index, mode) in modes.iter().enumerate() {
                let best = (0..modes.len())
                    .filter(|&other| modes[other].engine() == mode.engine())
                    .filter(|&other| modes[other].visibility() == mode.visibility())
                    .map(|other| samples[other][0])
                    .fold(0.0, f64::max);
                running[index] = samples[index][0] >= 0.5 * best;
            }
        }
    }
    let ours = modes.iter().position(|mode| mode.engine() == Engine::Irt);
    let reference = hits[ours.unwrap_or(0)];
    let tolerance = TOLERANCE * set.len() as f64;
    (0..modes.len())
        .map(|i| Row {
            scene: scene.name.clone(),
            kind: set.kind(),
            engine: modes[i].engine(),
            isa: modes[i].isa(),
            kernel: modes[i].kernel(),
            visibility: modes[i].visibility(),
            width: modes[i].width(),
            threads: options.threads,
            rays: set.len() as u64,
            hits: hits[i],
            mrays_per_s: std::mem::take(&mut samples[i]),
            agrees: hits[i].abs_diff(reference) as f64 <= tolerance,
        })
        .collect()
}

/// The fastest mode of each engine and visibility for each scene and kind, of those that ran all rounds: a mode that was
/// left out after the warm-up has one figure only, and where the warm-up of the others was disturbed it would win.
pub fn best_rows(rows: &[Row]) -> Vec<Row> {
    let mut best: Vec<&Row> = Vec::new();
    for row in rows {
        let rival = |other: &&mut &Row| {
            (&other.scene, other.kind, other.engine, other.visibility)
                == (&row.scene, row.kind, row.engine, row.visibility)
        };
        match best.iter_mut().find(rival) {
            None => best.push(row),
            Some(other) if row.standing() > other.standing() => *other = row,
            Some(_) => {}
        }
    }
    best.into_iter().cloned().collect()
}

impl Row {
    /// What modes are compared by: rounds, then speed.
    fn standing(&self) -> (usize, f64) {
        (self.mrays_per_s.len(), self.middle())
    }

    /// The middle of the rounds' figures, enough to compare modes by.
    fn middle(&self) -> f64 {
        let mut sorted = self.mrays_per_s.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
    }
}

/// The error of a bench with rows that disagree. Rows of [`Visibility::Fast`] may: it misses what it leaks.
///
/// # Errors
/// [`Error::Failed`] if there is such a row.
pub fn verdict(rows: &[Row]) -> Result<()> {
    let counts = |row: &&Row| row.visibility != Some(Visibility::Fast);
    match rows.iter().filter(counts).find(|row| !row.agrees) {
        None => Ok(()),
        Some(row) => Err(Error::Failed(format!(
            "{} of {}: {} {} finds {} hits in {} rays, which is more than {TOLERANCE} of them off; its figures mean \
             nothing",
            row.kind, row.scene, row.engine, row.kernel, row.hits, row.rays
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_that_was_left_out_is_never_the_best() {
        let row = |kernel: &str, mrays_per_s: &[f64]| Row {
            scene: "s".into(),
            kind: Kind::Primary,
            engine: Engine::Irt,
            isa: "avx2".into(),
            kernel: kernel.into(),
            visibility: Some(Visibility::Exact),
            width: 1,
            threads: 1,
            rays: 1,
            hits: 1,
            mrays_per_s: mrays_per_s.to_vec(),
            agrees: true,
        };
        let rows = [row("left out", &[100.0]), row("slow", &[5.0, 6.0, 7.0]), row("fast", &[8.0, 9.0, 1.0])];
        for turn in 0..3 {
            let mut rows = rows.clone();
            rows.rotate_left(turn);
            let best = best_rows(&rows);
            assert_eq!(best.len(), 1);
            assert_eq!(best[0].kernel, "fast");
        }
    }
}
