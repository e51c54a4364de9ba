//! Runs the tiles of a frame on pinned worker threads. `README.md` beside this file tells the protocol in prose.
//!
//! What a tile means is up to the [`TileTask`]; the scheduler knows no scene and no ray.

mod control;
mod master;
mod pin;
mod protocol;
mod topology;
mod worker;

#[cfg(test)]
mod tests;

pub use control::{Control, Progress};
pub use master::{FrameStats, Master, WorkerStats, with_workers};
pub use pin::{Machine, Pinned, Placement, pin_current_thread};
pub use topology::Topology;

use crate::error::Error;
use crate::tile::Tile;
use std::fmt;
use std::str::FromStr;

/// What to do with a tile.
///
/// The task itself holds what stays the same over many frames (scene, tree, kernels) and may borrow it.
pub trait TileTask: Sync {
    /// What belongs to one frame: camera, film, settings. Shared by all workers while the frame lasts.
    type Frame: Send + Sync;
    /// Buffers of one worker, reused from tile to tile. Made, used and dropped on the worker's thread.
    type Scratch;
    /// What a tile gives to the master: counts, or finished pixels.
    type Output: Send;

    /// Makes the buffers of worker number `worker` (counted from 0), after that worker was pinned.
    fn scratch(&self, worker: usize) -> Self::Scratch;

    /// Does the work of `tile`. Called exactly once per tile of a frame, by any worker, in any order. A panic ends
    /// the frame with [`Error::Worker`], not the process.
    fn run(&self, frame: &Self::Frame, tile: Tile, scratch: &mut Self::Scratch) -> Self::Output;
}

/// Which tile goes to which worker when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// Demand-driven: each worker starts with a tile chosen by its number; a returned result is answered with the
    /// next tile; the worker waits in between.
    #[default]
    Dynamic,
}

impl Strategy {
    /// Every strategy there is, for studies that sweep them and messages that list them.
    pub const ALL: [Strategy; 1] = [Strategy::Dynamic];

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::Dynamic => "dynamic",
        }
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Strategy {
    type Err = Error;

    /// Parses the name on the command line; the error lists the strategies there are.
    fn from_str(name: &str) -> Result<Strategy, Error> {
        Strategy::ALL.into_iter().find(|strategy| strategy.name() == name).ok_or_else(|| {
            let available = Strategy::ALL.map(Strategy::name).join(", ");
            Error::flag(
                "--schedule",
                format!("'{name}' is not available"),
                format!("use one of: {available}"),
            )
        })
    }
}
