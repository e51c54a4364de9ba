//! Thread scaling: the thesis' tables 2 to 5 on this machine, and beyond its cores by simulation. `README.md` beside this
//! file tells what is measured, what is simulated, and how far to trust it.

mod costs;
mod measure;
mod simulate;
mod sizes;
mod thesis;

pub use costs::{Costs, overhead_per_tile};
pub use measure::{Measured, TileCosts};
pub use simulate::simulate;
pub use sizes::{SizeRow, tile_sizes};
pub use thesis::{ThesisFigure, thesis_figure};

use crate::{
    error::Result,
    render::{RenderOptions, Stage},
    scene::Scene,
    schedule::{Control, FilmMode, FrameStats, Machine, Plan, Schedule},
};

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
    let mut rows = vec![];
    let mut tile_costs: Vec<(FilmMode, TileCosts)> = vec![];
    let base = stage.tiles(side);
    for film in FilmMode::ALL.into_iter().filter(|film| options.schedules.iter().any(|s| s.film == *film)) {
        let mut frames: Vec<&FrameStats> = all
            .iter()
            .filter(|m| m.workers == 1 && m.schedule.film == film)
            .flat_map(|m| &m.frames)
            .collect();
        let smaller = measure::smaller_tiles(&stage, film, side, pin, control)?;
        frames.extend(&smaller);
        tile_costs.push((film, TileCosts::new(&base, frames)));
    }
    for &schedule in &options.schedules {
        let Some((_, tiles)) = tile_costs.iter().find(|(film, _)| *film == schedule.film) else { continue };
        let predict = |workers: usize| {
            let plan = Plan::new(schedule.strategy, workers, &base, tiles.map());
            let seconds: Vec<f64> = plan.tiles.iter().map(|&tile| tiles.of(tile)).collect();
            let cluster = options.network.map(|(latency, bits)| costs.on_network(latency, bits));
            let costs = if workers > cores { cluster.unwrap_or(on_cores(*costs, workers)) } else { *costs };
            simulate(schedule, workers, &plan, &seconds, &costs)
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

/// The simulated machine has a core for each worker, and none for the master.
fn on_cores(costs: Costs, workers: usize) -> Costs {
    Costs { cores: workers, ..costs }
}

fn least(samples: &[f64]) -> f64 {
    samples.iter().copied().fold(f64::INFINITY, f64::min)
}

fn median(samples: &[f64]) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[half] } else { f64::midpoint(sorted[half - 1], sorted[half]) }
}
