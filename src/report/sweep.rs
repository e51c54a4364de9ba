//! Points, findings and plots of `irt coherence --sweep`.

use super::{
    Cell, Report, Table,
    plot::{Plot, Series},
};
use crate::study::coherence::{Finding, LIGHTS, LIKENESS, OCCLUDED, Point, TRIANGLE_SIZE};

/// All tables.
pub fn sweep_report(points: &[Point], findings: &[Finding]) -> Report {
    let mut report = Report::default();
    report.push("findings", "Findings: gains in percent, and lines through them", finding_table(findings));
    report.push("points", "Points: SET-OCC-PET by scene, size, order and cache", point_table(points));
    report.push("lights", "Single lights: SET-OCC", light_table(points));
    report
}

/// The findings alone, for the terminal.
pub fn finding_table(findings: &[Finding]) -> Table {
    let mut table = Table::new([
        "gain of",
        "against",
        "points",
        "mean %",
        "least %",
        "most %",
        "wins %",
        "at 0 %",
        "per unit %",
        "R2",
        "zero at",
    ]);
    for finding in findings.iter().filter(|finding| !finding.points.is_empty()) {
        let ys = || finding.points.iter().map(|&(_, y)| y);
        let line = finding.line;
        table.push([
            finding.what.as_str().into(),
            finding.against.into(),
            finding.points.len().into(),
            finding.mean().into(),
            ys().fold(f64::INFINITY, f64::min).into(),
            ys().fold(f64::NEG_INFINITY, f64::max).into(),
            finding.wins().into(),
            line.map(|line| line.intercept).into(),
            line.map(|line| line.slope).into(),
            line.map(|line| line.r2).into(),
            line.and_then(|line| line.zero()).into(),
        ]);
    }
    table
}

fn head(point: &Point) -> [Cell; 5] {
    [
        point.scene.as_str().into(),
        format!("{}x{}", point.size[0], point.size[1]).into(),
        point.order.name().into(),
        point.shape.area.name().into(),
        point.shape.entries.into(),
    ]
}

fn share(part: u64, all: u64) -> Cell {
    (100.0 * part as f64 / all.max(1) as f64).into()
}

fn point_table(points: &[Point]) -> Table {
    let mut table = Table::new([
        "scene",
        "size",
        "order",
        "cache",
        "entries",
        "lights",
        "pixels per triangle",
        "same %",
        "occluded %",
        "PET seeds met %",
        "OCC seeds met %",
        "primary tests per ray",
        "shadow tests per ray",
        "tests",
    ]);
    for point in points {
        let (primary, shadow) = (point.primary, point.shadow());
        table.push(head(point).into_iter().chain([
            point.lights.len().into(),
            point.pixels_per_triangle.into(),
            share(point.same, primary.rays),
            share(shadow.hit, shadow.rays),
            share(primary.seeded, primary.rays),
            share(shadow.seeded, shadow.rays),
            (primary.tests as f64 / primary.rays.max(1) as f64).into(),
            (shadow.tests as f64 / shadow.rays.max(1) as f64).into(),
            (primary.tests + shadow.tests).into(),
        ]));
    }
    table
}

fn light_table(points: &[Point]) -> Table {
    let mut table = Table::new([
        "scene",
        "size",
        "order",
        "cache",
        "entries",
        "light",
        "occluded %",
        "OCC seeds met %",
        "tests per ray",
        "SET tests per ray",
        "base tests per ray",
    ]);
    for point in points {
        for (number, light) in point.lights.iter().enumerate() {
            let per_ray =
                |which: usize| Cell::from(light[which].tests as f64 / light[which].rays.max(1) as f64);
            table.push(head(point).into_iter().chain([
                number.into(),
                share(light[0].hit, light[0].rays),
                share(light[0].seeded, light[0].rays),
                per_ray(0),
                per_ray(2),
                per_ray(3),
            ]));
        }
    }
    table
}

/// Plots by file name.
pub fn sweep_plots(findings: &[Finding]) -> Vec<(&'static str, Plot)> {
    // File, title, what the gains are against, and how the names of the findings begin and end.
    [
        ("same-triangle.svg", "Same triangle as before, over scanline", TRIANGLE_SIZE, "same", ""),
        ("same-triangle-by-likeness.svg", "Same triangle as before, over scanline", LIKENESS, "same", ""),
        ("occ-successes.svg", "Successes of OCC, over scanline", OCCLUDED, "successes", ""),
        (
            "hilbert-by-cache.svg",
            "SET-OCC-PET: tests saved by hilbert over scanline, by cache",
            TRIANGLE_SIZE,
            "work with",
            "hilbert over scanline",
        ),
        (
            "caches-scanline.svg",
            "SET-OCC-PET in scanline order: tests saved over the previous ray alone",
            TRIANGLE_SIZE,
            "work in scanline order: cache",
            "",
        ),
        (
            "caches-hilbert.svg",
            "SET-OCC-PET in hilbert order: tests saved over the previous ray alone",
            TRIANGLE_SIZE,
            "work in hilbert order: cache",
            "",
        ),
        (
            "techniques.svg",
            "Techniques in hilbert order: tests saved over base",
            LIGHTS,
            "work in hilbert",
            "base",
        ),
    ]
    .into_iter()
    .map(|(file, title, against, start, end)| {
        let wanted = |finding: &&Finding| {
            finding.what.starts_with(start) && finding.what.ends_with(end) && finding.against == against
        };
        let series = findings.iter().filter(wanted).map(series).collect();
        (file, Plot { title: title.into(), x: against.into(), y: "gain in %".into(), series })
    })
    .collect()
}

fn series(finding: &Finding) -> Series {
    let name = finding.what.split(": ").last().unwrap_or(&finding.what);
    let name = if finding.what.starts_with("work with") {
        finding.what.split(": ").next().unwrap_or(name).trim_start_matches("work with ")
    } else {
        name
    };
    let line = finding.line.map(|line| (line.intercept, line.slope));
    Series { name: name.into(), points: finding.points.clone(), line }
}
