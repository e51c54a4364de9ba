//! What packets of primary rays have hit, by areas of the image: shared by all workers, and from frame to frame.

use crate::{
    kernels::{EMPTY_NODE, NodeRef, SEEDS},
    trace::EarlyTermination,
};
use std::sync::{Mutex, PoisonError};

/// Pixels along one side of an area: those of two packets.
const SIDE: u32 = 32;

/// Nothing to begin with.
pub(super) const NONE: [NodeRef; SEEDS] = [EMPTY_NODE; SEEDS];

/// Triangles hit last in each area of an image. They change the time, never what is hit, so that it does not matter
/// which worker was there last.
pub(super) struct HitSeeds {
    columns: u32,
    entries: usize,
    areas: Vec<Mutex<[NodeRef; SEEDS]>>,
}

impl HitSeeds {
    /// For an image of this size; remembers nothing unless PET by areas is asked for.
    pub(super) fn new(early: EarlyTermination, [width, height]: [u32; 2]) -> HitSeeds {
        let columns = width.div_ceil(SIDE);
        let wanted = early.pet_seed && early.area > 0;
        let count = if wanted { columns as usize * height.div_ceil(SIDE) as usize } else { 0 };
        HitSeeds { columns, entries: early.area, areas: (0..count).map(|_| Mutex::new(NONE)).collect() }
    }

    fn area(&self, [x, y]: [u32; 2]) -> Option<&Mutex<[NodeRef; SEEDS]>> {
        self.areas.get((y / SIDE * self.columns + x / SIDE) as usize)
    }

    /// What to try first at a pixel.
    pub(super) fn get(&self, at: [u32; 2]) -> [NodeRef; SEEDS] {
        self.area(at).map_or(NONE, |area| *area.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// A packet at this pixel has hit these.
    pub(super) fn put(&self, at: [u32; 2], hit: [NodeRef; SEEDS]) {
        if let Some(area) = self.area(at) {
            let mut seeds = NONE;
            seeds[..self.entries.min(SEEDS)].copy_from_slice(&hit[..self.entries.min(SEEDS)]);
            *area.lock().unwrap_or_else(PoisonError::into_inner) = seeds;
        }
    }
}
