//! Frames of a scene under every schedule, in interleaved rounds, and what its tiles cost.

use crate::error::Result;
use crate::render::{Session, Stage};
use crate::schedule::{Control, CostMap, FilmMode, FrameStats, Machine, Placement, Schedule, Strategy};
use crate::tile::Tile;
use std::collections::HashMap;

/// Frames of one schedule with one number of workers.
#[derive(Clone, Debug)]
pub struct Measured {
    /// How they were scheduled.
    pub schedule: Schedule,
    /// By how many workers.
    pub workers: usize,
    /// In the order of the rounds.
    pub frames: Vec<FrameStats>,
}

impl Measured {
    /// The frame whose time is the median (of an even number the faster one of the middle two).
    pub fn median_frame(&self) -> &FrameStats {
        let mut order: Vec<&FrameStats> = self.frames.iter().collect();
        order.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        order[(order.len() - 1) / 2]
    }

    /// Seconds of each frame.
    pub fn seconds(&self) -> Vec<f64> {
        self.frames.iter().map(|frame| frame.seconds).collect()
    }
}

/// Renders `rounds` frames for each schedule and number of workers: round by round, so that a busy moment of the machine
/// hits all of them alike. The first frame of new workers is not counted.
///
/// # Errors
/// As [`Session::frame`], and [`crate::error::Error::Failed`] if two images differ.
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
                    check_image(session, measured.schedule, &mut hash)?;
                }
                Ok(())
            })?;
        }
    }
    Ok(all)
}

/// A schedule that changes the image is not worth timing.
fn check_image(session: &Session<'_, '_>, schedule: Schedule, expected: &mut Option<String>) -> Result<()> {
    let hash = session.film().sha256();
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
pub struct TileCosts {
    seconds: HashMap<Tile, f64>,
    map: CostMap,
}

impl TileCosts {
    /// From the tiles of `frames`: the median of each. `base` covers the image.
    pub fn new<'a>(base: &[Tile], frames: impl IntoIterator<Item = &'a FrameStats>) -> TileCosts {
        let mut samples: HashMap<Tile, Vec<f64>> = HashMap::new();
        for span in frames.into_iter().flat_map(|frame| &frame.spans) {
            samples.entry(span.tile).or_default().push(span.end - span.start);
        }
        let seconds: HashMap<Tile, f64> = samples
            .into_iter()
            .map(|(tile, mut seconds)| {
                seconds.sort_by(f64::total_cmp);
                (tile, seconds[seconds.len() / 2])
            })
            .collect();
        let mut map = CostMap::covering(base);
        base.iter().for_each(|&tile| map.record(tile, seconds.get(&tile).copied().unwrap_or(0.0)));
        TileCosts { seconds, map }
    }

    /// As it was measured, or what its pixels took in the tile around it.
    pub fn of(&self, tile: Tile) -> f64 {
        self.seconds.get(&tile).copied().or_else(|| self.map.predict(tile)).unwrap_or(0.0)
    }

    /// For the cost-guided strategy.
    pub fn map(&self) -> &CostMap {
        &self.map
    }
}

/// Frames of one worker with tiles of half the side, a quarter and so on, down to 16 pixels: the strategies that cut tiles
/// cut them so.
///
/// # Errors
/// As [`Session::frame`].
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
