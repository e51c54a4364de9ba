//! The protocol under a scheduler that tries out interleavings: the very files of the protocol, compiled once more
//! with the mutexes, conditions and threads of `shuttle`. Its conditions never time out, so a lost wake-up is
//! a deadlock, and a deadlock fails the test. (The deques of `crossbeam` count as atomic here; their own project tests
//! their insides.)

#![allow(dead_code, unreachable_pub, clippy::duplicate_mod)]

#[path = "frame.rs"]
mod frame;
#[path = "mail.rs"]
mod mail;
#[path = "master.rs"]
mod master;
#[path = "message.rs"]
mod message;
#[path = "worker.rs"]
mod worker;

/// Stands for `sync.rs`.
mod sync {
    pub(super) use shuttle::sync::{Condvar, Mutex, MutexGuard};
    pub(super) use shuttle::thread::{Scope, scope};

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
    Control, CostMap, Dealer, FilmMode, FrameStats, Messages, Pause, Plan, Progress, Run, Schedule, Span,
    Strategy, TileTask, WorkerStats, pin,
};

use super::{Machine, Placement, Topology};
use crate::error::{Error, Result};
use crate::tile::{Order, Tile, tiles};
use master::{Master, with_workers};
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

/// Interleavings tried for each case.
const TRIES: usize = 60;

/// Outputs where the tile lies; panics at one place. Locks in between, so that workers overtake each other there.
struct Model {
    panic_at: Option<(u32, u32)>,
    gate: shuttle::sync::Mutex<()>,
}

impl TileTask for Model {
    type Frame = ();
    type Scratch = ();
    type Output = (u32, u32);

    fn scratch(&self, _worker: usize) {}

    fn run(&self, (): &(), tile: Tile, (): &mut (), output: &mut (u32, u32)) {
        drop(self.gate.lock());
        if self.panic_at == Some((tile.x, tile.y)) {
            // Without the panic hook, which would print.
            std::panic::resume_unwind(Box::new("modelled"));
        }
        *output = (tile.x, tile.y);
    }
}

/// Tries `body` with `workers` workers for every strategy and film mode.
fn explore(workers: usize, panic_at: Option<(u32, u32)>, body: fn(&mut Master<Model>, Schedule)) {
    for schedule in Schedule::all() {
        let run = move || {
            let task = Model { panic_at, gate: shuttle::sync::Mutex::new(()) };
            let machine = Machine::new(&Topology::flat(&[]), 1);
            let placement = Placement::new(&machine, Some(workers), false);
            with_workers(&task, &placement, |master| {
                body(master, schedule);
                Ok(())
            })
            .unwrap();
        };
        shuttle::check_random(run, TRIES);
        shuttle::check_pct(run, TRIES, 3);
    }
}

fn run_frame(master: &mut Master<Model>, schedule: Schedule, count: u32) -> Result<usize> {
    let tiles = tiles(count, 1, 1, Order::Scanline);
    let mut seen = vec![0; count as usize];
    let collect = |(): &(), tile: Tile, output: &mut (u32, u32)| {
        assert_eq!(*output, (tile.x, tile.y), "an output belongs to its tile");
        seen[tile.x as usize] += 1;
    };
    master.run_frame(schedule, (), &tiles, &Control::unattended(), collect)?;
    assert!(seen.iter().all(|&times| times == 1), "every tile once: {seen:?}");
    Ok(seen.len())
}

#[test]
fn no_tile_is_lost_and_nobody_waits_for_ever() {
    for workers in [1, 2, 3] {
        explore(workers, None, |master, schedule| {
            for count in [5, 0, 1] {
                run_frame(master, schedule, count).unwrap();
            }
        });
    }
}

#[test]
fn a_panic_ends_the_frame_and_not_the_workers() {
    explore(2, Some((3, 0)), |master, schedule| {
        assert!(matches!(run_frame(master, schedule, 6), Err(Error::Worker { x: 3, y: 0, .. })));
        run_frame(master, schedule, 3).unwrap();
    });
}

#[test]
fn a_cancelled_frame_ends_and_the_next_one_is_whole() {
    explore(2, None, |master, schedule| {
        let cancel = AtomicBool::new(false);
        let progress = |p: Progress| cancel.store(p.done == 2, Ordering::Relaxed);
        let control = Control::new(&cancel, &progress);
        let tiles = tiles(6, 1, 1, Order::Scanline);
        // Whoever has done all before the flag is seen was not cancelled.
        match master.run_frame(schedule, (), &tiles, &control, |_, _, _| {}) {
            Ok(_) | Err(Error::Interrupted) => {}
            Err(other) => panic!("{other}"),
        }
        run_frame(master, schedule, 4).unwrap();
    });
}

#[test]
fn a_panic_of_the_master_leaves_nobody_waiting() {
    explore(2, None, |master, schedule| {
        let calls = Cell::new(0);
        let tiles = tiles(6, 1, 1, Order::Scanline);
        let frame = AssertUnwindSafe(|| {
            master.run_frame(schedule, (), &tiles, &Control::unattended(), |_, _, _| {
                calls.set(calls.get() + 1);
                if calls.get() == 2 {
                    std::panic::resume_unwind(Box::new("modelled"));
                }
            })
        });
        assert!(catch_unwind(frame).is_err());
        run_frame(master, schedule, 4).unwrap();
    });
}
