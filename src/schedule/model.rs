//! The protocol under a scheduler that tries out interleavings: the very files of the protocol, compiled once more
//! with the mutexes, conditions and threads of `shuttle`. Its conditions never time out, so a lost wake-up is
//! a deadlock, and a deadlock fails the test. (The deques of `crossbeam` count as atomic here; their own project tests
//! their insides.)

#![allow(dead_code, unreachable_pub, clippy::duplicate_mod)]

#[path = "dealing.rs"]
mod dealing;
#[path = "flight.rs"]
mod flight;
#[path = "mail.rs"]
mod mail;
#[path = "master.rs"]
mod master;
#[path = "message.rs"]
mod message;
#[path = "source.rs"]
mod source;
#[path = "worker.rs"]
mod worker;

/// Stands for `sync.rs`.
mod sync {
    pub(super) use shuttle::sync::{Condvar, Mutex, MutexGuard};
    pub(super) use shuttle::thread::{Scope, scope, yield_now};

    pub(super) fn spawn<'scope>(
        scope: &'scope Scope<'scope, '_>,
        _worker: usize,
        work: impl FnOnce() + Send + 'scope,
    ) -> std::io::Result<()> {
        scope.spawn(work);
        Ok(())
    }
}

// What the protocol's files take from the module above them.
use super::{
    Control, CostMap, Dealer, End, FilmMode, FrameStats, Pause, Plan, Progress, Run, Schedule, Span,
    Strategy, TileTask, WorkerStats, pin,
};

use super::{Machine, Placement, Topology};
use crate::error::{Error, Result};
use crate::tile::{Order, Tile, tiles};
use master::{Master, with_workers};
use source::Source;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

/// Interleavings tried for each case.
const TRIES: usize = 60;

/// Outputs of which frame the tile is, and its place in the row; panics at one place. Locks in between, so that workers overtake each other there.
struct Model {
    panic_at: Option<u32>,
    gate: shuttle::sync::Mutex<()>,
}

impl TileTask for Model {
    type Frame = u32;
    type Scratch = ();
    type Output = (u32, u32);

    fn scratch(&self, _worker: usize) {}

    fn run(&self, &frame: &u32, tile: Tile, (): &mut (), output: &mut (u32, u32)) {
        drop(self.gate.lock());
        if self.panic_at == Some(tile.x) {
            // Without the panic hook, which would print.
            std::panic::resume_unwind(Box::new("modelled"));
        }
        *output = (frame, tile.x);
    }
}

/// Frames of `count` tiles in a row.
struct Frames {
    left: usize,
    begun: u32,
    count: u32,
    /// Of the frames in flight: how often each of its tiles was collected. A frame is its number.
    seen: Vec<Vec<usize>>,
    ended: u32,
    /// Panics when it has collected so many.
    panic_at: Option<usize>,
}

impl Source<Model> for Frames {
    fn next(&mut self) -> Option<u32> {
        self.left = self.left.checked_sub(1)?;
        self.seen.push(vec![0; self.count as usize]);
        self.begun += 1;
        Some(self.begun - 1)
    }

    fn more(&self) -> bool {
        self.left > 0
    }

    fn collect(&mut self, &frame: &u32, tile: Tile, output: &mut (u32, u32)) {
        assert_eq!(*output, (frame, tile.x), "an output belongs to its tile and frame");
        self.seen[frame as usize][tile.x as usize] += 1;
        self.panic_at = self.panic_at.map(|left| left - 1);
        if self.panic_at == Some(0) {
            std::panic::resume_unwind(Box::new("modelled"));
        }
    }

    fn done(&mut self, frame: u32) {
        assert_eq!(frame, self.ended, "frames come back in order");
        assert!(self.seen[frame as usize].iter().all(|&times| times == 1), "every tile once");
        self.ended += 1;
    }
}

/// Tries `body` with `workers` workers and up to `in_flight` frames at once for every strategy and film mode.
fn explore(workers: usize, in_flight: usize, panic_at: Option<u32>, body: fn(&mut Master<Model>, &Mode)) {
    for schedule in Schedule::all() {
        let run = move || {
            let task = Model { panic_at, gate: shuttle::sync::Mutex::new(()) };
            let machine = Machine::new(&Topology::flat(&[]), 1);
            let placement = Placement::new(&machine, Some(workers), false);
            with_workers(&task, &placement, |master| {
                body(master, &Mode { schedule, in_flight });
                Ok(())
            })
            .unwrap();
        };
        shuttle::check_random(run, TRIES);
        shuttle::check_pct(run, TRIES, 3);
    }
}

struct Mode {
    schedule: Schedule,
    in_flight: usize,
}

impl Mode {
    /// Runs frames of `count` tiles and returns how many came back.
    fn stream(&self, master: &mut Master<Model>, frames: usize, count: u32) -> Result<u32> {
        self.watched(master, frames, count, None, &Control::unattended())
    }

    fn watched(
        &self,
        master: &mut Master<Model>,
        frames: usize,
        count: u32,
        panic_at: Option<usize>,
        control: &Control<'_>,
    ) -> Result<u32> {
        let tiles = tiles(count, 1, 1, Order::Scanline);
        let mut source = Frames { left: frames, begun: 0, count, seen: vec![], ended: 0, panic_at };
        let stats = master.run_stream(self.schedule, self.in_flight, &tiles, control, &mut source)?;
        assert_eq!((stats.frames, source.ended as usize), (frames, frames), "all of them");
        Ok(source.ended)
    }
}

#[test]
fn no_tile_is_lost_and_nobody_waits_for_ever() {
    for (workers, in_flight) in [(1, 1), (2, 1), (3, 1), (1, 2), (2, 2), (3, 2), (2, 3)] {
        explore(workers, in_flight, None, |master, mode| {
            for (frames, count) in [(1, 5), (1, 0), (3, 1), (3, 4), (2, 0)] {
                mode.stream(master, frames, count).unwrap();
            }
        });
    }
}

#[test]
fn a_panic_ends_the_stream_and_not_the_workers() {
    for in_flight in [1, 2] {
        explore(2, in_flight, Some(3), |master, mode| {
            let broken = mode.stream(master, 3, 6);
            assert!(matches!(broken, Err(Error::Worker { x: 3, y: 0, .. })));
            mode.stream(master, 2, 3).unwrap();
        });
    }
}

#[test]
fn a_cancelled_stream_ends_and_the_next_one_is_whole() {
    for in_flight in [1, 2] {
        explore(2, in_flight, None, |master, mode| {
            let (cancel, calls) = (AtomicBool::new(false), Cell::new(0));
            let progress = |_: Progress| {
                calls.set(calls.get() + 1);
                cancel.store(calls.get() >= 5, Ordering::Relaxed);
            };
            // Whoever has done all before the flag is seen was not cancelled.
            match mode.watched(master, 2, 4, None, &Control::new(&cancel, &progress)) {
                Ok(_) | Err(Error::Interrupted) => {}
                Err(other) => panic!("{other}"),
            }
            mode.stream(master, 2, 4).unwrap();
        });
    }
}

#[test]
fn a_panic_of_the_master_leaves_nobody_waiting() {
    for in_flight in [1, 2] {
        explore(2, in_flight, None, |master, mode| {
            let broken = AssertUnwindSafe(|| mode.watched(master, 2, 5, Some(3), &Control::unattended()));
            assert!(catch_unwind(broken).is_err());
            mode.stream(master, 2, 4).unwrap();
        });
    }
}
