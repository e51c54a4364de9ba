//! Costs measured with tiles that do nothing, between threads of this machine.

use super::{Costs, NOTHING};
use crate::error::Result;
use crate::film::Film;
use crate::schedule::{
    Control, FilmMode, FrameStats, Machine, Placement, Schedule, SharedCore, Strategy, TileTask,
    pin_current_thread, steal_seconds, with_workers,
};
use crate::study::patience::Patience;
use crate::tile::{Order, Tile, tiles};
use std::sync::mpsc;
use std::time::Instant;

/// Frames per measurement; fewer where other processes keep the cores busy, since a message takes milliseconds then.
const PATIENCE: Patience = Patience { least: 3, most: 21, seconds: 0.6 };
/// Tiles in a side of an image of empty tiles ...
const SIDE: u32 = 128;
/// ... and of strategies that answer every tile: a message takes as long as hundreds of tiles do, or a frame.
const ANSWERED_SIDE: u32 = 8;
/// Side of a tile whose pixels are copied ...
const COPIED_SIDE: u32 = 64;
/// ... and how many those are.
const PIXELS: usize = (COPIED_SIDE * COPIED_SIDE) as usize;

impl Costs {
    /// Measures them, in about two seconds. What messages cost on a core that the master shares is a guess, until it is measured
    /// with the tiles of a scene.
    ///
    /// # Errors
    /// [`crate::error::Error::Flag`] if a thread cannot be started.
    pub fn measure(pin: bool) -> Result<Costs> {
        let frames =
            |strategy, side| empty_frames(Schedule { strategy, film: FilmMode::Shared }, 1, pin, side);
        let (stealing, mut dynamic) =
            (frames(Strategy::Stealing, SIDE)?, frames(Strategy::Dynamic, ANSWERED_SIDE)?);
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
        let Costs { send, reply, to_master, .. } = seen;
        // To the master and back, each about what waking somebody costs.
        let guess = SharedCore::punctual(send, to_master, 3.0 * send, 2.0 * send);
        Ok(Costs {
            // The first task wakes the worker.
            prepare: quiet(&dynamic, |stats| (stats.master.frames - reply).max(0.0)),
            steal: steal_seconds(PATIENCE.most),
            shared: guess,
            copying: guess,
            late: 0.0,
            delay: 0.0,
            per_byte: copy_seconds_per_byte(pin),
            copied: None,
            cores: Machine::get().default_workers(),
            ..seen
        })
    }
}

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
            let start = Instant::now();
            (0..).take_while(|&done| PATIENCE.lasts(done, start)).map(|_| frame()).collect()
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

/// Of tiles that another core has just written, as a worker does.
fn copy_seconds_per_byte(pin: bool) -> f64 {
    let film = Film::new(1024, 1024);
    let tiles = tiles(1024, 1024, COPIED_SIDE, Order::Hilbert);
    let placement = Placement::new(Machine::get(), Some(2), pin);
    let pin = |slot: usize| pin_current_thread(placement.slots()[slot]);
    let (fill, filled) = mpsc::channel();
    let (empty, emptied) = mpsc::channel();
    let worker = move || {
        pin(0);
        let mut planes = vec![0.0f32; 3 * PIXELS];
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
            let start = Instant::now();
            let [r, g, b] = [0, 1, 2].map(|plane| &planes[plane * PIXELS..][..PIXELS]);
            film.write_tile(tile, r, g, b);
            let seconds = start.elapsed().as_secs_f64();
            let _ = empty.send(planes);
            seconds
        };
        // The first time touches the memory; a later frame finds it there.
        let _ = tiles.iter().map(&mut copy).sum::<f64>();
        quarter(tiles.iter().map(copy).collect()) / (12 * PIXELS) as f64
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

    #[test]
    fn the_quieter_half_are_those_that_took_least() {
        let mut frames =
            [5.0, 1.0, 4.0, 2.0, 3.0].map(|seconds| FrameStats { seconds, ..FrameStats::default() });
        let quieter: Vec<f64> = quieter_half(&mut frames).iter().map(|stats| stats.seconds).collect();
        assert_eq!(quieter, [1.0, 2.0, 3.0]);
    }
}
