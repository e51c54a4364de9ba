//! The tree over a scene's triangles.
//!
//! ```text
//!   triangles --reference--> boxes --split--> binary tree --choice, collapse, pack--> 8-wide nodes + blocks of 8
//!        \--merged (slow only)----------------/
//! ```
//!
//! All of it runs on rayon's threads, so never call it from a pinned thread: they would inherit its CPU. The tree
//! does not depend on their number. `slow` takes its binary tree from obvhs, which is also a baseline of its own; no
//! other module names it.
//!
//! Where triangles move, the tree is fitted to their new places, or built anew ([`Bvh::follow`]).
//!
//! Boxes always enclose whole triangles, because the kernels' proof that no hit is lost needs every vertex inside
//! every box above it.

mod baseline;
mod binary;
mod build;
mod choice;
mod collapse;
mod merged;
mod pack;
mod reference;
mod refit;
mod report;
mod split;
mod validate;

pub use baseline::Baseline;
pub use build::BuildPreset;
pub use refit::{Update, WORN};
pub use report::TreeReport;
pub use validate::Violation;

use crate::{
    error::{Error, Result},
    kernels::{BvhView, MAX_DEPTH, Node, NodeRef, TriBlock},
    scene::TriangleMesh,
};
use collapse::Wide;
use std::time::{Duration, Instant};

/// An 8-wide tree with its triangles.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<TriBlock>,
    root: NodeRef,
    id: u64,
    build_time: Duration,
    /// Where each run of nodes starts whose children are in the same run, behind their parents; the first run is the top,
    /// whose children may be anywhere behind. The end is the last.
    pieces: Vec<usize>,
    /// Its cost when it was built, once somebody has asked.
    built_cost: Option<f64>,
}

impl Bvh {
    /// Builds the tree, on all cores the calling thread may use (so never from a pinned thread).
    ///
    /// # Errors
    /// [`Error::Failed`] if the geometry is so degenerate that the tree gets deeper than the kernels' stacks.
    pub fn build(mesh: &TriangleMesh, preset: BuildPreset) -> Result<Bvh> {
        let start = Instant::now();
        let Wide { nodes, blocks, root, pieces } = build::wide(mesh, preset);
        let id = BvhView::fresh_id();
        let bvh = Bvh { nodes, blocks, root, id, build_time: start.elapsed(), pieces, built_cost: None };
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
