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
//! A message to somebody who waits takes a latency, and some of its sender's time; one to somebody who is busy lies
//! there until he looks. The master handles reports in the order of their arrival. Where it has no core of its own, it
//! lives on that of one worker, as systems leave it: that one pays no wake-ups of its own, but what the master does for the
//! others is taken from its tiles. Only where another has been idle for long does the master move there.

mod state;

use super::costs::Costs;
use crate::schedule::{
    Dealer, End, FilmMode, FrameStats, Idle, MasterSeconds, Messages, Pause, Pinned, Plan, Run, Schedule,
    Span, Strategy, WorkerStats,
};
use state::{Event, Flight, Report, Task, What, Worker, take_first};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// A core that has been idle for so many seconds is where the system moves a thread that has to share one.
const LONG_IDLE: f64 = 0.5e-3;

/// How many frames follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flow {
    /// Frames in all, >= 1.
    pub frames: usize,
    /// How many of them are in flight at most, >= 1.
    pub in_flight: usize,
}

impl Flow {
    /// A single frame.
    pub const ONE: Flow = Flow { frames: 1, in_flight: 1 };

    /// The same for `workers` workers: so many times the frames, so that any number of them has about as long to do, but
    /// not more than `most`.
    pub(super) fn of(self, workers: usize, most: usize) -> Flow {
        Flow { frames: (self.frames * workers).min(most.max(self.frames)), ..self }
    }
}

/// A frame to be replayed.
#[derive(Clone, Debug)]
pub struct Replay {
    /// Its tiles.
    pub plan: Plan,
    /// What each of them costs, in the plan's order.
    pub seconds: Vec<f64>,
}

/// Predicts a stream of frames: those that others follow, and the last one.
///
/// # Panics
/// If there is not one cost per tile, or no worker.
pub fn simulate(
    schedule: Schedule,
    workers: usize,
    flow: Flow,
    replay: impl Fn(End) -> Replay,
    costs: &Costs,
) -> FrameStats {
    let replays = [End::Overlapped, End::Awaited].map(replay);
    let complete = |replay: &Replay| replay.seconds.len() == replay.plan.tiles.len();
    assert!(workers > 0 && replays.iter().all(complete), "a cost for every tile, and a worker");
    let mut run = Simulation::new(schedule, workers, flow, &replays, costs);
    run.begin_frames(0.0);
    while let Some(Reverse(event)) = run.events.pop() {
        match event.what {
            What::Look(worker) => run.look(worker, event.at()),
            What::Arrive(report) => run.arrive(report, event.at()),
        }
    }
    run.stats()
}

struct Simulation<'a> {
    schedule: Schedule,
    flow: Flow,
    /// Of a frame that another one follows, and of the last one.
    replays: &'a [Replay; 2],
    costs: &'a Costs,
    begun: usize,
    flights: VecDeque<Flight>,
    workers: Vec<Worker>,
    events: BinaryHeap<Reverse<Event>>,
    number: u64,
    master_free: f64,
    end: f64,
    spans: Vec<Span>,
    pauses: Vec<Pause>,
    tasks: Messages,
    reports: Messages,
    master: MasterSeconds,
}

