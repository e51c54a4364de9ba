//! The master's side of the protocol: who works for it, and what it does with their reports. What it deals is in
//! `dealing.rs`.

use super::flight::{Flight, Running};
use super::mail::{Desk, Inbox};
use super::message::{Parcel, Report};
use super::pin::{Pinned, Placement, refusals};
use super::source::{OneFrame, Source};
use super::sync::{scope, spawn};
use super::worker::work;
use super::{Control, CostMap, FrameStats, Plan, Progress, Schedule, TileTask, WorkerStats};
use crate::error::{Error, Result};
use crate::tile::Tile;
use crossbeam_deque::Worker as Deque;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// The cancel flag is looked at this often while no report comes.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// Deals the tiles of frames to the workers. Exists only inside [`with_workers`].
pub struct Master<T: TileTask> {
    pub(super) desks: Vec<Arc<Desk<T::Frame, T::Output>>>,
    inbox: Arc<Inbox<T::Output>>,
    pinned: Vec<Pinned>,
    /// False for a worker that was lost.
    alive: Vec<bool>,
    /// Those who take part.
    employed: Range<usize>,
    /// The frames under way, the oldest first, or those that a panic of the source left behind.
    pub(super) flights: VecDeque<Flight<T::Frame>>,
    /// Frames begun so far.
    pub(super) begun: usize,
    /// Taken from the inbox and not looked at.
    reports: VecDeque<Report<T::Output>>,
    /// Empty deques and used plans, for their memory.
    pub(super) spare_deques: Vec<Deque<usize>>,
    pub(super) spare_plans: Vec<Plan>,
    /// What the last complete frame took.
    pub(super) costs: CostMap,
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
    scope(|scope| {
        let mut master = Master::new();
        for (worker, &cpu) in placement.slots().iter().enumerate() {
            let (desk, inbox) = (Arc::new(Desk::new()), Arc::clone(&master.inbox));
            master.add(Arc::clone(&desk));
            spawn(scope, worker, move || work(task, worker, cpu, &desk, &inbox)).map_err(|error| {
                Error::flag("--threads", format!("only {worker} could be started ({error})"), "ask for fewer")
            })?;
        }
        master.await_ready()?;
        refusals(&master.pinned).iter().for_each(|note| log::warn!("{note}"));
        body(&mut master)
    })
}

impl<T: TileTask> Master<T> {
    fn new() -> Master<T> {
        Master {
            desks: vec![],
            inbox: Arc::new(Inbox::new()),
            pinned: vec![],
            alive: vec![],
            employed: 0..usize::MAX,
            flights: VecDeque::new(),
            begun: 0,
            reports: VecDeque::new(),
            spare_deques: vec![],
            spare_plans: vec![],
            costs: CostMap::default(),
        }
    }

