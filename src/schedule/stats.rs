//! What a frame took, tile by tile and worker by worker.

use super::pin::Pinned;
use crate::tile::Tile;
use std::time::Duration;

/// One tile's time on its worker, in seconds from the start of the stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Of which frame, counted from 0.
    pub frame: usize,
    /// Who ran it: a place in [`FrameStats::workers`].
    pub worker: usize,
    /// What was run.
    pub tile: Tile,
    /// When it began.
    pub start: f64,
    /// When it ended.
    pub end: f64,
}

/// A worker waited for the master, in seconds from the start of the stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pause {
    /// Who waited: a place in [`FrameStats::workers`].
    pub worker: usize,
    /// Since when.
    pub start: f64,
    /// Until when.
    pub end: f64,
    /// Until its results were taken, else for a task.
    pub deliver: bool,
}

/// Why a worker was not on a tile, in seconds. What is missing to the whole time is the scheduler's own work.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Idle {
    /// Before its first tile.
    pub start: f64,
    /// Between tiles: the next one had not come.
    pub work: f64,
    /// Between tiles: the master had not taken its results.
    pub deliver: f64,
    /// After its last tile, until all was complete.
    pub tail: f64,
}

/// What one worker did in a frame or a stream of frames.
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
    /// Its reports.
    pub reports: Messages,
    /// The answers that it waited for; they are not counted.
    pub answers: Messages,
    /// Seconds that the master was busy with its reports and with their answers.
    pub handled: f64,
    /// Seconds of these in which it woke the worker.
    pub woken: f64,
}

impl WorkerStats {
    /// Nothing done yet.
    pub(crate) fn new(pinned: Pinned) -> WorkerStats {
        let (idle, reports, answers) = (Idle::default(), Messages::default(), Messages::default());
        WorkerStats {
            pinned,
            busy_seconds: 0.0,
            tiles: 0,
            idle,
            steals: 0,
            reports,
            answers,
            handled: 0.0,
            woken: 0.0,
        }
    }
}

/// A message is late if it was not read after so many seconds: several times what waking takes, and a part of any time slice.
pub(super) const LATE: f64 = 3e-4;

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
    /// How many were late: under way for more than 0.3 ms, because the system, or the host of a virtual machine, had something
    /// else to do.
    pub late: usize,
    /// The sum of their latencies in seconds.
    pub late_sum: f64,
}

impl Messages {
    /// Counts the latency of an awaited message.
    pub(super) fn arrived(&mut self, latency: Duration) {
        let seconds = latency.as_secs_f64();
        self.awaited += 1;
        self.latency_sum += seconds;
        self.latency_max = self.latency_max.max(seconds);
        if seconds > LATE {
            self.late += 1;
            self.late_sum += seconds;
        }
    }

    pub(crate) fn add(&mut self, other: &Messages) {
        self.count += other.count;
        self.awaited += other.awaited;
        self.latency_sum += other.latency_sum;
        self.latency_max = self.latency_max.max(other.latency_max);
        self.late += other.late;
        self.late_sum += other.late_sum;
    }

    /// Mean latency in seconds; 0 if none was awaited.
    pub fn latency(&self) -> f64 {
        if self.awaited == 0 { 0.0 } else { self.latency_sum / self.awaited as f64 }
    }
}

/// What the master was busy with, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MasterSeconds {
    /// To begin and end frames: plans, first tasks, and what the source does with frames.
    pub frames: f64,
    /// To take reports to the source and to answer them.
    pub reports: f64,
}

/// What a frame took, or a stream of frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameStats {
    /// How many frames.
    pub frames: usize,
    /// Wall-clock seconds from planning the first frame to collecting the last output.
    pub seconds: f64,
    /// One entry per worker that took part, by number.
    pub workers: Vec<WorkerStats>,
    /// One entry per tile; frame by frame, within a frame in the order in which they were collected.
    pub spans: Vec<Span>,
    /// Tasks, master to worker.
    pub tasks: Messages,
    /// Results, worker to master.
    pub reports: Messages,
    /// What the master did meanwhile.
    pub master: MasterSeconds,
}

impl FrameStats {
    /// Seconds per frame; of none, of all.
    pub fn per_frame(&self) -> f64 {
        self.seconds / self.frames.max(1) as f64
    }

