//! What a frame took, tile by tile and worker by worker.

use super::pin::Pinned;
use crate::tile::Tile;
use std::time::Duration;

/// One tile's time on its worker, in seconds from the start of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Who ran it.
    pub worker: usize,
    /// What was run.
    pub tile: Tile,
    /// When it began.
    pub start: f64,
    /// When it ended.
    pub end: f64,
}

/// Why a worker was not on a tile, in seconds. What is missing to the whole frame is the scheduler's own work.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Idle {
    /// Before its first tile.
    pub start: f64,
    /// Between tiles: the next one had not come.
    pub work: f64,
    /// Between tiles: the master had not taken its results.
    pub deliver: f64,
    /// After its last tile, until the frame was complete.
    pub tail: f64,
}

/// What one worker did in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkerStats {
    /// Where it runs.
    pub pinned: Pinned,
    /// Seconds spent on tiles.
    pub busy_seconds: f64,
    /// Tiles finished.
    pub tiles: usize,
    /// Why it was not on a tile.
    pub idle: Idle,
    /// How often it took work from another worker.
    pub steals: usize,
}

impl WorkerStats {
    /// Nothing done yet.
    pub(super) fn new(pinned: Pinned) -> WorkerStats {
        WorkerStats { pinned, busy_seconds: 0.0, tiles: 0, idle: Idle::default(), steals: 0 }
    }
}

/// Messages of one direction. Those that were there before anybody waited for them have no latency.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Messages {
    /// How many there were.
    pub count: usize,
    /// How many of them have a latency.
    pub awaited: usize,
    /// Their latencies' sum in seconds.
    pub latency_sum: f64,
    /// The longest one in seconds.
    pub latency_max: f64,
}

impl Messages {
    /// Counts the latency of an awaited message.
    pub(super) fn arrived(&mut self, latency: Duration) {
        let seconds = latency.as_secs_f64();
        self.awaited += 1;
        self.latency_sum += seconds;
        self.latency_max = self.latency_max.max(seconds);
    }

    /// Mean latency in seconds; 0 if none was awaited.
    pub fn latency(&self) -> f64 {
        if self.awaited == 0 { 0.0 } else { self.latency_sum / self.awaited as f64 }
    }
}

/// What a frame took.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameStats {
    /// Wall-clock seconds from dealing the first task to collecting the last output.
    pub seconds: f64,
    /// One entry per worker, by number.
    pub workers: Vec<WorkerStats>,
    /// One entry per tile, in the order in which they were collected.
    pub spans: Vec<Span>,
    /// Tasks, master to worker.
    pub tasks: Messages,
    /// Results, worker to master.
    pub reports: Messages,
}

impl FrameStats {
    /// Busy seconds, idle seconds at the start and at the tail, from the spans.
    pub fn sum_up(&mut self) {
        let mut first = vec![f64::INFINITY; self.workers.len()];
        let mut last = vec![0.0f64; self.workers.len()];
        for span in &self.spans {
            let worker = &mut self.workers[span.worker];
            worker.busy_seconds += span.end - span.start;
            worker.tiles += 1;
            first[span.worker] = first[span.worker].min(span.start);
            last[span.worker] = last[span.worker].max(span.end);
        }
        for (i, worker) in self.workers.iter_mut().enumerate() {
            if worker.tiles == 0 {
                // It waited for a first tile and for the end at once; nothing came.
                worker.idle = Idle { start: self.seconds, ..Idle::default() };
                continue;
            }
            worker.idle.start = first[i];
            worker.idle.tail = (self.seconds - last[i]).max(0.0);
        }
    }
}
