//! What messages, steals and tiles cost the scheduler on this machine, measured with tiles that do nothing.

use crate::error::Result;
use crate::film::Film;
use crate::schedule::{
    Control, FilmMode, FrameStats, Machine, Placement, Schedule, Strategy, TileTask, steal_seconds,
    wake_seconds, with_workers,
};
use crate::tile::{Order, Tile, tiles};
use std::time::Instant;

/// Frames per measurement.
const FRAMES: usize = 21;
/// Tiles in a side of an image of empty tiles, where the time per tile matters ...
const SIDE: u32 = 128;
/// ... and where the time per frame does.
const SMALL_SIDE: u32 = 16;

/// What the simulator charges, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// The master, to end a frame and to begin another.
    pub prepare: f64,
    /// The sender, to wake somebody who waits.
    pub send: f64,
    /// From a message's sending to the moment when somebody who waited for it goes on.
    pub latency: f64,
    /// The master, for a report.
    pub collect: f64,
    /// The master, for each tile in a report.
    pub collect_tile: f64,
    /// A worker, for each tile beside running it.
    pub tile: f64,
    /// A worker, to take half of another's tiles.
    pub steal: f64,
    /// A worker whose core the master uses for a moment, beside the master's time.
    pub switch: f64,
    /// The master, for each byte of pixels that it gets as a message.
    pub per_byte: f64,
    /// With at least this many workers the master has no core of its own.
    pub cores: usize,
    /// By which factor a tile takes longer than it took one worker alone: cores share memory, cache and clock.
    pub inflation: f64,
}

impl Costs {
    /// The same on a cluster: a network of `latency` seconds and `bits` per second, and a node for the master alone.
    pub(super) fn on_network(self, latency: f64, bits: f64) -> Costs {
        Costs { latency, per_byte: self.per_byte + 8.0 / bits, cores: usize::MAX, ..self }
    }

    /// The same on a machine with a core for each of `workers` workers, and none for the master.
    pub(super) fn on_cores(self, workers: usize) -> Costs {
        Costs { cores: workers, ..self }
    }

    /// The same where tiles take `factor` times as long.
    pub(super) fn inflated(self, factor: f64) -> Costs {
        Costs { inflation: self.inflation * factor, ..self }
    }

    /// Measures them, in about a tenth of a second.
    ///
    /// # Errors
    /// [`crate::error::Error::Flag`] if a thread cannot be started.
    pub fn measure(pin: bool) -> Result<Costs> {
        let frames =
            |strategy, side| empty_frames(Schedule { strategy, film: FilmMode::Shared }, 1, pin, side);
        let (stealing, dynamic) = (frames(Strategy::Stealing, SIDE)?, frames(Strategy::Dynamic, SIDE)?);
        let small = frames(Strategy::Dynamic, SMALL_SIDE)?;
        let count = f64::from(SIDE * SIDE);
        let last = |stats: &FrameStats| stats.spans.iter().fold(0.0, |end: f64, span| end.max(span.end));
        let latency = |stats: &FrameStats| (stats.tasks.latency() + stats.reports.latency()) / 2.0;
        let send = wake_seconds(FRAMES);
        // Of stealing all tiles are in one report.
        let collect_tile = quiet(&stealing, |stats| stats.master.reports / count);
        // Of dynamic every report has one tile, and its answer wakes the worker.
        let report = quiet(&dynamic, |stats| stats.master.reports / stats.reports.count as f64);
        Ok(Costs {
            // The first task wakes the worker.
            prepare: quiet(&small, |stats| (stats.master.frames - send).max(0.0)),
            send,
            latency: quiet(&dynamic, latency),
            collect: (report - send - collect_tile).max(0.0),
            collect_tile,
            tile: quiet(&stealing, |stats| {
                (last(stats) - stats.workers[0].idle.start - stats.workers[0].busy_seconds).max(0.0) / count
            }),
            steal: steal_seconds(FRAMES),
            // To the master and back, each about what waking somebody costs.
            switch: 2.0 * send,
            per_byte: copy_seconds_per_byte(),
            cores: Machine::get().default_workers(),
            inflation: 1.0,
        })
    }
}

/// Seconds per tile of a frame of tiles that do nothing: the scheduler's own, in a quiet moment.
///
/// # Errors
/// [`crate::error::Error::Flag`] if a thread cannot be started.
pub fn overhead_per_tile(schedule: Schedule, workers: usize, pin: bool) -> Result<f64> {
    let frames = empty_frames(schedule, workers, pin, SIDE)?;
    Ok(quiet(&frames, |stats| stats.seconds / stats.spans.len() as f64))
}

fn empty_frames(schedule: Schedule, workers: usize, pin: bool, side: u32) -> Result<Vec<FrameStats>> {
    let placement = Placement::new(Machine::get(), Some(workers), pin);
    let tiles = tiles(side, side, 1, Order::Hilbert);
    with_workers(&Empty, &placement, |master| {
        let mut frame = || {
            let (_, stats) =
                master.run_frame(schedule, (), &tiles, &Control::unattended(), |(), _, ()| {})?;
            Ok(stats)
        };
        frame()?;
        (0..FRAMES).map(|_| frame()).collect()
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

fn copy_seconds_per_byte() -> f64 {
    let (film, side) = (Film::new(1024, 1024), 64);
    let plane = vec![0.5; (side * side) as usize];
    let all = tiles(1024, 1024, side, Order::Hilbert);
    let copy = || all.iter().for_each(|&tile| film.write_tile(tile, &plane, &plane, &plane));
    // The first time touches the memory; a later frame finds it there.
    copy();
    let start = Instant::now();
    copy();
    start.elapsed().as_secs_f64() / (1024.0 * 1024.0 * 12.0)
}

/// The value that a quarter of the frames stay below: other processes can only make steps longer.
fn quiet(frames: &[FrameStats], of: impl Fn(&FrameStats) -> f64) -> f64 {
    let mut sorted: Vec<f64> = frames.iter().map(of).collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 4]
}
