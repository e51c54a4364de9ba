//! Presets, and building by them.

use super::{
    binary::Builder,
    collapse::{Wide, collapse},
    merged::merged,
    reference::{references, room},
    split::Task,
};
use crate::{kernels::EMPTY_NODE, scene::TriangleMesh};
use rayon::prelude::*;
use std::{fmt, str::FromStr};

/// How much time the build may spend on a better tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildPreset {
    /// Soonest first image.
    Fast,
    /// A good compromise.
    #[default]
    Medium,
    /// Best tree, for long renders.
    Slow,
}

impl BuildPreset {
    /// All presets, quickest first.
    pub const ALL: [BuildPreset; 3] = [BuildPreset::Fast, BuildPreset::Medium, BuildPreset::Slow];

    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            BuildPreset::Fast => "fast",
            BuildPreset::Medium => "medium",
            BuildPreset::Slow => "slow",
        }
    }
}

impl fmt::Display for BuildPreset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for BuildPreset {
    type Err = String;

    fn from_str(text: &str) -> Result<BuildPreset, String> {
        BuildPreset::ALL
            .into_iter()
            .find(|preset| preset.name() == text)
            .ok_or_else(|| format!("unknown build preset '{text}'; use fast, medium or slow"))
    }
}

/// The wide tree over a mesh.
pub(super) fn wide(mesh: &TriangleMesh, preset: BuildPreset) -> Wide {
    if mesh.is_empty() {
        return Wide { nodes: Vec::new(), blocks: Vec::new(), root: EMPTY_NODE, pieces: vec![0, 0] };
    }
    if preset == BuildPreset::Slow
        && let Some(tree) = merged(mesh)
    {
        return collapse(&tree, mesh);
    }
    // A tree that was merged too deep is split instead, down to single triangles.
    let stop = match preset {
        BuildPreset::Fast => 4,
        BuildPreset::Medium => 2,
        BuildPreset::Slow => 1,
    };
    let mut from = references(mesh);
    let mut spare = room(from.len());
    let tree = Builder { stop }.build(Task { from: &mut from, spare: &mut spare });
    let wide = collapse(&tree, mesh);
    // Giving back so much memory takes a while as well.
    rayon::join(|| drop((from, spare)), || tree.grains.into_par_iter().for_each(drop));
    wide
}
