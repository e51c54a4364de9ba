//! What the simulation knows at a moment.

use crate::schedule::{Dealer, Messages, Run};
use std::collections::VecDeque;

/// Picoseconds, so that times have an order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Event {
    pub(super) at: u64,
    /// Of events at the same time, the first one created comes first.
    pub(super) number: u64,
    pub(super) what: What,
}

impl Event {
    pub(super) fn at(self) -> f64 {
        self.at as f64 * 1e-12
    }
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum What {
    /// The worker looks what to do next.
    Look(usize),
    /// The worker sends its parcel; second, whether its task is finished.
    Post(usize, bool),
    /// A report reaches the master.
    Arrive(Report),
    /// The master is done with the report that it handled under this number.
    Handled(u64),
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Report {
    pub(super) worker: usize,
    pub(super) frame: usize,
    pub(super) tiles: usize,
    pub(super) pixels: usize,
    pub(super) finished: bool,
    /// The master is not woken for it.
    pub(super) silent: bool,
    /// The master is woken by it, from another core.
    pub(super) calls: bool,
}

/// Some tiles of a frame.
#[derive(Clone, Copy)]
pub(super) struct Task {
    pub(super) frame: usize,
    pub(super) run: Run,
}

#[derive(Default)]
pub(super) struct Worker {
    /// By which factor its tiles take longer than they cost.
    pub(super) slowness: f64,
    /// What is left of the task it is on; a stealing worker's tiles are in its frame's ranges.
    pub(super) task: Option<Task>,
    pub(super) waiting: VecDeque<Task>,
    /// Tasks that it has, and those of which the master has not yet been told that they are finished.
    pub(super) due: usize,
    pub(super) parcels: usize,
    /// Since when, and for what it waits; it has no event then.
    pub(super) waits: Option<(f64, bool)>,
    /// When it goes on, or went on, after it waited.
    pub(super) wakes: f64,
    /// Results in the parcel being filled: tiles, pixels.
    pub(super) filled: (usize, usize),
    /// Time that the master took from it between two tiles, ...
    pub(super) stood: f64,
    /// ... and in the middle of one.
    pub(super) debt: f64,
    pub(super) steals: usize,
    pub(super) reports: Messages,
    pub(super) answers: Messages,
    /// Seconds that the master was busy with its reports and with their answers.
    pub(super) handled: f64,
    /// Part of that was waking it.
    pub(super) woken: f64,
}

impl Worker {
    /// It has something to do and an event, but goes on only after so many more seconds.
    pub(super) fn stand(&mut self, now: f64, seconds: f64) {
        self.wakes = self.wakes.max(now) + seconds;
        self.stood += seconds;
    }
}

/// A frame in flight.
pub(super) struct Flight {
    pub(super) number: usize,
    /// 0, or 1 for the last one.
    pub(super) replay: usize,
    pub(super) dealer: Dealer,
    pub(super) due: usize,
    /// Tasks that are not finished, if that is told only of the last one.
    pub(super) unfinished: usize,
    /// Tiles of which the master was told.
    pub(super) done: usize,
    /// Of a stealing strategy, what each worker has left.
    pub(super) ranges: Vec<Run>,
}

/// The first tile of a run, which then begins behind it.
pub(super) fn take_first(run: &mut Run) -> Option<usize> {
    let place = (!run.is_empty()).then_some(run.first)?;
    run.first += run.step;
    Some(place)
}
