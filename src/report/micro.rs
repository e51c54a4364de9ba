//! The table of `irt bench --micro`.

use super::{Statistics, Table};
use crate::study::bench::MicroRow;

/// All steps as a table.
pub fn micro_table(rows: &[MicroRow]) -> Table {
    let mut table = Table::new([
        "scene", "step", "isa", "width", "unit", "units", "rounds", "ns/unit", "min", "max", "agrees",
    ]);
    for row in rows {
        let ns = Statistics::of(&row.ns);
        table.push([
            row.scene.as_str().into(),
            row.step.into(),
            row.isa.name().into(),
            row.isa.lanes().into(),
            row.unit.into(),
            row.units.into(),
            row.ns.len().into(),
            ns.map(|s| s.median).into(),
            ns.map(|s| s.min).into(),
            ns.map(|s| s.max).into(),
            row.agrees.into(),
        ]);
    }
    table
}
