//! Tables and machine-readable rows of `irt bench`.

use super::{Cell, Statistics, Table};
use crate::study::bench::{Engine, Kind, Row};
use serde::Serialize;

/// One row of `--export-json`.
#[derive(Clone, Debug, Serialize)]
pub struct BenchRow<'a> {
    scene: &'a str,
    kind: &'static str,
    engine: &'static str,
    isa: &'a str,
    kernel: &'a str,
    width: usize,
    threads: usize,
    rays: u64,
    hits: u64,
    rounds: usize,
    mrays_per_s: Option<Statistics>,
    agrees: bool,
}

impl<'a> From<&'a Row> for BenchRow<'a> {
    fn from(row: &'a Row) -> BenchRow<'a> {
        BenchRow {
            scene: &row.scene,
            kind: row.kind.name(),
            engine: row.engine.name(),
            isa: &row.isa,
            kernel: &row.kernel,
            width: row.width,
            threads: row.threads,
            rays: row.rays,
            hits: row.hits,
            rounds: row.mrays_per_s.len(),
            mrays_per_s: Statistics::of(&row.mrays_per_s),
            agrees: row.agrees,
        }
    }
}

/// All rows as a table.
pub fn bench_table(rows: &[Row]) -> Table {
    let mut table = Table::new([
        "scene", "kind", "engine", "isa", "kernel", "width", "threads", "rays", "hits", "rounds", "Mrays/s",
        "min", "max", "agrees",
    ]);
    for row in rows {
        let statistics = Statistics::of(&row.mrays_per_s);
        table.push([
            row.scene.as_str().into(),
            row.kind.name().into(),
            row.engine.name().into(),
            row.isa.as_str().into(),
            row.kernel.as_str().into(),
            row.width.into(),
            row.threads.into(),
            row.rays.into(),
            row.hits.into(),
            row.mrays_per_s.len().into(),
            statistics.map(|s| s.median).into(),
            statistics.map(|s| s.min).into(),
            statistics.map(|s| s.max).into(),
            row.agrees.into(),
        ]);
    }
    table
}

/// The best mode of each engine for each scene and kind, irt's ratio to the others, and the geometric mean of the
/// ratios by kind.
pub fn bench_summary(rows: &[Row], engines: &[Engine]) -> Table {
    let others: Vec<Engine> = engines.iter().copied().filter(|&engine| engine != Engine::Irt).collect();
    let mut columns = vec!["scene".to_string(), "kind".into(), "irt".into()];
    for engine in &others {
        columns.push(engine.to_string());
        columns.push(format!("irt / {engine}"));
    }
    let mut table = Table::new(columns);
    for kind in Kind::ALL {
        let mut logs = vec![Vec::new(); others.len()];
        let mut scenes: Vec<&str> =
            rows.iter().filter(|row| row.kind == kind).map(|row| row.scene.as_str()).collect();
        scenes.dedup();
        if scenes.is_empty() {
            continue;
        }
        for scene in scenes {
            let best = |engine: Engine| best(rows, scene, kind, engine);
            let ours = best(Engine::Irt);
            let mut cells: Vec<Cell> = vec![scene.into(), kind.name().into(), ours.into()];
            for (log, &engine) in logs.iter_mut().zip(&others) {
                let theirs = best(engine);
                let ratio = ours.zip(theirs).map(|(ours, theirs)| ours / theirs);
                log.extend(ratio.map(f64::ln));
                cells.extend([theirs.into(), ratio.into()]);
            }
            table.push(cells);
        }
        let mut cells: Vec<Cell> = vec!["geometric mean".into(), kind.name().into(), Cell::Missing];
        for log in &logs {
            let mean = (!log.is_empty()).then(|| (log.iter().sum::<f64>() / log.len() as f64).exp());
            cells.extend([Cell::Missing, mean.into()]);
        }
        table.push(cells);
    }
    table
}

fn best(rows: &[Row], scene: &str, kind: Kind, engine: Engine) -> Option<f64> {
    rows.iter()
        .filter(|row| row.scene == scene && row.kind == kind && row.engine == engine)
        .filter_map(|row| Statistics::of(&row.mrays_per_s))
        .map(|statistics| statistics.median)
        .max_by(f64::total_cmp)
}
