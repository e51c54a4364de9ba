//! What each approximation costs and changes.

use super::{Cell, Report, Table};
use crate::study::accuracy::{Row, SceneAccuracy, Spread, verdict};

/// All tables.
pub fn accuracy_report(scenes: &[SceneAccuracy]) -> Report {
    let mut report = Report::default();
    report.push("scenes", "Scenes and their converged images", scene_table(scenes));
    report.push(
        "modes",
        "Modes: time against the default, error against the converged image",
        mode_table(scenes),
    );
    let title = "Hits and shadows against the f64 reference, leaks of closed meshes";
    report.push("geometry", title, geometry_table(scenes));
    report.push("verdicts", "Verdicts", verdict_table(scenes));
    report.push("omitted", "Left out", omitted_table(scenes));
    report
}

fn scene_table(scenes: &[SceneAccuracy]) -> Table {
    let columns = ["scene", "triangles", "width", "height", "threads", "isa", "samples", "noise RMSE"];
    let mut table = Table::new(columns);
    for scene in scenes {
        table.push([
            scene.scene.as_str().into(),
            scene.triangles.into(),
            scene.size[0].into(),
            scene.size[1].into(),
            scene.threads.into(),
            scene.isa.into(),
            scene.converged.into(),
            scene.noise.into(),
        ]);
    }
    table
}

fn rows(scenes: &[SceneAccuracy]) -> impl Iterator<Item = (&SceneAccuracy, &Row)> {
    scenes.iter().flat_map(|scene| scene.rows.iter().map(move |row| (scene, row)))
}

/// Infinite for equal images, which JSON cannot tell.
fn finite(value: f64) -> Cell {
    value.is_finite().then_some(value).into()
}

pub(super) fn mode_table(scenes: &[SceneAccuracy]) -> Table {
    let columns = [
        "scene",
        "mode",
        "ms",
        "ratio",
        "from",
        "to",
        "rounds",
        "Mrays/s",
        "RMSE",
        "PSNR",
        "SSIM",
        "FLIP",
        "max",
        "changed %",
        "same",
        "front",
    ];
    let mut table = Table::new(columns);
    for (scene, row) in rows(scenes) {
        let Spread { median, low, high, rounds } = row.times.ratio;
        let seconds = row.times.seconds.median;
        table.push([
            scene.scene.as_str().into(),
            row.mode.to_string().into(),
            (1e3 * seconds).into(),
            median.into(),
            low.into(),
            high.into(),
            rounds.into(),
            (row.times.rays as f64 / seconds.max(1e-9) * 1e-6).into(),
            row.error.rmse.into(),
            finite(row.error.psnr),
            row.error.ssim.into(),
            row.error.flip.into(),
            row.error.max.into(),
            (100.0 * row.change.changed).into(),
            row.same.into(),
            row.front.into(),
        ]);
    }
    table
}

pub(super) fn geometry_table(scenes: &[SceneAccuracy]) -> Table {
    let columns = [
        "scene",
        "mode",
        "rays",
        "ties",
        "errors",
        "ulp of t",
        "max",
        "NaN",
        "shadows",
        "shadow errors",
        "aimed",
        "leaks",
        "leaks per million",
        "spawned",
        "self-hits",
    ];
    let mut table = Table::new(columns);
    for (scene, row) in rows(scenes) {
        let Some(geometry) = &row.geometry else { continue };
        let aimed = row.aimed.as_ref();
        table.push([
            scene.scene.as_str().into(),
            row.mode.to_string().into(),
            geometry.rays.into(),
            geometry.ties.into(),
            geometry.errors.into(),
            geometry.depth_median.into(),
            geometry.depth_max.into(),
            (geometry.nan + row.nan + aimed.map_or(0, |aimed| aimed.nan)).into(),
            geometry.shadows.into(),
            geometry.shadow_errors.into(),
            aimed.map(|aimed| aimed.rays).into(),
            aimed.map(|aimed| aimed.leaks).into(),
            aimed.map(|aimed| 1e6 * aimed.leaks as f64 / aimed.rays.max(1) as f64).into(),
            aimed.map(|aimed| aimed.spawned).into(),
            aimed.map(|aimed| aimed.self_hits).into(),
        ]);
    }
    table
}

fn verdict_table(scenes: &[SceneAccuracy]) -> Table {
    let mut table = Table::new(["scene", "verdict", "may err by", "flag"]);
    for (scene, row) in rows(scenes) {
        table.push([
            scene.scene.as_str().into(),
            verdict(scene, row).into(),
            row.mode.knob().map(|knob| knob.error()).into(),
            row.mode.flag().into(),
        ]);
    }
    table
}

pub(super) fn omitted_table(scenes: &[SceneAccuracy]) -> Table {
    let mut table = Table::new(["scene", "knob", "why"]);
    for scene in scenes {
        for omission in &scene.omissions {
            let why = omission.why.as_str();
            table.push([scene.scene.as_str().into(), omission.knob.into(), why.into()]);
        }
    }
    table
}