    /// This frame and another one after it, of the same workers, as one.
    pub fn followed_by(mut self, next: FrameStats) -> FrameStats {
        let later = self.seconds;
        self.spans.extend(next.spans.into_iter().map(|span| Span {
            start: later + span.start,
            end: later + span.end,
            ..span
        }));
        self.seconds += next.seconds;
        for (worker, next) in self.workers.iter_mut().zip(next.workers) {
            worker.busy_seconds += next.busy_seconds;
            worker.tiles += next.tiles;
            worker.steals += next.steals;
            worker.idle.start += next.idle.start;
            worker.idle.work += next.idle.work;
            worker.idle.deliver += next.idle.deliver;
            worker.idle.tail += next.idle.tail;
            worker.reports.add(&next.reports);
            worker.answers.add(&next.answers);
            worker.handled += next.handled;
            worker.woken += next.woken;
        }
        self.tasks.add(&next.tasks);
        self.reports.add(&next.reports);
        self.master.frames += next.master.frames;
        self.master.reports += next.master.reports;
        self
    }

    /// Sums up what the workers did, from the spans and these pauses. A pause counts between the first tile of a worker
    /// and its last: before lies its start, behind its tail.
    pub fn sum_up(&mut self, pauses: &[Pause]) {
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
        for &Pause { worker, start, end, deliver } in pauses {
            let idle = &mut self.workers[worker].idle;
            if start >= first[worker] && end <= last[worker] {
                *(if deliver { &mut idle.deliver } else { &mut idle.work }) += end - start;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_moment_of_a_worker_has_one_cause() {
        let mut stats = FrameStats {
            frames: 2,
            seconds: 10.0,
            workers: vec![WorkerStats::new(Pinned::Free); 2],
            spans: [(1.0, 3.0), (4.0, 6.0)]
                .map(|(start, end)| Span {
                    frame: 0,
                    worker: 0,
                    tile: Tile { x: 0, y: 0, width: 1, height: 1 },
                    start,
                    end,
                })
                .to_vec(),
            ..FrameStats::default()
        };
        assert_eq!(stats.per_frame(), 5.0);
        // Before the first tile, between the two, and behind the last one.
        let pauses = [
            (0, 0.0, 1.0, false),
            (0, 3.0, 3.25, true),
            (0, 3.25, 4.0, false),
            (0, 6.0, 8.0, false),
            (1, 0.0, 9.0, false),
        ]
        .map(|(worker, start, end, deliver)| Pause { worker, start, end, deliver });
        stats.sum_up(&pauses);
        let [busy, lazy] = [&stats.workers[0], &stats.workers[1]];
        assert_eq!((busy.busy_seconds, busy.tiles), (4.0, 2));
        assert_eq!(busy.idle, Idle { start: 1.0, work: 0.75, deliver: 0.25, tail: 4.0 });
        assert_eq!((lazy.busy_seconds, lazy.tiles), (0.0, 0));
        assert_eq!(lazy.idle, Idle { start: 10.0, ..Idle::default() });
    }

    #[test]
    fn one_frame_after_another_takes_as_long_as_both() {
        let frame = |seconds, worker| {
            let tile = Tile { x: 0, y: 0, width: 1, height: 1 };
            let mut stats = FrameStats {
                frames: 1,
                seconds,
                workers: vec![WorkerStats::new(Pinned::Free); 2],
                spans: vec![Span { frame: 0, worker, tile, start: 1.0, end: 2.0 }],
                tasks: Messages {
                    count: 2,
                    awaited: 1,
                    latency_sum: seconds,
                    latency_max: seconds,
                    late: 1,
                    late_sum: 2.0 * seconds,
                },
                ..FrameStats::default()
            };
            stats.sum_up(&[]);
            stats
        };
        let both = frame(4.0, 0).followed_by(frame(3.0, 1));
        assert_eq!((both.frames, both.seconds), (1, 7.0));
        let spans: Vec<_> = both.spans.iter().map(|span| (span.worker, span.start, span.end)).collect();
        assert_eq!(spans, [(0, 1.0, 2.0), (1, 5.0, 6.0)]);
        for (worker, start, tail) in [(0, 1.0 + 3.0, 2.0), (1, 4.0 + 1.0, 1.0)] {
            let worker = &both.workers[worker];
            assert_eq!((worker.busy_seconds, worker.tiles), (1.0, 1));
            assert_eq!(worker.idle, Idle { start, tail, ..Idle::default() });
        }
        let tasks =
            Messages { count: 4, awaited: 2, latency_sum: 7.0, latency_max: 4.0, late: 2, late_sum: 14.0 };
        assert_eq!(both.tasks, tasks);
    }

    #[test]
    fn the_latency_is_the_mean_of_the_awaited_messages() {
        let mut messages = Messages { count: 5, ..Messages::default() };
        assert_eq!(messages.latency(), 0.0);
        messages.arrived(Duration::from_secs(1));
        messages.arrived(Duration::from_secs(4));
        assert_eq!((messages.awaited, messages.latency(), messages.latency_max), (2, 2.5, 4.0));
        assert_eq!((messages.late, messages.late_sum), (2, 5.0));
        messages.arrived(Duration::from_micros(299));
        assert_eq!((messages.awaited, messages.late, messages.late_sum), (3, 2, 5.0));
    }
}
