//! The scheduler as a simulation of events: any number of workers, with known tile costs.
//!
//! Tasks come from the scheduler's own `Plan` and `Dealer`. Workers and master are clocks that advance with what
//! [`Costs`] says:
//!
//! ```text
//!   worker   [tile][tile].post...............wait [tile]
//!                        \ latency          / latency
//!   master                [collect][reply]--
//! ```
//!
//! A message to somebody who waits takes `latency`, and `send` of its sender's time; one to somebody who is busy lies
//! there until he looks. The master handles reports in the order of their arrival. Where it has no core of its own, a
//! worker loses the time that the master takes, unless one waits anyway.

use super::costs::Costs;
use crate::schedule::{
    Dealer, FilmMode, FrameStats, Idle, Messages, Pause, Pinned, Plan, Run, Schedule, Span, Strategy,
    WorkerStats,
};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Predicts one frame. `seconds` are the costs of the plan's tiles, in its order.
///
/// # Panics
/// If there is not one cost per tile, or no worker.
pub fn simulate(
    schedule: Schedule,
    workers: usize,
    plan: &Plan,
    seconds: &[f64],
    costs: &Costs,
) -> FrameStats {
    assert!(workers > 0 && seconds.len() == plan.tiles.len(), "a cost for every tile, and a worker");
    let mut run = Simulation::new(schedule, workers, plan, seconds, costs);
    run.deal_first();
    while let Some(Reverse(event)) = run.events.pop() {
        match event.what {
            What::Look(worker) => run.look(worker, event.at()),
            What::Arrive(report) => run.arrive(report, event.at()),
        }
    }
    run.stats()
}

/// Picoseconds, so that times have an order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Event {
    at: u64,
    /// Of events at the same time, the first one created comes first.
    number: u64,
    what: What,
}

impl Event {
    fn at(self) -> f64 {
        self.at as f64 * 1e-12
    }
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    /// The worker looks what to do next.
    Look(usize),
    /// A report reaches the master.
    Arrive(Report),
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Report {
    worker: usize,
    tiles: usize,
    pixels: usize,
    finished: bool,
}

#[derive(Default)]
struct Worker {
    /// What is left of the task it is on.
    task: Option<Run>,
    waiting: VecDeque<Run>,
    parcels: usize,
    /// Since when, and for what it waits; it has no event then.
    waits: Option<(f64, bool)>,
    /// Results in the parcel being filled: tiles, pixels.
    filled: (usize, usize),
    /// Time that the master took from it.
    debt: f64,
    steals: usize,
}

struct Simulation<'a> {
    schedule: Schedule,
    plan: &'a Plan,
    seconds: &'a [f64],
    costs: &'a Costs,
    dealer: Dealer,
    workers: Vec<Worker>,
    events: BinaryHeap<Reverse<Event>>,
    number: u64,
    master_free: f64,
    end: f64,
    spans: Vec<Span>,
    pauses: Vec<Pause>,
    tasks: Messages,
    reports: Messages,
}

