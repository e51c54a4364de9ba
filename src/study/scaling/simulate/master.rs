//! What the master does.

use super::{
    Costs, Simulation,
    state::{Flight, Report, Task, What},
};
use crate::schedule::{Dealer, FilmMode, Pause, Run, SharedCore};

impl Simulation<'_> {
    /// The master ends complete frames and begins others, from `now` on.
    pub(super) fn begin_frames(&mut self, now: f64) {
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
            desk.woken += reply;
            desk.answers.awaited += 1;
            desk.answers.latency_sum += reply + latency;
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

    pub(super) fn arrive(&mut self, report: Report, now: f64) {
        self.inbox.push_back(report);
        if report.calls {
            self.called = false;
        }
        // Who comes while it is about to wake up is read together with who woke it.
        if !self.awake
            && !self.called
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
        let late = if woken { self.lateness(report.worker, now) } else { 0.0 };
        let mut work = self.costs.collect + report.tiles as f64 * self.costs.collect_tile;
        if self.schedule.film == FilmMode::Messages {
            let byte = match (self.host(), self.costs.copied) {
                (Some(host), Some(copied)) => copied[usize::from(host == report.worker)],
                _ => self.costs.per_byte,
            };
            work += report.pixels as f64 * 12.0 * byte;
        }
        self.late_until = now + late;
        self.master_free = self.late_until + work;
        self.master.reports += work;
        self.workers[report.worker].handled += work;
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
    pub(super) fn handled(&mut self, number: u64, now: f64) {
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
        let before = self.master_free;
        self.lay(report.worker, true, next);
        self.master.reports += self.master_free - before;
        self.workers[report.worker].handled += self.master_free - before;
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

    /// How much later than usual the master wakes up; on the core of a busy worker unless that one's tile ends before.
    fn lateness(&mut self, worker: usize, now: f64) -> f64 {
        let Costs { late, delay, shared, .. } = *self.costs;
        let (which, late, delay) = match self.busy_host(now) {
            Some(_) => (1, shared.late, shared.delay),
            None => (0, late, delay),
        };
        let due = &mut self.lateness[which];
        *due += late;
        if *due < 1.0 {
            return 0.0;
        }
        *due -= 1.0;
        let (wakes, latency) = self.way_to_master(now);
        let reports = &mut self.workers[worker].reports;
        reports.late += 1;
        reports.late_sum += wakes + latency + delay;
        reports.latency_sum += delay;
        delay
    }
}
