//! Tables and machine-readable rows of `irt scaling`.

use super::number::significant;
use super::{Cell, Statistics, Table};
use crate::math::Spread;
use crate::schedule::{FilmMode, Strategy};
use crate::study::scaling::{ScalingRow, SizeRow};
use serde::Serialize;

/// One row of `--export-json`.
#[derive(Clone, Debug, Serialize)]
pub struct ScalingRecord {
    scene: String,
    strategy: &'static str,
    film: &'static str,
    workers: usize,
    simulated: bool,
    fps: f64,
    fps_min: f64,
    fps_max: f64,
    rounds: usize,
    frames: usize,
    speedup: f64,
    efficiency: f64,
    efficiency_fastest: f64,
    inflation: f64,
    scheduling_efficiency: f64,
    predicted_efficiency: Option<f64>,
    /// By how much that is too much, round by round.
    apart: Option<Spread>,
    thesis_fps: Option<f64>,
    thesis_efficiency: Option<f64>,
    idle: Vec<IdleRecord>,
    tasks: MessageRecord,
    reports: MessageRecord,
    /// Seconds that the master was busy with frames, and with reports.
    master: [f64; 2],
    limited_by: &'static str,
    limit_share: f64,
}

/// One worker in the stream of the median round, in seconds.
#[derive(Clone, Debug, Serialize)]
struct IdleRecord {
    tiles: usize,
    steals: usize,
    busy: f64,
    start: f64,
    work: f64,
    deliver: f64,
    tail: f64,
}

/// Messages of one direction in the stream of the median round; latencies in seconds; late are those of more than 0.3 ms.
#[derive(Clone, Debug, Serialize)]
struct MessageRecord {
    count: usize,
    awaited: usize,
    latency_mean: f64,
    latency_max: f64,
    late: usize,
}

impl From<&ScalingRow> for ScalingRecord {
    fn from(row: &ScalingRow) -> ScalingRecord {
        let messages = |m: &crate::schedule::Messages| MessageRecord {
            count: m.count,
            awaited: m.awaited,
            latency_mean: m.latency(),
            latency_max: m.latency_max,
            late: m.late,
        };
        let idle = row.frame.workers.iter().map(|worker| IdleRecord {
            tiles: worker.tiles,
            steals: worker.steals,
            busy: worker.busy_seconds,
            start: worker.idle.start,
            work: worker.idle.work,
            deliver: worker.idle.deliver,
            tail: worker.idle.tail,
        });
        let (min, max) = Statistics::of(&row.seconds).map_or((f64::NAN, f64::NAN), |s| (s.min, s.max));
        let (limited_by, limit_share) = row.limits()[0];
        ScalingRecord {
            scene: row.scene.clone(),
            strategy: row.schedule.strategy.name(),
            film: row.schedule.film.name(),
            workers: row.workers,
            simulated: row.simulated,
            fps: 1.0 / row.median(),
            fps_min: 1.0 / max,
            fps_max: 1.0 / min,
            rounds: row.seconds.len(),
            frames: row.frame.frames,
            speedup: row.efficiency * row.workers as f64,
            efficiency: row.efficiency,
            efficiency_fastest: row.fastest,
            inflation: row.inflation,
            scheduling_efficiency: row.scheduling(),
            predicted_efficiency: row.predicted,
            apart: row.apart,
            thesis_fps: row.thesis.map(|thesis| thesis.fps),
            thesis_efficiency: row.thesis.and_then(|thesis| thesis.efficiency),
            idle: idle.collect(),
            tasks: messages(&row.frame.tasks),
            reports: messages(&row.frame.reports),
            master: [row.frame.master.frames, row.frame.master.reports],
            limited_by,
            limit_share,
        }
    }
}

