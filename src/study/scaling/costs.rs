//! What messages, steals and tiles cost the scheduler on this machine: measured with tiles that do nothing, and seen in
//! streams of one worker.
//!
//! Waking a thread costs several times more where its core has been idle for as long as a real tile takes than in a
//! ping-pong of empty ones, most of all on virtual machines. So what one worker's messages took while it rendered counts,
//! where there were enough of them.

use crate::error::Result;
use crate::film::Film;
use crate::math::median;
use crate::schedule::{
    Control, FilmMode, FrameStats, Machine, Placement, Schedule, SharedCore, Strategy, TileTask,
    pin_current_thread, shared_core_seconds, steal_seconds, with_workers,
};
use crate::tile::{Order, Tile, tiles};
use std::sync::mpsc;
use std::time::Instant;

/// Frames per measurement.
const FRAMES: usize = 21;
/// Messages of either kind between threads that share a core: enough to see how often one is late.
const MESSAGES: usize = 1500;
/// Tiles in a side of an image of empty tiles, where the time per tile matters ...
const SIDE: u32 = 128;
/// ... the same of strategies that answer every tile: a message takes as long as hundreds of tiles do.
const ANSWERED_SIDE: u32 = 32;
/// ... and where the time per frame matters.
const SMALL_SIDE: u32 = 16;
/// Of a tile of 64x64 pixels.
const TILE_BYTES: f64 = 64.0 * 64.0 * 12.0;
/// A stream with fewer messages than one for so many tiles tells little of what they cost.
const TILES_PER_MESSAGE: f64 = 4.0;

/// What the simulator charges, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// The master, to end a frame and to begin another.
    pub prepare: f64,
    /// A worker, to wake the master.
    pub send: f64,
    /// The master, to wake a worker.
    pub reply: f64,
    /// From a report's sending to the moment when the master, who waited for it, goes on.
    pub to_master: f64,
    /// From an answer's sending to the moment when a worker that waited for it goes on.
    pub to_worker: f64,
    /// The master, for a report.
    pub collect: f64,
    /// The master, for each tile in a report.
    pub collect_tile: f64,
    /// A worker, for each tile beside running it.
    pub tile: f64,
    /// A worker, to take half of another's tiles.
    pub steal: f64,
    /// The same two where the master shares a core with a worker that computes.
    pub shared: SharedCore,
    /// The same for a master who copies a tile for each report.
    pub copying: SharedCore,
    /// The master, for each byte of pixels that it gets as a message.
    pub per_byte: f64,
    /// With at least this many workers the master has no core of its own.
    pub cores: usize,
}

impl Costs {
    /// The same on a cluster: a network of `latency` seconds and `bits` per second, and a node for the master alone.
    pub(super) fn on_network(self, latency: f64, bits: f64) -> Costs {
        let per_byte = self.per_byte + 8.0 / bits;
        Costs { to_master: latency, to_worker: latency, per_byte, cores: usize::MAX, ..self }
    }

    /// The same on a machine with a core for each of `workers` workers, and none for the master.
    pub(super) fn on_cores(self, workers: usize) -> Costs {
        Costs { cores: workers, ..self }
    }

    /// The same where everything takes `factor` times as long. A time slice is still a time slice.
    pub(super) fn slower(self, factor: f64) -> Costs {
        Costs {
            prepare: self.prepare * factor,
            send: self.send * factor,
            reply: self.reply * factor,
            to_master: self.to_master * factor,
            to_worker: self.to_worker * factor,
            collect: self.collect * factor,
            collect_tile: self.collect_tile * factor,
            tile: self.tile * factor,
            steal: self.steal * factor,
            shared: self.shared.slower(factor),
            copying: self.copying.slower(factor),
            per_byte: self.per_byte * factor,
            cores: self.cores,
        }
    }

    /// The median of each of what streams of one worker can show.
    pub(super) fn median(all: &[Costs]) -> Costs {
        let of = |of: fn(&Costs) -> f64| median(&all.iter().map(of).collect::<Vec<f64>>());
        Costs {
            send: of(|costs| costs.send),
            reply: of(|costs| costs.reply),
            to_master: of(|costs| costs.to_master),
            to_worker: of(|costs| costs.to_worker),
            collect: of(|costs| costs.collect),
            per_byte: of(|costs| costs.per_byte),
            ..all[0]
        }
    }

    /// What the simulator is told for this film.
    pub(super) fn of(self, film: FilmMode) -> Costs {
        match film {
            FilmMode::Shared => self,
            FilmMode::Messages => Costs { shared: self.copying, ..self },
        }
    }

