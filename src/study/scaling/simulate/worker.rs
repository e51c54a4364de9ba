//! What workers do.

use super::{
    Replay, Simulation,
    state::{Report, Task, What, take_first},
};
use crate::schedule::{FilmMode, Run, Span};

impl Simulation<'_> {
    /// The worker goes on at `now`.
    pub(super) fn look(&mut self, worker: usize, now: f64) {
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
    pub(super) fn post(&mut self, worker: usize, now: f64, finished: bool) {
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
        let way = if silent { None } else { self.wake_master(worker, now) };
        let (wakes, latency) = way.unwrap_or((0.0, 0.0));
        let arrives = now + wakes + latency;
        self.workers[worker].reports.count += 1;
        self.at(
            arrives,
            What::Arrive(Report { worker, frame, tiles, pixels, finished, silent, calls: way.is_some() }),
        );
        self.at(now + wakes, What::Look(worker));
    }

    /// Who finds the master asleep wakes it: what that takes, and how long it takes from then on. On the same core it goes on at
    /// once.
    fn wake_master(&mut self, worker: usize, now: f64) -> Option<(f64, f64)> {
        if self.called || now < self.master_free {
            return None;
        }
        self.workers[worker].reports.awaited += 1;
        if self.host() == Some(worker) {
            return None;
        }
        let (wakes, latency) = self.way_to_master(now);
        self.workers[worker].reports.latency_sum += wakes + latency;
        self.called = true;
        Some((wakes, latency))
    }

    /// A worker, to wake the master from another core, and from then on until that goes on, unless it is late.
    pub(super) fn way_to_master(&self, now: f64) -> (f64, f64) {
        match self.busy_host(now) {
            Some(_) => (self.costs.shared.send, self.costs.shared.latency),
            None => (self.costs.send, self.costs.to_master),
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
}
