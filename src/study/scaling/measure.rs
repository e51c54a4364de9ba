//! Frames of a scene under every schedule, in interleaved rounds, and what its tiles cost.

use super::{Costs, simulate};
use crate::error::Result;
use crate::math::median;
use crate::render::Stage;
use crate::schedule::{Control, CostMap, FilmMode, FrameStats, Machine, Placement, Plan, Schedule, Strategy};
use crate::tile::Tile;
use std::collections::HashMap;

/// Frames of one schedule with one number of workers.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    /// How they were scheduled.
    pub(super) schedule: Schedule,
    /// By how many workers.
    pub(super) workers: usize,
    /// In the order of the rounds.
    pub(super) frames: Vec<FrameStats>,
}

impl Measured {
    /// The frame whose time is the median (of an even number the faster one of the middle two).
    pub(super) fn median_frame(&self) -> &FrameStats {
        let mut order: Vec<&FrameStats> = self.frames.iter().collect();
        order.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        order[(order.len() - 1) / 2]
    }

    /// Seconds of each frame.
    pub(super) fn seconds(&self) -> Vec<f64> {
        self.frames.iter().map(|frame| frame.seconds).collect()
    }
}

/// Renders `rounds` frames for each schedule and number of workers: round by round, so that a busy moment of the machine
/// hits all of them alike. The first frame of new workers is not counted.
///
/// # Errors
/// As [`crate::render::Session::frame`], and [`crate::error::Error::Failed`] if two images differ.
pub(super) fn measure(
    stage: &Stage<'_>,
    schedules: &[Schedule],
    workers: &[usize],
    rounds: u32,
    pin: bool,
    side: u32,
    control: &Control<'_>,
) -> Result<Vec<Measured>> {
    let tiles = stage.tiles(side);
    let mut all: Vec<Measured> = workers
        .iter()
        .flat_map(|&workers| {
            schedules.iter().map(move |&schedule| Measured { schedule, workers, frames: vec![] })
        })
        .collect();
    let mut hash: Option<String> = None;
    for _ in 0..rounds {
        for &count in workers {
            let placement = Placement::new(Machine::get(), Some(count), pin);
            stage.with_session(&placement, |session| {
                session.frame(Schedule::default(), &tiles, control)?;
                for measured in all.iter_mut().filter(|measured| measured.workers == count) {
                    measured.frames.push(session.frame(measured.schedule, &tiles, control)?);
                    check_image(session.film().sha256(), measured.schedule, &mut hash)?;
                }
                Ok(())
            })?;
        }
    }
    Ok(all)
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

/// What tiles cost one worker that has the machine for itself.
#[derive(Clone, Debug, Default)]
pub(super) struct TileCosts {
    seconds: HashMap<Tile, f64>,
    map: CostMap,
}

impl TileCosts {
    /// From the tiles of `frames`: the median of each. `base` covers the image.
    pub(super) fn new<'a>(base: &[Tile], frames: impl IntoIterator<Item = &'a FrameStats>) -> TileCosts {
        let mut samples: HashMap<Tile, Vec<f64>> = HashMap::new();
        for span in frames.into_iter().flat_map(|frame| &frame.spans) {
            samples.entry(span.tile).or_default().push(span.end - span.start);
        }
        let seconds: HashMap<Tile, f64> =
            samples.into_iter().map(|(tile, seconds)| (tile, median(&seconds))).collect();
        let mut map = CostMap::covering(base);
        base.iter().for_each(|&tile| map.record(tile, seconds.get(&tile).copied().unwrap_or(0.0)));
        TileCosts { seconds, map }
    }

    /// What a frame of `tiles` would take `workers` workers.
    pub(super) fn simulate(
        &self,
        schedule: Schedule,
        workers: usize,
        tiles: &[Tile],
        costs: &Costs,
    ) -> FrameStats {
        let plan = Plan::new(schedule.strategy, workers, tiles, &self.map);
        let seconds: Vec<f64> = plan.tiles.iter().map(|&tile| self.of(tile)).collect();
        simulate(schedule, workers, &plan, &seconds, costs)
    }

    /// As it was measured, or what its pixels took in the tile around it.
    pub(super) fn of(&self, tile: Tile) -> f64 {
        self.seconds.get(&tile).copied().or_else(|| self.map.predict(tile)).unwrap_or(0.0)
    }
}

/// Frames of one worker with tiles of half the side, a quarter and so on, down to 16 pixels: the strategies that cut tiles
/// cut them so.
///
/// # Errors
/// As [`crate::render::Session::frame`].
pub(super) fn smaller_tiles(
    stage: &Stage<'_>,
    film: FilmMode,
    side: u32,
    pin: bool,
    control: &Control<'_>,
) -> Result<Vec<FrameStats>> {
    let placement = Placement::new(Machine::get(), Some(1), pin);
    let schedule = Schedule { strategy: Strategy::Stealing, film };
    let sides: Vec<u32> =
        std::iter::successors(Some(side / 2), |side| Some(side / 2)).take_while(|&side| side >= 16).collect();
    stage.with_session(&placement, |session| {
        let mut frames = vec![];
        for side in sides {
            let tiles = stage.tiles(side);
            for _ in 0..3 {
                frames.push(session.frame(schedule, &tiles, control)?);
            }
        }
        Ok(frames)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::{Messages, Span};

    #[test]
    fn a_tile_costs_its_median_and_a_part_of_it_its_share() {
        let tile = Tile { x: 0, y: 0, width: 32, height: 32 };
        let frames = [1.0, 9.0, 3.0].map(|end| FrameStats {
            seconds: end,
            workers: vec![],
            spans: vec![Span { worker: 0, tile, start: 0.0, end }],
            tasks: Messages::default(),
            reports: Messages::default(),
        });
        let costs = TileCosts::new(&[tile], &frames);
        assert_eq!(costs.of(tile), 3.0);
        assert!((costs.of(Tile { width: 16, ..tile }) - 1.5).abs() < 1e-12);
        assert_eq!(costs.of(Tile { x: 32, ..tile }), 0.0, "of what is not in the image");
    }

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
    fn the_median_frame_is_one_that_was_rendered() {
        let frame = |seconds: f64| FrameStats {
            seconds,
            workers: vec![],
            spans: vec![],
            tasks: Messages::default(),
            reports: Messages::default(),
        };
        let frames = [4.0, 1.0, 3.0, 2.0].map(frame).to_vec();
        let measured = Measured { schedule: Schedule::default(), workers: 1, frames };
        assert_eq!(measured.median_frame().seconds, 2.0);
        assert_eq!(measured.seconds(), [4.0, 1.0, 3.0, 2.0]);
    }
}
