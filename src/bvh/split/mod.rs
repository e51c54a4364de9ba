//! Splitting a set of references in two.

mod bins;
mod sweep;

use super::reference::{Bounds, Extent, Reference};

/// Sets up to this size are swept exactly, larger ones are binned.
const FEW: usize = 8;

/// References that cost about as much as one: a leaf tests several at once, and sets that fill it are preferred.
const LANES: u32 = 4;

/// Expected cost of a set of references.
#[inline(always)]
fn cost(bounds: &Bounds, count: u32) -> f32 {
    bounds.half_area() * count.div_ceil(LANES) as f32
}

/// A set of references, with as much memory again to move them to.
pub(super) struct Task<'a> {
    pub(super) from: &'a mut [Reference],
    pub(super) spare: &'a mut [Reference],
}

impl<'a> Task<'a> {
    /// Number of references.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.from.len()
    }

    /// A task with the first `left` of the references that `partition` moves, and one with the others.
    #[inline(always)]
    fn divide(self, left: usize, partition: impl FnOnce(&[Reference], &mut [Reference])) -> [Task<'a>; 2] {
        partition(self.from, self.spare);
        let (to_left, to_right) = self.spare.split_at_mut(left);
        let (from_left, from_right) = self.from.split_at_mut(left);
        [Task { from: to_left, spare: from_left }, Task { from: to_right, spare: from_right }]
    }
}

/// Splits a set of two or more in two that are not empty.
// Not inlined, because its bins must not lie on the stack of whoever goes on recursively.
#[inline(never)]
pub(super) fn split<'a>(task: Task<'a>, extent: &Extent) -> [Task<'a>; 2] {
    if task.len() <= FEW {
        match sweep::best(task.from) {
            Some(sweep) => sweep.divide(task),
            None => halve(task),
        }
    } else {
        match bins::best(task.from, extent) {
            Some(split) => split.divide(task),
            None => halve(task),
        }
    }
}

/// The first half and the second, in the order in which they happen to be.
pub(super) fn halve(task: Task) -> [Task; 2] {
    let half = task.len() / 2;
    task.divide(half, |from, to| to.copy_from_slice(from))
}
