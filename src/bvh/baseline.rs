//! obvhs' own traversal, one ray at a time over its binary tree: a baseline to measure against.

use super::{BuildPreset, build};
use crate::{kernels::Ray, scene::TriangleMesh};
use obvhs::{
    bvh2::Bvh2,
    ray::{Ray as ObvhsRay, RayHit},
    triangle::Triangle,
};

/// A tree of obvhs with its triangles in leaf order.
pub struct Baseline {
    tree: Bvh2,
    triangles: Vec<Triangle>,
}

impl Baseline {
    /// Builds the tree that ours is made from.
    pub fn build(mesh: &TriangleMesh, preset: BuildPreset) -> Baseline {
        let tree = build::binary(mesh, preset);
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
