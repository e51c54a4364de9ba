//! What the tile kernel keeps between packets: working memory, and the set-up of leaves it has met.
//!
//! The set-up of a block depends on the tree, the origin, the face and the visibility alone, and neighbouring packets meet the same
//! blocks: a small direct-mapped cache serves them. It changes the time, never the answer.

use super::{
    SEEDS, State, TileEarly,
    block::{BlockPlanes, set_up},
};
use crate::{
    generic::{Frame, finish::Planes},
    node::{BvhView, NodeRef},
    packet::TilePacket,
    simd::Simd,
    visibility::Policy,
};

/// Blocks remembered: 320 KiB, to stay in the second-level cache.
const ENTRIES: usize = 512;
/// Origins remembered; a picture with more lights than this loses a little time.
const ORIGINS: usize = 16;

/// What a set-up depends on: tree, origin, face and visibility.
type Key = (u64, [u32; 3], usize);

/// Working memory of the tile kernels: one for each thread, for any trees and packets. About 330 KiB.
#[derive(Clone, Debug)]
pub struct TileScratch {
    pub(super) state: Box<State>,
    pub(super) leaves: LeafCache,
    pub(super) planes: Box<Planes>,
}

impl TileScratch {
    /// Nothing remembered.
    pub fn new() -> TileScratch {
        TileScratch {
            state: Box::new(State::new()),
            leaves: LeafCache::new(),
            planes: Box::new(Planes::new()),
        }
    }

    /// How the searches of the packets to come end early: [`TileEarly::ALL`] unless told otherwise.
    pub fn set_early(&mut self, early: TileEarly) {
        self.state.early = early;
    }

    /// How much work a packet may take before the kernel gives it up, in units: about a pair of a triangle and a sub-packet
    /// each, eight for a node. There is no limit (`u32::MAX`) unless told otherwise.
    pub fn set_budget(&mut self, budget: u32) {
        self.state.budget = budget;
    }

    /// Whether the last packet was given up: its first hits were not stored, and the rays not told as blocked may be.
    pub fn gave_up(&self) -> bool {
        self.state.gave_up
    }

    /// Units of work that the last packet took.
    pub fn work(&self) -> u32 {
        self.state.work
    }

    /// Triangles that `packet`, of which the first hits were found just before, has hit: seeds for a packet like it.
    pub fn hit_seeds(&self, packet: &TilePacket) -> [NodeRef; SEEDS] {
        self.state.hit_seeds(packet)
    }
}

impl Default for TileScratch {
    fn default() -> TileScratch {
        TileScratch::new()
    }
}

/// Set-ups by block, for the origins met last.
#[derive(Clone, Debug)]
pub(super) struct LeafCache {
    blocks: Box<[BlockPlanes; ENTRIES]>,
    /// Epoch and block of each entry.
    tags: Box<[u64; ENTRIES]>,
    /// Entries that may not be replaced are those that hold the number of the current batch.
    held: Box<[u32; ENTRIES]>,
    batch: u32,
    /// The epoch of each key; 0 is no epoch.
    keys: [(Key, u32); ORIGINS],
    /// Place of the current key.
    current: usize,
    next: usize,
    epochs: u32,
}

impl LeafCache {
    fn new() -> LeafCache {
        LeafCache {
            blocks: vec![BlockPlanes::EMPTY; ENTRIES].try_into().expect("as many entries"),
            tags: Box::new([0; ENTRIES]),
            held: Box::new([0; ENTRIES]),
            batch: 1,
            keys: [((0, [0; 3], 0), 0); ORIGINS],
            current: 0,
            next: 0,
            epochs: 0,
        }
    }

    /// Must be called before a packet's blocks are asked for.
    #[inline(always)]
    pub(super) fn begin<V: Policy>(&mut self, bvh: &BvhView, packet: &TilePacket) {
        let [x, y, z] = packet.org;
        let face = packet.face.index() << 1 | usize::from(V::EXACT);
        let key = (bvh.id, [x.to_bits(), y.to_bits(), z.to_bits()], face);
        let (current, epoch) = self.keys[self.current % ORIGINS];
        if epoch == 0 || current != key {
            self.change(key);
        }
    }

    #[cold]
    #[inline(never)]
    fn change(&mut self, key: Key) {
        if let Some(at) = self.keys.iter().position(|&(known, epoch)| known == key && epoch != 0) {
            self.current = at;
            return;
        }
        if self.epochs == u32::MAX {
            // Epochs start again: nothing of the old ones may be taken for new.
            self.epochs = 0;
            self.keys = [((0, [0; 3], 0), 0); ORIGINS];
            self.tags.fill(0);
        }
        self.epochs += 1;
        self.keys[self.next] = (key, self.epochs);
        self.current = self.next;
        self.next = (self.next + 1) % ORIGINS;
    }

    /// Stands for the current tree, origin and face; never 0.
    #[inline(always)]
    pub(super) fn epoch(&self) -> u32 {
        self.keys[self.current % ORIGINS].1
    }

    /// True if a block is set up for the current packet.
    #[inline(always)]
    pub(super) fn has(&self, block: usize) -> bool {
        self.tags[block % ENTRIES] == u64::from(self.epoch()) << 32 | block as u64
    }

    /// True if setting up a block would replace one that is still needed.
    #[inline(always)]
    pub(super) fn is_in_the_way(&self, block: usize) -> bool {
        self.held[block % ENTRIES] == self.batch && !self.has(block)
    }

    /// Lets go of what [`LeafCache::get`] has returned since the last time.
    #[inline(always)]
    pub(super) fn release(&mut self) {
        self.batch = self.batch.wrapping_add(1);
    }

    /// The set-up of the block of a slot, which [`LeafCache::get`] has returned and nothing has replaced since.
    #[inline(always)]
    pub(super) fn at(&self, slot: u32) -> &BlockPlanes {
        &self.blocks[slot as usize / 8 % ENTRIES]
    }

    /// The set-up of a block for the current packet; stays until released.
    #[inline(always)]
    pub(super) fn get<S: Simd, V: Policy>(
        &mut self,
        s: S,
        bvh: &BvhView,
        frame: &Frame,
        block: usize,
    ) -> &BlockPlanes {
        let at = block % ENTRIES;
        let tag = u64::from(self.epoch()) << 32 | block as u64;
        self.held[at] = self.batch;
        let entry = &mut self.blocks[at];
        if self.tags[at] != tag {
            self.tags[at] = tag;
            set_up::<S, V>(s, &bvh.blocks[block], frame, entry);
        }
        entry
    }
}
