//! Thread scaling: the thesis' tables 2 to 5 on this machine, and beyond its cores by simulation. `README.md` beside this
//! file tells what is measured, what is simulated, and how far to trust it.

mod costs;
mod measure;
mod simulate;
mod sizes;
mod thesis;

pub use costs::{Costs, overhead_per_tile};
pub use simulate::{Flow, Replay, simulate};
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
use measure::{Measured, Method, Rounds, TileCosts};
use thesis::thesis_figure;

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

/// The simulator is never told that tiles became cheaper than this.
const LEAST_INFLATION: f64 = 0.5;
/// How often the simulator is asked for the slowness that explains what tiles took: each time what is left of the difference
/// is a fraction of it, the share of tiles' time that the master takes.
const TRIALS: usize = 4;

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
    };
    let rounds = method.measure(&stage, control)?;
    let base = stage.tiles(method.side);
    let mut rows = vec![];
    for film in measure::films(&options.schedules) {
        let alone = || rounds.all.iter().filter(|m| m.workers == 1 && m.schedule.film == film);
        let costs = &match film {
            FilmMode::Shared => *costs,
            FilmMode::Messages => {
                costs.copying_as_in(alone().map(|m| (m.schedule, &m.streams[..])), method.pin)
            }
        };
        let streams = alone().flat_map(|m| &m.streams).chain(rounds.smaller.get(&film).into_iter().flatten());
        let tiles = TileCosts::new(&base, streams);
        let study = Study { scene, options, costs, cores, rounds: &rounds, base: &base };
        for &schedule in options.schedules.iter().filter(|schedule| schedule.film == film) {
            rows.extend(study.rows(schedule, &tiles));
        }
    }
    Ok(rows)
}

/// What the rows of a scene are made of.
struct Study<'a> {
    scene: &'a Scene,
    options: &'a ScalingOptions,
    costs: &'a Costs,
    cores: usize,
    rounds: &'a Rounds,
    base: &'a [Tile],
}

