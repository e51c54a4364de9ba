//! obvhs' own traversal, one ray at a time over its binary tree: a baseline to measure against.

use crate::{kernels::Ray, scene::TriangleMesh};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ploc::{PlocSearchDistance, SortPrecision},
    ray::{Ray as ObvhsRay, RayHit},
    triangle::Triangle,
};
use std::time::Duration;

/// A tree of obvhs with its triangles in leaf order.
pub struct Baseline {
    tree: Bvh2,
    triangles: Vec<Triangle>,
}

impl Baseline {
    /// Builds obvhs' best tree for its own traversal, without splitting triangles.
    pub fn build(mesh: &TriangleMesh) -> Baseline {
        let tree = binary(mesh);
        let triangle = |&prim: &u32| {
            let [a, b, c] = mesh.corners(prim as usize);
            Triangle { v0: a.into(), v1: b.into(), v2: c.into() }
        };
        let triangles = tree.primitive_indices.iter().map(triangle).collect();
        Baseline { tree, triangles }
    }

    /// Primitive and depth of the first hit, by plain f32 arithmetic.
    pub fn intersect(&self, ray: &Ray) -> Option<(u32, f32)> {
        let mut hit = RayHit::none();
        let found = self.tree.ray_traverse(convert(ray), &mut hit, |ray, i| self.triangles[i].intersect(ray));
        found.then(|| (self.tree.primitive_indices[hit.primitive_id as usize], hit.t))
    }

    /// True if anything is hit.
    pub fn occluded(&self, ray: &Ray) -> bool {
        !self.tree.ray_traverse_miss(convert(ray), |ray, i| self.triangles[i].intersect(ray))
    }
}

fn convert(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(ray.org.into(), ray.dir.into(), ray.tnear, ray.tfar)
}

/// PLOC, then reinsertion of every node; one triangle a leaf.
pub(super) fn binary(mesh: &TriangleMesh) -> Bvh2 {
    let boxes: Vec<Aabb> = (0..mesh.len())
        .map(|prim| {
            let [a, b, c] = mesh.corners(prim);
            Aabb::new(a.min(b).min(c).into(), a.max(b).max(c).into())
        })
        .collect();
    let params = BvhBuildParams {
        pre_split: false,
        ploc_search_distance: PlocSearchDistance::High,
        search_depth_threshold: 2,
        reinsertion_batch_ratio: 1.0,
        post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
        sort_precision: SortPrecision::U64,
        max_prims_per_leaf: 1,
        collapse_traversal_cost: 1.0,
    };
    build_bvh2(&boxes, params, &mut Duration::default())
}
