//! What the builder sorts: boxes around triangles, or around parts of them.

use crate::scene::TriangleMesh;
use glam::Vec4;
use rayon::prelude::*;

/// References that one task works on at a time. Fixed, so that nothing depends on the number of threads.
pub(super) const CHUNK: usize = 8192;

/// A box; the fourth components mean nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) lo: Vec4,
    pub(super) hi: Vec4,
}

impl Bounds {
    pub(super) const EMPTY: Bounds = Bounds { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub(super) fn union(&self, other: &Bounds) -> Bounds {
        Bounds { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Half of the surface area, of a box that is not empty.
    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let [x, y, z, _] = (self.hi - self.lo).to_array();
        x * (y + z) + y * z
    }
}

/// A box with the triangle that it belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// Its fourth component carries the bits of the primitive id.
    lo: Vec4,
    /// Its fourth component is a measure of the box's size.
    hi: Vec4,
}

impl Reference {
    /// Takes no room that matters.
    pub(super) const NONE: Reference = Reference { lo: Vec4::ZERO, hi: Vec4::ZERO };

    #[inline(always)]
    pub(super) fn new(bounds: &Bounds, prim: u32) -> Reference {
        // The bits of a positive float, as a number, are about its logarithm.
        let size = bounds.half_area().to_bits() as f32;
        Reference {
            lo: bounds.lo.truncate().extend(f32::from_bits(prim)),
            hi: bounds.hi.truncate().extend(size),
        }
    }

    #[inline(always)]
    pub(super) fn prim(&self) -> u32 {
        self.lo.w.to_bits()
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Bounds {
        Bounds { lo: self.lo, hi: self.hi }
    }

    /// The middle, but doubled, and the size.
    #[inline(always)]
    pub(super) fn middle(&self) -> Vec4 {
        let lo = self.lo;
        Vec4::new(lo.x, lo.y, lo.z, 0.0) + self.hi
    }

    /// One component of the middle.
    #[inline(always)]
    pub(super) fn middle_along(&self, axis: usize) -> f32 {
        if axis == 3 { self.hi.w } else { self.lo[axis] + self.hi[axis] }
    }
}

/// One reference for each triangle.
pub(super) fn references(mesh: &TriangleMesh) -> Vec<Reference> {
    let reference = |prim: usize| {
        let [a, b, c] = mesh.corners(prim).map(|p| p.extend(0.0));
        Reference::new(&Bounds { lo: a.min(b).min(c), hi: a.max(b).max(c) }, prim as u32)
    };
    (0..mesh.len()).into_par_iter().with_min_len(CHUNK).map(reference).collect()
}

/// Memory for so many references.
pub(super) fn room(count: usize) -> Vec<Reference> {
    (0..count).into_par_iter().with_min_len(CHUNK).map(|_| Reference::NONE).collect()
}

/// What is around a set of references.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// All boxes.
    pub(super) bounds: Bounds,
    /// All (doubled) middles.
    pub(super) middles: Bounds,
}

impl Extent {
    const EMPTY: Extent = Extent { bounds: Bounds::EMPTY, middles: Bounds::EMPTY };

    #[inline(always)]
    pub(super) fn of(references: &[Reference]) -> Extent {
        if references.len() > 4 * CHUNK {
            return references
                .par_chunks(CHUNK)
                .map(Extent::serial)
                .reduce(|| Extent::EMPTY, |a, b| a.union(&b));
        }
        Extent::serial(references)
    }

    #[inline(always)]
    fn serial(references: &[Reference]) -> Extent {
        let mut extent = Extent::EMPTY;
        for reference in references {
            extent.bounds = extent.bounds.union(&reference.bounds());
            let middle = reference.middle();
            extent.middles = extent.middles.union(&Bounds { lo: middle, hi: middle });
        }
        extent
    }

    fn union(&self, other: &Extent) -> Extent {
        Extent { bounds: self.bounds.union(&other.bounds), middles: self.middles.union(&other.middles) }
    }
}
