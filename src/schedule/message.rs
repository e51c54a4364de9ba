//! The messages between master and workers.

use super::Run;
use super::pin::Pinned;
use crate::tile::Tile;
use crossbeam_deque::{Stealer, Worker as Deque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// What all workers read while a frame lasts.
pub(super) struct Shared<F> {
    /// Which frame of its master this is.
    pub(super) number: usize,
    pub(super) frame: F,
    pub(super) tiles: Vec<Tile>,
    /// Set by anyone: no further tile is begun.
    pub(super) stop: AtomicBool,
    /// Every tile is a message of its own; else a task's results travel together.
    pub(super) each_tile: bool,
    /// The other end of every worker's deque for this frame; empty unless its strategy steals.
    pub(super) stealers: Vec<Stealer<usize>>,
}

/// Master to worker: do this.
pub(super) struct Task<F> {
    pub(super) shared: Arc<Shared<F>>,
    pub(super) work: Work,
    /// Of a frame whose tasks are all dealt at first, and entitle to nothing when they are finished.
    pub(super) unfinished: Option<Unfinished>,
}

/// How many tasks of a frame are unfinished. Only the news that there is none left is worth waking the master for.
#[derive(Clone)]
pub(super) struct Unfinished(Arc<AtomicUsize>);

impl Unfinished {
    pub(super) fn new(tasks: usize) -> Unfinished {
        Unfinished(Arc::new(AtomicUsize::new(tasks)))
    }

    /// So many more are finished, or will never be. True if none is left.
    pub(super) fn finish(&self, tasks: usize) -> bool {
        tasks > 0 && self.0.fetch_sub(tasks, Ordering::AcqRel) == tasks
    }
}

/// The tiles of a task.
pub(super) enum Work {
    /// These.
    Run(Run),
    /// Those in this deque, then those in the others' of the same frame. The deque returns with the last parcel.
    Share(Deque<usize>),
}

/// Worker to master.
pub(super) enum Report<O> {
    /// Sent once, before the first task.
    Ready { worker: usize, pinned: Pinned },
    /// Results. The master empties the parcel and lays it back on the worker's desk.
    /// `sent` if the master was woken for it.
    Parcel { worker: usize, parcel: Box<Parcel<O>>, sent: Option<Instant> },
    /// Sent at most once: the thread ends although its desk was not closed.
    Lost { worker: usize },
}

/// Results of some tiles; travels full to the master and empty back.
pub(super) struct Parcel<O> {
    /// Number of the frame whose they are.
    pub(super) frame: usize,
    /// The first `used` are results; the others keep their memory for later ones.
    pub(super) items: Vec<Item<O>>,
    pub(super) used: usize,
    /// The task is done, and its worker has let go of the frame.
    pub(super) finished: bool,
    /// The tile that panicked, and its message.
    pub(super) failure: Option<(Tile, String)>,
    pub(super) deque: Option<Deque<usize>>,
    /// How the worker waited since the last parcel.
    pub(super) waits: Vec<Wait>,
    pub(super) steals: usize,
}

/// One tile's result.
pub(super) struct Item<O> {
    pub(super) place: usize,
    pub(super) start: Instant,
    pub(super) end: Instant,
    pub(super) output: O,
}

/// A worker waited from `start` to `end`.
#[derive(Clone, Copy)]
pub(super) struct Wait {
    pub(super) start: Instant,
    pub(super) end: Instant,
    /// For an empty parcel, else for a task.
    pub(super) deliver: bool,
    /// How long that was on its way.
    pub(super) latency: Duration,
}

impl<O> Default for Parcel<O> {
    fn default() -> Parcel<O> {
        Parcel {
            frame: 0,
            items: vec![],
            used: 0,
            finished: false,
            failure: None,
            deque: None,
            waits: vec![],
            steals: 0,
        }
    }
}

impl<O> Parcel<O> {
    /// Makes it ready to be filled again, and keeps its memory.
    pub(super) fn empty(&mut self) {
        self.used = 0;
        self.finished = false;
        self.failure = None;
        self.deque = None;
        self.waits.clear();
        self.steals = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_who_finishes_the_last_task_is_told_so_even_if_another_ones_will_never_be() {
        let unfinished = Unfinished::new(4);
        let told = [1, 0, 2, 0, 1].map(|tasks| unfinished.clone().finish(tasks));
        assert_eq!(told, [false, false, false, false, true]);
    }
}
