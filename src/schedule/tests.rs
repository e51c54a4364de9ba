//! The protocol on real threads: load, panics, cancellation. Every test has a deadline: a hang is a failure.

mod ahead;
mod cancel;
mod dying;
mod figures;
mod panics;
mod stream;

use super::*;
use crate::error::Result;
use crate::tile::{Order, tiles};
use std::cell::Cell;
use std::collections::HashMap;
use std::panic::panic_any;
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
    number: usize,
    width: u32,
    mishap: Option<(u32, u32, Mishap)>,
    count: Vec<AtomicUsize>,
}

impl Visits {
    fn new(width: u32, height: u32) -> Visits {
        let count = (0..width * height).map(|_| AtomicUsize::new(0)).collect();
        Visits { number: 0, width, mishap: None, count }
    }

    fn with(self, x: u32, y: u32, mishap: Mishap) -> Visits {
        Visits { mishap: Some((x, y, mishap)), ..self }
    }

    fn numbered(self, number: usize) -> Visits {
        Visits { number, ..self }
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
fn reports_of_a_stolen_frame_are_awaited_by_nobody() {
    in_time(|| {
        with_counting(4, |master| {
            // Of those that wake the master it is known how long they were on their way.
            for (film, wakes) in [(FilmMode::Shared, false), (FilmMode::Messages, true)] {
                let schedule = Schedule { strategy: Strategy::Stealing, film };
                let stats = check_frame(master, schedule, [128, 128], 8);
                assert!(stats.reports.count >= 4 && (stats.reports.awaited > 0) == wakes, "{stats:?}");
            }
            Ok(())
        })
        .unwrap();
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
