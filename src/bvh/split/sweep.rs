//! The best split of a few references between neighbours in the order of their middles, along every axis.

use super::{FEW, Task, cost};
use crate::bvh::reference::{Bounds, Reference};

/// The first `left` of `order` against the others.
pub(super) struct Sweep {
    cost: f32,
    order: [u8; FEW],
    left: usize,
}

impl Sweep {
    /// Moves references to their sides, in order.
    #[inline(always)]
    pub(super) fn divide<'a>(&self, task: Task<'a>) -> [Task<'a>; 2] {
        task.divide(self.left, |from, to| {
            for (to, &index) in to.iter_mut().zip(&self.order) {
                *to = from[usize::from(index)];
            }
        })
    }
}

/// The best split of at most [`FEW`] references; `None` if boxes are too large to compare.
#[inline(always)]
pub(super) fn best(references: &[Reference]) -> Option<Sweep> {
    let n = references.len();
    if n == 2 {
        return Some(Sweep { cost: 0.0, order: [0, 1, 0, 0, 0, 0, 0, 0], left: 1 });
    }
    let mut best: Option<Sweep> = None;
    for axis in 0..3 {
        let order = order(references, axis);
        let at = |i: usize| references[usize::from(order[i])].bounds();
        let mut right = [Bounds::EMPTY; FEW];
        let mut sum = Bounds::EMPTY;
        for i in (1..n).rev() {
            sum = sum.union(&at(i));
            right[i] = sum;
        }
        let mut left = Bounds::EMPTY;
        for i in 1..n {
            left = left.union(&at(i - 1));
            let total = cost(&left, i as u32) + cost(&right[i], (n - i) as u32);
            if total < best.as_ref().map_or(f32::INFINITY, |best| best.cost) {
                best = Some(Sweep { cost: total, order, left: i });
            }
        }
    }
    best
}

/// Indices in the order of the middles; equal ones stay as they are.
#[inline(always)]
fn order(references: &[Reference], axis: usize) -> [u8; FEW] {
    let mut keys = [0.0; FEW];
    let mut order = [0; FEW];
    for (i, reference) in references.iter().enumerate().take(FEW) {
        let key = reference.middle_along(axis);
        let mut at = i;
        while at > 0 && key < keys[at - 1] {
            (keys[at], order[at]) = (keys[at - 1], order[at - 1]);
            at -= 1;
        }
        (keys[at], order[at]) = (key, i as u8);
    }
    order
}
