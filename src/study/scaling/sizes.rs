//! Plachetka's question (chapter 3.8 of the thesis): how large should tiles be?
//!
//! He found one column of the image per task best where the dearest of two regions of one size takes 2.5 to 4 times as
//! long as the cheapest. So each size is told with that ratio; and with that of the dearest tile to the mean, since a
//! cheapest tile that shows nothing but background makes the first one huge.

use super::{
    Costs, Flow, LONGEST_MEASURED, LONGEST_SIMULATED, ScalingOptions,
    costs::{MESSAGES, SharedCores},
    tiles::TileCosts,
};
use crate::{
    error::Result,
    math::median,
    render::Stage,
    scene::Scene,
    schedule::{Control, FrameStats, Machine, Placement},
    tile::Tile,
};
use std::collections::BTreeMap;

/// Ratios of Plachetka's rule.
const RATIOS: std::ops::RangeInclusive<f64> = 2.5..=4.0;
/// Side of the tiles between messages.
const BASE: u32 = 64;

/// One size of tiles.
#[derive(Clone, Debug)]
pub struct SizeRow {
    /// The scene's name.
    pub scene: String,
    /// Side of a tile in pixels.
    pub side: u32,
    /// Number of tiles.
    pub tiles: usize,
    /// Workers of the frame times.
    pub workers: usize,
    /// Predicted from the tile costs of one worker instead of measured.
    pub simulated: bool,
    /// Seconds of a frame: the median of the rounds.
    pub seconds: f64,
    /// Cost of the dearest tile over that of the cheapest.
    pub ratio: f64,
    /// Cost of the dearest tile over the mean.
    pub over_mean: f64,
    /// The fastest size for this scene and number of workers.
    pub best: bool,
    /// The size that the rule picks: the largest one with a ratio of 2.5 to 4, if there is one.
    pub by_rule: bool,
}

/// Tiles of one size, and what they cost one worker.
struct Size {
    side: u32,
    tiles: Vec<Tile>,
    costs: TileCosts,
    ratio: f64,
    over_mean: f64,
}

impl Size {
    fn new(stage: &Stage<'_>, side: u32, frames: &[FrameStats]) -> Size {
        let tiles = stage.tiles(side);
        let costs = TileCosts::new(&tiles, frames);
        let [ratio, over_mean] = ratios(side, &tiles, &costs);
        Size { side, tiles, costs, ratio, over_mean }
    }
}

/// Cost of the dearest tile over that of the cheapest and over the mean. Tiles at the edges of the image are smaller, and no
/// measure of what regions of one size cost.
fn ratios(side: u32, tiles: &[Tile], costs: &TileCosts) -> [f64; 2] {
    let full = |tile: &&Tile| tile.width == side && tile.height == side;
    let seconds: Vec<f64> = tiles.iter().filter(full).map(|&tile| costs.of(tile)).collect();
    let dearest = seconds.iter().copied().fold(f64::NAN, f64::max);
    let cheapest = seconds.iter().copied().fold(f64::NAN, f64::min);
    let mean = seconds.iter().sum::<f64>() / seconds.len().max(1) as f64;
    [dearest / cheapest, dearest / mean]
}

