//! What the master keeps about the frame under way.

use super::message::Parcel;
use super::plan::Dealer;
use super::{FrameStats, Schedule, Span};
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
    /// How workers waited: worker, start and end in seconds, and whether it was to deliver.
    pub(super) waits: Vec<(usize, [f64; 2], bool)>,
}

impl Running {
    /// Of several failures the first one is told.
    pub(super) fn fail(&mut self, error: Error) {
        self.failure.get_or_insert(error);
    }

    /// Sums up what the workers did. A wait counts between the first tile of a worker and its last: before lies its
    /// start, behind its tail.
    pub(super) fn sum_up(&mut self) {
        self.stats.sum_up();
        let seconds = self.stats.seconds;
        for &(worker, [start, end], deliver) in &self.waits {
            let idle = &mut self.stats.workers[worker].idle;
            if start >= idle.start && end <= seconds - idle.tail {
                *(if deliver { &mut idle.deliver } else { &mut idle.work }) += end - start;
            }
        }
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
        self.waits.extend(
            parcel.waits.iter().map(|wait| (worker, [since(wait.start), since(wait.end)], wait.deliver)),
        );
        parcel.task_latencies.iter().for_each(|&latency| self.stats.tasks.arrived(latency));
        if let Some((Tile { x, y, width, height }, message)) = parcel.failure.take() {
            self.fail(Error::Worker { x, y, width, height, message });
        }
    }
}
