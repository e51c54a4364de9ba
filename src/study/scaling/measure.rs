//! A scene under every schedule, in interleaved rounds.
//!
//! One round of a schedule, with two workers: frames by one worker, twice as many by two, then by one worker on another
//! core. So whatever makes the machine faster or slower for a while, or one core slower than another, is on both
//! sides of the ratio. The master is pinned, too: to a core without a worker, or else to that of the last worker, where the
//! simulator has it. What messages cost there is measured in every round.

use super::{
    Costs, Flow, LONGEST_MEASURED,
    costs::{MESSAGES, SharedCores},
    tiles::ratio,
};
use crate::error::Result;
use crate::math::median;
use crate::render::{Session, Stage};
use crate::schedule::{
    Control, FilmMode, FrameStats, Machine, Placement, Schedule, Strategy, pin_current_thread,
};
use crate::tile::Tile;
use std::collections::HashMap;
use std::ops::Range;

/// Rounds of one schedule with one number of workers.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    /// How they were scheduled.
    pub(super) schedule: Schedule,
    /// By how many workers.
    pub(super) workers: usize,
    /// Streams of frames: two for each round of one worker, else one.
    pub(super) streams: Vec<FrameStats>,
}

impl Measured {
    /// The streams of each round.
    pub(super) fn rounds(&self) -> std::slice::Chunks<'_, FrameStats> {
        self.streams.chunks(if self.workers == 1 { 2 } else { 1 })
    }

    /// Seconds per frame in each round.
    pub(super) fn seconds(&self) -> Vec<f64> {
        let per_frame = |streams: &[FrameStats]| {
            let frames: usize = streams.iter().map(|stream| stream.frames).sum();
            streams.iter().map(|stream| stream.seconds).sum::<f64>() / frames as f64
        };
        self.rounds().map(per_frame).collect()
    }

    /// The stream whose time per frame is the median (of an even number the faster one of the middle two).
    pub(super) fn median_stream(&self) -> &FrameStats {
        let mut order: Vec<&FrameStats> = self.streams.iter().collect();
        order.sort_by(|a, b| a.per_frame().total_cmp(&b.per_frame()));
        order[(order.len() - 1) / 2]
    }

    /// By which factor tiles take longer than those of `alone` in the same round: the median of the rounds. Tiles that only
    /// one of them has are left out: strategies may cut them in other ways for more workers.
    pub(super) fn inflation(&self, alone: &Measured) -> f64 {
        let ratio = |(many, one): (&[FrameStats], &[FrameStats])| {
            ratio(many, &mean_costs(one), |_| true).unwrap_or(1.0)
        };
        median(&self.rounds().zip(alone.rounds()).map(ratio).collect::<Vec<f64>>())
    }
}

/// Mean seconds of each tile.
fn mean_costs(streams: &[FrameStats]) -> HashMap<Tile, f64> {
    let mut sums: HashMap<Tile, (f64, f64)> = HashMap::new();
    for span in streams.iter().flat_map(|stream| &stream.spans) {
        let (seconds, count) = sums.entry(span.tile).or_default();
        *seconds += span.end - span.start;
        *count += 1.0;
    }
    sums.into_iter().map(|(tile, (seconds, count))| (tile, seconds / count)).collect()
}

/// What is measured.
#[derive(Clone, Debug, Default)]
pub(super) struct Rounds {
    /// One per schedule and number of workers.
    pub(super) all: Vec<Measured>,
    /// Of each film mode, in each round: streams of one worker with the same tiles again, then with tiles of half the side, a
    /// quarter and so on, down to 16 pixels: the strategies that cut tiles cut them so.
    pub(super) smaller: HashMap<FilmMode, Vec<Vec<FrameStats>>>,
}

