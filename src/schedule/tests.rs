//! The protocol under load, panics and cancellation. Every test has a deadline: a hang is a failure.

use super::*;
use crate::error::Result;
use crate::tile::{Order, tiles};
use std::cell::Cell;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// Runs `test` on its own thread and fails if it hangs. The deadline is far off, because the machine may be busy.
fn in_time<R: Send + 'static>(test: impl FnOnce() -> R + Send + 'static) -> R {
    let (done, finished) = crossbeam_channel::bounded(1);
    std::thread::spawn(move || done.send(test()));
    finished.recv_timeout(Duration::from_secs(300)).expect("panicked or hung")
}

/// Counts visits in the frame, panics where the frame says so.
struct Counting<'a> {
    alive: &'a AtomicUsize,
}

struct Visits {
    width: u32,
    panic_at: Option<(u32, u32)>,
    count: Vec<AtomicUsize>,
}

impl Visits {
    fn new(width: u32, height: u32) -> Visits {
        Visits { width, panic_at: None, count: (0..width * height).map(|_| AtomicUsize::new(0)).collect() }
    }
}

/// Makes and drops are counted; not `Send`, as scratch need not be.
struct Buffer<'a> {
    alive: &'a AtomicUsize,
    uses: Cell<usize>,
}

impl Drop for Buffer<'_> {
    fn drop(&mut self) {
        self.alive.fetch_sub(1, Ordering::SeqCst);
    }
}

impl<'a> TileTask for Counting<'a> {
    type Frame = Visits;
    type Scratch = Buffer<'a>;
    type Output = usize;

    fn scratch(&self, _worker: usize) -> Buffer<'a> {
        self.alive.fetch_add(1, Ordering::SeqCst);
        Buffer { alive: self.alive, uses: Cell::new(0) }
    }

    fn run(&self, frame: &Visits, tile: Tile, scratch: &mut Buffer<'a>) -> usize {
        scratch.uses.set(scratch.uses.get() + 1);
        assert!(frame.panic_at != Some((tile.x, tile.y)), "no tile at {} {}", tile.x, tile.y);
        for y in tile.y..tile.y + tile.height {
            for x in tile.x..tile.x + tile.width {
                frame.count[(y * frame.width + x) as usize].fetch_add(1, Ordering::Relaxed);
            }
        }
        tile.len()
    }
}

fn workers(count: usize) -> Placement {
    Placement::new(Machine::get(), Some(count), true)
}

