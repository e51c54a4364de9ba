//! What messages cost as streams of real tiles show it.
//!
//! Waking a thread costs several times more where its core has been idle for as long as a real tile takes than in a
//! ping-pong of empty ones, most of all on virtual machines. So what one worker's messages took while it rendered counts,
//! where there were enough of them.

use super::Costs;
use crate::schedule::{FilmMode, FrameStats, Messages, Schedule, Span};

/// A stream with fewer messages than one for so many tiles tells little of what they cost.
pub(super) const TILES_PER_MESSAGE: f64 = 4.0;

impl Costs {
    /// What streams of one worker show of them. If tiles took `slowness` times as long in them as they are taken to cost, so did
    /// everything else.
    pub(in crate::study::scaling) fn seen_in(
        self,
        streams: &[FrameStats],
        schedule: Schedule,
        slowness: f64,
    ) -> Costs {
        let seen = Seen::new(streams, slowness);
        let known = Costs { prepare: seen.frames, ..self.of(schedule.film) };
        if seen.reports * TILES_PER_MESSAGE < seen.tiles || seen.reports == 0.0 {
            // Real tiles leave less of the bookkeeping in the caches than those that do nothing.
            let own = seen.own - seen.awaited * self.send;
            return Costs { tile: own.max(0.0) / seen.tiles, ..known };
        }
        // A master that always has something to read is not woken.
        let known = if seen.awaited * TILES_PER_MESSAGE < seen.tiles {
            known
        } else {
            let send = ((seen.own - seen.tiles * self.tile) / seen.awaited).max(0.0);
            let Lateness { usual, late, delay } = seen.lateness;
            Costs { send, to_master: (usual - send).max(0.0), late, delay, ..known }
        };
        match schedule.strategy.parcels() {
            1 => known.answered(&seen, schedule.film),
            _ => known.unanswered(&seen, schedule.film),
        }
    }

    /// Where the worker waits for every answer: what is late only makes it wait longer.
    fn answered(self, seen: &Seen, film: FilmMode) -> Costs {
        let Seen { reports, awaited, latency, waits, work, woken, bytes, tiles, .. } = *seen;
        let to_master = if awaited > 0.0 { (latency - self.send).max(0.0) } else { self.to_master };
        let to_worker = (waits / reports - to_master - work / reports).max(0.0);
        let rest = (work - woken - tiles * self.collect_tile).max(0.0);
        let known = Costs { to_master, to_worker, reply: woken / reports, late: 0.0, ..self };
        match film {
            FilmMode::Shared => Costs { collect: rest / reports, ..known },
            FilmMode::Messages => {
                Costs { per_byte: (rest - reports * self.collect).max(0.0) / bytes, ..known }
            }
        }
    }

    /// Where the worker goes on without answers it matters how often a report is late: others wait behind it.
    fn unanswered(self, seen: &Seen, film: FilmMode) -> Costs {
        let Seen { reports, work, bytes, tiles, .. } = *seen;
        let rest = work - tiles * self.collect_tile;
        let known = Costs { to_worker: self.to_master, ..self };
        match film {
            FilmMode::Shared => Costs { collect: rest.max(0.0) / reports, ..known },
            FilmMode::Messages => {
                Costs { per_byte: (rest - reports * self.collect).max(0.0) / bytes, ..known }
            }
        }
    }
}

/// How late messages are, in seconds as they were if tiles took what they are taken to cost.
pub(super) struct Lateness {
    /// What those take that are in time.
    pub(super) usual: f64,
    /// The share of the others ...
    pub(super) late: f64,
    /// ... and how much longer they take.
    pub(super) delay: f64,
}

impl Lateness {
    pub(super) fn of(messages: &Messages, slowness: f64) -> Lateness {
        let Messages { awaited, latency_sum, late, late_sum, .. } = *messages;
        let mean = |sum: f64, count: usize| if count == 0 { 0.0 } else { sum / count as f64 / slowness };
        let usual = mean(latency_sum - late_sum, awaited - late);
        let delay = (mean(late_sum, late) - usual).max(0.0);
        Lateness { usual, late: late as f64 / awaited.max(1) as f64, delay }
    }
}

