//! Rows of the tables from what was measured: efficiencies, what the simulator says of them, and of more workers.

use super::{
    Costs, LONGEST_MEASURED, LONGEST_SIMULATED, ScalingOptions, ScalingRow,
    measure::{Measured, Rounds},
    thesis::thesis_figure,
    tiles::TileCosts,
};
use crate::{
    math::{Spread, median},
    scene::Scene,
    schedule::{FrameStats, Schedule, SharedCore},
    tile::Tile,
};

/// The simulator is never told that tiles became cheaper than this.
const LEAST_INFLATION: f64 = 0.5;
/// How often at most the simulator is asked for the slowness that explains what tiles took: each time what is left of the
/// difference is a fraction of it, the share of tiles' time that the master takes, ...
const TRIALS: usize = 15;
/// ... until it is this small.
const CLOSE: f64 = 5e-4;

/// What the rows of a scene are made of.
pub(super) struct Study<'a> {
    pub(super) scene: &'a Scene,
    pub(super) options: &'a ScalingOptions,
    pub(super) costs: &'a Costs,
    pub(super) cores: usize,
    pub(super) rounds: &'a Rounds,
    pub(super) base: &'a [Tile],
}

/// One worker of a schedule.
struct Alone<'a> {
    measured: &'a Measured,
    /// By which factor its tiles took longer in each round than they are taken to cost.
    slowness: Vec<f64>,
    /// Seconds of a frame in each round.
    seconds: Vec<f64>,
    /// The same as the simulator has them, where tiles take what they are taken to cost and messages what they took in that
    /// round. What it leaves out, it leaves out for several workers, too.
    simulated: Vec<f64>,
    /// What messages cost in the median of the rounds, ...
    costs: Costs,
    /// ... and seconds of a frame with that.
    usual: f64,
}

impl<'a> Alone<'a> {
    /// `measured` with one worker; `full` with one on every core, if that was measured, has the master on one of theirs.
    fn new(measured: &'a Measured, full: Option<&Measured>, study: &Study, tiles: &TileCosts) -> Alone<'a> {
        let schedule = measured.schedule;
        let slowness: Vec<f64> = measured.rounds().map(|round| tiles.slowness_of_all(round)).collect();
        let simulate = |costs: &Costs| {
            tiles.simulate(schedule, &[1.0], study.options.flow, study.base, costs).per_frame()
        };
        // Each stream by itself: they are on different cores, and what waits for the dearer messages of one is not made good by the
        // other.
        let mut all = vec![];
        let mut simulate_stream = |stream: &FrameStats| {
            let stream = std::slice::from_ref(stream);
            let own = tiles.slowness_of_all(stream);
            let seen = study.costs.seen_in(stream, schedule, own);
            all.push(seen);
            own * simulate(&seen)
        };
        let mut simulate_round = |(streams, &slowness): (&[FrameStats], &f64)| {
            mean(&streams.iter().map(&mut simulate_stream).collect::<Vec<f64>>()) / slowness
        };
        let simulated = measured.rounds().zip(&slowness).map(&mut simulate_round).collect();
        let costs = Costs::median(&all).unwrap_or(*study.costs);
        let costs = full.map_or(costs, |full| costs.as_in(full, tiles));
        Alone { measured, slowness, seconds: measured.seconds(), simulated, costs, usual: simulate(&costs) }
    }
}

impl Costs {
    /// With what messages cost in the median of rounds with a worker on every core, as far as these tell.
    fn as_in(self, full: &Measured, tiles: &TileCosts) -> Costs {
        // By what tiles took in that round, messages are as dear as they are taken to be.
        let usual = |round: &[FrameStats]| tiles.slowness_of_all(round);
        let shared: Vec<SharedCore> =
            full.rounds().filter_map(|round| self.shared_in(round, full.schedule, usual(round))).collect();
        let costs = Costs { shared: SharedCore::median(&shared).unwrap_or(self.shared), ..self };
        let copied: Vec<[f64; 2]> =
            full.rounds().filter_map(|round| costs.copied_in(round, full.schedule, usual(round))).collect();
        let of = |who: usize| median(&copied.iter().map(|byte| byte[who]).collect::<Vec<f64>>());
        let copied = if copied.is_empty() { self.copied } else { Some([of(0), of(1)]) };
        Costs { copied, ..costs }
    }
}

/// A round of several workers.
struct Round<'a> {
    streams: &'a [FrameStats],
    /// By which factor tiles took longer than they are taken to cost when one worker had them in that round, ...
    one: f64,
    /// ... and by which those of each of several workers took longer than then.
    slowness: Vec<f64>,
}

