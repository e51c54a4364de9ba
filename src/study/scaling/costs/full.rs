//! What messages cost where the master has no core of its own, as streams with a worker on every core show it.
//!
//! The master lives on the core of the last worker then. What the others' reports and answers took counts, where there were enough
//! of them: no probe beside the streams leaves in the caches what tiles leave there, nor sleeps as long as workers do.

use super::{
    Costs,
    seen::{Lateness, TILES_PER_MESSAGE, bytes},
};
use crate::schedule::{FilmMode, FrameStats, Idle, Messages, Schedule, SharedCore, Strategy};

impl Costs {
    /// What a byte cost the master that it copied, from the other workers and from the last one, in streams where it lives on that
    /// one's core: tiles leave less of the film and of its page tables in the caches than anything that is measured beside them.
    /// `None` if it copied nothing of one of them. If one worker's tiles took `slowness` times as long in that round as they are
    /// taken to cost, so did copying.
    pub(in crate::study::scaling) fn copied_in(
        &self,
        streams: &[FrameStats],
        schedule: Schedule,
        slowness: f64,
    ) -> Option<[f64; 2]> {
        let copied = |host: bool| {
            let (mut seconds, mut copied) = (0.0, 0.0);
            for stream in streams {
                let last = stream.workers.len().saturating_sub(1);
                let (others, own) = stream.workers.split_at(last);
                for worker in if host { own } else { others } {
                    let (reports, tiles) = (worker.reports.count as f64, worker.tiles as f64);
                    seconds += (worker.handled - worker.woken) / slowness;
                    seconds -= reports * self.collect + tiles * self.collect_tile;
                }
                copied += bytes(stream, |span| (span.worker == last) == host);
            }
            (seconds > 0.0 && copied > 0.0).then(|| seconds / copied)
        };
        match schedule.film {
            FilmMode::Shared => None,
            FilmMode::Messages => Some([copied(false)?, copied(true)?]),
        }
    }

    /// What messages cost the others in streams where the master lives on the last worker's core, if they sent one every few
    /// tiles. If one worker's tiles took `slowness` times as long in that round as they are taken to cost, so did everything
    /// else. What the others cannot see is as much dearer than it was measured as their way to the master is.
    pub(in crate::study::scaling) fn shared_in(
        &self,
        streams: &[FrameStats],
        schedule: Schedule,
        slowness: f64,
    ) -> Option<SharedCore> {
        let others = Others::new(streams, slowness);
        // Whoever has other parcels waits for answers only at times.
        let answered = if schedule.strategy.parcels() == 1 { others.answers() } else { None };
        let known = self.shared;
        let [way, answer] = [known.send + known.latency, known.reply + known.back];
        let dearer = |found: f64, known: f64| if known > 0.0 { found / known } else { 1.0 };
        let shared = match (others.way(self, streams, schedule.strategy), answered) {
            (Some([send, latency]), _) => {
                SharedCore { send, latency, ..dearer_switches(known, dearer(send + latency, way)) }
            }
            (None, Some([reply, back])) => {
                let factor = dearer(reply + back, answer);
                let [send, latency] = [known.send, known.latency].map(|seconds| seconds * factor);
                SharedCore { send, latency, ..dearer_switches(known, factor) }
            }
            (None, None) => return None,
        };
        Some(match answered {
            // Who only waits longer for what is late: that is the mean of all, however long they slept.
            Some([reply, back]) => SharedCore { reply, back, wait: f64::INFINITY, late: 0.0, ..shared },
            None => {
                let Lateness { late, delay, .. } = Lateness::of(&others.reports, slowness);
                SharedCore { late, delay, ..shared }
            }
        })
    }
}

fn dearer_switches(known: SharedCore, factor: f64) -> SharedCore {
    SharedCore { interrupt: known.interrupt * factor, switch: known.switch * factor, ..known }
}

/// What it is on a busy core, if that is what `busy` of `mean` were, and the others were on one that sleeps.
fn unmixed(mean: f64, asleep: f64, busy: f64) -> f64 {
    ((mean - (1.0 - busy) * asleep) / busy).max(0.0)
}

/// Sums of streams in which the master lives on the last worker's core: of the other workers. Times as they were if tiles took
/// what they are taken to cost.
#[derive(Default)]
struct Others {
    tiles: f64,
    slowness: f64,
    /// What is neither tiles nor waits.
    own: f64,
    reports: Messages,
    answers: Messages,
    /// The master's time to wake them.
    woken: f64,
}

impl Others {
    fn new(streams: &[FrameStats], slowness: f64) -> Others {
        let mut sum = Others { slowness, ..Others::default() };
        for stream in streams {
            let Some((_, others)) = stream.workers.split_last() else { continue };
            for worker in others {
                let Idle { start, work, deliver, tail } = worker.idle;
                sum.tiles += worker.tiles as f64;
                sum.own += (stream.seconds - worker.busy_seconds - start - work - deliver - tail) / slowness;
                sum.reports.add(&worker.reports);
                sum.answers.add(&worker.answers);
                sum.woken += worker.woken / slowness;
            }
        }
        sum
    }