    fn add(&mut self, desk: Arc<Desk<T::Frame, T::Output>>) {
        self.desks.push(desk);
        self.pinned.push(Pinned::Free);
        self.alive.push(true);
    }

    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.desks.len()
    }

    /// Where each worker runs.
    pub fn pinned(&self) -> &[Pinned] {
        &self.pinned
    }

    /// From now on only these workers take part, counted from 0; the others stay parked. At first all do.
    pub fn employ(&mut self, workers: Range<usize>) {
        self.employed = workers;
    }

    /// Runs every tile once and hands each output to `collect` on this thread, in the order in which they arrive. The
    /// strategy may cut the tiles and change their order. Returns the frame when no worker uses it any more.
    ///
    /// # Errors
    ///
    /// As [`Master::run_stream`].
    pub fn run_frame(
        &mut self,
        schedule: Schedule,
        frame: T::Frame,
        tiles: &[Tile],
        control: &Control<'_>,
        collect: impl FnMut(&T::Frame, Tile, &mut T::Output),
    ) -> Result<(T::Frame, FrameStats)> {
        let mut one = OneFrame { waiting: Some(frame), collect, complete: None };
        let stats = self.run_stream(schedule, 1, tiles, control, &mut one)?;
        Ok((one.complete.ok_or_else(lost_worker)?, stats))
    }

    /// Runs the frames that `source` gives, up to `in_flight` (at least one) at once, every tile of each once. Progress
    /// is told for each frame by itself.
    ///
    /// # Errors
    ///
    /// [`Error::Worker`] if a tile panicked, [`Error::Interrupted`] if `control` was cancelled before the end: then no
    /// worker is busy afterwards, and the next stream can be run. [`Error::Failed`] if a worker thread was lost or none
    /// of those [employed](Master::employ) is left; the next stream does without the lost ones. Frames that were in flight are dropped.
    pub fn run_stream(
        &mut self,
        schedule: Schedule,
        in_flight: usize,
        tiles: &[Tile],
        control: &Control<'_>,
        source: &mut impl Source<T>,
    ) -> Result<FrameStats> {
        self.settle();
        let workers: Vec<usize> =
            (0..self.workers()).filter(|&i| self.alive[i] && self.employed.contains(&i)).collect();
        if workers.is_empty() {
            return Err(lost_worker());
        }
        self.desks.iter().for_each(|desk| desk.stock(schedule.strategy.parcels()));
        let mut running = Running {
            start: Instant::now(),
            schedule,
            stats: self.empty_stats(&workers),
            workers,
            failure: control.cancelled().then_some(Error::Interrupted),
            pauses: Vec::new(),
        };
        loop {
            if running.failure.is_none() {
                let start = Instant::now();
                self.end_frames(&mut running, source)?;
                self.begin_frames(in_flight.max(1), tiles, &mut running, source);
                running.stats.master.frames += start.elapsed().as_secs_f64();
            }
            if self.is_due() {
                self.collect_some(control, &mut running, source);
            } else if running.failure.is_some() || !self.flights.front().is_some_and(Flight::is_complete) {
                break;
            }
            // Else the frame was empty.
        }
        self.finish(running, control)
    }

    /// Waits for reports, collects what has come, and answers.
    fn collect_some(&mut self, control: &Control<'_>, running: &mut Running, source: &mut impl Source<T>) {
        self.inbox.take(&mut self.reports, LONGEST_WAIT);
        let now = Instant::now();
        // One by one: if the source panics, the others stay for `settle`.
        while let Some(report) = self.reports.pop_front() {
            match report {
                Report::Ready { .. } => {}
                Report::Lost { worker } => {
                    self.lose(worker);
                    self.fail(running, lost_worker());
                }
                Report::Parcel { worker, parcel, sent } => {
                    let begun = Instant::now();
                    running.arrived(worker, sent.map(|sent| now.saturating_duration_since(sent)));
                    self.answer(worker, parcel, control, running, source);
                    running.handled(worker, begun.elapsed());
                }
            }
        }
        running.stats.master.reports += now.elapsed().as_secs_f64();
        if control.cancelled() {
            self.fail(running, Error::Interrupted);
        }
    }

    /// Collects a parcel, and gives it back with what that entitles to.
    fn answer(
        &mut self,
        worker: usize,
        mut parcel: Box<Parcel<T::Output>>,
        control: &Control<'_>,
        running: &mut Running,
        source: &mut impl Source<T>,
    ) {
        self.collect(worker, &mut parcel, control, running, source);
        // Before the parcel goes back: its worker may be waiting for it with the next tile in mind.
        if control.cancelled() {
            self.fail(running, Error::Interrupted);
        }
        let entitled = parcel.finished && running.failure.is_none();
        let next = if entitled { self.next_task(worker, running) } else { None };
        parcel.empty();
        let laying = Instant::now();
        if self.desks[worker].lay(Some(parcel), next) {
            running.woke(worker, laying.elapsed());
        }
    }

    /// Takes the results of a parcel to the source.
    fn collect(
        &mut self,
        worker: usize,
        parcel: &mut Parcel<T::Output>,
        control: &Control<'_>,
        running: &mut Running,
        source: &mut impl Source<T>,
    ) {
        running.note(worker, parcel);
        if running.failure.is_some() {
            self.stop();
        }
        self.note_finished(worker, parcel);
        let Some(flight) = self.flights.iter_mut().find(|f| f.shared.number == parcel.frame) else { return };
        flight.note(worker, parcel, running);
        let (shared, used) = (&flight.shared, parcel.used);
        for item in &mut parcel.items[..used] {
            source.collect(&shared.frame, shared.tiles[item.place], &mut item.output);
            flight.done += 1;
            control.report(Progress { done: flight.done, total: shared.tiles.len() });
        }
    }

    /// If a task is finished, it is no longer due.
    fn note_finished(&mut self, worker: usize, parcel: &mut Parcel<T::Output>) {
        if !parcel.finished {
            return;
        }
        let Some(flight) = self.flights.iter_mut().find(|f| f.shared.number == parcel.frame) else { return };
        flight.due[worker] = flight.due[worker].saturating_sub(1);
        // Until the frame ends, others may look into it for more of this frame's tiles.
        flight.deques.extend(parcel.deque.take());
    }

    /// Nothing is due any more.
    fn finish(&mut self, mut running: Running, control: &Control<'_>) -> Result<FrameStats> {
        running.stats.seconds = running.start.elapsed().as_secs_f64();
        if control.cancelled() {
            running.fail(Error::Interrupted);
        }
        if let Some(error) = running.failure {
            self.flights.clear();
            return Err(error);
        }
        if !self.flights.is_empty() {
            self.flights.clear();
            return Err(lost_worker());
        }
        running.stats.sum_up(&running.pauses);
        Ok(running.stats)
    }

    /// Collects what a stream left due whose source or progress callback panicked.
    fn settle(&mut self) {
        self.stop();
        for (worker, desk) in self.desks.iter().enumerate() {
            if self.flights.iter().any(|flight| flight.due[worker] > 0) {
                // In place of the one that was lost in the panic.
                desk.lay(Some(Box::default()), None);
            }
        }
        while self.is_due() {
            if self.reports.is_empty() {
                self.inbox.take(&mut self.reports, LONGEST_WAIT);
            }
            match self.reports.pop_front() {
                Some(Report::Lost { worker }) => self.lose(worker),
                Some(Report::Parcel { worker, mut parcel, .. }) => {
                    self.note_finished(worker, &mut parcel);
                    parcel.empty();
                    self.desks[worker].lay(Some(parcel), None);
                }
                Some(Report::Ready { .. }) | None => {}
            }
        }
        self.flights.clear();
    }

    fn is_due(&self) -> bool {
        self.flights.iter().any(Flight::is_due)
    }

    fn lose(&mut self, worker: usize) {
        self.alive[worker] = false;
        for flight in &mut self.flights {
            let lost = std::mem::take(&mut flight.due[worker]);
            // Whoever finishes the last one after this tells; the reports of those who did before are in the inbox.
            if let Some(unfinished) = &flight.unfinished {
                unfinished.finish(lost);
            }
        }
        self.desks[worker].clear();
    }

    /// The stream under way comes to nothing. (The worker on whose tile it failed has stopped that frame already.)
    fn fail(&self, running: &mut Running, error: Error) {
        running.fail(error);
        self.stop();
    }

    /// No further tile of the frames under way is begun.
    fn stop(&self) {
        self.flights.iter().for_each(|flight| flight.shared.stop.store(true, Ordering::Relaxed));
    }

    fn await_ready(&mut self) -> Result<()> {
        let mut missing = self.workers();
        while missing > 0 {
            self.inbox.take(&mut self.reports, LONGEST_WAIT);
            while let Some(report) = self.reports.pop_front() {
                let Report::Ready { worker, pinned } = report else { return Err(lost_worker()) };
                self.pinned[worker] = pinned;
                missing -= 1;
            }
        }
        Ok(())
    }

    fn empty_stats(&self, workers: &[usize]) -> FrameStats {
        let workers = workers.iter().map(|&worker| WorkerStats::new(self.pinned[worker])).collect();
        FrameStats { workers, ..FrameStats::default() }
    }
}

/// Wherever the master goes, its workers must not wait for it.
impl<T: TileTask> Drop for Master<T> {
    fn drop(&mut self) {
        self.stop();
        self.desks.iter().for_each(|desk| desk.close());
    }
}

/// A worker ends only when its desk is closed, so this tells of a defect, not of a condition.
pub(super) fn lost_worker() -> Error {
    Error::Failed("a worker thread was lost; please report this with the command line".into())
}
