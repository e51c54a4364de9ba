//! What `irt render` tells at its end: the fields of `--export-json`, and the same numbers in a few lines.

use super::number::{bytes, count, significant};
use super::statistics::Statistics;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// Everything about one `irt render`. Serialised, it is the JSON export; displayed, the summary on the terminal.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The scene's name.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: u64,
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// Number of workers.
    pub threads: usize,
    /// Instruction set that the kernels were chosen for.
    pub isa: String,
    /// Kernel that traced the primary rays.
    pub kernel: String,
    /// Order of the tiles.
    pub order: String,
    /// Scheduling strategy.
    pub schedule: String,
    /// How finished pixels reach the film.
    pub film: String,
    /// Side of a tile in pixels.
    pub tile: u32,
    /// How ray-triangle tests are decided.
    pub visibility: String,
    /// Effects that the frame simulated.
    pub effects: Vec<String>,
    /// The tree.
    pub build: BuildSummary,
    /// Seconds to read or generate the scene.
    pub load_seconds: f64,
    /// Each frame, in order; all of them have the same rays.
    pub frames: Vec<FrameSummary>,
    /// Seconds of the whole process by stage.
    pub stages: StageSeconds,
    /// Each worker, over all frames.
    pub workers: Vec<WorkerSummary>,
    /// Further counts by name.
    pub counters: BTreeMap<String, u64>,
}

/// The tree and its build.
#[derive(Clone, Debug, Serialize)]
pub struct BuildSummary {
    /// Seconds to build and convert it.
    pub seconds: f64,
    /// Its size in memory.
    pub bytes: u64,
    /// The preset it was built with.
    pub preset: String,
}

/// One frame.
#[derive(Clone, Debug, Serialize)]
pub struct FrameSummary {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Rays traced.
    pub rays: RayCounts,
    /// Rays of all kinds per second of wall-clock time, in millions.
    pub mrays_per_s: f64,
    /// Hash of the linear pixels.
    pub image_sha256: String,
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RayCounts {
    /// From the camera.
    pub primary: u64,
    /// Towards lights.
    pub shadow: u64,
    /// Mirrored.
    pub reflection: u64,
    /// Refracted, or on their way through holes.
    pub refraction: u64,
    /// Diffusely reflected.
    pub indirect: u64,
    /// Looking for what keeps ambient light away.
    pub ambient: u64,
}

impl RayCounts {
    /// Rays of all kinds.
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.reflection + self.refraction + self.indirect + self.ambient
    }
}

/// Wall-clock seconds by stage. Workers trace and shade in turns; what they spent on each is added up over workers and
/// frames and divided by the number of workers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Reading or generating the scene.
    pub load: f64,
    /// Building the tree.
    pub build: f64,
    /// Traversal and intersection.
    pub trace: f64,
    /// Everything else on the workers.
    pub shade: f64,
    /// Encoding and writing the image.
    pub write: f64,
}

/// One worker.
#[derive(Clone, Debug, Serialize)]
pub struct WorkerSummary {
    /// Where it ran: "cpu 3", "unpinned", or what was refused.
    pub pinned: String,
    /// Seconds spent on tiles.
    pub busy_seconds: f64,
    /// Tiles finished.
    pub tiles: u64,
}

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(f, "scene    {}: {} triangles, {width}x{height} pixels", self.scene, count(self.triangles))?;
        let BuildSummary { seconds, bytes: size, preset } = &self.build;
        writeln!(f, "tree     {} in {} s ({preset} build)", bytes(*size), significant(*seconds, 3))?;
        writeln!(f, "kernel   {} on {}, {} visibility", self.kernel, self.isa, self.visibility)?;
        writeln!(f, "workers  {}: {}", self.threads, self.places())?;
        writeln!(
            f,
            "tiles    {} pixels square, {} order, {} schedule",
            self.tile, self.order, self.schedule
        )?;
        self.fmt_rays(f)?;
        self.fmt_exact(f)?;
        let StageSeconds { load, build, trace, shade, write } = self.stages;
        let stages = [("load", load), ("build", build), ("trace", trace), ("shade", shade), ("write", write)];
        let stages = stages.map(|(name, seconds)| format!("{name} {}", significant(seconds, 3))).join(", ");
        writeln!(f, "seconds  {stages}")
    }
}

impl Summary {
    fn fmt_rays(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(last) = self.frames.last() else { return Ok(()) };
        let RayCounts { primary, shadow, reflection, refraction, indirect, ambient } = last.rays;
        let kinds = [
            ("primary", primary),
            ("shadow", shadow),
            ("reflection", reflection),
            ("refraction", refraction),
            ("indirect", indirect),
            ("ambient", ambient),
        ];
        let kinds: Vec<_> = kinds
            .iter()
            .filter(|kind| kind.1 > 0)
            .map(|(name, rays)| format!("{} {name}", count(*rays)))
            .collect();
        let kinds = if kinds.is_empty() { "none".to_string() } else { kinds.join(", ") };
        writeln!(f, "rays     {kinds}{}", if self.frames.len() > 1 { " per frame" } else { "" })?;
        let speeds: Vec<f64> = self.frames.iter().map(|frame| frame.mrays_per_s).collect();
        let Some(speed) = Statistics::of(&speeds) else { return Ok(()) };
        let [median, min, max] = [speed.median, speed.min, speed.max].map(|s| significant(s, 4));
        match self.frames.len() {
            1 => writeln!(f, "speed    {median} Mrays/s"),
            frames => writeln!(f, "speed    {median} Mrays/s (median of {frames} frames, {min} to {max})"),
        }
    }

