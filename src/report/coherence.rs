//! Tables 1 and 6 to 10 of the thesis for our scenes, beside the thesis' own figures.

use super::{Cell, Report, Statistics, Table};
use crate::{
    study::coherence::{
        Line, ROWS, Row, SceneCoherence, Walk, counterpart, frames_per_second, gain, technique_gain,
        thesis_primary, thesis_shadow,
    },
    tile::Order,
};

/// All tables.
pub fn coherence_report(scenes: &[SceneCoherence]) -> Report {
    let mut report = Report::default();
    report.push("scenes", "Scenes", scene_table(scenes));
    report.push("table1", "Table 1: pixels that hit the same triangle as the one before", table_1(scenes));
    let title = "Tables 6 and 7: pixels by the number of lights that the same triangle as before occludes";
    report.push("table6_7", title, tables_6_7(scenes));
    report.push("table8", "Table 8: gain over scanline in percent, of tables 1, 6 and 7", table_8(scenes));
    report.push("table9_10", "Tables 9 and 10: what early termination saves", tables_9_10(scenes));
    let title =
        "Where the time goes: nanoseconds per ray, as a line through the techniques of tables 9 and 10";
    report.push("cost", title, cost_table(scenes));
    report.push(
        "caches",
        "Caches: SET-OCC-PET with other memories, against the previous ray",
        cache_table(scenes),
    );
    report.push("orders", "Voorhies' measure: how often a region is entered", order_table(scenes));
    report
}

fn scene_table(scenes: &[SceneCoherence]) -> Table {
    let columns = [
        "scene",
        "triangles",
        "lights",
        "width",
        "height",
        "pixels per triangle seen",
        "like the left %",
        "like the one above %",
        "shadow rays",
        "occluded %",
        "image_sha256",
    ];
    let mut table = Table::new(columns);
    for scene in scenes {
        let primary = &scene.walks[0].primary;
        table.push([
            scene.scene.as_str().into(),
            scene.triangles.into(),
            scene.lights.into(),
            scene.size[0].into(),
            scene.size[1].into(),
            (primary.hit as f64 / primary.triangles.max(1) as f64).into(),
            (100.0 * scene.likeness[0]).into(),
            (100.0 * scene.likeness[1]).into(),
            scene.shadow_rays.into(),
            (100.0 * scene.blocked as f64 / scene.shadow_rays.max(1) as f64).into(),
            scene.image_sha256.as_str().into(),
        ]);
    }
    table
}

fn table_1(scenes: &[SceneCoherence]) -> Table {
    let columns = [
        "scene",
        "order",
        "same",
        "same %",
        "gain %",
        "both missed",
        "thesis scene",
        "thesis same",
        "thesis gain %",
    ];
    let mut table = Table::new(columns);
    for (scene, walk) in walks(scenes) {
        let pixels = f64::from(scene.size[0]) * f64::from(scene.size[1]);
        let theirs = |order| thesis_primary(&scene.scene, order);
        table.push([
            scene.scene.as_str().into(),
            walk.order.name().into(),
            walk.primary.same.into(),
            (100.0 * walk.primary.same as f64 / pixels).into(),
            over_scanline(scene, walk, |walk| walk.primary.same).into(),
            walk.primary.both_missed.into(),
            counterpart(&scene.scene).into(),
            theirs(walk.order).into(),
            gain_of(theirs(walk.order), theirs(Order::Scanline)).into(),
        ]);
    }
    table
}

/// Rows of tables 6 to 8 by name, and what our walk counts there.
fn rows(walk: &Walk) -> Vec<(String, u64)> {
    let name = |i: usize| if i + 1 == ROWS { format!("{ROWS}+") } else { (i + 1).to_string() };
    let mut rows: Vec<_> = (0..ROWS).map(|i| (name(i), walk.shadow.pixels[i])).collect();
    rows.push(("total".into(), walk.shadow.total));
    rows
}

