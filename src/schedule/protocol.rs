//! The messages between master and workers.

use super::pin::Pinned;
use crate::tile::Tile;
use std::sync::Arc;
use std::time::Duration;

/// Master to worker: run this tile.
pub(super) struct Command<F> {
    pub(super) frame: Arc<F>,
    pub(super) tile: Tile,
}

/// Worker to master.
pub(super) enum Report<O> {
    /// Sent once, before the first tile.
    Ready { worker: usize, pinned: Pinned },
    /// Sent once per command, after the worker let go of the frame.
    Done {
        worker: usize,
        tile: Tile,
        /// Time the worker spent on the tile.
        busy: Duration,
        /// The task's output, or the message of its panic.
        outcome: Result<O, String>,
    },
}