    /// How many pairs of a ray and a triangle exact arithmetic had to decide, and how that compares with the rays.
    fn fmt_exact(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let counters = ["exact_primary", "exact_shadow"].map(|name| self.counters.get(name));
        let exact: u64 = counters.into_iter().flatten().sum();
        let rays: u64 = self.frames.iter().map(|frame| frame.rays.total()).sum();
        if counters.iter().all(Option::is_none) || self.visibility != "exact" || rays == 0 {
            return Ok(());
        }
        let share = significant(100.0 * exact as f64 / rays as f64, 3);
        writeln!(f, "exact    {} tests in doubt, {share} per 100 rays", count(exact))
    }

    /// Where the workers ran, with equal places counted once.
    fn places(&self) -> String {
        let mut places: Vec<(&str, usize)> = vec![];
        for worker in &self.workers {
            match places.iter_mut().find(|(place, _)| *place == worker.pinned) {
                Some((_, times)) => *times += 1,
                None => places.push((&worker.pinned, 1)),
            }
        }
        let text = |(place, times): &(&str, usize)| match times {
            1 => (*place).to_string(),
            _ => format!("{times} {place}"),
        };
        places.iter().map(text).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(frames: usize) -> Summary {
        let rays = RayCounts { primary: 1_000_000, shadow: 2_500_000, ..RayCounts::default() };
        let frame = FrameSummary { seconds: 0.05, rays, mrays_per_s: 70.0, image_sha256: "00ff".into() };
        let worker = |pinned: &str| WorkerSummary { pinned: pinned.into(), busy_seconds: 0.04, tiles: 100 };
        Summary {
            scene: "atrium".into(),
            triangles: 262_144,
            size: [1000, 1000],
            threads: 4,
            isa: "avx512".into(),
            kernel: "tile".into(),
            order: "hilbert".into(),
            schedule: "dynamic".into(),
            film: "shared".into(),
            tile: 64,
            visibility: "exact".into(),
            effects: vec!["direct light".into()],
            build: BuildSummary { seconds: 0.25, bytes: 20 << 20, preset: "medium".into() },
            load_seconds: 0.125,
            frames: vec![frame; frames],
            stages: StageSeconds { load: 0.125, build: 0.25, trace: 0.04, shade: 0.01, write: 0.02 },
            workers: vec![worker("cpu 0"), worker("cpu 2"), worker("unpinned"), worker("unpinned")],
            counters: BTreeMap::from([
                ("tiles".into(), 256),
                ("exact_primary".into(), 3000),
                ("exact_shadow".into(), 4000),
            ]),
        }
    }

    #[test]
    fn the_terminal_gets_every_number_in_a_few_lines() {
        let expected = "\
scene    atrium: 262,144 triangles, 1000x1000 pixels
tree     20.0 MiB in 0.250 s (medium build)
kernel   tile on avx512, exact visibility
workers  4: cpu 0, cpu 2, 2 unpinned
tiles    64 pixels square, hilbert order, dynamic schedule
rays     1,000,000 primary, 2,500,000 shadow
speed    70.00 Mrays/s
exact    7,000 tests in doubt, 0.200 per 100 rays
seconds  load 0.125, build 0.250, trace 0.0400, shade 0.0100, write 0.0200
";
        assert_eq!(summary(1).to_string(), expected);
    }

    #[test]
    fn several_frames_are_told_by_their_median() {
        let text = summary(3).to_string();
        assert!(text.contains("speed    70.00 Mrays/s (median of 3 frames, 70.00 to 70.00)"), "{text}");
        assert!(text.contains("2,500,000 shadow per frame"), "{text}");
    }

    #[test]
    fn the_json_has_the_documented_fields() {
        let json = serde_json::to_value(summary(1)).unwrap();
        for field in [
            "scene",
            "triangles",
            "size",
            "threads",
            "isa",
            "order",
            "schedule",
            "visibility",
            "effects",
            "build",
            "load_seconds",
            "frames",
            "counters",
        ] {
            assert!(!json[field].is_null(), "{field}");
        }
        assert_eq!(json["build"]["bytes"], 20 << 20);
        assert_eq!(json["frames"][0]["rays"]["shadow"], 2_500_000);
        assert_eq!(json["frames"][0]["image_sha256"], "00ff");
        assert_eq!(json["size"], serde_json::json!([1000, 1000]));
    }
}