impl Study<'_> {
    /// One for each number of workers.
    fn rows(&self, schedule: Schedule, tiles: &TileCosts) -> Vec<ScalingRow> {
        let of = |workers| self.rounds.all.iter().find(|m| m.workers == workers && m.schedule == schedule);
        let Some(one) = of(1) else { return vec![] };
        let row = |&workers: &usize| match of(workers) {
            Some(measured) => self.measured(measured, one, tiles),
            None => self.simulated(schedule, &one.streams, workers, tiles),
        };
        self.options.workers.iter().map(row).collect()
    }

    fn measured(&self, measured: &Measured, one: &Measured, tiles: &TileCosts) -> ScalingRow {
        let (workers, seconds, alone) = (measured.workers, measured.seconds(), one.seconds());
        let against = |one: f64, many: f64| one / (workers as f64 * many);
        let ratios: Vec<f64> = alone.iter().zip(&seconds).map(|(&one, &many)| against(one, many)).collect();
        let predict = |slowness: &Vec<f64>, seen: &Costs| {
            let slowness = self.apart_from_master(measured.schedule, seen, slowness, tiles);
            self.predict(measured.schedule, seen, &slowness, tiles).0
        };
        let each: Vec<Costs> =
            one.rounds().map(|streams| self.seen(measured.schedule, streams, tiles)).collect();
        let slow = measured.slowness(one);
        let predictions: Vec<f64> = slow.iter().zip(&each).map(|(slow, seen)| predict(slow, seen)).collect();
        let parts: Vec<(f64, f64)> = slow
            .iter()
            .zip(&each)
            .zip(one.rounds())
            .zip(&seconds)
            .map(|(((slow, seen), streams), two)| {
                let all = tiles.slowness_of_all(streams);
                let slowness = self.apart_from_master(measured.schedule, seen, slow, tiles);
                let (e, stream) = self.predict(measured.schedule, seen, &slowness, tiles);
                let t1 = e * workers as f64 * stream.per_frame();
                let m1 = streams.iter().map(|s| s.seconds).sum::<f64>()
                    / streams.iter().map(|s| s.frames).sum::<usize>() as f64;
                (t1 * all / m1, stream.per_frame() * all / two)
            })
            .collect();
        log::debug!(
            "YY {} {} {} {} {:.4} {:.4} {:.4} {:.4}",
            self.scene.name,
            measured.schedule.strategy,
            measured.schedule.film,
            workers,
            median(&ratios),
            median(&predictions),
            median(&parts.iter().map(|p| p.0).collect::<Vec<f64>>()),
            median(&parts.iter().map(|p| p.1).collect::<Vec<f64>>()),
        );
        // One worker against itself, which no rounding should tell from 1.
        let itself = |value: f64| if workers == 1 { 1.0 } else { value };
        ScalingRow {
            simulated: false,
            efficiency: median(&ratios),
            fastest: against(least(&alone), least(&seconds)),
            seconds,
            inflation: itself(measured.inflation(one)),
            predicted: Some(itself(median(&predictions))),
            frame: measured.median_stream().clone(),
            ..self.row(measured.schedule, workers)
        }
    }

    /// How slow each worker is if its tiles took `seen` times as long: without what the master takes from them, which is not
    /// the machine's, but the simulator's to find. Solved for by trial, since the slower everything is, the more that is.
    fn apart_from_master(
        &self,
        schedule: Schedule,
        costs: &Costs,
        seen: &[f64],
        tiles: &TileCosts,
    ) -> Vec<f64> {
        let mut slowness = vec![1.0; seen.len()];
        for _ in 0..TRIALS {
            let (_, stream) = self.predict(schedule, costs, &slowness, tiles);
            for ((own, seen), simulated) in slowness.iter_mut().zip(seen).zip(tiles.slowness(&stream)) {
                *own = (*own * seen / simulated).max(LEAST_INFLATION);
            }
        }
        slowness
    }

    fn simulated(
        &self,
        schedule: Schedule,
        one: &[FrameStats],
        workers: usize,
        tiles: &TileCosts,
    ) -> ScalingRow {
        let inflation = self.options.inflation;
        let seen = self.seen(schedule, one, tiles);
        let (efficiency, frame) = self.predict(schedule, &seen, &vec![inflation; workers], tiles);
        ScalingRow {
            simulated: true,
            seconds: vec![frame.per_frame()],
            efficiency,
            fastest: efficiency,
            inflation,
            frame,
            ..self.row(schedule, workers)
        }
    }

    /// What messages cost as these streams of one worker show it.
    fn seen(&self, schedule: Schedule, one: &[FrameStats], tiles: &TileCosts) -> Costs {
        self.costs.seen_in(one, schedule, tiles.slowness_of_all(one))
    }

    /// Efficiency and stream as the simulator has them, of workers of such slowness.
    fn predict(
        &self,
        schedule: Schedule,
        &seen: &Costs,
        slowness: &[f64],
        tiles: &TileCosts,
    ) -> (f64, FrameStats) {
        let workers = slowness.len();
        let (alone, costs) = match self.options.network {
            // What slows tiles down slows down everything else on the same cores.
            _ if workers <= self.cores => (seen, seen.slower(slowness.iter().sum::<f64>() / workers as f64)),
            Some((latency, bits)) => (*self.costs, self.costs.on_network(latency, bits)),
            None => (seen, seen.on_cores(workers)),
        };
        let longest = if workers <= self.cores { LONGEST_MEASURED } else { LONGEST_SIMULATED };
        let flow = self.options.flow.of(workers, longest);
        let one = tiles.simulate(schedule, &[1.0], self.options.flow, self.base, &alone);
        let many = tiles.simulate(schedule, slowness, flow, self.base, &costs);
        (one.per_frame() / (workers as f64 * many.per_frame()), many)
    }

    /// What is known of a row before it is measured or simulated.
    fn row(&self, schedule: Schedule, workers: usize) -> ScalingRow {
        let thesis = self.options.thesis_scene.as_deref();
        ScalingRow {
            scene: self.scene.name.clone(),
            schedule,
            workers,
            simulated: false,
            seconds: vec![],
            efficiency: f64::NAN,
            fastest: f64::NAN,
            inflation: 1.0,
            predicted: None,
            frame: FrameStats::default(),
            thesis: thesis.and_then(|name| thesis_figure(name, schedule.strategy, workers)),
        }
    }
}

