//! Tables and machine-readable rows of `irt stability`.

use super::{Cell, Table};
use crate::study::stability::{Accuracy, Offset, Place, Report, Tally};

/// All cells of the closed meshes: instruction set x kernel x place, and the other engines.
pub fn stability_cells(report: &Report) -> Table {
    let mut table = leak_table(&["center", "radius"]);
    for cell in &report.leaks.cells {
        let names = ["irt".into(), cell.isa.name().into(), cell.kernel.name().into()];
        table.push(names.into_iter().chain(place(cell.place)).chain(counts(&cell.tally)));
    }
    for cell in &report.leaks.peers {
        let names = [cell.engine.name().into(), Cell::Missing, cell.mode.into()];
        let counts = [cell.rays.into(), cell.aimed.into(), cell.leaks.into()];
        let missing = [Cell::Missing, Cell::Missing, Cell::Missing, Cell::Missing];
        table.push(names.into_iter().chain(place(cell.place)).chain(counts).chain(missing));
    }
    table
}

fn leak_table(place: &[&str]) -> Table {
    let counts = ["rays", "aimed", "leaks", "rejected", "differ", "NaN", "doubtful"];
    Table::new(["engine", "isa", "kernel"].iter().chain(place).chain(&counts).copied())
}

fn place(place: Place) -> [Cell; 2] {
    let [x, y, z] = place.center.to_array();
    let center = if x == y && y == z { format!("{x}") } else { format!("{x},{y},{z}") };
    [center.into(), format!("{:e}", place.radius).into()]
}

fn counts(tally: &Tally) -> [Cell; 7] {
    let Tally { rays, aimed, leaks, rejected, differ, nan, doubtful } = *tally;
    [rays.into(), aimed.into(), leaks.into(), rejected.into(), differ.into(), nan.into(), doubtful.into()]
}

/// The cells added up, each row over all places.
pub fn stability_kernels(report: &Report) -> Table {
    let mut rows: Vec<([Cell; 3], Tally, bool)> = Vec::new();
    let mut add =
        |names: [Cell; 3], tally: &Tally, ours: bool| match rows.iter_mut().find(|row| row.0 == names) {
            Some(row) => row.1.add(tally),
            None => rows.push((names, *tally, ours)),
        };
    for cell in &report.leaks.cells {
        add(["irt".into(), cell.isa.name().into(), cell.kernel.name().into()], &cell.tally, true);
    }
    for cell in &report.leaks.peers {
        let tally = Tally { rays: cell.rays, aimed: cell.aimed, leaks: cell.leaks, ..Tally::default() };
        add([cell.engine.name().into(), Cell::Missing, cell.mode.into()], &tally, false);
    }
    let mut table = leak_table(&[]);
    for (names, tally, ours) in rows {
        let mut counts = counts(&tally);
        if !ours {
            counts[3..].fill(Cell::Missing);
        }
        table.push(names.into_iter().chain(counts));
    }
    table
}

/// The cells added up, each row over all kernels and instruction sets; leaks of other engines beside them.
pub fn stability_places(report: &Report) -> Table {
    let mut peers: Vec<String> = Vec::new();
    for cell in &report.leaks.peers {
        let name = format!("{} {} leaks", cell.engine, cell.mode);
        if !peers.contains(&name) {
            peers.push(name);
        }
    }
    let columns = ["center", "radius", "rays", "aimed", "leaks", "rejected", "differ", "NaN"];
    let mut table = Table::new(columns.map(String::from).into_iter().chain(peers.iter().cloned()));
    let mut places: Vec<Place> = report.leaks.cells.iter().map(|cell| cell.place).collect();
    places.dedup();
    for at in places {
        let mut sum = Tally::default();
        report.leaks.cells.iter().filter(|cell| cell.place == at).for_each(|cell| sum.add(&cell.tally));
        let theirs = report.leaks.peers.iter().filter(|cell| cell.place == at);
        let theirs = theirs.map(|cell| format!("{} of {}", cell.leaks, cell.rays).into());
        table.push(place(at).into_iter().chain(counts(&sum).into_iter().take(6)).chain(theirs));
    }
    table
}

/// Random meshes by family.
pub fn stability_fuzz(report: &Report) -> Table {
    let columns = ["meshes", "tried", "rays", "differ", "NaN", "judged", "imagined", "missed", "inaccurate"];
    let mut table = Table::new(columns);
    for cell in &report.fuzz.cells {
        let Accuracy { judged, imagined, missed, inaccurate, .. } = cell.accuracy;
        table.push([
            cell.family.to_string().into(),
            cell.meshes.into(),
            cell.tally.rays.into(),
            cell.tally.differ.into(),
            cell.tally.nan.into(),
            judged.into(),
            imagined.into(),
            missed.into(),
            inaccurate.into(),
        ]);
    }
    table
}

/// Errors of depth and weights against the oracle, in units in the last place.
pub fn stability_errors(report: &Report) -> Table {
    let mut table = Table::new(["rays", "judged", "quantity", "unit", "samples", "median", "99.9 %", "max"]);
    let mut fuzzed = Accuracy::default();
    report.fuzz.cells.iter().for_each(|cell| fuzzed.merge(cell.accuracy.clone()));
    for (rays, accuracy) in [("closed meshes", &report.leaks.accuracy), ("random meshes", &fuzzed)] {
        let quantities = [("t", "its last place"), ("u", "2^-24"), ("v", "2^-24")];
        for ((quantity, unit), errors) in quantities.into_iter().zip(accuracy.errors()) {
            table.push([
                rays.into(),
                accuracy.judged.into(),
                quantity.into(),
                unit.into(),
                errors.map_or(0, |errors| errors.samples).into(),
                errors.map(|errors| f64::from(errors.median)).into(),
                errors.map(|errors| f64::from(errors.p999)).into(),
                errors.map(|errors| f64::from(errors.max)).into(),
            ]);
        }
    }
    table
}

/// Spawned rays by size and place, over all kernels and instruction sets.
pub fn stability_spawn(report: &Report) -> Table {
    let columns = [
        "size",
        "center / size",
        "rays",
        "self-hits",
        "lost neighbours",
        "facet hits",
        "mean offset / size",
        "max offset / size",
    ];
    let mut table = Table::new(columns);
    let mut places: Vec<Place> = report.spawn.cells.iter().map(|cell| cell.place).collect();
    places.dedup();
    for at in places {
        let cells = || report.spawn.cells.iter().filter(move |cell| cell.place == at);
        let rays: u64 = cells().map(|cell| cell.rays).sum();
        let mut offset = Offset::default();
        cells().for_each(|cell| offset.merge(cell.offset));
        table.push([
            format!("{:e}", at.radius).into(),
            (f64::from(at.center.x) / f64::from(at.radius)).round().into(),
            rays.into(),
            cells().map(|cell| cell.self_hits).sum::<u64>().into(),
            cells().map(|cell| cell.lost).sum::<u64>().into(),
            cells().map(|cell| cell.facet).sum::<u64>().into(),
            offset.mean(rays).into(),
            offset.most.into(),
        ]);
    }
    table
}

/// The equality matrix of images.
pub fn stability_images(report: &Report) -> Table {
    let mut table = Table::new(["varied", "value", "images", "differ"]);
    for cell in &report.images.cells {
        table.push([cell.dimension.into(), cell.value.trim().into(), cell.images.into(), cell.differ.into()]);
    }
    table
}
