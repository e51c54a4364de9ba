//! What the master keeps about frames under way.

use super::message::{Parcel, Shared, Task, Unfinished, Work};
use super::{Dealer, FrameStats, Pause, Plan, Schedule, Span};
use crate::error::Error;
use crate::tile::Tile;
use crossbeam_deque::Worker as Deque;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A stream of frames, from planning the first one to collecting the last result.
pub(super) struct Running {
    pub(super) start: Instant,
    pub(super) schedule: Schedule,
    /// Those who take part, ascending. Figures count them from 0 in this order.
    pub(super) workers: Vec<usize>,
    pub(super) stats: FrameStats,
    /// Why nothing more is dealt.
    pub(super) failure: Option<Error>,
    /// How workers waited.
    pub(super) pauses: Vec<Pause>,
}

impl Running {
    /// Of several failures the first one is told.
    pub(super) fn fail(&mut self, error: Error) {
        self.failure.get_or_insert(error);
    }

    fn since_start(&self, at: Instant) -> f64 {
        at.saturating_duration_since(self.start).as_secs_f64()
    }

    fn place_of(&self, worker: usize) -> usize {
        self.workers.partition_point(|&other| other < worker)
    }

    /// A report is there; if the master waited for it, it was under way for so long.
    pub(super) fn arrived(&mut self, worker: usize, latency: Option<Duration>) {
        let worker = self.place_of(worker);
        for reports in [&mut self.stats.reports, &mut self.stats.workers[worker].reports] {
            reports.count += 1;
            latency.into_iter().for_each(|latency| reports.arrived(latency));
        }
    }

    /// A report was handled, and answered.
    pub(super) fn handled(&mut self, worker: usize, time: Duration) {
        let worker = self.place_of(worker);
        self.stats.workers[worker].handled += time.as_secs_f64();
    }

    /// Part of that was waking the worker.
    pub(super) fn woke(&mut self, worker: usize, time: Duration) {
        let worker = self.place_of(worker);
        self.stats.workers[worker].woken += time.as_secs_f64();
    }

    /// Takes the figures and the failure out of a parcel.
    pub(super) fn note<O>(&mut self, worker: usize, parcel: &mut Parcel<O>) {
        let worker = self.place_of(worker);
        self.stats.workers[worker].steals += parcel.steals;
        for wait in &parcel.waits {
            let (start, end) = (self.since_start(wait.start), self.since_start(wait.end));
            self.pauses.push(Pause { worker, start, end, deliver: wait.deliver });
            self.stats.workers[worker].answers.arrived(wait.latency);
            if !wait.deliver {
                self.stats.tasks.arrived(wait.latency);
            }
        }
        if let Some((Tile { x, y, width, height }, message)) = parcel.failure.take() {
            self.fail(Error::Worker { x, y, width, height, message });
        }
    }
}

/// A frame in flight.
pub(super) struct Flight<F> {
    pub(super) shared: Arc<Shared<F>>,
    /// Without its tiles, which are shared.
    pub(super) plan: Plan,
    pub(super) dealer: Dealer,
    /// Tasks that each worker was dealt and has not finished.
    pub(super) due: Vec<usize>,
    /// If only the last task that is finished is worth waking the master for.
    pub(super) unfinished: Option<Unfinished>,
    /// Those that came back.
    pub(super) deques: Vec<Deque<usize>>,
    /// Tiles collected.
    pub(super) done: usize,
    /// When they were run.
    pub(super) spans: Vec<Span>,
}

impl<F> Flight<F> {
    /// True while a worker has to tell of a task.
    pub(super) fn is_due(&self) -> bool {
        self.due.iter().any(|&due| due > 0)
    }

    /// True if every tile was collected and no worker uses the frame.
    pub(super) fn is_complete(&self) -> bool {
        self.done == self.shared.tiles.len() && !self.is_due()
    }

    /// A message for `worker`, whose task is due from now on.
    pub(super) fn task(&mut self, worker: usize, work: Work, stats: &mut FrameStats) -> Task<F> {
        self.due[worker] += 1;
        stats.tasks.count += 1;
        Task { shared: Arc::clone(&self.shared), work, unfinished: self.unfinished.clone() }
    }

    /// The next tiles of this frame, as a message for `worker`; `None` if all are dealt.
    pub(super) fn next_task(&mut self, worker: usize, stats: &mut FrameStats) -> Option<Task<F>> {
        let run = self.dealer.next(&self.plan)?;
        Some(self.task(worker, Work::Run(run), stats))
    }

    /// Notes when the tiles of a parcel were run.
    pub(super) fn note<O>(&mut self, worker: usize, parcel: &Parcel<O>, running: &Running) {
        let worker = running.place_of(worker);
        for item in &parcel.items[..parcel.used] {
            let (start, end) = (running.since_start(item.start), running.since_start(item.end));
            // Which frame of the stream is known at its end.
            self.spans.push(Span { frame: 0, worker, tile: self.shared.tiles[item.place], start, end });
        }
    }
}
