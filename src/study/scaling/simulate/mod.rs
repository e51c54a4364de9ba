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

mod master;
mod state;
mod worker;

use super::costs::Costs;
use crate::schedule::{
    End, FrameStats, MasterSeconds, Messages, Pause, Pinned, Plan, Schedule, Span, Strategy, WorkerStats,
};
use state::{Event, Flight, Report, What, Worker};
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
    /// Somebody has called it, and it is about to wake up.
    called: bool,
    master_free: f64,
    /// Late wake-ups of the master that are due: where it has a core of its own, and on that of a busy worker.
    lateness: [f64; 2],
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
            called: false,
            master_free: 0.0,
            lateness: [0.0; 2],
            late_until: 0.0,
            owed: 0.0,
            handling: 0,
            end: 0.0,
            spans: Vec::with_capacity(flow.frames * replays[0].plan.tiles.len()),
            pauses: vec![],
            tasks: Messages::default(),
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

    fn stats(mut self) -> FrameStats {
        self.spans.sort_by(|a, b| a.frame.cmp(&b.frame).then(a.end.total_cmp(&b.end)));
        let worker = |worker: &Worker| WorkerStats {
            steals: worker.steals,
            reports: worker.reports,
            answers: worker.answers,
            handled: worker.handled,
            woken: worker.woken,
            ..WorkerStats::new(Pinned::Free)
        };
        let mut reports = Messages::default();
        self.workers.iter().for_each(|worker| reports.add(&worker.reports));
        let mut stats = FrameStats {
            frames: self.flow.frames,
            seconds: self.end,
            workers: self.workers.iter().map(worker).collect(),
            spans: self.spans,
            tasks: self.tasks,
            reports,
            master: self.master,
        };
        stats.sum_up(&self.pauses);
        stats
    }
}

#[cfg(test)]
mod tests;
