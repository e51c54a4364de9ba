//! The master's side of the protocol.

use super::pin::{Pinned, Placement};
use super::protocol::{Command, Report};
use super::worker::work;
use super::{Control, Progress, Strategy, TileTask};
use crate::error::{Error, Result};
use crate::tile::Tile;
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::sync::Arc;
use std::thread;
use std::time::Instant;

/// What one worker did in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkerStats {
    /// Where it runs.
    pub pinned: Pinned,
    /// Seconds spent on tiles; the rest of the frame it waited.
    pub busy_seconds: f64,
    /// Tiles finished.
    pub tiles: usize,
}

/// What a frame took.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameStats {
    /// Wall-clock seconds from dealing the first tile to collecting the last output.
    pub seconds: f64,
    /// One entry per worker, by number.
    pub workers: Vec<WorkerStats>,
}

/// Deals the tiles of frames to the workers. Exists only inside [`with_workers`].
pub struct Master<T: TileTask> {
    commands: Vec<Sender<Command<T::Frame>>>,
    reports: Receiver<Report<T::Output>>,
    pinned: Vec<Pinned>,
    /// Commands that were sent and not reported on.
    due: usize,
}

/// Starts one worker per slot of `placement`, waits until all are ready, and calls `body` with their master. The
/// workers end when `body` returns or panics.
///
/// # Errors
///
/// [`Error::Flag`] if a thread cannot be started, and whatever `body` returns.
pub fn with_workers<T: TileTask, R>(
    task: &T,
    placement: &Placement,
    body: impl FnOnce(&mut Master<T>) -> Result<R>,
) -> Result<R> {
    thread::scope(|scope| {
        let (report, reports) = unbounded();
        let mut master = Master { commands: vec![], reports, pinned: vec![], due: 0 };
        for (worker, &cpu) in placement.slots().iter().enumerate() {
            let (command, commands) = unbounded();
            let report = report.clone();
            thread::Builder::new()
                .name(format!("worker {worker}"))
                .spawn_scoped(scope, move || work(task, worker, cpu, commands, report))
                .map_err(|error| {
                    Error::flag(
                        "--threads",
                        format!("only {worker} could be started ({error})"),
                        "ask for fewer",
                    )
                })?;
            master.commands.push(command);
        }
        // Only workers may hold senders: then a lost worker is an error here instead of a wait without end.
        drop(report);
        master.await_ready()?;
        body(&mut master)
    })
}

impl<T: TileTask> Master<T> {
    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.commands.len()
    }

    /// Where each worker runs.
    pub fn pinned(&self) -> &[Pinned] {
        &self.pinned
    }

    /// Runs every tile once and hands each output to `collect` on this thread, in the order in which they finish.
    /// Returns the frame when no worker uses it any more.
    ///
    /// # Errors
    ///
    /// [`Error::Worker`] if a tile panicked, [`Error::Interrupted`] if `control` was cancelled before the end. Either
    /// way no worker is busy afterwards, and the next frame can be run.
    pub fn run_frame(
        &mut self,
        strategy: Strategy,
        frame: T::Frame,
        tiles: &[Tile],
        control: &Control<'_>,
        mut collect: impl FnMut(Tile, T::Output),
    ) -> Result<(T::Frame, FrameStats)> {
        self.settle()?;
        let frame = Arc::new(frame);
        let mut stats = FrameStats { seconds: 0.0, workers: self.idle_stats() };
        let start = Instant::now();
        match strategy {
            Strategy::Dynamic => self.dynamic(&frame, tiles, control, &mut stats, &mut collect)?,
        }
        stats.seconds = start.elapsed().as_secs_f64();
        if control.cancelled() {
            return Err(Error::Interrupted);
        }
        Ok((Arc::into_inner(frame).ok_or_else(lost_worker)?, stats))
    }

    /// [`Strategy::Dynamic`]: one tile each, then one tile per report.
    fn dynamic(
        &mut self,
        frame: &Arc<T::Frame>,
        tiles: &[Tile],
        control: &Control<'_>,
        stats: &mut FrameStats,
        collect: &mut impl FnMut(Tile, T::Output),
    ) -> Result<()> {
        let mut rest = tiles.iter();
        let mut stopped = if control.cancelled() { Some(Error::Interrupted) } else { None };
        if stopped.is_none() {
            for (worker, &tile) in (0..self.workers()).zip(rest.by_ref()) {
                self.deal(worker, frame, tile)?;
            }
        }
        let mut done = 0;
        while self.due > 0 {
            let (worker, result) = self.collect_one(stats)?;
            match result {
                Ok((tile, output)) => {
                    collect(tile, output);
                    done += 1;
                    control.report(Progress { done, total: tiles.len() });
                }
                // Of several panics the first one collected is told.
                Err(error) => stopped = stopped.or(Some(error)),
            }
            if stopped.is_none() && control.cancelled() {
                stopped = Some(Error::Interrupted);
            }
            if let (None, Some(&tile)) = (&stopped, rest.next()) {
                self.deal(worker, frame, tile)?;
            }
        }
        stopped.map_or(Ok(()), Err)
    }

    fn deal(&mut self, worker: usize, frame: &Arc<T::Frame>, tile: Tile) -> Result<()> {
        let command = Command { frame: Arc::clone(frame), tile };
        self.commands[worker].send(command).map_err(|_| lost_worker())?;
        self.due += 1;
        Ok(())
    }

    /// Waits for one report: who sent it, and the tile's output or its panic as an error.
    #[allow(clippy::type_complexity)]
    fn collect_one(&mut self, stats: &mut FrameStats) -> Result<(usize, Result<(Tile, T::Output)>)> {
        let Report::Done { worker, tile, busy, outcome } = self.reports.recv().map_err(|_| lost_worker())?
        else {
            return Err(lost_worker());
        };
        self.due -= 1;
        stats.workers[worker].busy_seconds += busy.as_secs_f64();
        stats.workers[worker].tiles += usize::from(outcome.is_ok());
        let Tile { x, y, width, height } = tile;
        let result = outcome.map(|output| (tile, output)).map_err(|message| Error::Worker {
            x,
            y,
            width,
            height,
            message,
        });
        Ok((worker, result))
    }

    /// Collects what a frame left due whose `collect` or progress callback panicked.
    fn settle(&mut self) -> Result<()> {
        let mut ignored = FrameStats { seconds: 0.0, workers: self.idle_stats() };
        while self.due > 0 {
            let _ = self.collect_one(&mut ignored)?;
        }
        Ok(())
    }

    fn await_ready(&mut self) -> Result<()> {
        self.pinned = vec![Pinned::Free; self.workers()];
        for _ in 0..self.workers() {
            match self.reports.recv() {
                Ok(Report::Ready { worker, pinned }) => self.pinned[worker] = pinned,
                _ => return Err(lost_worker()),
            }
        }
        Ok(())
    }

    fn idle_stats(&self) -> Vec<WorkerStats> {
        self.pinned.iter().map(|&pinned| WorkerStats { pinned, busy_seconds: 0.0, tiles: 0 }).collect()
    }
}

/// Workers outlive their master and report every command once, so this tells of a defect, not of a condition.
fn lost_worker() -> Error {
    Error::Failed("a worker thread broke the protocol; please report this with the command line".into())
}
