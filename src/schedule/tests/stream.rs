//! Several frames in flight.

use super::super::*;
use super::{Counting, Mishap, Visits, in_time, with_counting};
use crate::error::{Error, Result};
use crate::tile::{Order, Tile, tiles};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

const SIZE: u32 = 40;
const SIDE: u32 = 8;

/// Gives `count` frames, of which some have a mishap; checks what comes back.
struct Frames {
    count: usize,
    mishap: Option<(usize, Mishap)>,
    given: usize,
    /// In the order in which they came back: the number of each, and whether each of its pixels was visited once.
    back: Vec<(usize, bool)>,
    collected: usize,
    panic_at: Option<usize>,
}

impl Frames {
    fn new(count: usize) -> Frames {
        Frames { count, mishap: None, given: 0, back: vec![], collected: 0, panic_at: None }
    }
}

impl Source<Counting<'_>> for Frames {
    fn next(&mut self) -> Option<Visits> {
        let number = self.given;
        self.given += usize::from(number < self.count);
        let frame = Visits::new(SIZE, SIZE).numbered(number);
        let mishap = self.mishap.filter(|&(at, _)| at == number);
        (number < self.count).then(|| match mishap {
            Some((_, mishap)) => frame.with(0, 0, mishap),
            None => frame,
        })
    }

    fn more(&self) -> bool {
        self.given < self.count
    }

    fn collect(&mut self, _: &Visits, tile: Tile, output: &mut usize) {
        assert_eq!(*output, tile.len());
        self.collected += 1;
        assert_ne!(Some(self.collected), self.panic_at, "the master breaks");
    }

    fn done(&mut self, frame: Visits) {
        self.back.push((frame.number, frame.whole()));
    }
}

fn stream(
    master: &mut Master<Counting<'_>>,
    schedule: Schedule,
    in_flight: usize,
    frames: &mut Frames,
    control: &Control<'_>,
) -> Result<FrameStats> {
    master.run_stream(schedule, in_flight, &tiles(SIZE, SIZE, SIDE, Order::Hilbert), control, frames)
}

/// A stream of `count` frames is whole, in order, and its figures fit.
fn check_stream(master: &mut Master<Counting<'_>>, schedule: Schedule, in_flight: usize, count: usize) {
    let mut frames = Frames::new(count);
    let stats = stream(master, schedule, in_flight, &mut frames, &Control::unattended()).unwrap();
    let expected: Vec<(usize, bool)> = (0..count).map(|number| (number, true)).collect();
    assert_eq!(frames.back, expected, "{schedule:?}");
    assert_eq!((stats.frames, stats.spans.len()), (count, frames.collected));
    for number in 0..count {
        let of = stats.spans.iter().filter(|span| span.frame == number);
        assert_eq!(of.map(|span| span.tile.len()).sum::<usize>(), (SIZE * SIZE) as usize, "{schedule:?}");
    }
    assert_eq!(stats.workers.iter().map(|w| w.tiles).sum::<usize>(), stats.spans.len());
    for worker in &stats.workers {
        let Idle { start, work, deliver, tail } = worker.idle;
        assert!(worker.busy_seconds + start + work + deliver + tail <= stats.seconds * 1.001 + 1e-6);
    }
}

#[test]
fn every_tile_of_every_frame_is_run_once_and_frames_come_back_in_order() {
    in_time(|| {
        for workers in [1, 2, 3, 8] {
            with_counting(workers, |master| {
                for schedule in Schedule::all() {
                    for (in_flight, count) in [(0, 2), (1, 3), (2, 0), (2, 1), (2, 5), (3, 7), (5, 3)] {
                        check_stream(master, schedule, in_flight, count);
                    }
                }
                Ok(())
            })
            .unwrap();
        }
    });
}

