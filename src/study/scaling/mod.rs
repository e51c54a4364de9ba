//! Thread scaling: the thesis' tables 2 to 5 on this machine, and beyond its cores by simulation. `README.md` beside this
//! file tells what is measured, what is simulated, and how far to trust it.

mod costs;
mod measure;
mod simulate;
mod sizes;
mod thesis;

pub use costs::{Costs, overhead_per_tile};
pub use simulate::simulate;
pub use sizes::{SizeRow, tile_sizes};
pub use thesis::ThesisFigure;

use crate::{
    error::Result,
    math::median,
    render::{RenderOptions, Stage},
    scene::Scene,
    schedule::{Control, FilmMode, FrameStats, Machine, Schedule},
    tile::Tile,
};
use measure::{Measured, TileCosts};
use thesis::thesis_figure;

/// What to measure.
#[derive(Clone, Debug)]
pub struct ScalingOptions {
    /// How to render; its threads, frames and schedule mean nothing here.
    pub render: RenderOptions,
    /// Every one with every number of workers.
    pub schedules: Vec<Schedule>,
    /// Numbers of workers, ascending; more than the machine has cores are simulated.
    pub workers: Vec<usize>,
    /// Frames of which the median counts, >= 1.
    pub rounds: u32,
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
    /// Seconds of every frame.
    pub seconds: Vec<f64>,
    /// T1 / (n Tn), medians; for one worker 1.
    pub efficiency: f64,
    /// The same of the fastest frames, which other processes disturbed least.
    pub fastest: f64,
    /// Of a measured row: what the simulator says.
    pub predicted: Option<f64>,
    /// The median frame.
    pub frame: FrameStats,
    /// What the thesis found.
    pub thesis: Option<ThesisFigure>,
}

impl ScalingRow {
    /// Median seconds.
    pub fn median(&self) -> f64 {
        median(&self.seconds)
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
/// As [`Stage::new`] and [`crate::render::Session::frame`]; [`crate::error::Error::Failed`] if images differ.
pub fn scaling(
    scene: &Scene,
    options: &ScalingOptions,
    costs: &Costs,
    control: &Control<'_>,
) -> Result<Vec<ScalingRow>> {
    let stage = Stage::new(scene, &options.render)?;
    let RenderOptions { pin, tile: side, .. } = options.render;
    let cores = Machine::get().default_workers();
    // Efficiency is against one worker, asked for or not.
    let mut measured: Vec<usize> = options.workers.iter().copied().filter(|&n| n > 1 && n <= cores).collect();
    measured.insert(0, 1);
    let all = measure::measure(&stage, &options.schedules, &measured, options.rounds, pin, side, control)?;
    let base = stage.tiles(side);
    let tile_costs = tile_costs(&stage, &base, options, &all, control)?;
    let mut rows = vec![];
    for &schedule in &options.schedules {
        let Some((_, tiles)) = tile_costs.iter().find(|(film, _)| *film == schedule.film) else { continue };
        let predict = |workers: usize| {
            let costs = match options.network {
                _ if workers <= cores => *costs,
                Some((latency, bits)) => costs.on_network(latency, bits),
                None => costs.on_cores(workers),
            };
            tiles.simulate(schedule, workers, &base, &costs)
        };
        let predicted_one = predict(1).seconds;
        let find = |workers: usize| all.iter().find(|m| m.workers == workers && m.schedule == schedule);
        let one = find(1).map_or(f64::NAN, |m| median(&m.seconds()));
        let fastest_one = find(1).map_or(f64::NAN, |m| least(&m.seconds()));
        for &workers in &options.workers {
            let predicted = predict(workers);
            let predicted_efficiency = predicted_one / (workers as f64 * predicted.seconds);
            let (simulated, seconds, frame) = match find(workers) {
                Some(measured) => (false, measured.seconds(), measured.median_frame().clone()),
                None => (true, vec![predicted.seconds], predicted),
            };
            let against = |one: f64, many: f64| match simulated {
                true => predicted_efficiency,
                false => one / (workers as f64 * many),
            };
            let efficiency = against(one, median(&seconds));
            let fastest = against(fastest_one, least(&seconds));
            rows.push(ScalingRow {
                scene: scene.name.clone(),
                schedule,
                workers,
                simulated,
                seconds,
                efficiency,
                fastest,
                predicted: (!simulated).then_some(predicted_efficiency),
                frame,
                thesis: options
                    .thesis_scene
                    .as_deref()
                    .and_then(|name| thesis_figure(name, schedule.strategy, workers)),
            });
        }
    }
    Ok(rows)
}

/// What tiles cost one worker, for each film mode that is asked for.
fn tile_costs(
    stage: &Stage<'_>,
    base: &[Tile],
    options: &ScalingOptions,
    measured: &[Measured],
    control: &Control<'_>,
) -> Result<Vec<(FilmMode, TileCosts)>> {
    let RenderOptions { pin, tile: side, .. } = options.render;
    let asked_for = |film: &FilmMode| options.schedules.iter().any(|schedule| schedule.film == *film);
    let costs = |film: FilmMode| -> Result<_> {
        let smaller = measure::smaller_tiles(stage, film, side, pin, control)?;
        let alone = measured.iter().filter(|m| m.workers == 1 && m.schedule.film == film);
        let frames = alone.flat_map(|m| &m.frames).chain(&smaller);
        Ok((film, TileCosts::new(base, frames)))
    };
    FilmMode::ALL.into_iter().filter(asked_for).map(costs).collect()
}

fn least(samples: &[f64]) -> f64 {
    samples.iter().copied().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::{Idle, Messages, Pinned, Strategy, WorkerStats};

    #[test]
    fn what_limits_a_frame_is_told_by_its_mean_share() {
        let worker = |busy_seconds, start, tail| WorkerStats {
            pinned: Pinned::Free,
            busy_seconds,
            tiles: 1,
            idle: Idle { start, work: 0.5, deliver: 0.0, tail },
            steals: 0,
        };
        let frame = FrameStats {
            seconds: 10.0,
            workers: vec![worker(8.0, 1.0, 0.5), worker(5.0, 1.0, 3.5)],
            spans: vec![],
            tasks: Messages::default(),
            reports: Messages::default(),
        };
        let row = ScalingRow {
            scene: String::new(),
            schedule: Schedule { strategy: Strategy::Static, film: FilmMode::Shared },
            workers: 2,
            simulated: false,
            seconds: vec![10.0],
            efficiency: 1.0,
            fastest: 1.0,
            predicted: None,
            frame,
            thesis: None,
        };
        let expected = [("tail", 0.2), ("start", 0.1), ("work", 0.05), ("deliver", 0.0), ("scheduler", 0.0)];
        let limits = row.limits();
        assert_eq!(limits.len(), expected.len());
        for (name, share) in expected {
            let found = limits.iter().find(|limit| limit.0 == name).unwrap();
            assert!((found.1 - share).abs() < 1e-12, "{limits:?}");
        }
        assert!(limits.is_sorted_by(|a, b| a.1 >= b.1));
    }

    #[test]
    fn the_least_sample_is_found() {
        assert_eq!(least(&[3.0, 1.0, 2.0]), 1.0);
    }
}