    /// What streams of one worker show of them, if there were a message every few tiles. If tiles took `slowness` times as
    /// long in them as they are taken to cost, so did messages.
    pub(super) fn seen_in(self, streams: &[FrameStats], schedule: Schedule, slowness: f64) -> Costs {
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
        let bytes = 12.0 * sum(|s| s.spans.iter().map(|span| span.tile.len() as f64).sum());
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

    /// Measures them, in about four seconds.
    ///
    /// # Errors
    /// [`crate::error::Error::Flag`] if a thread cannot be started.
    pub fn measure(pin: bool) -> Result<Costs> {
        let frames =
            |strategy, side| empty_frames(Schedule { strategy, film: FilmMode::Shared }, 1, pin, side);
        let (stealing, mut dynamic) =
            (frames(Strategy::Stealing, SIDE)?, frames(Strategy::Dynamic, ANSWERED_SIDE)?);
        let small = frames(Strategy::Dynamic, SMALL_SIDE)?;
        let count = f64::from(SIDE * SIDE);
        let last = |stats: &FrameStats| stats.spans.iter().fold(0.0, |end: f64, span| end.max(span.end));
        // Of stealing all tiles are in one report.
        let collect_tile = quiet(&stealing, |stats| stats.master.reports / count);
        let tile = quiet(&stealing, |stats| {
            (last(stats) - stats.workers[0].idle.start - stats.workers[0].busy_seconds).max(0.0) / count
        });
        // Of dynamic every report has one tile, and its answer wakes the worker.
        let nothing = Costs { collect_tile, tile, ..NOTHING };
        let answered = Schedule { strategy: Strategy::Dynamic, film: FilmMode::Shared };
        let seen = nothing.seen_in(quieter_half(&mut dynamic), answered, 1.0);
        let Costs { send, reply, to_master, collect, .. } = seen;
        let per_byte = copy_seconds_per_byte(pin);
        // To the master and back, each about what waking somebody costs.
        let guess = SharedCore::punctual(send, to_master, 3.0 * send, 2.0 * send);
        let shared = shared_core(pin, collect).unwrap_or(guess);
        let seen = Costs {
            // The first task wakes the worker.
            prepare: quiet(&small, |stats| (stats.master.frames - reply).max(0.0)),
            steal: steal_seconds(FRAMES),
            shared,
            per_byte,
            cores: Machine::get().default_workers(),
            ..seen
        };
        Ok(seen.sharing_while_copying(collect + per_byte * TILE_BYTES, pin))
    }

    /// The same with [`Costs::copying`] measured for a master who has as much to do for a report of one tile as in these
    /// streams of one worker. Takes a second.
    pub(super) fn copying_as_in<'a>(
        self,
        streams: impl Iterator<Item = (Schedule, &'a [FrameStats])>,
        pin: bool,
    ) -> Costs {
        let work = streams.map(|(schedule, streams)| {
            let Costs { collect, per_byte, .. } = self.seen_in(streams, schedule, 1.0);
            collect + per_byte * TILE_BYTES
        });
        let work: Vec<f64> = work.collect();
        if work.is_empty() { self } else { self.sharing_while_copying(median(&work), pin) }
    }

    fn sharing_while_copying(self, work: f64, pin: bool) -> Costs {
        Costs { copying: shared_core(pin, work).unwrap_or(self.shared), ..self }
    }
}

/// Where nothing takes any time, and the master has a core of its own.
pub(super) const NOTHING: Costs = Costs {
    prepare: 0.0,
    send: 0.0,
    reply: 0.0,
    to_master: 0.0,
    to_worker: 0.0,
    collect: 0.0,
    collect_tile: 0.0,
    tile: 0.0,
    steal: 0.0,
    shared: SharedCore::punctual(0.0, 0.0, 0.0, 0.0),
    copying: SharedCore::punctual(0.0, 0.0, 0.0, 0.0),
    per_byte: 0.0,
    cores: usize::MAX,
};

/// Seconds per tile of a frame of tiles that do nothing: the scheduler's own, in a quiet moment.
///
/// # Errors
/// [`crate::error::Error::Flag`] if a thread cannot be started.
pub fn overhead_per_tile(schedule: Schedule, workers: usize, pin: bool) -> Result<f64> {
    let side = match schedule.strategy {
        Strategy::Dynamic | Strategy::Overlap | Strategy::NonBlocking => ANSWERED_SIDE,
        _ => SIDE,
    };
    let frames = empty_frames(schedule, workers, pin, side)?;
    Ok(quiet(&frames, |stats| stats.seconds / stats.spans.len() as f64))
}

fn empty_frames(schedule: Schedule, workers: usize, pin: bool, side: u32) -> Result<Vec<FrameStats>> {
    let most = workers.max(Machine::get().default_workers());
    let placement = Placement::new(Machine::get(), Some(most), pin);
    let tiles = tiles(side, side, 1, Order::Hilbert);
    let measure = || {
        // As in the streams that are measured.
        pin_current_thread(placement.beside(0..workers));
        with_workers(&Empty, &placement, |master| {
            master.employ(0..workers);
            let mut frame = || {
                let (_, stats) =
                    master.run_frame(schedule, (), &tiles, &Control::unattended(), |(), _, ()| {})?;
                Ok(stats)
            };
            frame()?;
            (0..FRAMES).map(|_| frame()).collect()
        })
    };
    std::thread::scope(|scope| match scope.spawn(measure).join() {
        Ok(frames) => frames,
        Err(panic) => std::panic::resume_unwind(panic),
    })
}

/// A tile that does nothing.
struct Empty;

impl TileTask for Empty {
    type Frame = ();
    type Scratch = ();
    type Output = ();

