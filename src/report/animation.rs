//! What `irt render` tells of the images of a moving scene.

use super::{RayCounts, Statistics, count, significant};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// One moment.
#[derive(Clone, Debug, Serialize)]
pub struct MomentSummary {
    /// Seconds from the beginning of the motion.
    pub time: f64,
    /// The image.
    pub file: String,
    /// What was done to the tree: `built`, `refitted` or `rebuilt`.
    pub tree: &'static str,
    /// Expected cost of a random ray in it.
    pub sah_cost: f64,
    /// Seconds to move the vertices.
    pub pose_seconds: f64,
    /// Seconds to build the tree, or to let it follow, the surface table included.
    pub tree_seconds: f64,
    /// Seconds of the frame.
    pub seconds: f64,
    /// Rays traced.
    pub rays: RayCounts,
    /// Seconds to write the image.
    pub write_seconds: f64,
    /// Hash of the linear pixels.
    pub image_sha256: String,
}

/// All moments. Serialised, it is the JSON export; displayed, what the terminal shows.
#[derive(Clone, Debug, Serialize)]
pub struct AnimationSummary {
    /// The scene's name.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: u64,
    /// Width and height of the images in pixels.
    pub size: [u32; 2],
    /// Instruction set that the kernels were chosen for.
    pub isa: String,
    /// Moments per second of motion.
    pub fps: f64,
    /// Seconds to read the scene.
    pub load_seconds: f64,
    /// Each moment, in order.
    pub moments: Vec<MomentSummary>,
}

impl Display for AnimationSummary {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let AnimationSummary { scene, size: [width, height], fps, moments, .. } = self;
        writeln!(f, "scene    {scene}: {} triangles, {width}x{height} pixels", count(self.triangles))?;
        let length = moments.last().map_or(0.0, |last| last.time);
        writeln!(f, "moments  {} of {} s, {fps} per second", moments.len(), significant(length, 3))?;
        for tree in ["built", "refitted", "rebuilt"] {
            let seconds: Vec<f64> = moments
                .iter()
                .filter(|moment| moment.tree == tree)
                .map(|moment| moment.tree_seconds)
                .collect();
            if let Some(Statistics { median, .. }) = Statistics::of(&seconds) {
                writeln!(f, "tree     {} {tree}, {} s (median)", seconds.len(), significant(median, 3))?;
            }
        }
        let costs = moments.iter().map(|moment| moment.sah_cost);
        let (least, most) = costs.fold((f64::INFINITY, 0.0f64), |(a, b), cost| (a.min(cost), b.max(cost)));
        writeln!(f, "cost     {} to {} (SAH)", significant(least, 3), significant(most, 3))?;
        let sum = |seconds: fn(&MomentSummary) -> f64| moments.iter().map(seconds).sum::<f64>();
        let stages = [
            ("load", self.load_seconds),
            ("pose", sum(|moment| moment.pose_seconds)),
            ("tree", sum(|moment| moment.tree_seconds)),
            ("render", sum(|moment| moment.seconds)),
            ("write", sum(|moment| moment.write_seconds)),
        ];
        let stages = stages.map(|(name, seconds)| format!("{name} {}", significant(seconds, 3))).join(", ");
        writeln!(f, "seconds  {stages}")
    }
}