impl<'a> Simulation<'a> {
    fn new(
        schedule: Schedule,
        workers: usize,
        flow: Flow,
        replays: &'a [Replay; 2],
        costs: &'a Costs,
    ) -> Simulation<'a> {
        let parcels = schedule.strategy.parcels();
        let worker = || Worker { parcels, waits: Some((0.0, false)), ..Worker::default() };
        Simulation {
            schedule,
            flow,
            replays,
            costs,
            begun: 0,
            flights: VecDeque::new(),
            workers: (0..workers).map(|_| worker()).collect(),
            events: BinaryHeap::new(),
            number: 0,
            master_free: 0.0,
            end: 0.0,
            spans: Vec::with_capacity(flow.frames * replays[0].plan.tiles.len()),
            pauses: vec![],
            tasks: Messages::default(),
            reports: Messages::default(),
            master: MasterSeconds::default(),
        }
    }

    fn at(&mut self, seconds: f64, what: What) {
        self.number += 1;
        self.events.push(Reverse(Event { at: (seconds * 1e12) as u64, number: self.number, what }));
    }

    fn stealing(&self) -> bool {
        self.schedule.strategy == Strategy::Stealing
    }

    /// The master ends complete frames and begins others, from `now` on.
    fn begin_frames(&mut self, now: f64) {
        let replays = self.replays;
        let complete = |f: &mut Flight| f.due == 0 && f.done == replays[f.replay].plan.tiles.len();
        while self.flights.pop_front_if(complete).is_some() {}
        while self.flights.len() < self.flow.in_flight && self.begun < self.flow.frames {
            self.master_free = self.master_free.max(now) + self.costs.prepare;
            self.master.frames += self.costs.prepare;
            let frame = self.begun;
            self.begun += 1;
            let replay = usize::from(self.flow.in_flight == 1 || self.begun == self.flow.frames);
            let plan = &replays[replay].plan;
            let dealer = Dealer::new(self.schedule.strategy, self.workers.len(), plan);
            let first: Vec<_> = (0..self.workers.len()).map(|i| dealer.first(i, plan)).collect();
            let empty = Run { first: 0, end: 0, step: 1 };
            let ranges = match self.stealing() {
                true => first.iter().map(|run| run.unwrap_or(empty)).collect(),
                false => vec![],
            };
            self.flights.push_back(Flight { number: frame, replay, dealer, due: 0, done: 0, ranges });
            for (worker, run) in first.into_iter().enumerate() {
                // Who owns nothing may steal.
                let run = if self.stealing() { Some(empty) } else { run };
                self.lay(worker, false, run.map(|run| Task { frame, run }));
            }
            self.supply();
        }
    }

    /// As many tasks as each may have: a first one to each, then a second one.
    fn supply(&mut self) {
        for have in 0..self.schedule.strategy.tasks_at_once() {
            for worker in 0..self.workers.len() {
                if self.workers[worker].due <= have {
                    let task = self.next_task();
                    self.lay(worker, false, task);
                }
            }
        }
    }

    /// The next task of the oldest frame that has one left.
    fn next_task(&mut self) -> Option<Task> {
        let replays = self.replays;
        self.flights.iter_mut().find_map(|flight| {
            let run = flight.dealer.next(&replays[flight.replay].plan)?;
            Some(Task { frame: flight.number, run })
        })
    }

    fn flight(&mut self, frame: usize) -> Option<&mut Flight> {
        self.flights.iter_mut().find(|flight| flight.number == frame)
    }

    /// The worker on whose core the master lives, if it has none of its own.
    fn host(&self) -> Option<usize> {
        (self.workers.len() >= self.costs.cores).then(|| self.workers.len() - 1)
    }

    /// The master lays something on a worker's desk, and wakes it if it waits.
    fn lay(&mut self, worker: usize, parcel: bool, task: Option<Task>) {
        let (reply, latency) = match self.host() == Some(worker) {
            // It goes on when the master lies down.
            true => (0.0, self.costs.switch),
            false => (self.costs.reply, self.costs.to_worker),
        };
        if let Some(Task { frame, .. }) = task
            && let Some(flight) = self.flight(frame)
        {
            flight.due += 1;
            self.tasks.count += 1;
        }
        let desk = &mut self.workers[worker];
        desk.parcels += usize::from(parcel);
        desk.due += usize::from(task.is_some());
        desk.waiting.extend(task);
        if !parcel && task.is_none() {
            return;
        }
        // Who sleeps is woken once: then it has an event.
        if let Some((start, deliver)) = desk.waits.take() {
            self.master_free += reply;
            let end = self.master_free + latency;
            desk.wakes = end;
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
        let Some((frame, place, now)) = self.take_tile(worker, now) else {
            self.post(worker, now, true);
            return;
        };
        let stealing = self.stealing();
        let Some(replay) = self.flight(frame).map(|flight| flight.replay) else { return };
        let Replay { plan, seconds } = &self.replays[replay];
        let desk = &mut self.workers[worker];
        let start = now;
        let end = start + std::mem::take(&mut desk.debt) + seconds[place] * self.costs.inflation;
        desk.filled.0 += 1;
        desk.filled.1 += plan.tiles[place].len();
        self.spans.push(Span { frame, worker, tile: plan.tiles[place], start, end });
        let end = end + self.costs.tile;
        let last = desk.task.is_none_or(|task| task.run.is_empty()) && !stealing;
        if last || self.schedule.film == FilmMode::Messages {
            self.post(worker, end, last);
        } else {
            self.at(end, What::Look(worker));
        }
    }

    /// The next tile of the worker's task, of a stealing worker of its own range or the largest other one; with its frame,
    /// and the time when the worker has it.
    fn take_tile(&mut self, worker: usize, now: f64) -> Option<(usize, usize, f64)> {
        let steal = self.costs.steal;
        let task = self.workers[worker].task.as_mut()?;
        let (frame, own) = (task.frame, &mut task.run);
        if let Some(place) = take_first(own) {
            return Some((frame, place, now));
        }
        let ranges = &mut self.flight(frame)?.ranges;
        if let Some(place) = take_first(ranges.get_mut(worker)?) {
            return Some((frame, place, now));
        }
        let rest = ranges.iter_mut().max_by_key(|range| range.len()).filter(|rest| !rest.is_empty())?;
        let half = rest.len().div_ceil(2);
        let (place, end) = (rest.first, rest.first + half);
        rest.first = end;
        ranges[worker] = Run { first: place + 1, end, step: 1 };
        self.workers[worker].steals += 1;
        Some((frame, place, now + steal))
    }

    /// The worker sends its parcel and goes on.
    fn post(&mut self, worker: usize, now: f64, finished: bool) {
        let desk = &mut self.workers[worker];
        let (tiles, pixels) = std::mem::take(&mut desk.filled);
        desk.parcels -= 1;
        let Some(Task { frame, .. }) = desk.task else { return };
        if finished {
            desk.task = None;
        }
        // Who finds the master asleep wakes it; on the same core it goes on at once.
        let asleep = now >= self.master_free && self.host() != Some(worker);
        let (wakes, latency) = if asleep { (self.costs.send, self.costs.to_master) } else { (0.0, 0.0) };
        let arrives = now + wakes + latency;
        self.reports.count += 1;
        self.at(arrives, What::Arrive(Report { worker, frame, tiles, pixels, finished }));
        self.at(now + wakes, What::Look(worker));
    }

    fn arrive(&mut self, report: Report, now: f64) {
        let begin = now.max(self.master_free);
        let mut work = self.costs.collect + report.tiles as f64 * self.costs.collect_tile;
        if self.schedule.film == FilmMode::Messages {
            work += report.pixels as f64 * 12.0 * self.costs.per_byte;
        }
        self.master_free = begin + work;
        self.master.reports += work;
        if let Some(flight) = self.flight(report.frame) {
            flight.done += report.tiles;
            flight.due -= usize::from(report.finished);
        }
        self.workers[report.worker].due -= usize::from(report.finished);
        let next = if report.finished { self.next_task() } else { None };
        self.lay(report.worker, true, next);
        self.begin_frames(self.master_free);
        if let Some(host) = self.host() {
            self.take_from(host, report.worker, begin);
        }
        self.end = self.end.max(self.master_free);
    }

    /// The master ran from `begin` on for a report of `reporter`, on the core of `host` unless another is long idle.
    fn take_from(&mut self, host: usize, reporter: usize, begin: f64) {
        let idle = |worker: &Worker| worker.waits.is_some_and(|(since, _)| begin - since > LONG_IDLE);
        // Who has just been woken has an event, and who waits has time.
        let busy = self.workers[host].waits.is_none() && self.workers[host].wakes <= begin;
        if busy && !self.workers.iter().any(idle) {
            let Costs { switch, interrupt, .. } = *self.costs;
            let extra = if reporter == host { switch } else { switch + interrupt };
            self.workers[host].debt += self.master_free - begin + extra;
        }
    }

    fn stats(mut self) -> FrameStats {
        self.spans.sort_by(|a, b| a.frame.cmp(&b.frame).then(a.end.total_cmp(&b.end)));
        let worker = |worker: &Worker| WorkerStats {
            pinned: Pinned::Free,
            busy_seconds: 0.0,
            tiles: 0,
            idle: Idle::default(),
            steals: worker.steals,
        };
        let mut stats = FrameStats {
            frames: self.flow.frames,
            seconds: self.end,
            workers: self.workers.iter().map(worker).collect(),
            spans: self.spans,
            tasks: self.tasks,
            reports: self.reports,
            master: self.master,
        };
        stats.sum_up(&self.pauses);
        stats
    }
}

#[cfg(test)]
mod tests;
