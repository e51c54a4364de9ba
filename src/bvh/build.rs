//! The binary tree, by obvhs.

use crate::scene::TriangleMesh;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ploc::{PlocSearchDistance, SortPrecision},
};
use std::{fmt, str::FromStr, time::Duration};

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

    fn params(self) -> BvhBuildParams {
        let (ploc_search_distance, search_depth_threshold, reinsertion_batch_ratio) = match self {
            BuildPreset::Fast => (PlocSearchDistance::Minimum, 0, 0.01),
            BuildPreset::Medium => (PlocSearchDistance::Low, 2, 0.05),
            BuildPreset::Slow => (PlocSearchDistance::High, 2, 1.0),
        };
        BvhBuildParams {
            pre_split: false,
            ploc_search_distance,
            search_depth_threshold,
            reinsertion_batch_ratio,
            post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
            sort_precision: SortPrecision::U64,
            // The collapse to wide nodes decides about leaves.
            max_prims_per_leaf: 1,
            collapse_traversal_cost: 1.0,
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

/// A binary tree with one triangle a leaf.
pub(super) fn binary(mesh: &TriangleMesh, preset: BuildPreset) -> Bvh2 {
    let boxes: Vec<Aabb> = (0..mesh.len())
        .map(|prim| {
            let [a, b, c] = mesh.corners(prim);
            Aabb::new(a.min(b).min(c).into(), a.max(b).max(c).into())
        })
        .collect();
    let mut core_time = Duration::ZERO;
    build_bvh2(&boxes, preset.params(), &mut core_time)
}
