//! Workers that cannot begin, or do not live to the end.

use super::super::*;
use super::{in_time, workers};
use crate::error::Error;
use crate::tile::{Order, tiles};
use std::sync::atomic::{AtomicBool, Ordering};

/// A task that borrows what is not `'static` and whose scratch cannot be made.
struct NoScratch<'a>(&'a str);

impl TileTask for NoScratch<'_> {
    type Frame = ();
    type Scratch = ();
    type Output = ();

    fn scratch(&self, _worker: usize) {
        panic!("{}", self.0);
    }

    fn run(&self, (): &(), _tile: Tile, (): &mut (), (): &mut ()) {}
}

#[test]
fn scratch_that_cannot_be_made_fails_the_first_tile() {
    in_time(|| {
        let text = String::from("no memory");
        let tiles = tiles(8, 8, 8, Order::Hilbert);
        for schedule in Schedule::all() {
            let result = with_workers(&NoScratch(&text), &workers(2), |master| {
                master.run_frame(schedule, (), &tiles, &Control::unattended(), |(), _, ()| {})
            });
            let message = result.err().unwrap().to_string();
            assert!(message.starts_with("tile at (0, 0) of 8x8 pixels failed: no memory;"), "{message}");
        }
    });
}

/// The first output ever made takes its worker's thread along: it is made outside of what is guarded.
struct Deadly;

static DIED: AtomicBool = AtomicBool::new(true);

struct Fragile;

impl Default for Fragile {
    fn default() -> Fragile {
        assert!(DIED.swap(true, Ordering::SeqCst), "the thread dies");
        Fragile
    }
}

impl TileTask for Deadly {
    type Frame = ();
    type Scratch = ();
    type Output = Fragile;

    fn scratch(&self, _worker: usize) {}

    fn run(&self, (): &(), _tile: Tile, (): &mut (), _: &mut Fragile) {}
}

#[test]
fn a_dying_worker_fails_the_frame_and_the_others_go_on() {
    in_time(|| {
        for schedule in Schedule::all() {
            DIED.store(false, Ordering::SeqCst);
            with_workers(&Deadly, &workers(3), |master| {
                let tiles = tiles(64, 64, 8, Order::Hilbert);
                let mut frame = || {
                    let mut done = 0;
                    let result =
                        master.run_frame(schedule, (), &tiles, &Control::unattended(), |(), _, _| done += 1);
                    result.map(|_| done)
                };
                let message = frame().unwrap_err().to_string();
                assert!(message.starts_with("a worker thread was lost"), "{schedule:?}: {message}");
                for _ in 0..3 {
                    assert!(frame()? >= tiles.len(), "{schedule:?}");
                }
                Ok(())
            })
            .unwrap();
        }
    });
}

#[test]
fn when_the_last_worker_has_died_every_frame_fails_at_once() {
    in_time(|| {
        struct Dead;
        #[derive(Debug)]
        struct Never;
        impl Default for Never {
            fn default() -> Never {
                panic!("the thread dies")
            }
        }
        impl TileTask for Dead {
            type Frame = ();
            type Scratch = ();
            type Output = Never;
            fn scratch(&self, _worker: usize) {}
            fn run(&self, (): &(), _tile: Tile, (): &mut (), _: &mut Never) {}
        }
        with_workers(&Dead, &workers(1), |master| {
            for _ in 0..3 {
                let tiles = tiles(64, 64, 8, Order::Hilbert);
                let control = Control::unattended();
                let frame = master.run_frame(Schedule::default(), (), &tiles, &control, |(), _, _| {});
                assert!(matches!(frame, Err(Error::Failed(_))));
            }
            Ok(())
        })
        .unwrap();
    });
}
