//! `irt inspect`.

use super::{args::InspectArgs, export::Export, interrupt, price, terminal};
use crate::{
    bvh::{Bvh, TreeReport},
    effects::{Reason, Reasons},
    error::Result,
    report::{bytes, count, significant, to_json},
    scene::{CameraReport, LightReport, SceneReport, Share, TextureReport, TrackReport, load},
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
    /// Why, and why not the others.
    reasons: Vec<Told>,
    load_seconds: f64,
    tree: Tree,
}

/// A reason for or against an effect.
#[derive(Serialize)]
struct Told {
    effect: String,
    called: bool,
    why: String,
}

impl Told {
    fn new(reason: &Reason) -> Told {
        let Reason { effect, called, why } = reason;
        Told { effect: effect.to_string(), called: *called, why: why.clone() }
    }
}

#[derive(Serialize)]
struct Tree {
    preset: String,
    build_seconds: f64,
    #[serde(flatten)]
    report: TreeReport,
}

/// Tells what is in a scene, and how good the tree over it is; or what its effects cost.
///
/// # Errors
/// Whatever is wrong with the scene or the export.
pub(super) fn run(args: &InspectArgs) -> Result<()> {
    interrupt::install()?;
    let export = Export::open(args.export_json.as_deref())?;
    let start = Instant::now();
    let scene = load(&args.scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    if args.price {
        return price::run(args, &scene, export);
    }
    let bvh = Bvh::build(&scene.mesh, args.build)?;
    let reasons = Reasons::new(&scene);
    let inspection = Inspection {
        scene: scene.report(),
        effects: reasons.set().iter().map(|effect| effect.to_string()).collect(),
        reasons: reasons.iter().map(Told::new).collect(),
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
        self.textures(f)?;
        self.motion(f)?;
        let CameraReport { eye, at, up, fov_deg } = self.scene.camera;
        let [eye, at, up] = [eye, at, up].map(point);
        writeln!(f, "camera     eye {eye}, at {at}, up {up}, {fov_deg} degrees")?;
        self.effects(f)?;
        self.tree.fmt(f)?;
        self.scene.warnings.iter().try_for_each(|warning| writeln!(f, "warning    {warning}"))
    }
}

impl Inspection {
    fn textures(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let SceneReport { textures, sky, sky_light, .. } = &self.scene;
        writeln!(f, "textures   {}", textures.len())?;
        for TextureReport { name, size: [width, height], bytes: memory } in textures {
            writeln!(f, "  {name} of {width}x{height} pixels, {}", bytes(*memory as u64))?;
        }
        writeln!(f, "sky        {sky}{}", if *sky_light { ", a light" } else { "" })
    }

    fn motion(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(motion) = &self.scene.motion else { return Ok(()) };
        writeln!(f, "motion     {} s", significant(motion.length, 3))?;
        for TrackReport { vertices, shapes, rate, keys } in &motion.tracks {
            write!(f, "  {} vertices", count(*vertices as u64))?;
            if *shapes > 1 {
                write!(f, ", {shapes} shapes, {rate} per second")?;
            }
            writeln!(f, "{}", if *keys > 0 { format!(", {keys} keys") } else { String::new() })?;
        }
        Ok(())
    }

    /// Effects that are called for, and why; then the others, and why not.
    fn effects(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "effects    {}", some(&self.effects.join(", ")))?;
        for called in [true, false] {
            for Told { effect, why, .. } in self.reasons.iter().filter(|told| told.called == called) {
                let sign = if called { '+' } else { '-' };
                writeln!(f, "  {sign} {effect:<18} {why}")?;
            }
        }
        Ok(())
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
    if let Some([u, v]) = light.edges {
        text += &format!(" edges {} and {}", point(u), point(v));
    }
    if let Some(radius) = light.radius {
        text += &format!(" radius {}", significant(radius.into(), 4));
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
