//! The protocol on real threads: load, panics, cancellation. Every test has a deadline: a hang is a failure.

mod dying;

use super::*;
use crate::error::{Error, Result};
use crate::tile::{Order, tiles};
use std::cell::Cell;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind, panic_any};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// Runs `test` on its own thread and fails if it hangs. The deadline is far off, because the machine may be busy.
fn in_time<R: Send + 'static>(test: impl FnOnce() -> R + Send + 'static) -> R {
    let (done, finished) = mpsc::channel();
    std::thread::spawn(move || done.send(test()));
    finished.recv_timeout(Duration::from_secs(300)).expect("panicked or hung")
}

/// What a tile does besides being counted.
#[derive(Clone, Copy)]
enum Mishap {
    Panic,
    /// Panics with a payload that panics when it is dropped.
    Bomb,
    Sleep(Duration),
}

/// Counts visits in the frame.
struct Counting<'a> {
    alive: &'a AtomicUsize,
}

struct Visits {
    width: u32,
    mishap: Option<(u32, u32, Mishap)>,
    count: Vec<AtomicUsize>,
}

impl Visits {
    fn new(width: u32, height: u32) -> Visits {
        Visits { width, mishap: None, count: (0..width * height).map(|_| AtomicUsize::new(0)).collect() }
    }

    fn with(self, x: u32, y: u32, mishap: Mishap) -> Visits {
        Visits { mishap: Some((x, y, mishap)), ..self }
    }

    fn whole(&self) -> bool {
        self.count.iter().all(|count| count.load(Ordering::Relaxed) == 1)
    }
}

/// Makes and drops are counted; not `Send`, as scratch need not be.
struct Buffer<'a> {
    alive: &'a AtomicUsize,
    /// A tile panicked while it used this.
    spoilt: Cell<bool>,
}

impl Drop for Buffer<'_> {
    fn drop(&mut self) {
        self.alive.fetch_sub(1, Ordering::SeqCst);
    }
}

struct Bomb;

impl Drop for Bomb {
    fn drop(&mut self) {
        panic!("again");
    }
}

impl<'a> TileTask for Counting<'a> {
    type Frame = Visits;
    type Scratch = Buffer<'a>;
    type Output = usize;

