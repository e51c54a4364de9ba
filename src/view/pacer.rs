//! What a frame can afford: which pixels to trace in the time there is.
//!
//! Every frame begins with a *base*, the same level everywhere, so that the picture is complete: all pixels if there is
//! time for them, else a quarter, else a sixteenth. The rest of the time goes to the tiles where it helps most: larger
//! and more varied regions first (Notkin and Gotsman, "Parallel progressive ray-tracing", 1997).

use crate::{
    render::{Level, Progressive, Target},
    tile::Tile,
};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::time::Duration;

/// Share of a frame's time that is planned for; the rest is for what no estimate foresees.
const PLANNED: f64 = 0.87;
/// How much a new measurement counts against the old ones.
const WEIGHT: f64 = 0.4;
/// Bytes of sRGB that any neighbours are taken to differ by: what looks even may hide something.
const LEAST_VARIATION: f64 = 1.0;

/// Seconds of a worker per pixel, by level that the pixel belongs to.
type Rates = [f64; 5];

/// Learns what pixels cost, and plans frames.
#[derive(Clone, Debug)]
pub struct Pacer {
    budget: f64,
    base: Rates,
    refine: Rates,
    fill: f64,
}

impl Pacer {
    /// For frames of this length.
    pub fn new(budget: Duration) -> Pacer {
        // Before anything is known: as slow as a large scene on an old machine, so that the first frame is in time.
        let rates = [0.0, 1.0e-6, 6.0e-7, 5.0e-7, 4.0e-7];
        Pacer { budget: budget.as_secs_f64(), base: rates, refine: rates, fill: 2.0e-3 }
    }

    /// Seconds that a frame may spend on tracing.
    pub fn tracing(&self) -> f64 {
        (PLANNED * self.budget - self.fill).max(0.2 * self.budget)
    }

    /// The same for a frame that took this long until tracing could begin.
    pub fn left(&self, before: Duration) -> f64 {
        (self.tracing() - before.as_secs_f64()).max(0.2 * self.budget)
    }

    /// The level that everything is traced at first, in so many seconds, for this many pixels and workers.
    pub fn base(&self, available: f64, pixels: f64, workers: usize) -> Level {
        let seconds =
            |level: Level| self.base[level as usize] * level.share() * pixels / workers.max(1) as f64;
        let fits = |level: &Level| seconds(*level) <= available;
        [Level::Full, Level::Quarter].into_iter().find(fits).unwrap_or(Level::Sixteenth)
    }

    /// Learns what a base pass took.
    pub fn learn_base(&mut self, level: Level, pixels: f64, workers: usize, seconds: f64) {
        let measured = seconds * workers as f64 / (level.share() * pixels).max(1.0);
        let rates = &mut self.base;
        let old = rates[level as usize];
        let factor = (1.0 - WEIGHT) + WEIGHT * measured / old;
        // The other levels are likely to have become slower or faster with it.
        rates.iter_mut().for_each(|rate| *rate *= factor);
    }

    /// Learns by which factor a refining pass took longer than planned.
    pub fn learn_refine(&mut self, planned: f64, seconds: f64) {
        if planned > 0.0 {
            let factor = (1.0 - WEIGHT) + WEIGHT * (seconds / planned).clamp(0.1, 10.0);
            self.refine.iter_mut().for_each(|rate| *rate *= factor);
        }
    }

    /// Learns what filling in the missing pixels took.
    pub fn learn_fill(&mut self, seconds: f64) {
        self.fill += WEIGHT * (seconds - self.fill);
    }

    /// The tiles to raise in `seconds` with these workers, and the seconds that is expected to take. At least one, if any
    /// is left.
    pub fn refine(&self, regions: &[Region], seconds: f64, workers: usize) -> (Vec<Target>, f64) {
        let mut goals: Vec<Level> = regions.iter().map(|region| region.level).collect();
        let mut heap: BinaryHeap<Candidate> = regions
            .iter()
            .enumerate()
            .filter_map(|(place, region)| Candidate::new(place, region, region.level))
            .collect();
        let mut planned = 0.0;
        while planned < seconds {
            let Some(Candidate { place, .. }) = heap.pop() else { break };
            let (region, from) = (&regions[place], goals[place]);
            let to = next(from);
            let pixels = (to.share() - from.share()) * region.tile.len() as f64;
            planned += self.refine[to as usize] * pixels / workers.max(1) as f64;
            goals[place] = to;
            heap.extend(Candidate::new(place, region, to));
        }
        let raised = |(region, goal): (&Region, Level)| {
            (goal > region.level).then_some(Target { tile: region.tile, level: goal })
        };
        (regions.iter().zip(goals).filter_map(raised).collect(), planned)
    }
}

