//! Tables and machine-readable rows of `irt bench`.

use super::{Cell, Statistics, Table};
use crate::{
    kernels::Visibility,
    study::bench::{Engine, Kind, Row},
};
use serde::Serialize;

/// One row of `--export-json`.
#[derive(Clone, Debug, Serialize)]
pub struct BenchRow<'a> {
    scene: &'a str,
    kind: &'static str,
    engine: &'static str,
    isa: &'a str,
    kernel: &'a str,
    visibility: Option<&'static str>,
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
            visibility: row.visibility.map(Visibility::name),
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
        "scene",
        "kind",
        "engine",
        "isa",
        "kernel",
        "visibility",
        "width",
        "threads",
        "rays",
        "hits",
        "rounds",
        "Mrays/s",
        "min",
        "max",
        "agrees",
    ]);
    for row in rows {
        let statistics = Statistics::of(&row.mrays_per_s);
        table.push([
            row.scene.as_str().into(),
            row.kind.name().into(),
            row.engine.name().into(),
            row.isa.as_str().into(),
            row.kernel.as_str().into(),
            row.visibility.map(|v| v.name().to_string()).into(),
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

/// The speed of irt's best mode for each scene and kind, that of its rivals (other engines, or irt with another
/// visibility), irt's ratio to them, and the geometric mean of the ratios by kind. The first visibility is irt's.
pub fn bench_summary(rows: &[Row], engines: &[Engine], visibility: &[Visibility]) -> Table {
    let rivals = rivals(engines, visibility);
    let first = visibility.first().copied();
    let ours = match visibility {
        [_] => "irt".to_string(),
        _ => format!("irt {}", first.unwrap_or_default()),
    };
    let mut columns = vec!["scene".to_string(), "kind".into(), ours.clone()];
    for (name, _) in &rivals {
        columns.extend([name.clone(), format!("{ours} / {name}")]);
    }
    let mut table = Table::new(columns);
    for kind in Kind::ALL {
        let mut logs = vec![Vec::new(); rivals.len()];
        let mut scenes: Vec<&str> =
            rows.iter().filter(|row| row.kind == kind).map(|row| row.scene.as_str()).collect();
        scenes.dedup();
        if scenes.is_empty() {
            continue;
        }
        for scene in scenes {
            let ours = best(rows, scene, kind, (Engine::Irt, first));
            let mut cells: Vec<Cell> = vec![scene.into(), kind.name().into(), ours.into()];
            for (log, &(_, rival)) in logs.iter_mut().zip(&rivals) {
                let theirs = best(rows, scene, kind, rival);
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

/// An engine, with a visibility if it has several.
type Rival = (Engine, Option<Visibility>);

/// The names of those that irt is compared with.
fn rivals(engines: &[Engine], visibility: &[Visibility]) -> Vec<(String, Rival)> {
    let others = engines.iter().filter(|&&engine| engine != Engine::Irt);
    let mut rivals: Vec<_> = others.map(|&engine| (engine.to_string(), (engine, None))).collect();
    if engines.contains(&Engine::Irt) {
        rivals.extend(visibility.iter().skip(1).map(|&v| (format!("irt {v}"), (Engine::Irt, Some(v)))));
    }
    rivals
}

fn best(rows: &[Row], scene: &str, kind: Kind, (engine, visibility): Rival) -> Option<f64> {
    rows.iter()
        .filter(|row| row.scene == scene && row.kind == kind)
        .filter(|row| row.engine == engine && row.visibility == visibility)
        .filter_map(|row| Statistics::of(&row.mrays_per_s))
        .map(|statistics| statistics.median)
        .max_by(f64::total_cmp)
}
