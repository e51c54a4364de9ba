//! What the tiles of a scene cost.

use super::{Costs, Flow, Replay, simulate};
use crate::math::median;
use crate::schedule::{CostMap, FrameStats, Plan, Schedule, Span};
use crate::tile::Tile;
use std::collections::HashMap;

/// What tiles cost one worker that has the machine for itself.
#[derive(Clone, Debug, Default)]
pub(super) struct TileCosts {
    seconds: HashMap<Tile, f64>,
    map: CostMap,
}

impl TileCosts {
    /// From the tiles of `frames`: the median of each. `base` covers the image.
    pub(super) fn new<'a>(base: &[Tile], frames: impl IntoIterator<Item = &'a FrameStats>) -> TileCosts {
        let mut samples = Samples::default();
        frames.into_iter().for_each(|frame| samples.add(frame, 1.0));
        let seconds: HashMap<Tile, f64> = samples.medians().collect();
        let mut map = CostMap::covering(base);
        base.iter().for_each(|&tile| map.record(tile, seconds.get(&tile).copied().unwrap_or(0.0)));
        TileCosts { seconds, map }
    }

    /// And what other tiles cost, which strategies cut from these. Each group are streams of one moment: the first one has these
    /// tiles, and tells how slow the machine was then.
    pub(super) fn with_smaller(mut self, groups: &[Vec<FrameStats>]) -> TileCosts {
        let mut samples = Samples::default();
        for group in groups {
            let Some((same, smaller)) = group.split_first() else { continue };
            let slowness = self.slowness_of_all(std::slice::from_ref(same));
            smaller.iter().for_each(|stream| samples.add(stream, slowness));
        }
        samples.medians().for_each(|(tile, seconds)| {
            self.seconds.entry(tile).or_insert(seconds);
        });
        self
    }

    /// By which factor each worker's tiles of a stream took longer than these.
    pub(super) fn slowness(&self, stream: &FrameStats) -> Vec<f64> {
        let streams = std::slice::from_ref(stream);
        (0..stream.workers.len()).map(|worker| self.slowness_of(streams, worker, 1.0)).collect()
    }

    /// By which factor the worker's tiles of these streams took longer than `usual` times these; 1 if it had none.
    pub(super) fn slowness_of(&self, streams: &[FrameStats], worker: usize, usual: f64) -> f64 {
        ratio(streams, &self.seconds, |span| span.worker == worker).map_or(1.0, |factor| factor / usual)
    }

    /// By which factor the tiles of these streams took longer than these.
    pub(super) fn slowness_of_all(&self, streams: &[FrameStats]) -> f64 {
        ratio(streams, &self.seconds, |_| true).unwrap_or(1.0)
    }

    /// What frames of `tiles` would take workers of such slowness.
    pub(super) fn simulate(
        &self,
        schedule: Schedule,
        slowness: &[f64],
        flow: Flow,
        tiles: &[Tile],
        costs: &Costs,
    ) -> FrameStats {
        let replay = |end| {
            let plan = Plan::new(schedule.strategy, slowness.len(), end, tiles, &self.map);
            let seconds = plan.tiles.iter().map(|&tile| self.of(tile)).collect();
            Replay { plan, seconds }
        };
        simulate(schedule, slowness, flow, replay, costs)
    }

    /// As it was measured, or what its pixels took in the tile around it.
    pub(super) fn of(&self, tile: Tile) -> f64 {
        self.seconds.get(&tile).copied().or_else(|| self.map.predict(tile)).unwrap_or(0.0)
    }
}

/// Seconds of tiles.
#[derive(Default)]
struct Samples(HashMap<Tile, Vec<f64>>);

impl Samples {
    /// Those of a stream in which everything took `slowness` times as long.
    fn add(&mut self, stream: &FrameStats, slowness: f64) {
        for span in &stream.spans {
            self.0.entry(span.tile).or_default().push((span.end - span.start) / slowness);
        }
    }

    fn medians(self) -> impl Iterator<Item = (Tile, f64)> {
        self.0.into_iter().map(|(tile, seconds)| (tile, median(&seconds)))
    }
}

/// Seconds of those tiles over what they cost, of those that have a cost, if there are any.
pub(super) fn ratio(
    streams: &[FrameStats],
    costs: &HashMap<Tile, f64>,
    of: impl Fn(&Span) -> bool,
) -> Option<f64> {
    let spans = streams.iter().flat_map(|stream| &stream.spans).filter(|span| of(span));
    let common = spans.filter_map(|span| Some((span.end - span.start, *costs.get(&span.tile)?)));
    let (took, cost) = common.fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
    (cost > 0.0).then(|| took / cost)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A stream of one frame whose tiles took so long, one after another.
    pub(in crate::study::scaling) fn stream(tiles: &[(Tile, f64)]) -> FrameStats {
        let mut seconds = 0.0;
        let mut spans = vec![];
        for &(tile, took) in tiles {
            spans.push(Span { frame: 0, worker: 0, tile, start: seconds, end: seconds + took });
            seconds += took;
        }
        FrameStats { frames: 1, seconds, spans, ..FrameStats::default() }
    }

    #[test]
    fn a_tile_costs_its_median_and_a_part_of_it_its_share() {
        let tile = Tile { x: 0, y: 0, width: 32, height: 32 };
        let frames = [1.0, 9.0, 3.0].map(|end| stream(&[(tile, end)]));
        let costs = TileCosts::new(&[tile], &frames);
        assert_eq!(costs.of(tile), 3.0);
        assert_eq!(costs.slowness_of_all(&frames), (1.0 + 9.0 + 3.0) / 9.0);
        assert!((costs.of(Tile { width: 16, ..tile }) - 1.5).abs() < 1e-12);
        assert_eq!(costs.of(Tile { x: 32, ..tile }), 0.0, "of what is not in the image");
    }

    #[test]
    fn smaller_tiles_cost_what_they_did_beside_the_same_ones() {
        let [whole, half, cut] = [32, 16, 8].map(|width| Tile { x: 0, y: 0, width, height: 32 });
        // The cut one was seen among these.
        let costs = TileCosts::new(&[whole], &[stream(&[(whole, 8.0), (cut, 3.0)])]);
        let group =
            |slow, half_took| vec![stream(&[(whole, 8.0 * slow)]), stream(&[(half, half_took), (cut, 99.0)])];
        let costs = costs.with_smaller(&[group(1.0, 5.0), group(2.0, 10.5), group(3.0, 30.0), vec![]]);
        assert_eq!([whole, half, cut].map(|tile| costs.of(tile)), [8.0, 5.25, 3.0]);
    }

    #[test]
    fn each_worker_is_slow_by_its_own_tiles_and_who_has_none_is_not() {
        let tile = |x| Tile { x, y: 0, width: 16, height: 16 };
        let costs = TileCosts::new(&[tile(0), tile(16)], [&stream(&[(tile(0), 2.0), (tile(16), 4.0)])]);
        // The third tile is not known.
        let mut many = stream(&[(tile(0), 5.0), (tile(16), 4.0), (tile(32), 99.0)]);
        many.spans[1].worker = 1;
        let of = |worker| costs.slowness_of(std::slice::from_ref(&many), worker, 2.0);
        assert_eq!([0, 1, 2].map(of), [1.25, 0.5, 1.0]);
        assert_eq!(costs.slowness_of_all(&[many]), 9.0 / 6.0);
        assert_eq!(costs.slowness_of_all(&[]), 1.0);
    }
}