fn tables_6_7(scenes: &[SceneCoherence]) -> Table {
    let mut table = Table::new(["scene", "of", "order", "1", "2", "3", "4", "5", "6", "7", "8+", "total"]);
    for (scene, walk) in walks(scenes) {
        let rows = rows(walk);
        let ours = rows.iter().map(|&(_, count)| Cell::from(count));
        table.push(
            [scene.scene.as_str().into(), "irt".into(), walk.order.name().into()].into_iter().chain(ours),
        );
        let theirs: Vec<_> =
            rows.iter().map(|(row, _)| thesis_shadow(&scene.scene, walk.order, row)).collect();
        if theirs.iter().any(Option::is_some) {
            let name = counterpart(&scene.scene);
            let head = [name.into(), "thesis".into(), walk.order.name().into()];
            table.push(head.into_iter().chain(theirs.into_iter().map(Cell::from)));
        }
    }
    table
}

fn table_8(scenes: &[SceneCoherence]) -> Table {
    let mut table = Table::new(["scene", "order", "row", "gain %", "thesis gain %"]);
    for (scene, walk) in walks(scenes).filter(|(_, walk)| walk.order != Order::Scanline) {
        let Some(lines) = scene.walks.iter().find(|walk| walk.order == Order::Scanline) else { continue };
        let mut push = |row: &str, ours: [u64; 2], theirs: [Option<u64>; 2]| {
            table.push([
                scene.scene.as_str().into(),
                walk.order.name().into(),
                row.into(),
                gain(ours[0] as f64, ours[1] as f64).into(),
                gain_of(theirs[0], theirs[1]).into(),
            ]);
        };
        let orders = [walk.order, Order::Scanline];
        let theirs = orders.map(|order| thesis_primary(&scene.scene, order));
        push("primary", [walk.primary.same, lines.primary.same], theirs);
        for ((row, with), (_, without)) in rows(walk).into_iter().zip(rows(lines)) {
            if with + without > 0 {
                let theirs = orders.map(|order| thesis_shadow(&scene.scene, order, &row));
                push(&row, [with, without], theirs);
            }
        }
    }
    table
}

/// Columns that tell what a technique takes.
const COST: [&str; 11] = [
    "steps per ray",
    "boxes per ray",
    "triangles per ray",
    "primary tests per ray",
    "shadow tests per ray",
    "PET seeds met %",
    "OCC seeds met %",
    "fps",
    "min fps",
    "max fps",
    "work gain %",
];

fn cost(row: &Row, base: &Row) -> [Cell; 11] {
    let rays = row.rays().max(1) as f64;
    let sum = |a: u64, b: u64| Cell::from((a + b) as f64 / rays);
    let percent = |part: u64, all: u64| Cell::from((all > 0).then(|| 100.0 * part as f64 / all as f64));
    let (primary, shadow) = (&row.primary, &row.shadow);
    let fps =
        Statistics::of(&row.seconds().iter().map(|seconds| 1.0 / seconds.max(1e-9)).collect::<Vec<_>>());
    let (a, b) = (&primary.counts, &shadow.counts);
    [
        sum(a.steps, b.steps),
        sum(a.boxes, b.boxes),
        sum(a.triangles, b.triangles),
        Cell::from(primary.tests() as f64 / primary.rays.max(1) as f64),
        Cell::from(shadow.tests() as f64 / shadow.rays.max(1) as f64),
        percent(primary.seeded, primary.rays),
        percent(shadow.seeded, shadow.rays),
        fps.map(|s| s.median).into(),
        fps.map(|s| s.min).into(),
        fps.map(|s| s.max).into(),
        // As a gain in frames, if tests were all that takes time.
        gain(base.tests() as f64, row.tests() as f64).into(),
    ]
}

/// The gain in frames per second.
fn time_gain(row: &Row, base: &Row) -> Option<f64> {
    let seconds = |row: &Row| Statistics::of(&row.seconds()).map(|s| s.median);
    gain(seconds(base)?, seconds(row)?)
}

