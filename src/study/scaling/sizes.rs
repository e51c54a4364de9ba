//! Plachetka's question (chapter 3.8 of the thesis): how large should tiles be?
//!
//! He found one column of the image per task best where the dearest of two regions of one size takes 2.5 to 4 times as
//! long as the cheapest. So each size is told with that ratio; and with that of the dearest tile to the mean, since a
//! cheapest tile that shows nothing but background makes the first one huge.

use super::measure::TileCosts;
use super::{Costs, median, on_cores, simulate};
use crate::{
    error::Result,
    render::{RenderOptions, Stage},
    scene::Scene,
    schedule::{Control, Machine, Placement, Plan, Schedule},
};

/// Ratios of Plachetka's rule.
const RATIOS: std::ops::RangeInclusive<f64> = 2.5..=4.0;

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

/// Measures frames of every size in `sides` for 1 worker up to the machine's, and simulates more.
///
/// # Errors
/// As [`Stage::new`] and [`crate::render::Session::frame`].
pub fn tile_sizes(
    scene: &Scene,
    options: &RenderOptions,
    sides: &[u32],
    workers: &[usize],
    rounds: u32,
    costs: &Costs,
    control: &Control<'_>,
) -> Result<Vec<SizeRow>> {
    let stage = Stage::new(scene, options)?;
    let schedule = options.schedule;
    let cores = Machine::get().default_workers();
    let mut one: Vec<Vec<_>> = vec![vec![]; sides.len()];
    let mut many: Vec<(usize, usize, Vec<f64>)> = vec![];
    for _ in 0..rounds {
        for &count in std::iter::once(&1).chain(workers.iter().filter(|&&n| n > 1 && n <= cores)) {
            let placement = Placement::new(Machine::get(), Some(count), options.pin);
            stage.with_session(&placement, |session| {
                session.frame(schedule, &stage.tiles(64), control)?;
                for (index, &side) in sides.iter().enumerate() {
                    let frame = session.frame(schedule, &stage.tiles(side), control)?;
                    match many.iter_mut().find(|(i, n, _)| (*i, *n) == (index, count)) {
                        Some((_, _, seconds)) => seconds.push(frame.seconds),
                        None => many.push((index, count, vec![frame.seconds])),
                    }
                    if count == 1 {
                        one[index].push(frame);
                    }
                }
                Ok(())
            })?;
        }
    }
    let mut rows = vec![];
    for &count in workers {
        for (index, &side) in sides.iter().enumerate() {
            let measured = many.iter().find(|(i, n, _)| (*i, *n) == (index, count));
            rows.push(row(scene, &stage, schedule, [side, count as u32], &one[index], measured, costs));
        }
    }
    mark(&mut rows, workers);
    Ok(rows)
}

fn row(
    scene: &Scene,
    stage: &Stage<'_>,
    schedule: Schedule,
    [side, workers]: [u32; 2],
    frames: &[crate::schedule::FrameStats],
    measured: Option<&(usize, usize, Vec<f64>)>,
    costs: &Costs,
) -> SizeRow {
    let workers = workers as usize;
    let tiles = stage.tiles(side);
    let tile_costs = TileCosts::new(&tiles, frames);
    // Tiles at the edges of the image are smaller, and no measure of what regions of one size cost.
    let full = |tile: &&crate::tile::Tile| tile.width == side && tile.height == side;
    let mut seconds: Vec<f64> = tiles.iter().filter(full).map(|&tile| tile_costs.of(tile)).collect();
    seconds.sort_by(f64::total_cmp);
    let dearest = seconds.last().copied().unwrap_or(f64::NAN);
    let cheapest = seconds.first().copied().unwrap_or(f64::NAN);
    let mean = seconds.iter().sum::<f64>() / seconds.len().max(1) as f64;
    let predicted = || {
        let plan = Plan::new(schedule.strategy, workers, &tiles, tile_costs.map());
        let seconds: Vec<f64> = plan.tiles.iter().map(|&tile| tile_costs.of(tile)).collect();
        simulate(schedule, workers, &plan, &seconds, &on_cores(*costs, workers)).seconds
    };
    SizeRow {
        scene: scene.name.clone(),
        side,
        tiles: tiles.len(),
        workers,
        simulated: measured.is_none(),
        seconds: measured.map_or_else(predicted, |(_, _, seconds)| median(seconds)),
        ratio: dearest / cheapest,
        over_mean: dearest / mean,
        best: false,
        by_rule: false,
    }
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