impl<'a> Round<'a> {
    fn all(measured: &'a Measured, alone: &Alone, tiles: &TileCosts) -> Vec<Round<'a>> {
        let round = |(streams, &one): (&'a [FrameStats], &f64)| {
            // By what tiles are taken to cost, since no single round tells that of each tile.
            let of = |worker| tiles.slowness_of(streams, worker, one);
            Round { streams, one, slowness: (0..measured.workers).map(of).collect() }
        };
        measured.rounds().zip(&alone.slowness).map(round).collect()
    }

    /// These costs where workers are as slow as here, and with what this round tells of messages on the core that the master
    /// shares. What slows tiles down slows down everything else on the same cores.
    fn costs(&self, usual: Costs, slowness: &[f64], schedule: Schedule) -> Costs {
        let costs = usual.slower(mean(slowness));
        let shared = costs.shared_in(self.streams, schedule, self.one).unwrap_or(costs.shared);
        let costs = Costs { shared, ..costs };
        Costs { copied: costs.copied_in(self.streams, schedule, self.one).or(costs.copied), ..costs }
    }
}

impl Study<'_> {
    /// One for each number of workers.
    pub(super) fn rows(&self, schedule: Schedule, tiles: &TileCosts) -> Vec<ScalingRow> {
        let of = |workers| self.rounds.all.iter().find(|m| m.workers == workers && m.schedule == schedule);
        let Some(one) = of(1) else { return vec![] };
        let alone = Alone::new(one, of(self.cores), self, tiles);
        let row = |&workers: &usize| match of(workers) {
            Some(measured) => self.measured(measured, &alone, tiles),
            None => self.simulated(&alone, workers, tiles),
        };
        self.options.workers.iter().map(row).collect()
    }

    fn measured(&self, measured: &Measured, alone: &Alone, tiles: &TileCosts) -> ScalingRow {
        let (workers, seconds) = (measured.workers, measured.seconds());
        let against = |one: f64, many: f64| one / (workers as f64 * many);
        let ratios: Vec<f64> =
            alone.seconds.iter().zip(&seconds).map(|(&one, &many)| against(one, many)).collect();
        let predict = |(round, one): (&Round, &f64)| {
            let slowness = self.apart_from_master(alone, round, tiles);
            against(*one, self.predict(alone, round, &slowness, tiles).per_frame())
        };
        // One worker against itself, which no rounding should tell from 1.
        let predictions: Vec<f64> = match workers {
            1 => vec![1.0; ratios.len()],
            _ => Round::all(measured, alone, tiles).iter().zip(&alone.simulated).map(predict).collect(),
        };
        let apart: Vec<f64> = predictions.iter().zip(&ratios).map(|(said, is)| said - is).collect();
        ScalingRow {
            simulated: false,
            efficiency: median(&ratios),
            fastest: against(least(&alone.seconds), least(&seconds)),
            seconds,
            inflation: if workers == 1 { 1.0 } else { measured.inflation(alone.measured) },
            predicted: Some(median(&predictions)),
            apart: Some(Spread::of(&apart)),
            frame: measured.median_stream().clone(),
            ..self.row(measured.schedule, workers)
        }
    }

    /// How slow each worker is if its tiles took as long as in this round: without what the master takes from them, which is not
    /// the machine's, but the simulator's to find. Solved for by trial, since the slower everything is, the more that is.
    fn apart_from_master(&self, alone: &Alone, round: &Round, tiles: &TileCosts) -> Vec<f64> {
        closest(&round.slowness, |slowness| tiles.slowness(&self.predict(alone, round, slowness, tiles)))
    }

    /// The stream of workers of such slowness as the simulator has it, with what messages cost in this round.
    fn predict(&self, alone: &Alone, round: &Round, slowness: &[f64], tiles: &TileCosts) -> FrameStats {
        let schedule = alone.measured.schedule;
        let costs = round.costs(alone.costs, slowness, schedule);
        let flow = self.options.flow.of(slowness.len(), LONGEST_MEASURED);
        tiles.simulate(schedule, slowness, flow, self.base, &costs)
    }

    fn simulated(&self, alone: &Alone, workers: usize, tiles: &TileCosts) -> ScalingRow {
        let (schedule, inflation) = (alone.measured.schedule, self.options.inflation);
        let costs = match self.options.network {
            Some((latency, bits)) => self.costs.on_network(latency, bits),
            None => alone.costs.on_cores(workers),
        };
        let flow = self.options.flow.of(workers, LONGEST_SIMULATED);
        let frame = tiles.simulate(schedule, &vec![inflation; workers], flow, self.base, &costs);
        let efficiency = alone.usual / (workers as f64 * frame.per_frame());
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
            apart: None,
            frame: FrameStats::default(),
            thesis: thesis.and_then(|name| thesis_figure(name, schedule.strategy, workers)),
        }
    }
}

/// The slowness with which workers are found to be as slow as `seen`, or as close to that as was found: each trial takes them
/// to be slower by what they are not slow enough.
fn closest(seen: &[f64], mut found: impl FnMut(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let mut slowness = vec![1.0; seen.len()];
    let (mut least, mut best) = (f64::INFINITY, slowness.clone());
    for trial in 0..TRIALS {
        let ratios: Vec<f64> = seen.iter().zip(found(&slowness)).map(|(seen, found)| seen / found).collect();
        let off = ratios.iter().fold(0.0, |off: f64, ratio| off.max((ratio - 1.0).abs()));
        if off < least {
            (least, best) = (off, slowness.clone());
        }
        if off < CLOSE {
            break;
        }
        // Workers that fall into another rhythm make it jump; then smaller steps come closer.
        let step = if trial < TRIALS / 3 { 1.0 } else { 0.4 };
        for (own, ratio) in slowness.iter_mut().zip(ratios) {
            *own = (*own * ratio.powf(step)).max(LEAST_INFLATION);
        }
    }
    best
}

fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len() as f64
}

fn least(samples: &[f64]) -> f64 {
    samples.iter().copied().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests;
