//! The tree over a scene's triangles.
//!
//! ```text
//!   triangles --obvhs--> binary tree, one triangle a leaf --collapse--> 8-wide nodes + blocks of 8 triangles
//! ```
//!
//! obvhs builds the binary tree (PLOC with reinsertion); [`collapse`] turns it into the layout of the kernels. This
//! is the only module that names obvhs.
//!
//! Boxes always enclose whole triangles: obvhs' spatial splits are not used, because the kernels' proof that no hit
//! is lost needs every vertex inside every box above it.

mod baseline;
mod build;
mod collapse;
mod report;
mod validate;

pub use baseline::Baseline;
pub use build::BuildPreset;
pub use report::TreeReport;
pub use validate::Violation;

use crate::{
    error::{Error, Result},
    kernels::{BvhView, MAX_DEPTH, Node, NodeRef, TriBlock},
    scene::TriangleMesh,
};
use std::time::{Duration, Instant};

/// An 8-wide tree with its triangles.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<TriBlock>,
    root: NodeRef,
    id: u64,
    build_time: Duration,
}

impl Bvh {
    /// Builds the tree, on all cores the calling thread may use (so never from a pinned thread).
    ///
    /// # Errors
    /// [`Error::Failed`] if the geometry is so degenerate that the tree gets deeper than the kernels' stacks.
    pub fn build(mesh: &TriangleMesh, preset: BuildPreset) -> Result<Bvh> {
        let start = Instant::now();
        let binary = build::binary(mesh, preset);
        let (nodes, blocks, root) = collapse::collapse(&binary, mesh);
        let bvh = Bvh { nodes, blocks, root, id: BvhView::fresh_id(), build_time: start.elapsed() };
        let depth = bvh.depth();
        if depth > MAX_DEPTH {
            return Err(Error::Failed(format!(
                "the tree over this geometry is {depth} levels deep, more than {MAX_DEPTH}; remove triangles whose \
                 sizes differ by many orders of magnitude"
            )));
        }
        Ok(bvh)
    }

    /// The tree as the kernels borrow it.
    pub fn view(&self) -> BvhView<'_> {
        BvhView { id: self.id, nodes: &self.nodes, blocks: &self.blocks, root: self.root }
    }

    /// Wall-clock time of the build.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }

    /// Size of nodes and triangles in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])
    }
}