/// Sums of streams of one worker; times as they were if tiles took what they are taken to cost.
struct Seen {
    tiles: f64,
    bytes: f64,
    reports: f64,
    /// Reports for which the master was woken, ...
    awaited: f64,
    /// ... how long they were under way on average ...
    latency: f64,
    /// ... and how late.
    lateness: Lateness,
    /// The worker's waits between tiles, ...
    waits: f64,
    /// ... and what else is not tiles: bookkeeping, and waking the master.
    own: f64,
    /// The master's, with reports, ...
    work: f64,
    /// ... part of which was waking the worker, ...
    woken: f64,
    /// ... and with each frame.
    frames: f64,
}

impl Seen {
    fn new(streams: &[FrameStats], slowness: f64) -> Seen {
        let count = |of: fn(&FrameStats) -> f64| streams.iter().map(of).sum::<f64>();
        let seconds = |of: fn(&FrameStats) -> f64| count(of) / slowness;
        let mut messages = Messages::default();
        streams.iter().for_each(|stream| messages.add(&stream.reports));
        let waits = seconds(|s| s.workers.iter().map(|w| w.idle.work + w.idle.deliver).sum());
        let busy = seconds(|s| s.workers.iter().map(|w| w.busy_seconds + w.idle.start + w.idle.tail).sum());
        Seen {
            tiles: count(|s| s.spans.len() as f64),
            bytes: count(|s| bytes(s, |_| true)),
            reports: messages.count as f64,
            awaited: messages.awaited as f64,
            latency: messages.latency() / slowness,
            lateness: Lateness::of(&messages, slowness),
            waits,
            own: seconds(|s| s.seconds) - waits - busy,
            work: seconds(|s| s.master.reports),
            woken: seconds(|s| s.workers.iter().map(|worker| worker.woken).sum()),
            frames: seconds(|s| s.master.frames) / count(|s| s.frames as f64).max(1.0),
        }
    }
}