/// All rows, one per scene, strategy, film mode and number of workers.
pub fn scaling_table(rows: &[ScalingRow]) -> Table {
    let mut table = Table::new([
        "scene",
        "strategy",
        "film",
        "workers",
        "simulated",
        "fps",
        "fps_min",
        "fps_max",
        "speedup",
        "efficiency",
        "inflation",
        "scheduling_efficiency",
        "predicted_efficiency",
        "apart",
        "thesis_fps",
        "thesis_efficiency",
        "tasks",
        "reports",
        "limited_by",
    ]);
    for row in rows.iter().map(ScalingRecord::from) {
        table.push([
            row.scene.into(),
            row.strategy.into(),
            row.film.into(),
            row.workers.into(),
            row.simulated.into(),
            row.fps.into(),
            row.fps_min.into(),
            row.fps_max.into(),
            row.speedup.into(),
            row.efficiency.into(),
            row.inflation.into(),
            row.scheduling_efficiency.into(),
            row.predicted_efficiency.into(),
            row.apart.map(|apart| apart.median).into(),
            row.thesis_fps.into(),
            row.thesis_efficiency.into(),
            row.tasks.count.into(),
            row.reports.count.into(),
            row.limited_by.into(),
        ]);
    }
    table
}

/// Tables 2 to 5's counterpart for one scene and film mode: frames per second and efficiency by number of workers, with
/// the thesis' figures below irt's. Simulated columns are marked with `*`.
pub fn thesis_table(rows: &[ScalingRow], scene: &str, film: FilmMode) -> Table {
    let rows: Vec<&ScalingRow> =
        rows.iter().filter(|row| row.scene == scene && row.schedule.film == film).collect();
    let mut counts: Vec<(usize, bool)> = rows.iter().map(|row| (row.workers, row.simulated)).collect();
    counts.sort_unstable();
    counts.dedup();
    let heading =
        |&(workers, simulated): &(usize, bool)| format!("{workers}{}", if simulated { " *" } else { "" });
    let mut table = Table::new(std::iter::once(format!("{scene}, {film}")).chain(counts.iter().map(heading)));
    for strategy in Strategy::ALL {
        let of =
            |workers| rows.iter().find(|row| row.schedule.strategy == strategy && row.workers == workers);
        let cells: Vec<Cell> = counts
            .iter()
            .map(|&(workers, _)| {
                of(workers).map(|row| figure(1.0 / row.median(), Some(row.efficiency))).into()
            })
            .collect();
        if cells.iter().all(|cell| *cell == Cell::Missing) {
            continue;
        }
        table.push(std::iter::once(strategy.name().into()).chain(cells));
        let thesis: Vec<Cell> = counts
            .iter()
            .map(|&(workers, _)| {
                of(workers).and_then(|row| row.thesis).map(|t| figure(t.fps, t.efficiency)).into()
            })
            .collect();
        if thesis.iter().any(|cell| *cell != Cell::Missing) {
            table.push(std::iter::once("  thesis".into()).chain(thesis));
        }
    }
    table
}