fn least(samples: &[f64]) -> f64 {
    samples.iter().copied().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::{Idle, Pinned, SharedCore, Span, Strategy, WorkerStats};
    use crate::tile::{self, Order};

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

    const SHARED: SharedCore = SharedCore {
        send: 0.012,
        latency: 0.009,
        interrupt: 0.015,
        switch: 0.008,
        reply: 0.01,
        back: 0.02,
        wait: 0.07,
        late: 0.0,
        delay: 0.0,
    };

    /// Costs of about the size of real ones, in milliseconds.
    const COSTS: Costs = Costs {
        prepare: 0.02,
        send: 0.014,
        reply: 0.014,
        to_master: 0.03,
        to_worker: 0.03,
        collect: 0.005,
        collect_tile: 0.0,
        tile: 0.0,
        steal: 0.0,
        // Nothing is late: when that falls is a matter of chance.
        shared: SHARED,
        copying: SHARED,
        per_byte: 4e-7,
        cores: 2,
    };

    /// Efficiency of two workers of such slowness as the simulator alone has it, and as the study finds it predicted that
    /// takes the simulator's streams for measured ones.
    fn found(schedule: Schedule, slowness: [f64; 2]) -> [f64; 2] {
        let flow = Flow { frames: 2, in_flight: 2 };
        let base = tile::tiles(512, 512, 64, Order::Hilbert);
        let cost = |(i, &tile): (usize, &Tile)| Span {
            frame: 0,
            worker: 0,
            tile,
            start: 0.0,
            end: 0.2 + 0.01 * (i % 7) as f64,
        };
        let seen = FrameStats {
            frames: 1,
            spans: base.iter().enumerate().map(cost).collect(),
            ..FrameStats::default()
        };
        let tiles = TileCosts::new(&base, [&seen]);
        let measured = |workers| Measured { schedule, workers, streams: vec![] };
        let mut all = vec![measured(1), measured(2)];
        // In the second round everything takes longer, and more so in the third one.
        for pace in [1.0, 1.3, 1.7] {
            let one = tiles.simulate(schedule, &[pace], flow, &base, &COSTS.slower(pace));
            all[0].streams.extend([one.clone(), one]);
            let paces = slowness.map(|slowness| slowness * pace);
            let slower = COSTS.slower((paces[0] + paces[1]) / 2.0);
            let two = tiles.simulate(schedule, &paces, flow.of(2, LONGEST_MEASURED), &base, &slower);
            all[1].streams.push(two);
        }
        let rounds = Rounds { all, ..Rounds::default() };
        let options = ScalingOptions {
            render: crate::study::accuracy::options(),
            schedules: vec![schedule],
            workers: vec![1, 2],
            rounds: 1,
            flow,
            inflation: 1.0,
            network: None,
            thesis_scene: None,
        };
        let scene = Scene::default();
        let study =
            Study { scene: &scene, options: &options, costs: &COSTS, cores: 2, rounds: &rounds, base: &base };
        let rows = study.rows(schedule, &tiles);
        assert_eq!((rows[0].efficiency, rows[0].inflation, rows[0].predicted), (1.0, 1.0, Some(1.0)));
        [rows[1].efficiency, rows[1].predicted.unwrap()]
    }

    #[test]
    fn what_the_simulator_made_it_predicts_though_workers_are_slow_and_the_master_interrupts_them() {
        for schedule in Schedule::all() {
            for slowness in [[1.0, 1.0], [1.0, 1.3], [1.4, 1.2]] {
                let [efficiency, predicted] = found(schedule, slowness);
                assert!(
                    (efficiency - predicted).abs() < 0.01,
                    "{schedule:?} {slowness:?}: {efficiency} {predicted}"
                );
            }
        }
    }

    #[test]
    fn the_least_sample_is_found() {
        assert_eq!(least(&[3.0, 1.0, 2.0]), 1.0);
    }
}