impl<'a> Simulation<'a> {
    fn new(
        schedule: Schedule,
        workers: usize,
        plan: &'a Plan,
        seconds: &'a [f64],
        costs: &'a Costs,
    ) -> Simulation<'a> {
        let parcels = schedule.strategy.parcels();
        let worker = || Worker { parcels, waits: Some((0.0, false)), ..Worker::default() };
        Simulation {
            schedule,
            plan,
            seconds,
            costs,
            dealer: Dealer::new(schedule.strategy, workers, plan),
            workers: (0..workers).map(|_| worker()).collect(),
            events: BinaryHeap::new(),
            number: 0,
            master_free: 0.0,
            end: 0.0,
            spans: Vec::with_capacity(plan.tiles.len()),
            pauses: vec![],
            tasks: Messages::default(),
            reports: Messages::default(),
        }
    }

    fn at(&mut self, seconds: f64, what: What) {
        self.number += 1;
        self.events.push(Reverse(Event { at: (seconds * 1e12) as u64, number: self.number, what }));
    }

    fn deal_first(&mut self) {
        self.master_free = self.costs.prepare;
        let stealing = self.schedule.strategy == Strategy::Stealing;
        for worker in 0..self.workers.len() {
            let run = self.dealer.first(worker, self.plan);
            // Who owns nothing may steal.
            let empty = Run { first: 0, end: 0, step: 1 };
            self.lay(worker, false, run.or(stealing.then_some(empty)));
        }
        for _ in 1..self.schedule.strategy.tasks_at_once() {
            for worker in 0..self.workers.len() {
                let task = self.dealer.next(self.plan);
                self.lay(worker, false, task);
            }
        }
    }

    /// The master lays something on a worker's desk, and wakes it if it waits.
    fn lay(&mut self, worker: usize, parcel: bool, task: Option<Run>) {
        let Costs { send, latency, .. } = *self.costs;
        let desk = &mut self.workers[worker];
        desk.parcels += usize::from(parcel);
        if let Some(task) = task {
            // A stealing worker's range can be stolen before it wakes.
            match self.schedule.strategy {
                Strategy::Stealing => desk.task = Some(task),
                _ => desk.waiting.push_back(task),
            }
            self.tasks.count += 1;
        }
        if !parcel && task.is_none() {
            return;
        }
        // Who sleeps is woken once: then it has an event.
        if let Some((start, deliver)) = desk.waits.take() {
            self.master_free += send;
            let end = self.master_free + latency;
            self.pauses.push(Pause { worker, start, end, deliver });
            self.at(end, What::Look(worker));
        }
    }

    /// The worker goes on at `now`.
    fn look(&mut self, worker: usize, now: f64) {
        let desk = &mut self.workers[worker];
        if desk.task.is_none() {
            desk.task = desk.waiting.pop_front();
        }
        if desk.task.is_none() {
            desk.waits = Some((now, false));
            return;
        }
        if desk.parcels == 0 {
            desk.waits = Some((now, true));
            return;
        }
        let Some((place, now)) = self.take_tile(worker, now) else {
            self.post(worker, now, true);
            return;
        };
        let desk = &mut self.workers[worker];
        let begin = now + std::mem::take(&mut desk.debt);
        let end = begin + self.seconds[place];
        desk.filled.0 += 1;
        desk.filled.1 += self.plan.tiles[place].len();
        self.spans.push(Span { worker, tile: self.plan.tiles[place], start: begin, end });
        let end = end + self.costs.tile;
        let last = desk.task.is_none_or(Run::is_empty) && self.schedule.strategy != Strategy::Stealing;
        if last || self.schedule.film == FilmMode::Messages {
            self.post(worker, end, last);
        } else {
            self.at(end, What::Look(worker));
        }
    }

    /// The next tile of the worker's task, of a stealing worker also of the largest other one, and the time when it has
    /// it.
    fn take_tile(&mut self, worker: usize, now: f64) -> Option<(usize, f64)> {
        let own = self.workers[worker].task.as_mut()?;
        if !own.is_empty() {
            let place = own.first;
            own.first += own.step;
            return Some((place, now));
        }
        if self.schedule.strategy != Strategy::Stealing {
            return None;
        }
        let rest = |i: usize, workers: &[Worker]| workers[i].task.map_or(0, Run::len);
        let victim = (0..self.workers.len()).max_by_key(|&i| rest(i, &self.workers))?;
        let rest = self.workers[victim].task.as_mut().filter(|rest| !rest.is_empty())?;
        let half = rest.len().div_ceil(2);
        let stolen = Run { first: rest.first + 1, end: rest.first + half, step: 1 };
        let place = rest.first;
        rest.first += half;
        self.workers[worker].task = Some(stolen);
        self.workers[worker].steals += 1;
        Some((place, now + self.costs.steal))
    }

    /// The worker sends its parcel and goes on.
    fn post(&mut self, worker: usize, now: f64, finished: bool) {
        let desk = &mut self.workers[worker];
        let (tiles, pixels) = std::mem::take(&mut desk.filled);
        desk.parcels -= 1;
        if finished {
            desk.task = None;
        }
        // Who finds the master asleep wakes it.
        let (wakes, latency) =
            if now >= self.master_free { (self.costs.send, self.costs.latency) } else { (0.0, 0.0) };
        let arrives = now + wakes + latency;
        self.reports.count += 1;
        self.at(arrives, What::Arrive(Report { worker, tiles, pixels, finished }));
        self.at(now + wakes, What::Look(worker));
    }

    fn arrive(&mut self, report: Report, now: f64) {
        let begin = now.max(self.master_free);
        let mut work = self.costs.collect + report.tiles as f64 * self.costs.collect_tile;
        if self.schedule.film == FilmMode::Messages {
            work += report.pixels as f64 * 12.0 * self.costs.per_byte;
        }
        self.master_free = begin + work;
        let next = if report.finished { self.dealer.next(self.plan) } else { None };
        self.lay(report.worker, true, next);
        if self.workers.len() >= self.costs.cores {
            self.take_from_a_worker(self.master_free - begin);
        }
        self.end = self.end.max(self.master_free);
    }

    /// The master ran for `seconds` on the core of a worker; idle ones come first.
    fn take_from_a_worker(&mut self, seconds: f64) {
        if self.workers.iter().all(|worker| worker.waits.is_none()) {
            let loser = self.number as usize % self.workers.len();
            self.workers[loser].debt += seconds + self.costs.switch;
        }
    }

    fn stats(mut self) -> FrameStats {
        self.spans.sort_by(|a, b| a.end.total_cmp(&b.end));
        let worker = |worker: &Worker| WorkerStats {
            pinned: Pinned::Free,
            busy_seconds: 0.0,
            tiles: 0,
            idle: Idle::default(),
            steals: worker.steals,
        };
        let mut stats = FrameStats {
            seconds: self.end,
            workers: self.workers.iter().map(worker).collect(),
            spans: self.spans,
            tasks: self.tasks,
            reports: self.reports,
        };
        stats.sum_up(&self.pauses);
        stats
    }
}

#[cfg(test)]
mod tests;