    fn scratch(&self, _worker: usize) -> Buffer<'a> {
        self.alive.fetch_add(1, Ordering::SeqCst);
        Buffer { alive: self.alive, spoilt: Cell::new(false) }
    }

    fn run(&self, frame: &Visits, tile: Tile, scratch: &mut Buffer<'a>, output: &mut usize) {
        assert!(!scratch.spoilt.get(), "after a panic there is a new one");
        scratch.spoilt.set(true);
        match frame.mishap {
            // Wherever the strategy cut.
            Some((x, y, mishap)) if tile.x <= x && x < tile.x + tile.width && tile.y == y => match mishap {
                Mishap::Panic => panic!("no tile at {x} {y}"),
                Mishap::Bomb => panic_any(Bomb),
                Mishap::Sleep(time) => std::thread::sleep(time),
            },
            _ => {}
        }
        for y in tile.y..tile.y + tile.height {
            for x in tile.x..tile.x + tile.width {
                frame.count[(y * frame.width + x) as usize].fetch_add(1, Ordering::Relaxed);
            }
        }
        *output = tile.len();
        scratch.spoilt.set(false);
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

/// Runs a frame and checks that it is whole, and its figures.
fn check_frame(
    master: &mut Master<Counting<'_>>,
    schedule: Schedule,
    size: [u32; 2],
    side: u32,
) -> FrameStats {
    let [width, height] = size;
    let tiles = tiles(width, height, side, Order::Hilbert);
    let (mut pixels, mut outputs) = (0, HashMap::new());
    let collect = |_: &Visits, tile: Tile, output: &mut usize| {
        assert_eq!(*output, tile.len());
        pixels += *output;
        *outputs.entry(tile).or_insert(0) += 1;
    };
    let control = Control::unattended();
    let (frame, stats) =
        master.run_frame(schedule, Visits::new(width, height), &tiles, &control, collect).unwrap();
    assert!(frame.whole(), "{schedule:?}");
    assert_eq!(pixels as u32, width * height);
    assert!(outputs.len() >= tiles.len() && outputs.values().all(|&times| times == 1));
    assert_eq!(stats.workers.iter().map(|w| w.tiles).sum::<usize>(), outputs.len());
    assert_eq!(stats.spans.len(), outputs.len());
    match schedule.film {
        FilmMode::Messages => assert!(stats.reports.count >= outputs.len(), "a message for each tile"),
        FilmMode::Shared => assert!(stats.reports.count >= stats.tasks.count, "a message for each task"),
    }
    for worker in &stats.workers {
        let Idle { start, work, deliver, tail } = worker.idle;
        assert!([worker.busy_seconds, start, work, deliver, tail].iter().all(|&seconds| seconds >= 0.0));
        assert!(worker.busy_seconds + start + work + deliver + tail <= stats.seconds * 1.001 + 1e-6);
    }
    stats
}

#[test]
fn every_tile_is_run_exactly_once_whatever_the_schedule() {
    in_time(|| {
        for count in [1, 2, 3, 8] {
            with_counting(count, |master| {
                for schedule in Schedule::all() {
                    // No tile, one tile, fewer tiles than workers, many.
                    for (width, height, side) in [(0, 0, 8), (1, 1, 8), (20, 10, 8), (100, 50, 8)] {
                        check_frame(master, schedule, [width, height], side);
                    }
                }
                Ok(())
            })
            .unwrap();
        }
    });
}

#[test]
fn many_more_workers_than_cores_finish() {
    in_time(|| {
        with_counting(64, |master| {
            Schedule::all().for_each(|schedule| drop(check_frame(master, schedule, [128, 128], 8)));
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn a_panicking_tile_is_named_and_the_next_frame_is_unaffected() {
    in_time(|| {
        with_counting(3, |master| {
            let tiles = tiles(64, 64, 8, Order::Scanline);
            let control = Control::unattended();
            for schedule in Schedule::all() {
                for (mishap, expected) in
                    [(Mishap::Panic, "no tile at 16 24"), (Mishap::Bomb, "a panic without a message")]
                {
                    let frame = Visits::new(64, 64).with(16, 24, mishap);
                    let error =
                        master.run_frame(schedule, frame, &tiles, &control, |_, _, _| {}).err().unwrap();
                    let Error::Worker { x: 16, y: 24, width: 8, height: 8, message } = error else {
                        panic!("{schedule:?}: {error}");
                    };
                    assert_eq!(message, expected);
                    check_frame(master, schedule, [64, 64], 8);
                }
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn leaving_right_after_a_panic_stops_the_other_workers() {
    in_time(|| {
        for schedule in Schedule::all() {
            let error = with_counting(4, |master| {
                let frame = Visits::new(640, 640).with(0, 0, Mishap::Panic);
                let tiles = tiles(640, 640, 8, Order::Scanline);
                master.run_frame(schedule, frame, &tiles, &Control::unattended(), |_, _, _| {}).map(|_| ())
            });
            assert!(matches!(error, Err(Error::Worker { x: 0, y: 0, .. })), "{schedule:?}");
        }
    });
}

#[test]
fn a_slow_tile_holds_up_only_its_own_worker() {
    in_time(|| {
        with_counting(2, |master| {
            // Static strategies leave the tiles behind a slow one to its worker, whatever happens.
            let asks = |s: &Schedule| !matches!(s.strategy, Strategy::Static | Strategy::StaticCyclic);
            for schedule in Schedule::all().filter(asks) {
                check_frame(master, schedule, [64, 64], 8);
                let frame = Visits::new(64, 64).with(0, 0, Mishap::Sleep(Duration::from_millis(300)));
                let tiles = tiles(64, 64, 8, Order::Scanline);
                let (_, stats) =
                    master.run_frame(schedule, frame, &tiles, &Control::unattended(), |_, _, _| {})?;
                let slow = stats.spans.iter().find(|span| (span.tile.x, span.tile.y) == (0, 0)).unwrap();
                // What its task holds, and the task behind it, is all that had to wait for the slow one.
                let late = stats.spans.iter().filter(|span| span.start > slow.end).count();
                let most = if schedule.strategy.shrinks() { 24 } else { 2 };
                assert!(late <= most, "{schedule:?}: {late} tiles waited");
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn cancelling_ends_the_frame_and_keeps_the_workers() {
    in_time(|| {
        with_counting(4, |master| {
            let tiles = tiles(64, 64, 4, Order::Hilbert);
            for schedule in Schedule::all() {
                let cancel = AtomicBool::new(false);
                let progress = |p: Progress| cancel.store(p.done >= 10, Ordering::Relaxed);
                let control = Control::new(&cancel, &progress);
                let frame = Visits::new(64, 64);
                let result = master.run_frame(schedule, frame, &tiles, &control, |_, _, _| {});
                assert!(matches!(result, Err(Error::Interrupted)), "{schedule:?}");
                let early =
                    master.run_frame(schedule, Visits::new(64, 64), &tiles, &control, |_, _, _| panic!());
                assert!(
                    matches!(early, Err(Error::Interrupted)),
                    "a frame that is cancelled before it starts"
                );
                check_frame(master, schedule, [64, 64], 4);
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn after_a_cancellation_no_worker_begins_another_tile() {
    in_time(|| {
        with_counting(1, |master| {
            // With one parcel only, the worker has to wait for the master after each tile.
            for strategy in [Strategy::Static, Strategy::StaticCyclic] {
                let schedule = Schedule { strategy, film: FilmMode::Messages };
                let cancel = AtomicBool::new(false);
                let progress = |_: Progress| cancel.store(true, Ordering::Relaxed);
                let control = Control::new(&cancel, &progress);
                let (tiles, mut ran) = (tiles(64, 64, 4, Order::Scanline), 0);
                let frame = Visits::new(64, 64);
                let result = master.run_frame(schedule, frame, &tiles, &control, |_, _, _| ran += 1);
                assert!(matches!(result, Err(Error::Interrupted)), "{schedule:?}");
                assert_eq!(ran, 1, "{schedule:?}");
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn the_flag_is_seen_while_no_report_comes() {
    in_time(|| {
        with_counting(2, |master| {
            for schedule in
                Schedule::all().filter(|s| matches!(s.strategy, Strategy::Static | Strategy::StaticCyclic))
            {
                let cancel = AtomicBool::new(false);
                let tiles = tiles(64, 64, 1, Order::Scanline);
                let mut ran = 0;
                std::thread::scope(|scope| {
                    scope.spawn(|| {
                        std::thread::sleep(Duration::from_millis(50));
                        cancel.store(true, Ordering::Relaxed);
                    });
                    // The first worker sits on its first tile while the flag is set; the others are behind it.
                    let frame = Visits::new(64, 64).with(0, 0, Mishap::Sleep(Duration::from_millis(500)));
                    let control = Control::new(&cancel, &|_| {});
                    let result = master.run_frame(schedule, frame, &tiles, &control, |_, _, _| ran += 1);
                    assert!(matches!(result, Err(Error::Interrupted)), "{schedule:?}");
                });
                assert!(ran <= 1 + 64 * 32, "{schedule:?}: {ran} tiles ran");
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn progress_counts_every_tile_on_the_masters_thread() {
    in_time(|| {
        for schedule in Schedule::all() {
            let (cancel, seen) = (AtomicBool::new(false), Cell::new(0));
            let here = std::thread::current().id();
            let progress = |p: Progress| {
                assert_eq!(std::thread::current().id(), here);
                assert_eq!(p.done, seen.get() + 1);
                assert!(p.total >= 64);
                seen.set(p.done);
            };
            with_counting(3, |master| {
                let tiles = tiles(64, 64, 8, Order::Hilbert);
                let control = Control::new(&cancel, &progress);
                master.run_frame(schedule, Visits::new(64, 64), &tiles, &control, |_, _, _| {})
            })
            .unwrap();
            assert!(seen.get() >= 64);
        }
    });
}

#[test]
fn hundreds_of_small_frames_run_on_the_same_workers() {
    in_time(|| {
        with_counting(4, |master| {
            for _ in 0..40 {
                Schedule::all().for_each(|schedule| drop(check_frame(master, schedule, [4, 4], 1)));
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn a_panic_while_collecting_is_survived_inside_and_outside_the_body() {
    in_time(|| {
        for schedule in Schedule::all() {
            let outside = catch_unwind(|| {
                with_counting(4, |master| {
                    let tiles = tiles(64, 64, 4, Order::Hilbert);
                    let control = Control::unattended();
                    let inside = catch_unwind(AssertUnwindSafe(|| {
                        master.run_frame(schedule, Visits::new(64, 64), &tiles, &control, |_, _, _| panic!())
                    }));
                    assert!(inside.is_err());
                    let stats = check_frame(master, schedule, [64, 64], 4);
                    if stats.seconds > 0.0 {
                        panic!("out of the body");
                    }
                    Ok(())
                })
            });
            let message = *outside.unwrap_err().downcast::<&str>().unwrap();
            assert_eq!(message, "out of the body", "{schedule:?}");
        }
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