fn with_counting<R>(count: usize, body: impl FnOnce(&mut Master<Counting<'_>>) -> Result<R>) -> Result<R> {
    let alive = AtomicUsize::new(0);
    let result = with_workers(&Counting { alive: &alive }, &workers(count), body);
    assert_eq!(alive.load(Ordering::SeqCst), 0, "every scratch is dropped when the workers have ended");
    result
}

#[test]
fn every_tile_is_run_exactly_once_by_one_to_eight_workers() {
    in_time(|| {
        for count in 1..=8 {
            with_counting(count, |master| {
                let tiles = tiles(100, 50, 8, Order::Hilbert);
                let (mut pixels, mut outputs) = (0, HashMap::new());
                let collect = |tile, output| {
                    pixels += output;
                    *outputs.entry(tile).or_insert(0) += 1;
                };
                let frame = Visits::new(100, 50);
                let control = Control::unattended();
                let (frame, stats) = master.run_frame(Strategy::Dynamic, frame, &tiles, &control, collect)?;
                assert!(frame.count.iter().all(|c| c.load(Ordering::Relaxed) == 1));
                assert_eq!((pixels, outputs.len()), (5000, tiles.len()));
                assert!(outputs.values().all(|&times| times == 1));
                assert_eq!(stats.workers.len(), count);
                assert_eq!(stats.workers.iter().map(|w| w.tiles).sum::<usize>(), tiles.len());
                assert!(stats.workers.iter().all(|w| w.busy_seconds <= stats.seconds));
                Ok(())
            })
            .unwrap();
        }
    });
}

#[test]
fn a_panicking_tile_is_named_and_the_next_frame_is_unaffected() {
    in_time(|| {
        with_counting(3, |master| {
            let tiles = tiles(64, 64, 8, Order::Scanline);
            let control = Control::unattended();
            for _ in 0..20 {
                let frame = Visits { panic_at: Some((16, 24)), ..Visits::new(64, 64) };
                let error =
                    master.run_frame(Strategy::Dynamic, frame, &tiles, &control, |_, _| {}).err().unwrap();
                let Error::Worker { x: 16, y: 24, width: 8, height: 8, message } = error else {
                    panic!("{error}");
                };
                assert_eq!(message, "no tile at 16 24");
                let frame = Visits::new(64, 64);
                let (frame, _) = master.run_frame(Strategy::Dynamic, frame, &tiles, &control, |_, _| {})?;
                assert!(frame.count.iter().all(|c| c.load(Ordering::Relaxed) == 1));
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn leaving_right_after_a_panic_stops_the_other_workers() {
    in_time(|| {
        let error = with_counting(4, |master| {
            let frame = Visits { panic_at: Some((0, 0)), ..Visits::new(640, 640) };
            let tiles = tiles(640, 640, 2, Order::Scanline);
            master.run_frame(Strategy::Dynamic, frame, &tiles, &Control::unattended(), |_, _| {}).map(|_| ())
        });
        assert!(matches!(error, Err(Error::Worker { x: 0, y: 0, .. })));
    });
}

#[test]
fn cancelling_ends_the_frame_and_keeps_the_workers() {
    in_time(|| {
        with_counting(4, |master| {
            let tiles = tiles(64, 64, 4, Order::Hilbert);
            let cancel = AtomicBool::new(false);
            let finished = Cell::new(0);
            let progress = |p: Progress| {
                finished.set(p.done);
                cancel.store(p.done >= 10, Ordering::Relaxed);
            };
            let control = Control::new(&cancel, &progress);
            let result =
                master.run_frame(Strategy::Dynamic, Visits::new(64, 64), &tiles, &control, |_, _| {});
            assert!(matches!(result, Err(Error::Interrupted)));
            assert!((10..14).contains(&finished.get()), "{} tiles ran", finished.get());

            let result =
                master.run_frame(Strategy::Dynamic, Visits::new(64, 64), &tiles, &control, |_, _| panic!());
            assert!(matches!(result, Err(Error::Interrupted)), "a frame that is cancelled before it starts");

            let whole = master.run_frame(
                Strategy::Dynamic,
                Visits::new(64, 64),
                &tiles,
                &Control::unattended(),
                |_, _| {},
            );
            assert!(whole.is_ok());
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn progress_counts_every_tile_on_the_masters_thread() {
    in_time(|| {
        let (cancel, seen, here) = (AtomicBool::new(false), Cell::new(0), std::thread::current().id());
        let progress = |p: Progress| {
            assert_eq!(std::thread::current().id(), here);
            assert_eq!((p.done, p.total), (seen.get() + 1, 64));
            seen.set(p.done);
        };
        with_counting(3, |master| {
            let tiles = tiles(64, 64, 8, Order::Hilbert);
            let control = Control::new(&cancel, &progress);
            master.run_frame(Strategy::Dynamic, Visits::new(64, 64), &tiles, &control, |_, _| {})
        })
        .unwrap();
        assert_eq!(seen.get(), 64);
    });
}

#[test]
fn no_tiles_and_fewer_tiles_than_workers_are_fine() {
    in_time(|| {
        with_counting(8, |master| {
            let control = Control::unattended();
            for (size, expected) in [(0, 0), (1, 1)] {
                let tiles = tiles(size, size, 16, Order::Hilbert);
                let frame = Visits::new(size, size);
                let (_, stats) = master.run_frame(Strategy::Dynamic, frame, &tiles, &control, |_, _| {})?;
                assert_eq!(stats.workers.iter().map(|w| w.tiles).sum::<usize>(), expected);
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn hundreds_of_small_frames_run_on_the_same_workers() {
    in_time(|| {
        with_counting(4, |master| {
            let tiles = tiles(4, 4, 1, Order::Hilbert);
            for _ in 0..500 {
                let (frame, _) = master.run_frame(
                    Strategy::Dynamic,
                    Visits::new(4, 4),
                    &tiles,
                    &Control::unattended(),
                    |_, _| {},
                )?;
                assert!(frame.count.iter().all(|c| c.load(Ordering::Relaxed) == 1));
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn a_panic_while_collecting_is_survived_inside_and_outside_the_body() {
    in_time(|| {
        let outside = catch_unwind(|| {
            with_counting(4, |master| {
                let tiles = tiles(64, 64, 4, Order::Hilbert);
                let control = Control::unattended();
                let inside = catch_unwind(AssertUnwindSafe(|| {
                    master.run_frame(
                        Strategy::Dynamic,
                        Visits::new(64, 64),
                        &tiles,
                        &control,
                        |_, _| panic!(),
                    )
                }));
                assert!(inside.is_err());
                let mut collected = 0;
                let count = |_, _| collected += 1;
                let (frame, _) =
                    master.run_frame(Strategy::Dynamic, Visits::new(64, 64), &tiles, &control, count)?;
                assert!(frame.count.iter().all(|c| c.load(Ordering::Relaxed) == 1));
                assert_eq!(collected, tiles.len());
                if collected > 0 {
                    panic!("out of the body");
                }
                Ok(())
            })
        });
        assert!(outside.is_err());
    });
}

#[test]
fn a_worker_is_pinned_where_the_system_allows_it_and_the_caller_never_is() {
    in_time(|| {
        let before = std::thread::available_parallelism().unwrap();
        with_counting(Machine::get().default_workers() + 1, |master| {
            assert_eq!(master.pinned().len(), master.workers());
            assert!(master.pinned().iter().all(|p| !matches!(p, Pinned::Refused(_))));
            Ok(())
        })
        .unwrap();
        assert_eq!(std::thread::available_parallelism().unwrap(), before);
    });
}

/// A task that borrows what is not `'static` and whose scratch cannot be made.
struct NoScratch<'a>(&'a str);

impl TileTask for NoScratch<'_> {
    type Frame = ();
    type Scratch = ();
    type Output = ();

    fn scratch(&self, _worker: usize) {
        panic!("{}", self.0);
    }

    fn run(&self, (): &(), _tile: Tile, (): &mut ()) {}
}

#[test]
fn scratch_that_cannot_be_made_fails_the_first_tile() {
    in_time(|| {
        let text = String::from("no memory");
        let tiles = tiles(8, 8, 8, Order::Hilbert);
        let result = with_workers(&NoScratch(&text), &workers(2), |master| {
            master.run_frame(Strategy::Dynamic, (), &tiles, &Control::unattended(), |_, ()| {})
        });
        let message = result.err().unwrap().to_string();
        assert!(message.starts_with("tile at (0, 0) of 8x8 pixels failed: no memory;"), "{message}");
    });
}

#[test]
fn an_unknown_strategy_is_answered_with_the_available_ones() {
    let message = "stealing".parse::<Strategy>().unwrap_err().to_string();
    assert_eq!(message, "--schedule: 'stealing' is not available; use one of: dynamic");
}