    fn scratch(&self, _worker: usize) {}

    fn run(&self, (): &(), _tile: Tile, (): &mut (), (): &mut ()) {}
}

/// Of the first two cores, if there are two, with so much to do for a report.
fn shared_core(pin: bool, work: f64) -> Option<SharedCore> {
    let placement = Placement::new(Machine::get(), Some(2), pin);
    match placement.slots() {
        &[Some(other), Some(core)] => shared_core_seconds(MESSAGES, core, other, work),
        _ => None,
    }
}

/// Of tiles that another core has just written, as a worker does.
fn copy_seconds_per_byte(pin: bool) -> f64 {
    let film = Film::new(1024, 1024);
    let (side, tiles) = (64, tiles(1024, 1024, 64, Order::Hilbert));
    let placement = Placement::new(Machine::get(), Some(2), pin);
    let pin = |slot: usize| pin_current_thread(placement.slots()[slot]);
    let (fill, filled) = mpsc::channel();
    let (empty, emptied) = mpsc::channel();
    let worker = move || {
        pin(0);
        let mut planes = vec![0.0f32; 3 * side * side];
        loop {
            planes.fill(0.5);
            if fill.send(planes).is_err() {
                return;
            }
            let Ok(back) = emptied.recv() else { return };
            planes = back;
        }
    };
    let master = move || {
        pin(1);
        let mut copy = |&tile: &Tile| {
            let Ok(planes) = filled.recv() else { return 0.0 };
            let [r, g, b] = [0, 1, 2].map(|plane| &planes[plane * side * side..][..side * side]);
            let start = Instant::now();
            film.write_tile(tile, r, g, b);
            let seconds = start.elapsed().as_secs_f64();
            let _ = empty.send(planes);
            seconds
        };
        // The first time touches the memory; a later frame finds it there.
        let _ = tiles.iter().map(&mut copy).sum::<f64>();
        quarter(tiles.iter().map(copy).collect()) / TILE_BYTES
    };
    std::thread::scope(|scope| {
        scope.spawn(worker);
        scope.spawn(master).join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Those that took least: other processes can only make frames longer.
fn quieter_half(frames: &mut [FrameStats]) -> &[FrameStats] {
    frames.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    &frames[..frames.len().div_ceil(2)]
}

/// The value that a quarter of the frames stay below: other processes can only make steps longer.
fn quiet(frames: &[FrameStats], of: impl Fn(&FrameStats) -> f64) -> f64 {
    quarter(frames.iter().map(of).collect())
}

fn quarter(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 4]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::{Idle, Pinned, Span, WorkerStats};

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
    fn the_quieter_half_are_those_that_took_least() {
        let mut frames =
            [5.0, 1.0, 4.0, 2.0, 3.0].map(|seconds| FrameStats { seconds, ..FrameStats::default() });
        let quieter: Vec<f64> = quieter_half(&mut frames).iter().map(|stats| stats.seconds).collect();
        assert_eq!(quieter, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn on_a_slower_core_everything_takes_longer() {
        let costs = Costs {
            prepare: 1.0,
            send: 2.0,
            reply: 3.0,
            to_master: 4.0,
            to_worker: 5.0,
            collect: 6.0,
            collect_tile: 7.0,
            tile: 8.0,
            steal: 9.0,
            shared: SharedCore::punctual(10.0, 11.0, 12.0, 13.0),
            copying: SharedCore::punctual(15.0, 16.0, 17.0, 18.0),
            per_byte: 14.0,
            cores: 2,
        };
        let twice = Costs {
            prepare: 2.0,
            send: 4.0,
            reply: 6.0,
            to_master: 8.0,
            to_worker: 10.0,
            collect: 12.0,
            collect_tile: 14.0,
            tile: 16.0,
            steal: 18.0,
            shared: SharedCore::punctual(20.0, 22.0, 24.0, 26.0),
            copying: SharedCore::punctual(30.0, 32.0, 34.0, 36.0),
            per_byte: 28.0,
            cores: 2,
        };
        assert_eq!(costs.slower(2.0), twice);
    }
}
