//! What the master keeps about the frame under way.

use super::message::Parcel;
use super::{Dealer, FrameStats, Pause, Schedule, Span};
use crate::error::Error;
use crate::tile::Tile;
use std::time::Instant;

/// One frame, from dealing the first task to collecting the last result.
pub(super) struct Running {
    pub(super) start: Instant,
    pub(super) schedule: Schedule,
    pub(super) dealer: Dealer,
    pub(super) stats: FrameStats,
    /// Why nothing more is dealt.
    pub(super) failure: Option<Error>,
    /// Tiles collected.
    pub(super) done: usize,
    /// How workers waited.
    pub(super) pauses: Vec<Pause>,
}

impl Running {
    /// Of several failures the first one is told.
    pub(super) fn fail(&mut self, error: Error) {
        self.failure.get_or_insert(error);
    }

    /// Takes the figures and the failure out of a parcel.
    pub(super) fn note<O>(&mut self, worker: usize, parcel: &mut Parcel<O>, tiles: &[Tile]) {
        let since = |at: Instant| at.saturating_duration_since(self.start).as_secs_f64();
        for item in &parcel.items[..parcel.used] {
            let (start, end) = (since(item.start), since(item.end));
            self.stats.spans.push(Span { worker, tile: tiles[item.place], start, end });
        }
        let stats = &mut self.stats.workers[worker];
        stats.steals += parcel.steals;
        self.pauses.extend(parcel.waits.iter().map(|wait| Pause {
            worker,
            start: since(wait.start),
            end: since(wait.end),
            deliver: wait.deliver,
        }));
        parcel.task_latencies.iter().for_each(|&latency| self.stats.tasks.arrived(latency));
        if let Some((Tile { x, y, width, height }, message)) = parcel.failure.take() {
            self.fail(Error::Worker { x, y, width, height, message });
        }
    }
}