/// Measures frames of every size in `sides` under the schedule of `options.render` for 1 worker up to the machine's, and
/// simulates more.
///
/// # Errors
/// As [`Stage::new`] and [`crate::render::Session::stream`].
pub fn tile_sizes(
    scene: &Scene,
    options: &ScalingOptions,
    sides: &[u32],
    costs: &Costs,
    control: &Control<'_>,
) -> Result<Vec<SizeRow>> {
    let ScalingOptions { ref render, ref workers, rounds, flow, .. } = *options;
    let stage = Stage::new(scene, render)?;
    let schedule = render.schedule;
    let cores = Machine::get().default_workers();
    let mut alone: BTreeMap<u32, Vec<FrameStats>> = BTreeMap::new();
    let mut measured: BTreeMap<(u32, usize), Vec<f64>> = BTreeMap::new();
    let most = workers.iter().copied().filter(|&n| n <= cores).max().unwrap_or(1);
    let placement = Placement::new(Machine::get(), Some(most), render.pin);
    let counts: Vec<usize> =
        std::iter::once(1).chain(workers.iter().copied().filter(|&n| n > 1 && n <= cores)).collect();
    // What a message costs hardly depends on the size of the tiles between.
    let base = stage.tiles(BASE);
    let mut shared = SharedCores::new(render.pin, std::iter::once(schedule.film));
    stage.with_session(&placement, |session| {
        // The first frames of new threads do not count.
        let Flow { frames, in_flight } = flow.of(most, LONGEST_MEASURED);
        session.stream(schedule, &base, frames, in_flight, control)?;
        for round in 0..rounds as usize {
            for &side in sides {
                for &count in &counts {
                    let first = if count == 1 { round % most } else { 0 };
                    session.employ(first..first + count);
                    let Flow { frames, in_flight } = flow.of(count, LONGEST_MEASURED);
                    let stats = session.stream(schedule, &stage.tiles(side), frames, in_flight, control)?;
                    measured.entry((side, count)).or_default().push(stats.per_frame());
                    if count == 1 {
                        alone.entry(side).or_default().push(stats);
                    }
                }
            }
            shared.measure(session, &base, MESSAGES);
        }
        Ok(())
    })?;
    let costs = shared.found(*costs, &base);
    let frames = |side: u32| alone.get(&side).map_or(&[][..], Vec::as_slice);
    let sizes: Vec<Size> = sides.iter().map(|&side| Size::new(&stage, side, frames(side))).collect();
    let mut rows = vec![];
    for &count in workers {
        for size in &sizes {
            let measured = measured.get(&(size.side, count));
            let predicted = || {
                let flow = flow.of(count, LONGEST_SIMULATED);
                size.costs
                    .simulate(
                        schedule,
                        &vec![1.0; count],
                        flow,
                        &size.tiles,
                        &costs.of(schedule.film).on_cores(count),
                    )
                    .per_frame()
            };
            rows.push(SizeRow {
                scene: scene.name.clone(),
                side: size.side,
                tiles: size.tiles.len(),
                workers: count,
                simulated: measured.is_none(),
                seconds: measured.map_or_else(predicted, |seconds| median(seconds)),
                ratio: size.ratio,
                over_mean: size.over_mean,
                best: false,
                by_rule: false,
            });
        }
    }
    mark(&mut rows, workers);
    Ok(rows)
}

/// Marks the best size and the rule's for each number of workers.
fn mark(rows: &mut [SizeRow], workers: &[usize]) {
    for &count in workers {
        let mut group: Vec<&mut SizeRow> = rows.iter_mut().filter(|row| row.workers == count).collect();
        if let Some(best) = group.iter_mut().min_by(|a, b| a.seconds.total_cmp(&b.seconds)) {
            best.best = true;
        }
        if let Some(chosen) =
            group.iter_mut().filter(|row| RATIOS.contains(&row.ratio)).max_by_key(|row| row.side)
        {
            chosen.by_rule = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::Span;

    #[test]
    fn tiles_that_the_edge_of_the_image_cuts_are_not_compared() {
        let tile = |x, width| Tile { x, y: 0, width, height: 16 };
        let tiles = [(tile(0, 16), 2.0), (tile(16, 16), 6.0), (tile(32, 16), 1.0), (tile(48, 5), 0.1)];
        let spans = tiles.map(|(tile, end)| Span { frame: 0, worker: 0, tile, start: 0.0, end }).to_vec();
        let tiles = tiles.map(|(tile, _)| tile);
        let costs = TileCosts::new(&tiles, &[FrameStats { frames: 1, spans, ..FrameStats::default() }]);
        assert_eq!(ratios(16, &tiles, &costs), [6.0, 2.0]);
    }

    #[test]
    fn the_fastest_size_and_the_largest_one_within_the_rule_are_marked_for_each_number_of_workers() {
        let row = |workers, side, seconds, ratio| SizeRow {
            scene: String::new(),
            side,
            tiles: 1,
            workers,
            simulated: false,
            seconds,
            ratio,
            over_mean: 1.0,
            best: false,
            by_rule: false,
        };
        let mut rows = [
            row(1, 16, 2.0, 5.0),
            row(1, 32, 1.0, 4.0),
            row(1, 64, 3.0, 2.5),
            row(1, 128, 4.0, 2.4),
            row(2, 16, 1.0, 1.0),
            row(2, 32, 2.0, 9.0),
        ];
        mark(&mut rows, &[1, 2]);
        assert_eq!(rows.each_ref().map(|row| row.best), [false, true, false, false, true, false]);
        assert_eq!(rows.each_ref().map(|row| row.by_rule), [false, false, true, false, false, false]);
    }
}
