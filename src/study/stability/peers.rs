//! Other engines at the same rays: obvhs, and Embree in its default and its robust mode where it is available.

use super::tally::Place;
#[cfg(feature = "embree")]
use crate::study::bench::peers::{embree, unavailable};
use crate::{bvh::Baseline, error::Result, kernels::Ray, scene::TriangleMesh, study::bench::Engine};

/// An engine with a tree.
pub(super) enum Peer {
    Obvhs(Baseline),
    #[cfg(feature = "embree")]
    Embree {
        scene: embree::Scene<'static>,
        mode: &'static str,
    },
}

/// What became of an engine's rays at one place.
#[derive(Clone, Copy, Debug)]
pub struct PeerCell {
    /// Whose.
    pub engine: Engine,
    /// How it was used.
    pub mode: &'static str,
    /// Place of the meshes.
    pub place: Place,
    /// Rays traced.
    pub rays: u64,
    /// Those that were aimed at vertices and edges.
    pub aimed: u64,
    /// Rays that leaked.
    pub leaks: u64,
}

impl PeerCell {
    pub(super) fn new(peer: &Peer, place: Place) -> PeerCell {
        let (engine, mode) = match peer {
            Peer::Obvhs(_) => (Engine::Obvhs, "single"),
            #[cfg(feature = "embree")]
            Peer::Embree { mode, .. } => (Engine::Embree, *mode),
        };
        PeerCell { engine, mode, place, rays: 0, aimed: 0, leaks: 0 }
    }

    pub(super) fn add(&mut self, other: &PeerCell) {
        self.rays += other.rays;
        self.aimed += other.aimed;
        self.leaks += other.leaks;
    }
}

impl Peer {
    /// The engines asked for over a mesh.
    ///
    /// # Errors
    /// [`crate::error::Error::Flag`] if Embree cannot be had.
    pub(super) fn all(engines: &[Engine], mesh: &TriangleMesh) -> Result<Vec<Peer>> {
        let mut peers = Vec::new();
        if engines.contains(&Engine::Obvhs) {
            peers.push(Peer::Obvhs(Baseline::build(mesh)));
        }
        #[cfg(feature = "embree")]
        if engines.contains(&Engine::Embree) {
            for (robust, mode) in [(false, "single"), (true, "single robust")] {
                peers.push(Peer::Embree { scene: embree_scene(mesh, robust).map_err(unavailable)?, mode });
            }
        }
        Ok(peers)
    }

    /// Counts the rays that meet nothing before their limits.
    pub(super) fn count(&self, rays: &[Ray], limits: &[f64], aimed: u64, cell: &mut PeerCell) {
        let depths: Vec<Option<f32>> = match self {
            Peer::Obvhs(tree) => rays.iter().map(|ray| tree.intersect(ray).map(|(_, t)| t)).collect(),
            #[cfg(feature = "embree")]
            Peer::Embree { scene, .. } => {
                let rays: Vec<embree::Ray> = rays.iter().map(|r| (r.org, r.dir, r.tnear, r.tfar)).collect();
                let mut rays = embree::Rays::<1>::pack(&rays);
                scene.intersect(&mut rays, false);
                rays.iter().map(|ray| ray.prim(0).map(|_| ray.depth(0))).collect()
            }
        };
        let leaks =
            depths.iter().zip(limits).filter(|(t, limit)| !t.is_some_and(|t| f64::from(t) <= **limit));
        cell.leaks += leaks.count() as u64;
        cell.rays += rays.len() as u64;
        cell.aimed += aimed;
    }
}

/// A tree of Embree's. Device and geometry are leaked: the library stays loaded for the life of the process anyway.
#[cfg(feature = "embree")]
fn embree_scene(mesh: &TriangleMesh, robust: bool) -> std::result::Result<embree::Scene<'static>, String> {
    use std::sync::OnceLock;
    static DEVICE: OnceLock<std::result::Result<embree::Embree, String>> = OnceLock::new();
    let device = DEVICE.get_or_init(|| embree::Embree::open("threads=1")).as_ref().map_err(Clone::clone)?;
    // Embree reads 16 bytes at the last vertex: one more stands behind it.
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.to_array()).chain([[0.0; 3]]).collect();
    let triangles = Vec::leak(mesh.triangles.clone());
    Ok(device.scene(Vec::leak(positions), triangles, embree::Quality::High, robust)?.0)
}
