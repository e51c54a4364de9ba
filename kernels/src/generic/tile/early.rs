//! Early terminations of the tile kernels as switches. They change the work, never the result.

use super::State;
use crate::{
    generic::doubt::NO_SLOT,
    node::{BvhView, EMPTY_NODE, NodeRef},
    packet::TilePacket,
};

/// Triangles that a packet leaves to others.
pub const SEEDS: usize = 4;

/// How searches end early, and what they begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileEarly {
    /// First hits: nothing beyond the farthest of a sub-packet's nearest hits so far is searched.
    pub bound: bool,
    /// Occlusion: rays that are blocked, and sub-packets of such rays, leave the search.
    pub stop: bool,
    /// Subtrees to try first; [`EMPTY_NODE`] is passed over, and so is what the tree has not.
    pub seeds: [NodeRef; SEEDS],
}

impl TileEarly {
    /// Searches end as early as they can and begin with nothing.
    pub const ALL: TileEarly = TileEarly { bound: true, stop: true, seeds: [EMPTY_NODE; SEEDS] };

    /// Seed number `at`, if it names triangles of this tree.
    #[inline(always)]
    pub(super) fn seed(&self, bvh: &BvhView, at: usize) -> Option<NodeRef> {
        let seed = self.seeds[at];
        (seed.is_leaf() && seed.block() < bvh.blocks.len()).then_some(seed)
    }
}

impl State {
    /// Four triangles that the packet just traced has hit, one of each quarter of 8x8 rays; [`EMPTY_NODE`] for those that
    /// are missing or the same as one before.
    pub(super) fn hit_seeds(&self, packet: &TilePacket) -> [NodeRef; SEEDS] {
        // The middle of each quarter: see `pixel_of` of the camera for how rays lie.
        let mut slots =
            [5, 7, 13, 15].map(|sub| if packet.active[sub] & 1 == 0 { NO_SLOT } else { self.slot[sub][0] });
        for i in 1..SEEDS {
            if slots[..i].contains(&slots[i]) {
                slots[i] = NO_SLOT;
            }
        }
        slots.map(|slot| if slot == NO_SLOT { EMPTY_NODE } else { NodeRef::triangle(slot) })
    }
}
