//! Runs the tiles of a frame on pinned worker threads. `README.md` beside this file tells the protocol in prose.
//!
//! What a tile means is up to the [`TileTask`]; the scheduler knows no scene and no ray.

mod control;
mod costs;
mod deal;
mod dealing;
mod flight;
mod mail;
mod master;
mod message;
mod pin;
mod plan;
mod policy;
mod probe;
mod source;
mod stats;
mod strategy;
mod sync;
mod topology;
mod worker;

#[cfg(test)]
mod model;
#[cfg(test)]
mod tests;

pub use control::{Control, Progress};
pub use costs::CostMap;
pub use deal::{Dealer, Run};
pub use master::{Master, with_workers};
pub use pin::{Machine, Pinned, Placement, pin_current_thread, refusals};
pub use plan::{End, Plan};
pub use probe::{Collect, Load, SharedCore, SharedCoreProbe, steal_seconds};
pub use source::Source;
pub use stats::{FrameStats, Idle, MasterSeconds, Messages, Pause, Span, WorkerStats};
pub use strategy::{FilmMode, Schedule, Strategy};
pub use topology::Topology;

use crate::tile::Tile;

/// What to do with a tile.
///
/// The task itself holds what stays the same over many frames (scene, tree, kernels) and may borrow it.
pub trait TileTask: Sync {
    /// What belongs to one frame: camera, film, settings. Shared by all workers while the frame lasts.
    type Frame: Send + Sync;
    /// Buffers of one worker, reused from tile to tile. Made, used and dropped on the worker's thread.
    type Scratch;
    /// What a tile gives to the master: counts, or finished pixels. Made anew only when the old ones do not suffice.
    type Output: Default + Send;

    /// Makes the buffers of worker number `worker` (counted from 0), after that worker was pinned.
    fn scratch(&self, worker: usize) -> Self::Scratch;

    /// Does the work of `tile`. Called exactly once per tile of a frame, by any worker, in any order. `output` is new or
    /// what another tile left there, and becomes this tile's. A panic ends the frame with
    /// [`Error::Worker`](crate::error::Error::Worker), not the process.
    fn run(&self, frame: &Self::Frame, tile: Tile, scratch: &mut Self::Scratch, output: &mut Self::Output);
}
