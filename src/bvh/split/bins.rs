//! Splitting a set of references in two by the surface area heuristic, judged at the borders of bins (Wald 2007).

use super::{Task, cost};
use crate::bvh::reference::{Bounds, CHUNK, Extent, Reference};
use glam::Vec4;
use rayon::prelude::*;

/// Bins along each axis: a power of two.
const BINS: usize = 16;

/// Along the three axes of space and, for sets larger than this, also by size: what is large, such as walls and
/// floors, then stays near the root, where packets of rays find it at once.
const BY_SIZE: usize = 4096;

/// Which bin a reference belongs to.
#[derive(Clone, Copy)]
struct Map {
    base: Vec4,
    scale: Vec4,
}

impl Map {
    #[inline(always)]
    fn new(middles: &Bounds) -> Map {
        let extent = middles.hi - middles.lo;
        // Just below the number of bins, so that the greatest middle falls into the last one.
        let bins = BINS as f32 * 0.9999;
        let scale = Vec4::select(extent.cmpgt(Vec4::ZERO), bins / extent, Vec4::ZERO);
        Map { base: middles.lo, scale }
    }

    /// Bins by axis. Any monotonic function would do; this one rounds by adding a number whose last bit counts one.
    #[inline(always)]
    fn bins(&self, reference: &Reference) -> [usize; 4] {
        let x = (reference.middle() - self.base) * self.scale - Vec4::splat(0.5) + Vec4::splat(WHOLE);
        let bin = |x: f32| x.to_bits() as usize & (BINS - 1);
        [bin(x.x), bin(x.y), bin(x.z), bin(x.w)]
    }

    /// The same for one axis.
    #[inline(always)]
    fn bin(&self, reference: &Reference, axis: usize) -> usize {
        let x = (reference.middle_along(axis) - self.base[axis]) * self.scale[axis] - 0.5 + WHOLE;
        x.to_bits() as usize & (BINS - 1)
    }
}

/// 1.5 * 2^23.
const WHOLE: f32 = 12_582_912.0;

/// What fell into the bins, by axis.
struct Bins<const AXES: usize> {
    bounds: [[Bounds; BINS]; AXES],
    count: [[u32; BINS]; AXES],
}

impl<const AXES: usize> Bins<AXES> {
    const EMPTY: Bins<AXES> = Bins { bounds: [[Bounds::EMPTY; BINS]; AXES], count: [[0; BINS]; AXES] };

    #[inline(always)]
    fn fill(&mut self, references: &[Reference], map: &Map) {
        for reference in references {
            let bounds = reference.bounds();
            let bins = map.bins(reference);
            for axis in 0..AXES {
                let bin = &mut self.bounds[axis][bins[axis]];
                *bin = bin.union(&bounds);
                self.count[axis][bins[axis]] += 1;
            }
        }
    }

    /// The best border between two bins; `None` if all references fall into one.
    #[inline(always)]
    fn best(&self, map: Map) -> Option<Split> {
        let mut best = Split { cost: f32::INFINITY, left: 0, map, axis: 0, bin: 0 };
        for axis in 0..AXES {
            let (bounds, count) = (&self.bounds[axis], &self.count[axis]);
            let mut right = [(0.0, 0); BINS];
            let mut sum = (Bounds::EMPTY, 0);
            for i in (1..BINS).rev() {
                sum = (sum.0.union(&bounds[i]), sum.1 + count[i]);
                right[i] = (cost(&sum.0, sum.1), sum.1);
            }
            let mut left = (Bounds::EMPTY, 0);
            for i in 1..BINS {
                left = (left.0.union(&bounds[i - 1]), left.1 + count[i - 1]);
                // An empty side costs infinity times zero, which is not less than anything.
                let total = cost(&left.0, left.1) + right[i].0;
                if total < best.cost && left.1 > 0 && right[i].1 > 0 {
                    best = Split { cost: total, left: left.1 as usize, axis, bin: i, ..best };
                }
            }
        }
        (best.cost < f32::INFINITY).then_some(best)
    }

    fn merge(mut self, other: &Bins<AXES>) -> Bins<AXES> {
        for axis in 0..AXES {
            for i in 0..BINS {
                self.bounds[axis][i] = self.bounds[axis][i].union(&other.bounds[axis][i]);
                self.count[axis][i] += other.count[axis][i];
            }
        }
        self
    }
}

/// The best split between two bins; `None` if all references fall into one.
#[inline(always)]
pub(super) fn best(references: &[Reference], extent: &Extent) -> Option<Split> {
    let map = Map::new(&extent.middles);
    if references.len() > BY_SIZE {
        return best_of_many(references, map);
    }
    let mut bins = Bins::<3>::EMPTY;
    bins.fill(references, &map);
    bins.best(map)
}

fn best_of_many(references: &[Reference], map: Map) -> Option<Split> {
    let fill = |references: &[Reference]| {
        let mut bins = Bins::<4>::EMPTY;
        bins.fill(references, &map);
        bins
    };
    let bins = if references.len() <= 4 * CHUNK {
        fill(references)
    } else {
        references.par_chunks(2 * CHUNK).map(fill).reduce(|| Bins::EMPTY, |a, b| a.merge(&b))
    };
    bins.best(map)
}

/// A border between two bins.
#[derive(Clone, Copy)]
pub(super) struct Split {
    cost: f32,
    left: usize,
    map: Map,
    axis: usize,
    bin: usize,
}

impl Split {
    /// Moves references to their sides, keeping their order.
    #[inline(always)]
    pub(super) fn divide<'a>(&self, task: Task<'a>) -> [Task<'a>; 2] {
        task.divide(self.left, |from, to| {
            if from.len() > 4 * CHUNK {
                self.partition(from, to);
            } else {
                self.scatter(from, to, self.left);
            }
        })
    }

    #[inline(always)]
    fn goes_left(&self, reference: &Reference) -> bool {
        self.map.bin(reference, self.axis) < self.bin
    }

    /// Many at a time, in parallel.
    fn partition(&self, from: &[Reference], to: &mut [Reference]) {
        let lefts = |chunk: &[Reference]| chunk.iter().filter(|reference| self.goes_left(reference)).count();
        let counts: Vec<usize> = from.par_chunks(2 * CHUNK).map(lefts).collect();
        let (mut left, mut right) = to.split_at_mut(self.left);
        let mut pieces = Vec::with_capacity(counts.len());
        for (chunk, lefts) in from.chunks(2 * CHUNK).zip(counts) {
            let (l, rest_left) = left.split_at_mut(lefts);
            let (r, rest_right) = right.split_at_mut(chunk.len() - lefts);
            (left, right) = (rest_left, rest_right);
            pieces.push((chunk, l, r));
        }
        pieces.into_par_iter().for_each(|(chunk, left, right)| {
            let (mut l, mut r) = (left.iter_mut(), right.iter_mut());
            for reference in chunk {
                let next = if self.goes_left(reference) { l.next() } else { r.next() };
                if let Some(next) = next {
                    *next = *reference;
                }
            }
        });
    }

    /// To the first `left` places and to those behind, without a branch that nobody can predict.
    #[inline(always)]
    fn scatter(&self, from: &[Reference], to: &mut [Reference], left: usize) {
        let mut next = [left, 0];
        for reference in from {
            let side = usize::from(self.goes_left(reference));
            to[next[side]] = *reference;
            next[side] += 1;
        }
    }
}
