//! What blocked earlier packets, by where their light saw them: the area variant of OCC for packets.

use super::NO_OCCLUDER;
use crate::kernels::{Face, NodeRef, SEEDS};

/// Places of the table; what falls on one place of two cells is shared, which costs time at worst.
const PLACES: usize = 4096;
/// Cells along one side of a face.
const GRID: f32 = 32.0;

/// Occluders by light, face and cell of slopes.
#[derive(Clone, Debug)]
pub(super) struct Areas {
    /// Entries of a cell in use, at most [`SEEDS`].
    entries: usize,
    cells: Vec<[NodeRef; SEEDS]>,
}

impl Areas {
    pub(super) fn new(entries: usize) -> Areas {
        Areas { entries: entries.clamp(1, SEEDS), cells: vec![[NO_OCCLUDER; SEEDS]; PLACES] }
    }

    /// The place of what the light at `origin` sees at slopes (u, v) of a face.
    pub(super) fn place(origin: [f32; 3], face: Face, u: f32, v: f32) -> usize {
        let cell = |slope: f32| ((slope + 1.0) * (0.5 * GRID)) as u64;
        let mut hash = face.index() as u64 | cell(u) << 8 | cell(v) << 16;
        for x in origin {
            hash = (hash ^ u64::from(x.to_bits())).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            hash ^= hash >> 29;
        }
        hash as usize % PLACES
    }

    /// What to try first there, the latest first.
    pub(super) fn seeds(&self, place: usize) -> [NodeRef; SEEDS] {
        self.cells[place]
    }

    /// Something was blocked there by this.
    pub(super) fn put(&mut self, place: usize, occluder: NodeRef) {
        let entries = &mut self.cells[place][..self.entries];
        let at = entries.iter().position(|&entry| entry == occluder).unwrap_or(entries.len() - 1);
        entries[..=at].rotate_right(1);
        entries[0] = occluder;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_keeps_its_latest_occluders_each_once() {
        let leaves = [1, 2, 3].map(|block| NodeRef::leaf(block, 0, 1));
        let mut areas = Areas::new(2);
        let place = Areas::place([1.0, 2.0, 3.0], Face::ALL[2], 0.5, -0.5);
        for leaf in [0, 1, 0, 2] {
            areas.put(place, leaves[leaf]);
        }
        assert_eq!(areas.seeds(place), [leaves[2], leaves[0], NO_OCCLUDER, NO_OCCLUDER]);
    }

    #[test]
    fn cells_of_lights_and_faces_mostly_have_their_own_places() {
        let mut places: Vec<usize> = (0..200)
            .map(|i| {
                let face = Face::ALL[i % 6];
                Areas::place([i as f32 / 7.0, 1.0, 0.0], face, (i % 5) as f32 * 0.2, -(i as f32) / 200.0)
            })
            .collect();
        places.sort_unstable();
        places.dedup();
        assert!(places.len() > 180, "{}", places.len());
    }
}
