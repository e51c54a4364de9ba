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

    /// By which factor each worker's tiles of a stream took longer than these.
    pub(super) fn slowness(&self, stream: &FrameStats) -> Vec<f64> {
        let streams = std::slice::from_ref(stream);
        let of = |worker| ratio(streams, &self.seconds, |span| span.worker == worker);
        (0..stream.workers.len()).map(of).collect()
    }

    /// By which factor the tiles of these streams took longer than these.
    pub(super) fn slowness_of_all(&self, streams: &[FrameStats]) -> f64 {
        ratio(streams, &self.seconds, |_| true)
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

/// Seconds of those tiles over what they cost, of those that have a cost; 1 if there are none.
pub(super) fn ratio(streams: &[FrameStats], costs: &HashMap<Tile, f64>, of: impl Fn(&Span) -> bool) -> f64 {
    let spans = streams.iter().flat_map(|stream| &stream.spans).filter(|span| of(span));
    let common = spans.filter_map(|span| Some((span.end - span.start, *costs.get(&span.tile)?)));
    let (took, cost) = common.fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
    if cost > 0.0 { took / cost } else { 1.0 }
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
}