#[test]
fn sixty_four_workers_share_frames_in_flight() {
    in_time(|| {
        with_counting(64, |master| {
            Schedule::all().for_each(|schedule| check_stream(master, schedule, 3, 4));
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn while_a_tile_is_slow_the_others_are_on_the_next_frame() {
    in_time(|| {
        with_counting(2, |master| {
            for schedule in Schedule::all() {
                for in_flight in [1, 2] {
                    let mut frames = Frames::new(2);
                    frames.mishap = Some((0, Mishap::Sleep(Duration::from_millis(200))));
                    let stats = stream(master, schedule, in_flight, &mut frames, &Control::unattended())?;
                    assert_eq!(frames.back, [(0, true), (1, true)], "the slow one comes back first");
                    let slow = stats.spans.iter().find(|span| (span.tile.x, span.tile.y) == (0, 0)).unwrap();
                    let meanwhile =
                        stats.spans.iter().filter(|span| span.frame == 1 && span.start < slow.end).count();
                    assert_eq!(meanwhile > 0, in_flight == 2, "{schedule:?}: {meanwhile}");
                }
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn a_panic_ends_the_stream_and_the_frames_before_it_are_kept() {
    in_time(|| {
        with_counting(3, |master| {
            for schedule in Schedule::all() {
                let mut frames = Frames::new(6);
                frames.mishap = Some((3, Mishap::Panic));
                let error = stream(master, schedule, 2, &mut frames, &Control::unattended()).unwrap_err();
                assert!(matches!(error, Error::Worker { x: 0, y: 0, .. }), "{schedule:?}: {error}");
                assert!(frames.back.len() <= 3 && frames.back.iter().all(|&(_, whole)| whole));
                assert!(frames.given <= 5, "no frame is begun behind the two in flight");
                check_stream(master, schedule, 2, 3);
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn a_cancelled_stream_ends_and_the_next_one_is_whole() {
    in_time(|| {
        with_counting(3, |master| {
            for schedule in Schedule::all() {
                let cancel = AtomicBool::new(false);
                let progress = |p: Progress| {
                    assert!(0 < p.done && p.done <= p.total, "of one frame");
                    cancel.store(p.done >= 10, Ordering::Relaxed);
                };
                let mut frames = Frames::new(1000);
                let result = stream(master, schedule, 3, &mut frames, &Control::new(&cancel, &progress));
                assert!(matches!(result, Err(Error::Interrupted)), "{schedule:?}");
                assert!(frames.given < 1000);
                check_stream(master, schedule, 3, 4);
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn a_source_that_panics_leaves_nothing_behind() {
    in_time(|| {
        with_counting(3, |master| {
            for schedule in Schedule::all() {
                let mut frames = Frames::new(6);
                frames.panic_at = Some(30);
                let broken = catch_unwind(AssertUnwindSafe(|| {
                    stream(master, schedule, 3, &mut frames, &Control::unattended())
                }));
                assert!(broken.is_err());
                check_stream(master, schedule, 3, 4);
            }
            Ok(())
        })
        .unwrap();
    });
}

#[test]
fn only_those_employed_take_part_and_are_counted_from_0() {
    in_time(|| {
        with_counting(4, |master| {
            for schedule in Schedule::all() {
                for employed in [1..2, 2..4, 0..9, 0..1] {
                    let count = employed.len().min(4);
                    master.employ(employed);
                    check_stream(master, schedule, 2, 3);
                    let mut frames = Frames::new(2);
                    let stats = stream(master, schedule, 1, &mut frames, &Control::unattended())?;
                    assert_eq!(stats.workers.len(), count, "{schedule:?}");
                    assert!(stats.spans.iter().all(|span| span.worker < count));
                }
            }
            master.employ(9..10);
            let nobody = stream(master, Schedule::default(), 1, &mut Frames::new(1), &Control::unattended());
            assert!(matches!(nobody, Err(Error::Failed(_))));
            Ok(())
        })
        .unwrap();
    });
}

/// Gives one frame, and cancels when it is handed back.
struct Cancels<'a> {
    left: Option<Visits>,
    cancel: &'a AtomicBool,
}

impl Source<Counting<'_>> for Cancels<'_> {
    fn next(&mut self) -> Option<Visits> {
        self.left.take()
    }

    fn more(&self) -> bool {
        false
    }

    fn collect(&mut self, _: &Visits, _: Tile, _: &mut usize) {}

    fn done(&mut self, _: Visits) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

#[test]
fn the_flag_is_looked_at_once_more_at_the_end() {
    in_time(|| {
        with_counting(2, |master| {
            let cancel = AtomicBool::new(false);
            let mut source = Cancels { left: Some(Visits::new(SIZE, SIZE)), cancel: &cancel };
            let tiles = tiles(SIZE, SIZE, SIDE, Order::Hilbert);
            let control = Control::new(&cancel, &|_| {});
            let result = master.run_stream(Schedule::default(), 1, &tiles, &control, &mut source);
            assert!(matches!(result, Err(Error::Interrupted)));
            Ok(())
        })
        .unwrap();
    });
}