/// How it is measured.
pub(super) struct Method<'a> {
    pub(super) schedules: &'a [Schedule],
    /// Numbers of workers, ascending and more than one; one worker is always measured.
    pub(super) workers: &'a [usize],
    pub(super) rounds: u32,
    /// For each worker.
    pub(super) flow: Flow,
    pub(super) pin: bool,
    pub(super) side: u32,
    /// What is known before.
    pub(super) costs: &'a Costs,
}

impl Method<'_> {
    /// Measures, on a thread of its own, which is pinned; `control` is not told of progress. The first frames of new
    /// workers are not counted. What messages cost is as it was known before, but for a core that the master shares.
    ///
    /// # Errors
    /// As [`Session::stream`], and [`crate::error::Error::Failed`] if two images differ.
    pub(super) fn measure(&self, stage: &Stage<'_>, control: &Control<'_>) -> Result<(Rounds, Costs)> {
        let cancel = control.flag();
        let measure = || self.measure_here(stage, &Control::new(cancel, &|_| {}));
        std::thread::scope(|scope| match scope.spawn(measure).join() {
            Ok(rounds) => rounds,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    }

    fn measure_here(&self, stage: &Stage<'_>, control: &Control<'_>) -> Result<(Rounds, Costs)> {
        let most = self.workers.last().map_or(1, |&most| most);
        let counts = std::iter::once(1).chain(self.workers.iter().copied());
        let measured = |&schedule: &Schedule| {
            counts.clone().map(move |workers| Measured { schedule, workers, streams: vec![] })
        };
        let mut rounds =
            Rounds { all: self.schedules.iter().flat_map(measured).collect(), ..Rounds::default() };
        let placement =
            Placement::new(Machine::get(), Some(most.max(Machine::get().default_workers())), self.pin);
        let costs = stage.with_session(&placement, |session| {
            let mut shared = SharedCores::new(self.pin, films(self.schedules));
            let tiles = stage.tiles(self.side);
            let cores = placement.slots().len();
            let mut bench = Bench { stage, session, placement: &placement, control, hash: None };
            bench.warm_up(self)?;
            for round in 0..self.rounds as usize {
                for of_schedule in rounds.all.chunks_mut(1 + self.workers.len()) {
                    let [one, more @ ..] = of_schedule else { continue };
                    let before = (2 * round) % cores;
                    one.streams.push(bench.stream(self, one.schedule, before..before + 1)?);
                    for many in more {
                        many.streams.push(bench.stream(self, many.schedule, 0..many.workers)?);
                    }
                    let after = (2 * round + 1) % cores;
                    one.streams.push(bench.stream(self, one.schedule, after..after + 1)?);
                }
                bench.smaller_tiles(self, round % cores, &mut rounds.smaller)?;
                shared.measure(bench.session, &tiles, MESSAGES);
            }
            Ok(shared.found(*self.costs, &tiles))
        })?;
        Ok((rounds, costs))
    }
}

struct Bench<'b, 'm, 'a, 's> {
    stage: &'b Stage<'s>,
    session: &'b mut Session<'m, 'a>,
    placement: &'b Placement,
    control: &'b Control<'b>,
    /// Of the first image.
    hash: Option<String>,
}

impl Bench<'_, '_, '_, '_> {
    fn employ(&mut self, workers: Range<usize>) {
        pin_current_thread(self.placement.beside(workers.clone()));
        self.session.employ(workers);
    }

    fn warm_up(&mut self, method: &Method<'_>) -> Result<()> {
        let tiles = self.stage.tiles(method.side);
        let most = method.workers.last().map_or(1, |&most| most);
        let Flow { frames, in_flight } = method.flow.of(most, LONGEST_MEASURED);
        self.session.stream(Schedule::default(), &tiles, frames, in_flight, self.control).map(|_| ())
    }

    fn stream(
        &mut self,
        method: &Method<'_>,
        schedule: Schedule,
        workers: Range<usize>,
    ) -> Result<FrameStats> {
        let Flow { frames, in_flight } = method.flow.of(workers.len(), LONGEST_MEASURED);
        self.employ(workers);
        let tiles = self.stage.tiles(method.side);
        let stats = self.session.stream(schedule, &tiles, frames, in_flight, self.control)?;
        self.session
            .films()
            .iter()
            .try_for_each(|film| check_image(film.sha256(), schedule, &mut self.hash))?;
        Ok(stats)
    }

    fn smaller_tiles(
        &mut self,
        method: &Method<'_>,
        worker: usize,
        smaller: &mut HashMap<FilmMode, Vec<Vec<FrameStats>>>,
    ) -> Result<()> {
        self.employ(worker..worker + 1);
        let Flow { frames, in_flight } = method.flow.of(1, LONGEST_MEASURED);
        for film in films(method.schedules) {
            let schedule = Schedule { strategy: Strategy::Stealing, film };
            let halves = std::iter::successors(Some(method.side), |side| Some(side / 2));
            let sides = halves.enumerate().take_while(|&(cuts, side)| cuts == 0 || side >= 16);
            let stream = |(_, side)| {
                let tiles = self.stage.tiles(side);
                self.session.stream(schedule, &tiles, frames, in_flight, self.control)
            };
            smaller.entry(film).or_default().push(sides.map(stream).collect::<Result<Vec<_>>>()?);
        }
        Ok(())
    }
}

/// Those that occur.
pub(super) fn films(schedules: &[Schedule]) -> impl Iterator<Item = FilmMode> {
    FilmMode::ALL.into_iter().filter(|&film| schedules.iter().any(|schedule| schedule.film == film))
}

/// A schedule that changes the image is not worth timing.
fn check_image(hash: String, schedule: Schedule, expected: &mut Option<String>) -> Result<()> {
    let expected = expected.get_or_insert_with(|| hash.clone());
    if *expected == hash {
        return Ok(());
    }
    let Schedule { strategy, film } = schedule;
    Err(crate::error::Error::Failed(format!(
        "{strategy} with film {film} gave another image than the others; please report this with the command line"
    )))
}

#[cfg(test)]
mod tests {
    use super::super::tiles::tests::stream;
    use super::*;

    #[test]
    fn another_image_ends_the_run_and_the_schedule_is_named() {
        let mut expected = None;
        let mut check = |hash: &str| check_image(hash.into(), Schedule::default(), &mut expected);
        check("00ff").unwrap();
        check("00ff").unwrap();
        let message = check("00fe").unwrap_err().to_string();
        assert!(message.starts_with("stealing with film shared gave another image"), "{message}");
        check("00ff").unwrap();
    }

    #[test]
    fn a_round_of_one_worker_is_two_streams_and_the_median_stream_was_rendered() {
        let tile = |x| Tile { x, y: 0, width: 16, height: 16 };
        let streams = [4.0, 1.0, 3.0, 2.0].map(|seconds| stream(&[(tile(0), seconds)])).to_vec();
        let mut measured = Measured { schedule: Schedule::default(), workers: 2, streams };
        assert_eq!(measured.median_stream().seconds, 2.0);
        assert_eq!(measured.seconds(), [4.0, 1.0, 3.0, 2.0]);
        measured.workers = 1;
        assert_eq!(measured.seconds(), [2.5, 2.5]);
    }

    #[test]
    fn inflation_is_of_the_tiles_that_both_have_round_by_round() {
        let tile = |x| Tile { x, y: 0, width: 16, height: 16 };
        let measured = |workers, streams| Measured { schedule: Schedule::default(), workers, streams };
        let one = measured(1, vec![stream(&[(tile(0), 1.0), (tile(16), 2.0)]), stream(&[(tile(0), 3.0)])]);
        // 2 + 2 alone; the third tile is not known there.
        let two = stream(&[(tile(0), 2.5), (tile(16), 2.5), (tile(32), 99.0)]);
        let two = measured(2, vec![two]);
        assert!((two.inflation(&one) - 1.25).abs() < 1e-12);
    }
}
