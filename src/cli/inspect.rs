//! `irt inspect`.

use super::{args::InspectArgs, export::Export, interrupt, terminal};
use crate::{
    bvh::{Bvh, TreeReport},
    effects::Reasons,
    error::Result,
    report::{bytes, count, significant, to_json},
    scene::{CameraReport, LightReport, SceneReport, Share, load},
};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::time::Instant;

/// Everything that is told about a scene. Serialised, it is the JSON export; displayed, what the terminal shows.
#[derive(Serialize)]
struct Inspection {
    #[serde(flatten)]
    scene: SceneReport,
    /// What it makes a frame simulate.
    effects: Vec<String>,
    load_seconds: f64,
    tree: Tree,
}

#[derive(Serialize)]
struct Tree {
    preset: String,
    build_seconds: f64,
    #[serde(flatten)]
    report: TreeReport,
}

/// Tells what is in a scene, and how good the tree over it is.
///
/// # Errors
/// Whatever is wrong with the scene or the export.
pub(super) fn run(args: &InspectArgs) -> Result<()> {
    interrupt::install()?;
    let export = Export::open(args.export_json.as_deref())?;
    let start = Instant::now();
    let scene = load(&args.scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let bvh = Bvh::build(&scene.mesh, args.build)?;
    let inspection = Inspection {
        scene: scene.report(),
        effects: Reasons::new(&scene).set().iter().map(|effect| effect.to_string()).collect(),
        load_seconds,
        tree: Tree {
            preset: args.build.to_string(),
            build_seconds: bvh.build_time().as_secs_f64(),
            report: bvh.report(),
        },
    };
    let stdout_taken = export.is_stdout();
    export.write(|| to_json(&inspection))?;
    if stdout_taken { Ok(()) } else { terminal::print(&inspection.to_string()) }
}

impl Display for Inspection {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let SceneReport { name, triangles, vertices, normals, duplicates, degenerate_dropped, .. } =
            &self.scene;
        let n = |number: &usize| count(*number as u64);
        writeln!(f, "scene      {name}, loaded in {} s", significant(self.load_seconds, 3))?;
        writeln!(
            f,
            "triangles  {}; {} duplicates kept, {} without area dropped",
            n(triangles),
            n(duplicates),
            n(degenerate_dropped)
        )?;
        writeln!(f, "vertices   {}; {} with a normal of their own", n(vertices), n(normals))?;
        let [min, max] = [self.scene.bounds_min, self.scene.bounds_max];
        writeln!(f, "bounds     {} to {}", point(min), point(max))?;
        shares(f, "parts", &self.scene.parts)?;
        shares(f, "materials", &self.scene.materials)?;
        writeln!(f, "lights     {}", self.scene.lights.len())?;
        self.scene.lights.iter().try_for_each(|light| writeln!(f, "  {}", light_text(light)))?;
        let CameraReport { eye, at, up, fov_deg } = self.scene.camera;
        let [eye, at, up] = [eye, at, up].map(point);
        writeln!(f, "camera     eye {eye}, at {at}, up {up}, {fov_deg} degrees")?;
        writeln!(f, "effects    {}", some(&self.effects.join(", ")))?;
        self.tree.fmt(f)?;
        self.scene.warnings.iter().try_for_each(|warning| writeln!(f, "warning    {warning}"))
    }
}

impl Display for Tree {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let TreeReport { nodes, leaves, depth, sah_cost, children_per_node, .. } = self.report;
        let TreeReport { triangles_per_leaf, block_fill, bytes_per_triangle, .. } = self.report;
        let seconds = significant(self.build_seconds, 3);
        writeln!(f, "tree       {} build in {seconds} s", self.preset)?;
        let [sah_cost, children, per_leaf, per_triangle] =
            [sah_cost, children_per_node, triangles_per_leaf, bytes_per_triangle].map(|v| significant(v, 3));
        writeln!(f, "  SAH cost {sah_cost}, depth {depth}")?;
        writeln!(f, "  {} nodes with {children} of 8 children", count(nodes as u64))?;
        let fill = significant(100.0 * block_fill, 3);
        writeln!(f, "  {} leaves with {per_leaf} triangles, blocks {fill} % full", count(leaves as u64))?;
        writeln!(f, "  {}, {per_triangle} bytes per triangle", bytes(self.report.bytes as u64))
    }
}

/// Longest list that is told in full.
const LONGEST_LIST: usize = 12;

/// The largest of a list, with their triangles.
fn shares(f: &mut Formatter<'_>, title: &str, shares: &[Share]) -> fmt::Result {
    writeln!(f, "{title:<10} {}", shares.len())?;
    let mut largest: Vec<&Share> = shares.iter().collect();
    largest.sort_by_key(|share| std::cmp::Reverse(share.triangles));
    for Share { name, triangles } in largest.iter().take(LONGEST_LIST) {
        writeln!(f, "  {} of {} triangles", some(name), count(*triangles as u64))?;
    }
    let rest = largest.iter().skip(LONGEST_LIST);
    if shares.len() > LONGEST_LIST {
        let triangles: usize = rest.clone().map(|share| share.triangles).sum();
        writeln!(f, "  {} more of {} triangles", rest.len(), count(triangles as u64))?;
    }
    Ok(())
}

fn light_text(light: &LightReport) -> String {
    let mut text = light.kind.to_string();
    let vectors =
        [("at", light.position), ("towards", light.direction), ("intensity", Some(light.intensity))];
    for (title, vector) in vectors {
        if let Some(vector) = vector {
            text += &format!(" {title} {}", point(vector));
        }
    }
    if let Some([inner, outer]) = light.cone_deg {
        text +=
            &format!(" cone {} to {} degrees", significant(inner.into(), 3), significant(outer.into(), 3));
    }
    if let Some(falloff) = light.falloff {
        text += &format!(" falloff {falloff}");
    }
    text
}

/// A vector as the flags take it.
fn point(p: [f32; 3]) -> String {
    p.map(|c| significant(c.into(), 4)).join(",")
}

fn some(text: &str) -> &str {
    if text.is_empty() { "none" } else { text }
}
