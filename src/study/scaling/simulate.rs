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
//! lives on that of the last worker: that one pays no wake-ups of its own, but what the master does is taken from its
//! tiles, and the others' reports find it faster while the core is busy, but for a few that find it late.

mod state;

use super::costs::Costs;
use crate::schedule::{
    Dealer, End, FilmMode, FrameStats, Idle, MasterSeconds, Messages, Pause, Pinned, Plan, Run, Schedule,
    SharedCore, Span, Strategy, WorkerStats,
};
use state::{Event, Flight, Report, Task, What, Worker, take_first};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

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

/// Predicts a stream of frames: those that others follow, and the last one. `slowness` has a factor for each worker: so many
/// times what they cost its tiles take.
///
/// # Panics
/// If there is not one cost per tile, or no worker.
pub fn simulate(
    schedule: Schedule,
    slowness: &[f64],
    flow: Flow,
    replay: impl Fn(End) -> Replay,
    costs: &Costs,
) -> FrameStats {
    let replays = [End::Overlapped, End::Awaited].map(replay);
    let complete = |replay: &Replay| replay.seconds.len() == replay.plan.tiles.len();
    assert!(!slowness.is_empty() && replays.iter().all(complete), "a cost for every tile, and a worker");
    let mut run = Simulation::new(schedule, slowness, flow, &replays, costs);
    run.begin_frames(0.0);
    while let Some(Reverse(event)) = run.events.pop() {
        match event.what {
            What::Look(worker) => run.look(worker, event.at()),
            What::Post(worker, finished) => run.post(worker, event.at(), finished),
            What::Arrive(report) => run.arrive(report, event.at()),
            What::Handled(number) => run.handled(number, event.at()),
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
    /// What the master has not handled yet; while it is awake, it is on the first one.
    inbox: VecDeque<Report>,
    awake: bool,
    master_free: f64,
    /// Late wake-ups of the master that are due.
    lateness: f64,
    /// Until when the master waits for its turn on the core of a busy worker.
    late_until: f64,
    /// What the report being handled takes from a tile of the host.
    owed: f64,
    /// Reports handled, counted again where the master came to its turn early.
    handling: u64,
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
        slowness: &[f64],
        flow: Flow,
        replays: &'a [Replay; 2],
        costs: &'a Costs,
    ) -> Simulation<'a> {
        let parcels = schedule.strategy.parcels();
        let worker = |&slowness| Worker { parcels, slowness, waits: Some((0.0, false)), ..Worker::default() };
        Simulation {
            schedule,
            flow,
            replays,
            costs,
            begun: 0,
            flights: VecDeque::new(),
            workers: slowness.iter().map(worker).collect(),
            events: BinaryHeap::new(),
            number: 0,
            inbox: VecDeque::new(),
            awake: false,
            master_free: 0.0,
            lateness: 0.0,
            late_until: 0.0,
            owed: 0.0,
            handling: 0,
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
            let unfinished = self.workers.len();
            self.flights.push_back(Flight {
                number: frame,
                replay,
                dealer,
                due: 0,
                unfinished,
                done: 0,
                ranges,
            });
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

    /// The host, if it computes at `now`. Who has just been woken has an event, and who waits has time.
    fn busy_host(&self, now: f64) -> Option<usize> {
        self.host().filter(|&host| self.workers[host].waits.is_none() && self.workers[host].wakes <= now)
    }

    /// The host, if it could go on but for the master, who does not lie down before `now`.
    fn waking_host(&self, now: f64) -> Option<usize> {
        self.host().filter(|&host| self.workers[host].waits.is_none() && self.workers[host].wakes > now)
    }

    /// The master lays something on a worker's desk, and wakes it if it waits.
    fn lay(&mut self, worker: usize, parcel: bool, task: Option<Task>) {
        let (reply, latency) = self.answer(worker);
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

    /// What it costs the master to wake the worker, and from then on until the worker goes on.
    fn answer(&self, worker: usize) -> (f64, f64) {
        let SharedCore { switch, reply, back, wait, .. } = self.costs.shared;
        let waits = |(start, _)| self.master_free - start;
        match self.host() {
            // It goes on when the master lies down.
            Some(host) if host == worker => (0.0, switch / 2.0),
            // The sooner an answer comes, the less deep its core sleeps.
            Some(_) if self.workers[worker].waits.map_or(0.0, waits) < wait => (reply, back),
            _ => (self.costs.reply, self.costs.to_worker),
        }
    }

    /// The worker goes on at `now`.
    fn look(&mut self, worker: usize, now: f64) {
        let desk = &mut self.workers[worker];
        let stood = std::mem::take(&mut desk.stood);
        if stood > 0.0 {
            self.at(now + stood, What::Look(worker));
            return;
        }
        if desk.task.is_none() {
            desk.task = desk.waiting.pop_front();
        }
        if desk.task.is_none() || desk.parcels == 0 {
            desk.waits = Some((now, desk.task.is_some()));
            self.give_way(worker, now);
            return;
        }
        if self.give_way(worker, now) {
            let time = self.master_free - now + self.costs.shared.switch;
            self.workers[worker].stand(now, time);
            self.at(now, What::Look(worker));
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
        let end = start + std::mem::take(&mut desk.debt) + seconds[place] * desk.slowness;
        desk.filled.0 += 1;
        desk.filled.1 += plan.tiles[place].len();
        self.spans.push(Span { frame, worker, tile: plan.tiles[place], start, end });
        let end = end + self.costs.tile;
        let last = desk.task.is_none_or(|task| task.run.is_empty()) && !stealing;
        if last || self.schedule.film == FilmMode::Messages {
            self.at(end, What::Post(worker, last));
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
        let tells_only_last = self.schedule.tells_only_last();
        let silent = match self.flight(frame) {
            Some(flight) if finished && tells_only_last => {
                flight.unfinished -= 1;
                flight.unfinished > 0
            }
            _ => false,
        };
        // Who finds the master asleep wakes it; on the same core it goes on at once.
        let (wakes, latency) = if silent || now < self.master_free || self.host() == Some(worker) {
            (0.0, 0.0)
        } else if self.busy_host(now).is_some() {
            (self.costs.shared.send, self.costs.shared.latency)
        } else {
            (self.costs.send, self.costs.to_master)
        };
        let arrives = now + wakes + latency;
        self.reports.count += 1;
        self.at(arrives, What::Arrive(Report { worker, frame, tiles, pixels, finished, silent }));
        self.at(now + wakes, What::Look(worker));
    }

    fn arrive(&mut self, report: Report, now: f64) {
        self.inbox.push_back(report);
        if !self.awake
            && !report.silent
            && let Some(&first) = self.inbox.front()
        {
            self.awake = true;
            self.handle(first, now, now >= self.master_free);
        }
    }

    /// The master begins with a report at `now`, or as soon as it is free. Whoever computes on its core stands still meanwhile.
    fn handle(&mut self, report: Report, now: f64, woken: bool) {
        let now = now.max(self.master_free);
        let (host, waking) = (self.busy_host(now), self.waking_host(now));
        let late = if host.is_some() && woken { self.lateness() } else { 0.0 };
        let mut work = self.costs.collect + report.tiles as f64 * self.costs.collect_tile;
        if self.schedule.film == FilmMode::Messages {
            work += report.pixels as f64 * 12.0 * self.costs.per_byte;
        }
        self.late_until = now + late;
        self.master_free = self.late_until + work;
        self.master.reports += work;
        self.at(self.master_free, What::Handled(self.handling));
        let SharedCore { switch, interrupt, .. } = self.costs.shared;
        let own = host == Some(report.worker) && late == 0.0;
        let wake = if own { switch } else { interrupt };
        let taken = work + if woken { wake } else { 0.0 };
        self.owed = if own { 0.0 } else { taken };
        // Who stands between two tiles must know before it goes on.
        if let Some(host) = host.filter(|_| own) {
            self.workers[host].stand(now, taken);
        }
        if let Some(host) = waking {
            self.workers[host].stand(now, work);
        }
    }

    /// The master is done with the first report of its inbox, answers, and goes on with the next one.
    fn handled(&mut self, number: u64, now: f64) {
        if number != self.handling {
            return;
        }
        self.handling += 1;
        let (host, waking) = (self.busy_host(now), self.waking_host(now));
        let Some(report) = self.inbox.pop_front() else { return };
        if let Some(flight) = self.flight(report.frame) {
            flight.done += report.tiles;
            flight.due -= usize::from(report.finished);
        }
        self.workers[report.worker].due -= usize::from(report.finished);
        let next = if report.finished { self.next_task() } else { None };
        self.lay(report.worker, true, next);
        self.begin_frames(self.master_free);
        if let Some(host) = waking {
            self.workers[host].stand(now, self.master_free - now);
        }
        // If it waits meanwhile, nothing was taken from it.
        if let Some(host) = host {
            self.workers[host].debt += self.owed + self.master_free - now;
        }
        self.end = self.end.max(self.master_free);
        match self.inbox.front() {
            Some(&next) => self.handle(next, self.master_free, false),
            None => self.awake = false,
        }
    }

    /// The worker is on no tile: a master that waits for its turn on the same core has it now. Whether there is one.
    fn give_way(&mut self, worker: usize, now: f64) -> bool {
        let gives = self.host() == Some(worker) && now < self.late_until;
        if gives {
            self.master_free -= self.late_until - now;
            self.late_until = now;
            // The worker stands still between tiles; nothing is taken from one.
            self.owed = 0.0;
            self.handling += 1;
            self.at(self.master_free, What::Handled(self.handling));
        }
        gives
    }

    /// How much later than usual a master on the core of a busy worker wakes up, unless that worker's tile ends before.
    fn lateness(&mut self) -> f64 {
        let SharedCore { late, delay, .. } = self.costs.shared;
        self.lateness += late;
        let is_late = self.lateness >= 1.0;
        self.lateness -= f64::from(is_late);
        if is_late { delay } else { 0.0 }
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