fn figure(fps: f64, efficiency: Option<f64>) -> String {
    let fps = significant(fps, 4);
    efficiency.map_or_else(|| fps.clone(), |e| format!("{fps} {}", percent(e)))
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

fn head(row: &ScalingRow) -> [Cell; 3] {
    [row.scene.as_str().into(), row.schedule.strategy.name().into(), row.schedule.film.name().into()]
}

/// Where each worker's time went in the median round, at the largest measured number of workers, and the messages.
pub fn idle_table(rows: &[ScalingRow]) -> Table {
    let mut table = Table::new([
        "scene",
        "strategy",
        "film",
        "worker",
        "tiles",
        "steals",
        "busy",
        "start",
        "work",
        "deliver",
        "tail",
        "tasks",
        "reports",
        "latency us",
        "master",
    ]);
    let most = rows.iter().filter(|row| !row.simulated).map(|row| row.workers).max();
    for row in rows.iter().filter(|row| !row.simulated && Some(row.workers) == most) {
        let share = |seconds: f64| Cell::from(percent(seconds / row.frame.seconds));
        for (number, worker) in row.frame.workers.iter().enumerate() {
            // Messages are counted for all workers together.
            let once = |cell: Cell| if number == 0 { cell } else { Cell::Missing };
            let reports = &row.frame.reports;
            let latency = if reports.awaited == 0 { Cell::Missing } else { (reports.latency() * 1e6).into() };
            table.push(head(row).into_iter().chain([
                number.into(),
                worker.tiles.into(),
                worker.steals.into(),
                share(worker.busy_seconds),
                share(worker.idle.start),
                share(worker.idle.work),
                share(worker.idle.deliver),
                share(worker.idle.tail),
                once(row.frame.tasks.count.into()),
                once(reports.count.into()),
                once(latency),
                once(share(row.frame.master.frames + row.frame.master.reports)),
            ]));
        }
    }
    table
}

/// Where efficiency is lost, and whether the simulator sees it. Measured efficiency is scheduling / inflation: what of the
/// time went into tiles, and by which factor these took longer than one worker alone takes for them. The simulator is told
/// the inflation. How far it is off is told round by round, since each round has its own.
pub fn validation_table(rows: &[ScalingRow]) -> Table {
    let mut table = Table::new([
        "scene",
        "strategy",
        "film",
        "workers",
        "measured",
        "inflation",
        "scheduling",
        "simulated *",
        "points apart, from to",
        "fastest",
    ]);
    for row in rows.iter().filter(|row| row.workers > 1) {
        let Some(predicted) = row.predicted else { continue };
        table.push(head(row).into_iter().chain([
            row.workers.into(),
            percent(row.efficiency).into(),
            format!("{:.3}", row.inflation).into(),
            percent(row.scheduling()).into(),
            percent(predicted).into(),
            row.apart.map(points).into(),
            percent(row.fastest).into(),
        ]));
    }
    table
}

/// Percentage points: the median of the rounds, and between what the true one lies.
fn points(apart: Spread) -> String {
    let [median, low, high] = [apart.median, apart.low, apart.high].map(|apart| 100.0 * apart);
    format!("{median:+.1} ({low:+.1} {high:+.1})")
}

/// What keeps the workers from their tiles at the largest number of workers: shares of the frame.
pub fn limits_table(rows: &[ScalingRow]) -> Table {
    let mut table = Table::new(["scene", "strategy", "film", "workers", "efficiency", "limited by"]);
    let most = rows.iter().map(|row| row.workers).max();
    for row in rows.iter().filter(|row| Some(row.workers) == most) {
        let limits = row.limits();
        let text = limits.iter().filter(|limit| limit.1 >= 0.005).take(3);
        let text: Vec<String> = text.map(|(name, share)| format!("{name} {}", percent(*share))).collect();
        table.push(head(row).into_iter().chain([
            format!("{}{}", row.workers, if row.simulated { " *" } else { "" }).into(),
            percent(row.efficiency).into(),
            if text.is_empty() { "nothing above 0.5 %".into() } else { text.join(", ").into() },
        ]));
    }
    table
}

/// Frame times by size of the tiles.
pub fn sizes_table(rows: &[SizeRow]) -> Table {
    let mut table = Table::new([
        "scene",
        "workers",
        "simulated",
        "side",
        "tiles",
        "ms",
        "dearest/cheapest",
        "dearest/mean",
        "best",
        "by_rule",
    ]);
    for row in rows {
        table.push([
            row.scene.as_str().into(),
            row.workers.into(),
            row.simulated.into(),
            row.side.into(),
            row.tiles.into(),
            (row.seconds * 1e3).into(),
            row.ratio.into(),
            row.over_mean.into(),
            row.best.into(),
            row.by_rule.into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_apart_are_told_with_what_they_lie_between() {
        let apart = Spread { median: 0.0123, low: -0.003, high: 0.026, rounds: 5 };
        assert_eq!(points(apart), "+1.2 (-0.3 +2.6)");
    }
}