fn tables_9_10(scenes: &[SceneCoherence]) -> Table {
    let head = ["scene", "lights", "order", "technique"];
    let tail = ["gain %", "thesis fps", "thesis gain %"];
    let mut table = Table::new(head.into_iter().chain(COST).chain(tail));
    for (scene, walk) in walks(scenes) {
        let base = &walk.techniques[0];
        for row in &walk.techniques {
            let name = row.technique.name;
            let cells =
                [scene.scene.as_str().into(), scene.lights.into(), walk.order.name().into(), name.into()];
            let thesis = [
                time_gain(row, base).into(),
                frames_per_second(&scene.scene, walk.order, name).into(),
                technique_gain(&scene.scene, walk.order, name).into(),
            ];
            table.push(cells.into_iter().chain(cost(row, base)).chain(thesis));
        }
    }
    table
}

/// What a ray takes however little of the tree it visits, and what each step adds.
fn cost_table(scenes: &[SceneCoherence]) -> Table {
    let mut table = Table::new(["scene", "ns per ray at 0 steps", "ns per step", "R2", "points"]);
    for scene in scenes {
        let point = |row: &Row| {
            let steps = row.primary.counts.steps + row.shadow.counts.steps;
            let seconds = Statistics::of(&row.seconds())?.median;
            let rays = row.rays() as f64;
            Some((steps as f64 / rays, 1e9 * seconds / rays))
        };
        let points: Vec<_> = scene.walks.iter().flat_map(|walk| &walk.techniques).filter_map(point).collect();
        if let Some(line) = Line::fit(&points) {
            let Line { intercept, slope, r2, points } = line;
            table.push([
                scene.scene.as_str().into(),
                intercept.into(),
                slope.into(),
                r2.into(),
                points.into(),
            ]);
        }
    }
    table
}

fn cache_table(scenes: &[SceneCoherence]) -> Table {
    let head = ["scene", "lights", "order", "cache", "entries"];
    let mut table = Table::new(head.into_iter().chain(COST).chain(["gain %"]));
    for (scene, walk) in walks(scenes) {
        for row in &walk.caches {
            let base = &walk.caches[0];
            let cells = [
                scene.scene.as_str().into(),
                scene.lights.into(),
                walk.order.name().into(),
                row.shape.area.name().into(),
                row.shape.entries.into(),
            ];
            table.push(cells.into_iter().chain(cost(row, base)).chain([time_gain(row, base).into()]));
        }
    }
    table
}

fn order_table(scenes: &[SceneCoherence]) -> Table {
    let mut table = Table::new(["scene", "order", "region", "entries", "after a long absence"]);
    for (scene, walk) in walks(scenes) {
        let mut push = |region: String, all: f64, long: Option<f64>| {
            let names = [scene.scene.as_str().into(), walk.order.name().into(), region.into()];
            table.push(names.into_iter().chain([all.into(), long.into()]));
        };
        push("triangle seen".into(), walk.primary.entries_per_triangle(), None);
        for entries in &walk.discs {
            push(format!("disc of radius {}", entries.radius), entries.all, Some(entries.long));
        }
    }
    table
}

fn walks(scenes: &[SceneCoherence]) -> impl Iterator<Item = (&SceneCoherence, &Walk)> {
    scenes.iter().flat_map(|scene| scene.walks.iter().map(move |walk| (scene, walk)))
}

fn over_scanline(scene: &SceneCoherence, walk: &Walk, count: impl Fn(&Walk) -> u64) -> Option<f64> {
    let lines = scene.walks.iter().find(|walk| walk.order == Order::Scanline)?;
    gain(count(walk) as f64, count(lines) as f64)
}

fn gain_of(with: Option<u64>, without: Option<u64>) -> Option<f64> {
    gain(with? as f64, without? as f64)
}