    /// To wake a master who lives on a core that is busy, and from then on until it goes on. Whoever waits for every answer only
    /// waits longer for what is late.
    fn way(&self, costs: &Costs, streams: &[FrameStats], strategy: Strategy) -> Option<[f64; 2]> {
        let Others { tiles, slowness, own, ref reports, .. } = *self;
        if reports.awaited as f64 * TILES_PER_MESSAGE < tiles || reports.awaited == 0 {
            return None;
        }
        let busy = host_busy(streams, strategy);
        let send = unmixed((own - tiles * costs.tile) / reports.awaited as f64, costs.send, busy);
        let way = match strategy.parcels() {
            1 => reports.latency() / slowness,
            _ => Lateness::of(reports, slowness).usual,
        };
        Some([send, (unmixed(way, costs.send + costs.to_master, busy) - send).max(0.0)])
    }

    /// The master, to wake who waits for its answer, and from then on until he goes on.
    fn answers(&self) -> Option<[f64; 2]> {
        let Others { tiles, slowness, ref answers, woken, .. } = *self;
        if answers.awaited as f64 * TILES_PER_MESSAGE < tiles || answers.awaited == 0 {
            return None;
        }
        let reply = woken / answers.awaited as f64;
        Some([reply, (answers.latency() / slowness - reply).max(0.0)])
    }
}

