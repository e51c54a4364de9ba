//! What messages cost as streams of real tiles show it.
//!
//! Waking a thread costs several times more where its core has been idle for as long as a real tile takes than in a
//! ping-pong of empty ones, most of all on virtual machines. So what one worker's messages took while it rendered counts,
//! where there were enough of them; and what copying took where a worker's tiles fill the caches.

use super::Costs;
use crate::schedule::{FilmMode, FrameStats, Schedule, Span};

/// A stream with fewer messages than one for so many tiles tells little of what they cost.
pub(in crate::study::scaling) const TILES_PER_MESSAGE: f64 = 4.0;

impl Costs {
    /// What a copied byte cost the master in streams where it lives on the last worker's core: tiles leave less of the film and of
    /// its page tables in the caches than anything that is measured beside them. `None` if it copied nothing. If one worker's
    /// tiles took `slowness` times as long in that round as they are taken to cost, so did messages.
    pub(in crate::study::scaling) fn copied_in(
        &self,
        streams: &[FrameStats],
        schedule: Schedule,
        slowness: f64,
    ) -> Option<[f64; 2]> {
        let Costs { collect, collect_tile, copying, .. } = *self;
        // Who has one parcel waits for every answer, and must be woken if not on this core.
        let woken = |stream: &FrameStats| match stream.workers.split_last() {
            Some((_, others)) if schedule.strategy.parcels() == 1 => others.iter().map(|w| w.tiles).sum(),
            _ => 0,
        };
        let copying = |stream: &FrameStats| {
            let (reports, tiles) = (stream.reports.count as f64, stream.spans.len() as f64);
            let other = reports * collect + tiles * collect_tile + woken(stream) as f64 * copying.reply;
            stream.master.reports / slowness - other
        };
        let seconds = streams.iter().map(copying).sum::<f64>().max(0.0);
        // Pixels of others and of the last worker differ as they do beside the streams.
        let known = self.copied.unwrap_or([1.0; 2]);
        let own = |stream: &FrameStats| bytes(stream, |span| span.worker + 1 == stream.workers.len());
        let (all, own): (f64, f64) =
            streams.iter().fold((0.0, 0.0), |sum, s| (sum.0 + bytes(s, |_| true), sum.1 + own(s)));
        let expected = known[0] * (all - own) + known[1] * own;
        let factor = seconds / expected;
        (schedule.film == FilmMode::Messages && expected > 0.0).then(|| known.map(|byte| byte * factor))
    }

    /// What streams of one worker show of them, if there were a message every few tiles. If tiles took `slowness` times as
    /// long in them as they are taken to cost, so did messages.
    pub(in crate::study::scaling) fn seen_in(
        self,
        streams: &[FrameStats],
        schedule: Schedule,
        slowness: f64,
    ) -> Costs {
        let known = self.of(schedule.film);
        let sum = |of: fn(&FrameStats) -> f64| streams.iter().map(of).sum::<f64>();
        let tiles = sum(|s| s.spans.len() as f64);
        let (reports, awaited) = (sum(|s| s.reports.count as f64), sum(|s| s.reports.awaited as f64));
        if awaited * TILES_PER_MESSAGE < tiles || awaited == 0.0 {
            return known;
        }
        let waits = sum(|s| s.workers.iter().map(|worker| worker.idle.work + worker.idle.deliver).sum());
        let others = sum(|s| s.workers.iter().map(|w| w.busy_seconds + w.idle.start + w.idle.tail).sum());
        // What is left is the worker's own: bookkeeping, and waking the master.
        let send = ((sum(|s| s.seconds) - others - waits - tiles * self.tile) / awaited).max(0.0);
        let to_master = (sum(|s| s.reports.latency_sum) / awaited - send).max(0.0);
        let work = sum(|s| s.master.reports);
        let bytes = sum(|s| bytes(s, |_| true));
        // Who has one parcel waits for every answer, and is woken by it: as dear as waking the master.
        let answered = schedule.strategy.parcels() == 1;
        let rest = work - tiles * self.collect_tile - if answered { reports * send } else { 0.0 };
        let usual = |seconds: f64| seconds.max(0.0) / slowness;
        let mut seen = Costs { send: usual(send), to_master: usual(to_master), ..known };
        (seen.reply, seen.to_worker) = match answered {
            true => (usual(send), usual(waits / reports - to_master - work / reports)),
            false => (self.reply, usual(to_master)),
        };
        match schedule.film {
            FilmMode::Shared => seen.collect = usual(rest / reports),
            FilmMode::Messages => seen.per_byte = usual((rest - reports * self.collect) / bytes),
        }
        seen
    }
}

