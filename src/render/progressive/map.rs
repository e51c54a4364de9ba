//! What the rays of an image do in the tree, pixel by pixel: for maps over the picture.

use crate::{
    camera::Camera,
    kernels::{
        MISS, Ray,
        probe::{Closest, Counts, ProbeScratch},
    },
    tile::Tile,
    trace::Traversal,
};
use std::sync::atomic::{AtomicU32, Ordering};

/// By pixel, row by row.
#[derive(Debug, Default)]
pub struct RayMap {
    /// Nodes and leaves that the primary ray visits, one ray at a time.
    pub steps: Vec<AtomicU32>,
    /// The triangle that it hits; [`MISS`] for none.
    pub prims: Vec<AtomicU32>,
}

impl RayMap {
    pub(super) fn new(pixels: usize) -> RayMap {
        let plane = || (0..pixels).map(|_| AtomicU32::new(0)).collect();
        RayMap { steps: plane(), prims: plane() }
    }

    /// Traces the rays of a tile again, and counts.
    pub(super) fn trace(&self, traversal: &Traversal, camera: &Camera, tile: Tile, width: u32) {
        let (kernels, bvh) = (traversal.kernels(), traversal.tree());
        let mut scratch = ProbeScratch::default();
        for y in tile.y..tile.y + tile.height {
            for x in tile.x..tile.x + tile.width {
                let (org, dir) = (camera.eye.to_array(), camera.direction(x, y).to_array());
                let ray = Ray { org, dir, tnear: 0.0, tfar: f32::INFINITY, skip: MISS };
                let mut counts = Counts::default();
                let (scratch, counter) = (&mut scratch, &mut counts);
                let found =
                    kernels.run(Closest { bvh: &bvh, ray: &ray, bound: true, seeds: &[], scratch, counter });
                let at = (y * width + x) as usize;
                self.steps[at].store(counts.steps as u32, Ordering::Relaxed);
                self.prims[at].store(found.hit.prim, Ordering::Relaxed);
            }
        }
    }
}