/// Of the pixels of these tiles.
pub(super) fn bytes(stream: &FrameStats, of: impl Fn(&Span) -> bool) -> f64 {
    12.0 * stream.spans.iter().filter(|span| of(span)).map(|span| span.tile.len() as f64).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::{Idle, Pinned, SharedCore, Strategy, WorkerStats};
    use crate::tile::Tile;

    /// Streams of one worker that a simulation with known costs made: the costs are found in them.
    #[test]
    fn what_messages_cost_one_worker_is_found_in_its_streams() {
        let costs = Costs {
            prepare: 0.0,
            send: 2.0,
            reply: 0.0,
            to_master: 3.0,
            late: 0.0,
            delay: 0.0,
            to_worker: 5.0,
            collect: 7.0,
            collect_tile: 0.5,
            tile: 0.25,
            steal: 0.0,
            shared: SharedCore::punctual(0.0, 0.0, 0.0, 0.0),
            copying: SharedCore::punctual(1.0, 0.0, 0.0, 0.0),
            per_byte: 0.0,
            copied: None,
            cores: 2,
        };
        // Round trips of ten tiles of 100, but for the last one's answer.
        let spans = (0..10).map(|i| {
            let start = 5.0 + f64::from(i) * (100.0 + 0.25 + 2.0 + 3.0 + 7.5 + 5.0);
            Span {
                frame: 0,
                worker: 0,
                tile: Tile { x: i, y: 0, width: 1, height: 1 },
                start,
                end: start + 100.0,
            }
        });
        let work = 9.0 * (3.0 + 7.5 + 5.0);
        let tail = 0.25 + 2.0 + 3.0 + 7.5;
        let mut stats = FrameStats {
            frames: 1,
            spans: spans.collect(),
            workers: vec![WorkerStats {
                busy_seconds: 1000.0,
                tiles: 10,
                idle: Idle { start: 5.0, work, deliver: 0.0, tail: tail - 0.25 - 2.0 },
                woken: 20.0,
                ..WorkerStats::new(Pinned::Free)
            }],
            ..FrameStats::default()
        };
        stats.seconds = 5.0 + 1000.0 + work + 10.0 * 2.25 + tail - 2.25;
        stats.reports.count = 10;
        stats.reports.awaited = 10;
        stats.reports.latency_sum = 10.0 * (2.0 + 3.0);
        stats.master.reports = 10.0 * 7.5;
        stats.master.frames = 6.0;
        let blind = Costs { send: 0.1, to_master: 0.1, to_worker: 0.1, collect: 0.1, ..costs };
        let seen_in = |stats: &FrameStats, strategy, film, slowness| {
            blind.seen_in(std::slice::from_ref(stats), Schedule { strategy, film }, slowness)
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        let seen = seen_in(&stats, Strategy::Dynamic, FilmMode::Shared, 1.0);
        assert!(near(seen.send, 2.0) && near(seen.to_master, 3.0) && seen.prepare == 6.0, "{seen:?}");
        // The master's 7.5 are 2 to wake the worker, and what it needs for a report and a tile.
        assert!(near(seen.reply, 2.0) && near(seen.collect, 5.0), "{seen:?}");
        // Nine waits for ten reports: the last one's answer never comes.
        assert!(near(seen.to_worker, work / 10.0 - 3.0 - 7.5), "{seen:?}");
        // Where tiles took twice as long as they cost, messages cost half of what is seen.
        let usual = seen_in(&stats, Strategy::Dynamic, FilmMode::Shared, 2.0);
        assert!(near(usual.send, 1.0 - 0.25 / 2.0) && usual.prepare == 3.0, "{usual:?}");
        assert!(near(usual.to_master, 2.5 - usual.send) && near(usual.reply, 1.0), "{usual:?}");
        assert!(near(usual.collect, 3.75 - 1.0 - 0.5), "{usual:?}");
        assert!(near(usual.to_worker, work / 20.0 - usual.to_master - 3.75), "{usual:?}");
        // As messages, the rest of the master's time is copying; what a report takes beside is measured elsewhere.
        let messages = seen_in(&stats, Strategy::Dynamic, FilmMode::Messages, 1.0);
        assert!(near(messages.per_byte, (75.0 - 10.0 * (2.0 + 0.1 + 0.5)) / (12.0 * 10.0)), "{messages:?}");
        assert!(near(messages.reply, 2.0) && messages.collect == 0.1, "{messages:?}");
        assert_eq!((seen.shared, messages.shared), (blind.shared, blind.copying));
        // Two reports of ten tiles tell nothing of messages, but of what tiles take beside running them.
        let mut few = stats.clone();
        (few.reports.count, few.reports.awaited) = (2, 2);
        let expected = Costs { prepare: 6.0, tile: (22.5 - 2.0 * 0.1) / 10.0, ..blind };
        let seen = seen_in(&few, Strategy::Dynamic, FilmMode::Shared, 1.0);
        assert!(near(seen.tile, expected.tile), "{seen:?}");
        assert_eq!(Costs { tile: expected.tile, ..seen }, expected);
        // Whoever has other parcels does not wait for answers: they take as long as reports that are in time.
        (stats.reports.late, stats.reports.late_sum) = (1, 14.0);
        let seen = seen_in(&stats, Strategy::Dynamic, FilmMode::Shared, 1.0);
        assert!(near(seen.to_master, 3.0) && seen.late == 0.0, "{seen:?}");
        let seen = seen_in(&stats, Strategy::NonBlocking, FilmMode::Shared, 1.0);
        assert!(near(seen.to_master, 4.0 - 2.0) && near(seen.to_worker, 2.0), "{seen:?}");
        assert!(near(seen.late, 0.1) && near(seen.delay, 14.0 - 4.0) && near(seen.collect, 7.0), "{seen:?}");
        let messages = seen_in(&stats, Strategy::NonBlocking, FilmMode::Messages, 1.0);
        assert!(
            near(messages.per_byte, (75.0 - 5.0 - 1.0) / 120.0) && messages.collect == 0.1,
            "{messages:?}"
        );
        // Where the master was woken twice only, that tells little of waking it.
        let mut busy = stats.clone();
        busy.reports.awaited = 2;
        let seen = seen_in(&busy, Strategy::NonBlocking, FilmMode::Shared, 1.0);
        assert_eq!((seen.send, seen.to_master, seen.late), (0.1, 0.1, 0.0), "{seen:?}");
        assert!(near(seen.collect, 7.0), "{seen:?}");
        let slow = seen_in(&stats, Strategy::NonBlocking, FilmMode::Shared, 2.0);
        assert!(near(slow.late, 0.1) && near(slow.delay, 5.0), "{slow:?}");
    }
}
