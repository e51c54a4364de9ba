//! The table of `irt bench --builds`.

use super::{Cell, Statistics, Table};
use crate::study::bench::{BuildRow, Kind};

/// All builds as a table, with a column of Mrays/s for each of `kinds`.
pub fn builds_table(rows: &[BuildRow], kinds: &[Kind]) -> Table {
    let mut columns: Vec<String> = [
        "scene",
        "triangles",
        "engine",
        "preset",
        "rounds",
        "seconds",
        "min",
        "max",
        "bytes/triangle",
        "SAH cost",
    ]
    .map(String::from)
    .into();
    columns.extend(kinds.iter().map(|kind| format!("{kind} Mrays/s")));
    let mut table = Table::new(columns);
    for row in rows {
        let seconds = Statistics::of(&row.seconds);
        let per_triangle = (row.triangles > 0).then(|| row.bytes as f64 / row.triangles as f64);
        let mut cells: Vec<Cell> = vec![
            row.scene.as_str().into(),
            row.triangles.into(),
            row.engine.name().into(),
            row.preset.into(),
            row.seconds.len().into(),
            seconds.map(|s| s.median).into(),
            seconds.map(|s| s.min).into(),
            seconds.map(|s| s.max).into(),
            per_triangle.into(),
            row.sah_cost.into(),
        ];
        let median = |kind| Some(Statistics::of(&row.traced(kind)?.mrays_per_s)?.median);
        cells.extend(kinds.iter().map(|&kind| Cell::from(median(kind))));
        table.push(cells);
    }
    table
}
