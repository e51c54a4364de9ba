//! The master's side of the protocol.

use super::frame::Running;
use super::mail::{Desk, Inbox};
use super::message::{Parcel, Report, Shared, Task, Work};
use super::pin::{Pinned, Placement, refusals};
use super::sync::{scope, spawn};
use super::worker::work;
use super::{
    Control, CostMap, Dealer, FilmMode, FrameStats, Messages, Plan, Progress, Schedule, Strategy, TileTask,
    WorkerStats,
};
use crate::error::{Error, Result};
use crate::tile::Tile;
use crossbeam_deque::{Stealer, Worker as Deque};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The cancel flag is looked at this often while no report comes.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// Deals the tiles of frames to the workers. Exists only inside [`with_workers`].
pub struct Master<T: TileTask> {
    desks: Vec<Arc<Desk<T::Frame, T::Output>>>,
    inbox: Arc<Inbox<T::Output>>,
    pinned: Vec<Pinned>,
    /// Tasks that each worker was dealt and has not finished; `None` if it was lost.
    due: Vec<Option<usize>>,
    /// Between frames, every worker's deque; all empty.
    deques: Vec<Option<Deque<usize>>>,
    /// The frame under way, or one that a panic of `collect` left behind.
    shared: Option<Arc<Shared<T::Frame>>>,
    /// Taken from the inbox and not looked at.
    reports: VecDeque<Report<T::Output>>,
    plan: Plan,
    costs: CostMap,
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
            due: vec![],
            deques: vec![],
            shared: None,
            reports: VecDeque::new(),
            plan: Plan::default(),
            costs: CostMap::default(),
        }
    }

    fn add(&mut self, desk: Arc<Desk<T::Frame, T::Output>>) {
        self.desks.push(desk);
        self.pinned.push(Pinned::Free);
        self.due.push(Some(0));
        self.deques.push(Some(Deque::new_fifo()));
    }

    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.desks.len()
    }

    /// Where each worker runs.
    pub fn pinned(&self) -> &[Pinned] {
        &self.pinned
    }

    /// Runs every tile once and hands each output to `collect` on this thread, in the order in which they arrive. The
    /// strategy may cut the tiles and change their order. Returns the frame when no worker uses it any more.
    ///
    /// # Errors
    ///
    /// [`Error::Worker`] if a tile panicked, [`Error::Interrupted`] if `control` was cancelled before the end: then no
    /// worker is busy afterwards, and the next frame can be run. [`Error::Failed`] if a worker thread was lost or none
    /// is left; the next frame does without the lost ones.
    pub fn run_frame(
        &mut self,
        schedule: Schedule,
        frame: T::Frame,
        tiles: &[Tile],
        control: &Control<'_>,
        mut collect: impl FnMut(&T::Frame, Tile, &mut T::Output),
    ) -> Result<(T::Frame, FrameStats)> {
        self.settle();
        let workers: Vec<usize> = (0..self.workers()).filter(|&worker| self.due[worker].is_some()).collect();
        if workers.is_empty() {
            return Err(lost_worker());
        }
        let start = Instant::now();
        self.plan.fill(schedule.strategy, workers.len(), tiles, &self.costs);
        let dealer = Dealer::new(schedule.strategy, workers.len(), &self.plan);
        let stats = self.empty_stats();
        let shared = self.share(schedule, frame);
        let mut running = Running {
            start,
            schedule,
            dealer,
            stats,
            failure: control.cancelled().then_some(Error::Interrupted),
            done: 0,
            pauses: Vec::new(),
        };
        if running.failure.is_none() {
            self.deal_first(&workers, &shared, &mut running);
        }
        self.shared = Some(shared);
        while self.is_due() {
            self.collect_some(control, &mut running, &mut collect);
        }
        self.finish(running, control)
    }

    /// What the workers will see of the frame; stocks their desks.
    fn share(&mut self, schedule: Schedule, frame: T::Frame) -> Arc<Shared<T::Frame>> {
        self.desks.iter().for_each(|desk| desk.stock(schedule.strategy.parcels()));
        let stealers: Vec<Stealer<usize>> =
            self.deques.iter_mut().map(|deque| deque.get_or_insert_with(Deque::new_fifo).stealer()).collect();
        Arc::new(Shared {
            frame,
            tiles: std::mem::take(&mut self.plan.tiles),
            stop: AtomicBool::new(false),
            each_tile: schedule.film == FilmMode::Messages,
            stealers,
        })
    }

    /// Each worker's first task, and those that wait behind it.
    fn deal_first(&mut self, workers: &[usize], shared: &Arc<Shared<T::Frame>>, running: &mut Running) {
        let stealing = running.schedule.strategy == Strategy::Stealing;
        let runs: Vec<_> = (0..workers.len()).map(|i| running.dealer.first(i, &self.plan)).collect();
        if stealing {
            // All deques are filled before anybody looks into them; who owns nothing may steal.
            for (&worker, run) in workers.iter().zip(&runs) {
                if let (Some(run), Some(deque)) = (run, &self.deques[worker]) {
                    run.places().for_each(|place| deque.push(place));
                }
            }
        }
        for (&worker, run) in workers.iter().zip(runs) {
            let work = match run {
                _ if stealing => self.deques[worker].take().map(Work::Share),
                run => run.map(Work::Run),
            };
            self.deal(worker, work, shared, None, running);
        }
        for _ in 1..running.schedule.strategy.tasks_at_once() {
            for &worker in workers {
                let next = running.dealer.next(&self.plan).map(Work::Run);
                self.deal(worker, next, shared, None, running);
            }
        }
    }

    /// Lays a parcel, a task, both or nothing on a worker's desk.
    fn deal(
        &mut self,
        worker: usize,
        work: Option<Work>,
        shared: &Arc<Shared<T::Frame>>,
        parcel: Option<Box<Parcel<T::Output>>>,
        running: &mut Running,
    ) {
        let Some(due) = &mut self.due[worker] else { return };
        let task = work.map(|work| {
            *due += 1;
            running.stats.tasks.count += 1;
            Task { shared: Arc::clone(shared), work, sent: Instant::now() }
        });
        self.desks[worker].lay(parcel, task);
    }

    /// Waits for reports, collects what has come, and answers.
    fn collect_some(
        &mut self,
        control: &Control<'_>,
        running: &mut Running,
        collect: &mut impl FnMut(&T::Frame, Tile, &mut T::Output),
    ) {
        self.inbox.take(&mut self.reports, LONGEST_WAIT);
        let now = Instant::now();
        // One by one: if `collect` panics, the others stay for `settle`.
        while let (Some(report), Some(shared)) = (self.reports.pop_front(), self.shared.clone()) {
            match report {
                Report::Ready { .. } => {}
                Report::Lost { worker } => {
                    self.lose(worker);
                    self.fail(running, lost_worker());
                }
                Report::Parcel { worker, mut parcel, sent } => {
                    running.stats.reports.count += 1;
                    running.stats.reports.arrived(now.saturating_duration_since(sent));
                    running.note(worker, &mut parcel, &shared.tiles);
                    self.note_finished(worker, &mut parcel);
                    let used = parcel.used;
                    for item in &mut parcel.items[..used] {
                        collect(&shared.frame, shared.tiles[item.place], &mut item.output);
                        running.done += 1;
                        control.report(Progress { done: running.done, total: shared.tiles.len() });
                    }
                    // Before the parcel goes back: its worker may be waiting for it with the next tile in mind.
                    if control.cancelled() {
                        self.fail(running, Error::Interrupted);
                    }
                    let entitled = parcel.finished && running.failure.is_none();
                    let next = if entitled { running.dealer.next(&self.plan) } else { None };
                    parcel.empty();
                    self.deal(worker, next.map(Work::Run), &shared, Some(parcel), running);
                }
            }
        }
        if control.cancelled() {
            self.fail(running, Error::Interrupted);
        }
    }

    fn note_finished(&mut self, worker: usize, parcel: &mut Parcel<T::Output>) {
        if parcel.finished {
            self.due[worker] = self.due[worker].map(|due| due - 1);
            self.deques[worker] = self.deques[worker].take().or(parcel.deque.take());
        }
    }

    /// All tasks are done.
    fn finish(&mut self, mut running: Running, control: &Control<'_>) -> Result<(T::Frame, FrameStats)> {
        running.stats.seconds = running.start.elapsed().as_secs_f64();
        self.empty_deques();
        let shared = self.shared.take().and_then(Arc::into_inner).ok_or_else(lost_worker)?;
        self.plan.tiles = shared.tiles;
        if control.cancelled() {
            running.fail(Error::Interrupted);
        }
        if let Some(error) = running.failure {
            return Err(error);
        }
        if running.done != self.plan.tiles.len() {
            return Err(lost_worker());
        }
        running.stats.sum_up(&running.pauses);
        self.costs.reset(&self.plan.tiles);
        running.stats.spans.iter().for_each(|span| self.costs.record(span.tile, span.end - span.start));
        Ok((shared.frame, running.stats))
    }

    /// Collects what a frame left due whose `collect` or progress callback panicked.
    fn settle(&mut self) {
        self.stop();
        for (desk, _) in self.desks.iter().zip(&self.due).filter(|(_, due)| due.is_some_and(|due| due > 0)) {
            // In place of the one that was lost in the panic.
            desk.lay(Some(Box::default()), None);
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
        self.shared = None;
        self.empty_deques();
    }

    fn is_due(&self) -> bool {
        self.due.iter().flatten().any(|&due| due > 0)
    }

    fn lose(&mut self, worker: usize) {
        self.due[worker] = None;
        self.desks[worker].clear();
    }

    /// The frame under way comes to nothing. (The worker on whose tile it failed has stopped it already.)
    fn fail(&self, running: &mut Running, error: Error) {
        running.fail(error);
        self.stop();
    }

    /// No further tile of the frame under way is begun.
    fn stop(&self) {
        if let Some(shared) = &self.shared {
            shared.stop.store(true, Ordering::Relaxed);
        }
    }

    /// A frame that stopped leaves tiles behind.
    fn empty_deques(&mut self) {
        for deque in self.deques.iter().flatten() {
            while deque.pop().is_some() {}
        }
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

    fn empty_stats(&self) -> FrameStats {
        FrameStats {
            seconds: 0.0,
            workers: self.pinned.iter().map(|&pinned| WorkerStats::new(pinned)).collect(),
            spans: Vec::with_capacity(self.plan.tiles.len()),
            tasks: Messages::default(),
            reports: Messages::default(),
        }
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
fn lost_worker() -> Error {
    Error::Failed("a worker thread was lost; please report this with the command line".into())
}
