//! What the master deals: it begins frames, and ends those that are complete.

use super::flight::{Flight, Running};
use super::master::{Master, lost_worker};
use super::message::{Shared, Task, Unfinished, Work};
use super::source::Source;
use super::{Dealer, End, FilmMode, Plan, Strategy, TileTask};
use crate::error::Result;
use crate::tile::Tile;
use crossbeam_deque::{Stealer, Worker as Deque};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

impl<T: TileTask> Master<T> {
    /// Hands back the frames that are complete, the oldest first.
    pub(super) fn end_frames(&mut self, running: &mut Running, source: &mut impl Source<T>) -> Result<()> {
        while let Some(flight) = self.flights.pop_front_if(|flight| flight.is_complete()) {
            let Flight { shared, mut plan, mut deques, mut spans, .. } = flight;
            self.spare_deques.append(&mut deques);
            let shared = Arc::into_inner(shared).ok_or_else(lost_worker)?;
            self.costs.reset(&shared.tiles);
            for span in &mut spans {
                self.costs.record(span.tile, span.end - span.start);
                span.frame = running.stats.frames;
            }
            running.stats.frames += 1;
            running.stats.spans.append(&mut spans);
            plan.tiles = shared.tiles;
            self.spare_plans.push(plan);
            source.done(shared.frame);
        }
        Ok(())
    }

    /// Begins frames until `in_flight` of them are under way.
    pub(super) fn begin_frames(
        &mut self,
        in_flight: usize,
        tiles: &[Tile],
        running: &mut Running,
        source: &mut impl Source<T>,
    ) {
        while self.flights.len() < in_flight
            && let Some(frame) = source.next()
        {
            let mut plan = self.spare_plans.pop().unwrap_or_default();
            let end = if in_flight > 1 && source.more() { End::Overlapped } else { End::Awaited };
            plan.fill(running.schedule.strategy, running.workers.len(), end, tiles, &self.costs);
            self.begin(frame, plan, running);
            self.supply(running);
        }
    }

    /// Puts a frame in flight and deals what its strategy deals at first.
    fn begin(&mut self, frame: T::Frame, mut plan: Plan, running: &mut Running) {
        let Running { schedule, ref workers, ref mut stats, .. } = *running;
        let dealer = Dealer::new(schedule.strategy, workers.len(), &plan);
        let first = workers.iter().enumerate().map(|(i, &worker)| (worker, dealer.first(i, &plan)));
        let deques = match schedule.strategy {
            Strategy::Stealing => self.empty_deques(),
            _ => vec![],
        };
        let mut work: Vec<(usize, Work)> = vec![];
        let stealers: Vec<Stealer<usize>> = deques.iter().map(Deque::stealer).collect();
        match schedule.strategy {
            Strategy::Stealing => {
                // All deques are filled before anybody looks into them; who owns nothing may steal.
                first.for_each(|(worker, run)| {
                    run.into_iter().flat_map(|run| run.places()).for_each(|place| deques[worker].push(place));
                });
                let alive = deques.into_iter().enumerate().filter(|(worker, _)| workers.contains(worker));
                work.extend(alive.map(|(worker, deque)| (worker, Work::Share(deque))));
            }
            _ => work.extend(first.filter_map(|(worker, run)| Some((worker, Work::Run(run?))))),
        }
        let shared = Arc::new(Shared {
            number: self.begun,
            frame,
            tiles: std::mem::take(&mut plan.tiles),
            stop: AtomicBool::new(false),
            each_tile: schedule.film == FilmMode::Messages,
            stealers,
        });
        self.begun += 1;
        let (due, spans) = (vec![0; self.desks.len()], Vec::with_capacity(shared.tiles.len()));
        let unfinished = schedule.tells_only_last().then(|| Unfinished::new(work.len()));
        let mut flight = Flight { shared, plan, dealer, due, unfinished, deques: vec![], done: 0, spans };
        for (worker, work) in work {
            let task = flight.task(worker, work, stats);
            self.desks[worker].lay(None, Some(task));
        }
        self.flights.push_back(flight);
    }

    /// A deque for each worker.
    fn empty_deques(&mut self) -> Vec<Deque<usize>> {
        (0..self.desks.len()).map(|_| self.spare_deques.pop().unwrap_or_else(Deque::new_fifo)).collect()
    }

    /// Gives every worker as many tasks as the strategy lets it have at once: a first one to each, then a second one.
    fn supply(&mut self, running: &mut Running) {
        for have in 0..running.schedule.strategy.tasks_at_once() {
            for i in 0..running.workers.len() {
                let worker = running.workers[i];
                let due: usize = self.flights.iter().map(|flight| flight.due[worker]).sum();
                if due <= have
                    && let Some(task) = self.next_task(worker, running)
                {
                    self.desks[worker].lay(None, Some(task));
                }
            }
        }
    }

    /// The next task of the oldest frame that has one left.
    pub(super) fn next_task(&mut self, worker: usize, running: &mut Running) -> Option<Task<T::Frame>> {
        self.flights.iter_mut().find_map(|flight| flight.next_task(worker, &mut running.stats))
    }
}