/// The share of the time when the last worker was not out of work, at least a half: less would tell little.
fn host_busy(streams: &[FrameStats], strategy: Strategy) -> f64 {
    let [mut idle, mut all] = [0.0, 0.0];
    for stream in streams {
        let Some((host, _)) = stream.workers.split_last() else { continue };
        // Who waits for an answer waits for a master that is awake.
        let dealt = matches!(strategy, Strategy::Static | Strategy::StaticCyclic | Strategy::Stealing);
        let work = if dealt { host.idle.work } else { 0.0 };
        idle += host.idle.start + work + host.idle.tail;
        all += stream.seconds;
    }
    if all > 0.0 { (1.0 - idle / all).max(0.5) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::NOTHING;
    use super::*;
    use crate::schedule::{Pinned, Span, WorkerStats};
    use crate::tile::Tile;

    /// A stream of two workers, the second one with the master on its core.
    fn two(other: WorkerStats, host: WorkerStats) -> FrameStats {
        let tile = Tile { x: 0, y: 0, width: 1, height: 1 };
        let spans =
            |worker, count| std::iter::repeat_n(Span { frame: 0, worker, tile, start: 0.0, end: 1.0 }, count);
        let spans = spans(0, other.tiles).chain(spans(1, host.tiles)).collect();
        FrameStats { seconds: 100.0, spans, workers: vec![other, host], ..FrameStats::default() }
    }

    #[test]
    fn what_messages_cost_on_a_core_that_the_master_shares_is_found_in_the_others_figures() {
        let shared = SharedCore { reply: 2.0, back: 7.0, ..SharedCore::punctual(4.0, 6.0, 72.0, 36.0) };
        let costs = Costs { tile: 0.2, collect: 0.5, collect_tile: 0.1, shared, ..NOTHING };
        let other = WorkerStats {
            busy_seconds: 60.0,
            tiles: 10,
            idle: Idle { start: 2.0, work: 20.0, deliver: 5.0, tail: 3.0 },
            reports: Messages {
                count: 10,
                awaited: 8,
                latency_sum: 40.0,
                late: 1,
                late_sum: 19.0,
                ..Messages::default()
            },
            answers: Messages { awaited: 5, latency_sum: 25.0, ..Messages::default() },
            woken: 16.0,
            ..WorkerStats::new(Pinned::Free)
        };
        let host = WorkerStats {
            busy_seconds: 1.0,
            tiles: 90,
            reports: Messages { count: 90, awaited: 90, latency_sum: 1e3, ..Messages::default() },
            answers: Messages { awaited: 90, latency_sum: 1e3, ..Messages::default() },
            woken: 1e3,
            idle: Idle { deliver: 50.0, ..Idle::default() },
            ..other
        };
        let in_stream = |other, strategy, film, slowness| {
            costs.shared_in(&[two(other, host)], Schedule { strategy, film }, slowness)
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        let schedule = |strategy| Schedule { strategy, film: FilmMode::Shared };
        // Of 100, 60 were tiles and 30 waits.
        let send = (10.0 - 10.0 * 0.2) / 8.0;
        let found = in_stream(other, Strategy::Dynamic, FilmMode::Shared, 1.0).unwrap();
        assert!(near(found.send, send) && near(found.latency, 5.0 - send) && found.late == 0.0, "{found:?}");
        let reply = 16.0 / 5.0;
        assert!(near(found.reply, reply) && near(found.back, 5.0 - reply), "{found:?}");
        // The way to the master took 5 instead of 10.
        assert_eq!((found.interrupt, found.switch, found.wait), (36.0, 18.0, f64::INFINITY));
        assert_eq!(in_stream(other, Strategy::Static, FilmMode::Messages, 1.0), Some(found));
        let slow = in_stream(other, Strategy::Dynamic, FilmMode::Shared, 2.0).unwrap();
        let send = (5.0 - 10.0 * 0.2) / 8.0;
        assert!(near(slow.send, send) && near(slow.latency, 2.5 - send), "{slow:?}");
        assert!(near(slow.reply, 8.0 / 5.0) && near(slow.back, 2.5 - 1.6), "{slow:?}");
        // Who does not wait for answers: one in eight is late, by 16.
        let free = in_stream(other, Strategy::NonBlocking, FilmMode::Shared, 1.0).unwrap();
        let seen =
            SharedCore { send: 1.0, latency: 2.0, interrupt: 0.3 * 72.0, switch: 0.3 * 36.0, ..shared };
        assert_eq!(free, SharedCore { late: 0.125, delay: 16.0, ..seen });
        // Few answers, or few reports.
        let waits = |answers, reports| {
            let mut other = other;
            (other.answers.awaited, other.reports.awaited) = (answers, reports);
            in_stream(other, Strategy::Dynamic, FilmMode::Shared, 1.0)
        };
        let few = waits(2, 8).unwrap();
        assert_eq!((few.send, few.reply, few.back), (1.0, 2.0, 7.0));
        // Answers of 5 instead of 9: so are reports.
        let busy = waits(5, 2).unwrap();
        assert_eq!((busy.reply, busy.back), (found.reply, found.back));
        assert!(near(busy.send, 4.0 * 5.0 / 9.0) && near(busy.latency, 6.0 * 5.0 / 9.0), "{busy:?}");
        assert!(near(busy.interrupt, 40.0) && near(busy.switch, 20.0), "{busy:?}");
        assert_eq!((waits(2, 2), waits(0, 0)), (None, None));
        // Out of work for a quarter of the time, which the master sleeps: a message then takes 1 and 3.
        let host = WorkerStats { idle: Idle { start: 10.0, tail: 15.0, work: 50.0, deliver: 0.0 }, ..host };
        let asleep = Costs { send: 1.0, to_master: 3.0, ..costs };
        let found = asleep.shared_in(&[two(other, host)], schedule(Strategy::Dynamic), 1.0).unwrap();
        let way = (5.0 - 0.25 * 4.0) / 0.75;
        assert!(near(found.send, 1.0) && near(found.latency, way - 1.0), "{found:?}");
        // Where all is dealt at first, who waits for a task is out of work; half of the time at most is taken out.
        let found = asleep.shared_in(&[two(other, host)], schedule(Strategy::Static), 1.0).unwrap();
        assert!(near(found.send, 1.0) && near(found.latency, (5.0 - 0.5 * 4.0) / 0.5 - 1.0), "{found:?}");
        let alone = FrameStats { workers: vec![host], ..two(other, host) };
        assert_eq!(costs.shared_in(&[alone], Schedule::default(), 1.0), None);
    }

    #[test]
    fn what_copying_cost_is_found_in_streams_where_the_master_lives_on_a_workers_core() {
        let costs = Costs { collect: 2.0, collect_tile: 0.5, ..NOTHING };
        let worker = |tiles, handled, woken| {
            let reports = Messages { count: tiles, ..Messages::default() };
            WorkerStats { tiles, reports, handled, woken, ..WorkerStats::new(Pinned::Free) }
        };
        // Two tiles of the first worker, one of the master's host: 12 bytes each.
        let stats = two(
            worker(2, 4.0 * (2.0 * (2.0 + 3.0) + 2.0 * 0.5 + 24.0 * 0.4), 4.0 * 2.0 * 3.0),
            worker(1, 4.0 * (2.0 + 1.0 + 0.5 + 12.0 * 0.2), 4.0),
        );
        let seen = |stats: &FrameStats, strategy, film| {
            costs.copied_in(std::slice::from_ref(stats), Schedule { strategy, film }, 4.0)
        };
        let found = seen(&stats, Strategy::Dynamic, FilmMode::Messages).unwrap();
        assert!((found[0] - 0.4).abs() < 1e-12 && (found[1] - 0.2).abs() < 1e-12, "{found:?}");
        assert_eq!(seen(&stats, Strategy::Dynamic, FilmMode::Shared), None);
        let nothing_of_the_host = two(worker(2, 99.0, 0.0), worker(0, 0.0, 0.0));
        assert_eq!(seen(&nothing_of_the_host, Strategy::Stealing, FilmMode::Messages), None);
        assert_eq!(seen(&FrameStats::default(), Strategy::Stealing, FilmMode::Messages), None);
    }
}
