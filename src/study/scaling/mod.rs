//! Thread scaling: the thesis' tables 2 to 5 on this machine, and beyond its cores by simulation. `README.md` beside this
//! file tells what is measured, what is simulated, and how far to trust it.

mod costs;
mod measure;
mod rows;
mod simulate;
mod sizes;
mod thesis;
mod tiles;

pub use costs::{Costs, overhead_per_tile};
pub use simulate::{Flow, Replay, simulate};
pub use sizes::{SizeRow, tile_sizes};
pub use thesis::ThesisFigure;

use crate::{
    error::Result,
    math::{Spread, median},
    render::{RenderOptions, Stage},
    scene::Scene,
    schedule::{Control, FrameStats, Machine, Schedule},
};
use measure::Method;
use rows::Study;
use tiles::TileCosts;

/// No stream is measured that is longer, since each of its frames has a film, ...
const LONGEST_MEASURED: usize = 16;
/// ... and none simulated.
const LONGEST_SIMULATED: usize = 64;

/// What to measure.
#[derive(Clone, Debug)]
pub struct ScalingOptions {
    /// How to render; its threads, frames and schedule mean nothing here.
    pub render: RenderOptions,
    /// Every one with every number of workers.
    pub schedules: Vec<Schedule>,
    /// Numbers of workers, ascending; more than the machine has cores are simulated.
    pub workers: Vec<usize>,
    /// Rounds of which the median counts, >= 1.
    pub rounds: u32,
    /// Frames of a round for each worker.
    pub flow: Flow,
    /// By which factor tiles are taken to last longer where more workers than cores are simulated.
    pub inflation: f64,
    /// Latency in seconds and bits per second of the network of a simulated cluster.
    pub network: Option<(f64, f64)>,
    /// The scene's name in the thesis, if it is one of the thesis'.
    pub thesis_scene: Option<String>,
}

/// One cell of the tables.
#[derive(Clone, Debug)]
pub struct ScalingRow {
    /// The scene's name.
    pub scene: String,
    /// Strategy and film mode.
    pub schedule: Schedule,
    /// Number of workers.
    pub workers: usize,
    /// Predicted from tile costs instead of measured.
    pub simulated: bool,
    /// Seconds per frame of every round.
    pub seconds: Vec<f64>,
    /// T1 / (n Tn), each of the same round, the median; for one worker 1.
    pub efficiency: f64,
    /// The same of the fastest rounds, which other processes disturbed least.
    pub fastest: f64,
    /// By which factor a tile took longer than one worker alone took for it, in the same round: the median. What cores
    /// share, and what others take from them; no scheduler can help it. Of a simulated row, what it was told.
    pub inflation: f64,
    /// Of a measured row: what the simulator says, told each worker's inflation in each round, without what by its own
    /// account the master took from tiles; the median.
    pub predicted: Option<f64>,
    /// By how much that is too much, round by round.
    pub apart: Option<Spread>,
    /// The stream of the median round.
    pub frame: FrameStats,
    /// What the thesis found.
    pub thesis: Option<ThesisFigure>,
}

impl ScalingRow {
    /// Median seconds.
    pub fn median(&self) -> f64 {
        median(&self.seconds)
    }

    /// Efficiency without inflation: what of the time went into tiles, compared with one worker.
    pub fn scheduling(&self) -> f64 {
        self.efficiency * self.inflation
    }

    /// What keeps the workers from their tiles: mean share of the frame by cause, the largest first. "scheduler" is what
    /// is left: messages, steals and bookkeeping between tiles.
    pub fn limits(&self) -> Vec<(&'static str, f64)> {
        let FrameStats { seconds, ref workers, .. } = self.frame;
        let share = |of: fn(&crate::schedule::WorkerStats) -> f64| {
            workers.iter().map(of).sum::<f64>() / (workers.len() as f64 * seconds)
        };
        let mut limits = vec![
            ("start", share(|worker| worker.idle.start)),
            ("work", share(|worker| worker.idle.work)),
            ("deliver", share(|worker| worker.idle.deliver)),
            ("tail", share(|worker| worker.idle.tail)),
        ];
        let known: f64 = limits.iter().map(|limit| limit.1).sum();
        limits.push(("scheduler", (1.0 - known - share(|worker| worker.busy_seconds)).max(0.0)));
        limits.sort_by(|a, b| b.1.total_cmp(&a.1));
        limits
    }
}

/// Measures and simulates one scene.
///
/// # Errors
/// As [`Stage::new`] and [`crate::render::Session::stream`]; [`crate::error::Error::Failed`] if images differ.
pub fn scaling(
    scene: &Scene,
    options: &ScalingOptions,
    costs: &Costs,
    control: &Control<'_>,
) -> Result<Vec<ScalingRow>> {
    let stage = Stage::new(scene, &options.render)?;
    let cores = Machine::get().default_workers();
    // Efficiency is against one worker, asked for or not.
    let several: Vec<usize> = options.workers.iter().copied().filter(|&n| n > 1 && n <= cores).collect();
    let method = Method {
        schedules: &options.schedules,
        workers: &several,
        rounds: options.rounds,
        flow: options.flow,
        pin: options.render.pin,
        side: options.render.tile,
        costs,
    };
    let (rounds, costs) = method.measure(&stage, control)?;
    log::debug!("messages in these rounds, in seconds: {costs:?}");
    let base = stage.tiles(method.side);
    let mut rows = vec![];
    for film in measure::films(&options.schedules) {
        let alone = rounds.all.iter().filter(|m| m.workers == 1 && m.schedule.film == film);
        let smaller = rounds.smaller.get(&film).map_or(&[][..], Vec::as_slice);
        let tiles = TileCosts::new(&base, alone.flat_map(|m| &m.streams)).with_smaller(smaller);
        let study = Study { scene, options, costs: &costs, cores, rounds: &rounds, base: &base };
        for &schedule in options.schedules.iter().filter(|schedule| schedule.film == film) {
            rows.extend(study.rows(schedule, &tiles));
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::{FilmMode, Idle, Pinned, Strategy, WorkerStats};

    #[test]
    fn what_limits_a_frame_is_told_by_its_mean_share() {
        let worker = |busy_seconds, start, tail| WorkerStats {
            busy_seconds,
            tiles: 1,
            idle: Idle { start, work: 0.5, deliver: 0.0, tail },
            ..WorkerStats::new(Pinned::Free)
        };
        let frame = FrameStats {
            frames: 1,
            seconds: 10.0,
            workers: vec![worker(8.0, 1.0, 0.5), worker(5.0, 1.0, 3.5)],
            ..FrameStats::default()
        };
        let row = ScalingRow {
            scene: String::new(),
            schedule: Schedule { strategy: Strategy::Static, film: FilmMode::Shared },
            workers: 2,
            simulated: false,
            seconds: vec![10.0],
            efficiency: 1.0,
            fastest: 1.0,
            inflation: 1.25,
            predicted: None,
            apart: None,
            frame,
            thesis: None,
        };
        let expected = [("tail", 0.2), ("start", 0.1), ("work", 0.05), ("deliver", 0.0), ("scheduler", 0.0)];
        let limits = row.limits();
        assert_eq!(row.scheduling(), 1.25);
        assert_eq!(limits.len(), expected.len());
        for (name, share) in expected {
            let found = limits.iter().find(|limit| limit.0 == name).unwrap();
            assert!((found.1 - share).abs() < 1e-12, "{limits:?}");
        }
        assert!(limits.is_sorted_by(|a, b| a.1 >= b.1));
    }
}