/// Of the pixels of these tiles.
fn bytes(stream: &FrameStats, of: impl Fn(&Span) -> bool) -> f64 {
    12.0 * stream.spans.iter().filter(|span| of(span)).map(|span| span.tile.len() as f64).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::super::NOTHING;
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
                pinned: Pinned::Free,
                busy_seconds: 1000.0,
                tiles: 10,
                idle: Idle { start: 5.0, work, deliver: 0.0, tail: tail - 0.25 - 2.0 },
                steals: 0,
            }],
            ..FrameStats::default()
        };
        stats.seconds = 5.0 + 1000.0 + work + 10.0 * 2.25 + tail - 2.25;
        stats.reports.count = 10;
        stats.reports.awaited = 10;
        stats.reports.latency_sum = 10.0 * (2.0 + 3.0);
        stats.master.reports = 10.0 * 7.5;
        let blind = Costs { send: 0.1, to_master: 0.1, to_worker: 0.1, collect: 0.1, ..costs };
        let dynamic = Schedule { strategy: Strategy::Dynamic, film: FilmMode::Shared };
        let seen = blind.seen_in(std::slice::from_ref(&stats), dynamic, 1.0);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(seen.send, 2.0) && near(seen.to_master, 3.0), "{seen:?}");
        // Waking the worker is as dear as waking the master, and part of the master's 7.5.
        assert!(near(seen.reply, 2.0) && near(seen.collect, 5.0), "{seen:?}");
        // Nine waits for ten reports: the last one's answer never comes.
        assert!(near(seen.to_worker, work / 10.0 - 3.0 - 7.5), "{seen:?}");
        // Where tiles took four times as long as they cost, messages cost a quarter of what is seen.
        let usual = blind.seen_in(std::slice::from_ref(&stats), dynamic, 4.0);
        assert!(near(usual.send, 0.5) && near(usual.to_master, 0.75) && near(usual.reply, 0.5), "{usual:?}");
        assert!(near(usual.collect, 1.25) && near(usual.to_worker, seen.to_worker / 4.0), "{usual:?}");
        // As messages, the master's time is that of copying.
        let messages = blind.seen_in(&[stats.clone()], Schedule { film: FilmMode::Messages, ..dynamic }, 1.0);
        assert!(near(messages.per_byte, (75.0 - 10.0 * (2.0 + 0.1 + 0.5)) / (12.0 * 10.0)), "{messages:?}");
        assert_eq!(messages.collect, 0.1, "measured elsewhere");
        assert_eq!((seen.shared, messages.shared), (blind.shared, blind.copying));
        // Whoever has other parcels does not wait for answers: they take as long as reports.
        let non_blocking = Schedule { strategy: Strategy::NonBlocking, film: FilmMode::Shared };
        let seen = blind.seen_in(std::slice::from_ref(&stats), non_blocking, 1.0);
        assert!(near(seen.to_worker, 3.0), "{seen:?}");
        // Two reports of ten tiles tell nothing.
        stats.reports.awaited = 2;
        assert_eq!(blind.seen_in(&[stats], dynamic, 1.0), blind);
    }

    #[test]
    fn what_copying_cost_is_found_in_streams_where_the_master_lives_on_a_workers_core() {
        let costs = Costs {
            collect: 2.0,
            collect_tile: 0.5,
            copying: SharedCore { reply: 3.0, ..SharedCore::punctual(0.0, 0.0, 0.0, 0.0) },
            copied: Some([2.0, 1.0]),
            ..NOTHING
        };
        let span = |worker| Span {
            frame: 0,
            worker,
            tile: Tile { x: 0, y: 0, width: 1, height: 1 },
            start: 0.0,
            end: 1.0,
        };
        let worker = |tiles| WorkerStats {
            pinned: Pinned::Free,
            busy_seconds: 1.0,
            tiles,
            idle: Idle::default(),
            steals: 0,
        };
        // Two tiles of the first worker, one of the master's host: 12 bytes each.
        let mut stats = FrameStats {
            spans: vec![span(0), span(0), span(1)],
            workers: vec![worker(2), worker(1)],
            ..FrameStats::default()
        };
        stats.reports.count = 3;
        stats.master.reports = 4.0 * (3.0 * 2.5 + 2.0 * 3.0 + 24.0 * 0.4 + 12.0 * 0.2);
        let seen =
            |strategy, film| costs.copied_in(std::slice::from_ref(&stats), Schedule { strategy, film }, 4.0);
        let near = |found: Option<[f64; 2]>, expected: [f64; 2]| {
            let found = found.unwrap();
            assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-12), "{found:?} {expected:?}");
        };
        near(seen(Strategy::Dynamic, FilmMode::Messages), [0.4, 0.2]);
        // Nobody waits to be woken: the master copied all that time.
        near(seen(Strategy::Stealing, FilmMode::Messages), [0.4 * 1.5, 0.2 * 1.5]);
        assert_eq!(seen(Strategy::Dynamic, FilmMode::Shared), None);
        assert_eq!(
            costs.copied_in(&[], Schedule { film: FilmMode::Messages, ..Schedule::default() }, 1.0),
            None
        );
    }
}