/// A part of the image that is refined as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Where it is.
    pub tile: Tile,
    /// How far it is.
    pub level: Level,
    /// How different neighbouring pixels are: see [`Progressive::variation`].
    pub variation: f64,
}

/// The regions of a frame, in the order of the options.
pub fn regions(session: &Progressive, side: u32) -> Vec<Region> {
    let region = |tile| Region { tile, level: session.level(tile), variation: session.variation(tile) };
    session.tiles(side).into_iter().map(region).collect()
}

/// The level after this one.
fn next(level: Level) -> Level {
    Level::ALL[(level as usize + 1).min(4)]
}

/// A region and what it gains by being refined.
struct Candidate {
    gain: f64,
    place: usize,
}

impl Candidate {
    /// `None` if nothing is left to refine.
    fn new(place: usize, region: &Region, level: Level) -> Option<Candidate> {
        // Each refinement halves the differences that are left, about.
        let variation = region.variation * 0.5f64.powi(level as i32 - region.level as i32) + LEAST_VARIATION;
        let missing = (1.0 - level.share()) * region.tile.len() as f64;
        (level < Level::Full).then_some(Candidate { gain: missing * variation, place })
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Candidate) -> Ordering {
        // Equals in the order of the image.
        self.gain.total_cmp(&other.gain).then(other.place.cmp(&self.place))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Candidate) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Candidate) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(x: u32, width: u32, level: Level, variation: f64) -> Region {
        Region { tile: Tile { x, y: 0, width, height: 64 }, level, variation }
    }

    #[test]
    fn larger_and_more_varied_regions_come_first() {
        let pacer = Pacer::new(Duration::from_millis(33));
        let regions = [
            region(0, 64, Level::Quarter, 1.0),
            region(64, 64, Level::Quarter, 50.0),
            region(128, 16, Level::Quarter, 50.0),
            region(144, 64, Level::Full, 500.0),
        ];
        let one = pacer.refine(&regions, 1e-12, 1).0;
        assert_eq!(one, [Target { tile: regions[1].tile, level: Level::Half }]);
        let all = pacer.refine(&regions, 1e12, 1).0;
        assert_eq!(all.len(), 3);
        assert!(all.iter().all(|target| target.level == Level::Full));
        assert_eq!(pacer.refine(&regions[3..], 1e12, 1), (vec![], 0.0));
    }

    #[test]
    fn a_frame_begins_with_what_there_is_time_for() {
        let mut pacer = Pacer::new(Duration::from_millis(33));
        let levels: Vec<Level> = [1e-9, 1e-7, 1e-6, 1e-3]
            .map(|seconds: f64| {
                // Once per pixel, until it is believed.
                (0..40).for_each(|_| pacer.learn_base(Level::Quarter, 1e6, 2, seconds * 0.25e6 / 2.0));
                pacer.base(pacer.tracing(), 1e6, 2)
            })
            .to_vec();
        assert_eq!(levels, [Level::Full, Level::Quarter, Level::Sixteenth, Level::Sixteenth]);
    }

    #[test]
    fn a_plan_takes_the_time_it_was_given() {
        let mut pacer = Pacer::new(Duration::from_millis(33));
        let regions: Vec<Region> =
            (0..100).map(|i| region(64 * i, 64, Level::Quarter, f64::from(i))).collect();
        // A machine that takes 3e-7 s per pixel whatever it is: two workers, 10 ms.
        for _ in 0..40 {
            let (targets, planned) = pacer.refine(&regions, 0.01, 2);
            let pixels: f64 = targets.iter().map(|target| (target.level.share() - 0.25) * 4096.0).sum();
            pacer.learn_refine(planned, 3e-7 * pixels / 2.0);
        }
        let (targets, _) = pacer.refine(&regions, 0.01, 2);
        let pixels: f64 = targets.iter().map(|target| (target.level.share() - 0.25) * 4096.0).sum();
        let seconds = 3e-7 * pixels / 2.0;
        assert!((0.009..0.0115).contains(&seconds), "{seconds}");
    }
}
