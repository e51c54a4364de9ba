//! The binary tree, built from the top.
//!
//! ```text
//!   all references --split, in parallel--> grains of at most GRAIN --split, one task each--> leaves
//! ```
//!
//! Every decision depends on the set of references alone, and sets keep their order when they are split, so that the
//! tree is the same whatever the number of threads.

use super::{
    choice::Choice,
    reference::{Bounds, Extent, Reference},
    split::{self, Task, halve},
};
use crate::kernels::MAX_DEPTH;

/// Subtrees of so many references are built by one task.
const GRAIN: usize = 4096;

/// A node of the binary tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binary {
    pub(super) lo: [f32; 3],
    pub(super) hi: [f32; 3],
    pub(super) link: Link,
    pub(super) choice: Choice,
}

/// What a binary node leads to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Link {
    /// The two nodes from this index on.
    Pair(u32),
    /// The root of a grain, which this node stands for.
    Grain(u32),
    /// So many primitives from this index on.
    Leaf { first: u32, count: u32 },
}

/// A subtree: the root is the first node.
#[derive(Default)]
pub(super) struct Grain {
    pub(super) nodes: Vec<Binary>,
    pub(super) prims: Vec<u32>,
}

/// A binary tree: the nodes at the top, and what hangs below.
pub(super) struct Tree {
    pub(super) top: Vec<Binary>,
    pub(super) grains: Vec<Grain>,
}

/// What one task hands up.
enum Part {
    Grain(Grain),
    Split(Bounds, Box<[Part; 2]>),
}

/// How to build.
#[derive(Clone, Copy)]
pub(super) struct Builder {
    /// Sets up to this size are not split.
    pub(super) stop: usize,
}

impl Builder {
    /// The tree over the references in `from`, of which there is at least one.
    pub(super) fn build(&self, task: Task) -> Tree {
        let part = self.part(task, 1);
        let mut tree = Tree { top: Vec::new(), grains: Vec::new() };
        tree.top.push(Binary::NONE);
        tree.flatten(0, part);
        tree
    }

    fn part(&self, task: Task, depth: usize) -> Part {
        if task.len() <= GRAIN {
            let capacity = 2 * task.len().div_ceil(self.stop);
            let mut grain =
                Grain { nodes: Vec::with_capacity(capacity), prims: Vec::with_capacity(task.len()) };
            grain.nodes.push(Binary::NONE);
            self.node(&mut grain, 0, task, depth);
            return Part::Grain(grain);
        }
        let extent = Extent::of(task.from);
        let [left, right] = split_at(task, &extent, depth);
        let (left, right) = rayon::join(|| self.part(left, depth + 1), || self.part(right, depth + 1));
        Part::Split(extent.bounds, Box::new([left, right]))
    }

    /// Builds the subtree below node `index` of a grain.
    fn node(&self, grain: &mut Grain, index: usize, task: Task, depth: usize) {
        let extent = Extent::of(task.from);
        if task.len() <= self.stop {
            let first = grain.prims.len() as u32;
            grain.prims.extend(task.from.iter().map(Reference::prim));
            let link = Link::Leaf { first, count: task.len() as u32 };
            grain.nodes[index] =
                Binary::new(&extent.bounds, link, Choice::leaf(extent.bounds.half_area(), task.len() as u32));
            return;
        }
        let [left, right] = split_at(task, &extent, depth);
        let first = grain.nodes.len();
        grain.nodes.extend([Binary::NONE; 2]);
        self.node(grain, first, left, depth + 1);
        self.node(grain, first + 1, right, depth + 1);
        let [left, right] = [&grain.nodes[first].choice, &grain.nodes[first + 1].choice];
        let choice = Choice::inner(extent.bounds.half_area(), left, right);
        grain.nodes[index] = Binary::new(&extent.bounds, Link::Pair(first as u32), choice);
    }
}

/// Splits the set of a node at this depth so that no path gets too long.
#[inline(never)]
fn split_at<'a>(task: Task<'a>, extent: &Extent, depth: usize) -> [Task<'a>; 2] {
    // From here on, halves reach the leaves just in time.
    let levels = usize::BITS - task.len().leading_zeros();
    if depth + levels as usize >= MAX_DEPTH { halve(task) } else { split::split(task, extent) }
}

impl Binary {
    pub(super) const NONE: Binary =
        Binary { lo: [0.0; 3], hi: [0.0; 3], link: Link::Pair(0), choice: Choice::NONE };

    pub(super) fn new(bounds: &Bounds, link: Link, choice: Choice) -> Binary {
        Binary { lo: bounds.lo.truncate().to_array(), hi: bounds.hi.truncate().to_array(), link, choice }
    }
}

impl Tree {
    /// Makes node `index` of the top stand for `part`.
    fn flatten(&mut self, index: usize, part: Part) {
        match part {
            Part::Grain(grain) => {
                self.top[index] = Binary { link: Link::Grain(self.grains.len() as u32), ..grain.nodes[0] };
                self.grains.push(grain);
            }
            Part::Split(bounds, parts) => {
                let first = self.top.len();
                self.top.extend([Binary::NONE; 2]);
                for (i, part) in parts.into_iter().enumerate() {
                    self.flatten(first + i, part);
                }
                let [left, right] = [&self.top[first].choice, &self.top[first + 1].choice];
                let choice = Choice::inner(bounds.half_area(), left, right);
                self.top[index] = Binary::new(&bounds, Link::Pair(first as u32), choice);
            }
        }
    }
}
