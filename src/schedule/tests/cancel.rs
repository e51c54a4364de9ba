//! Slow tiles, and frames that are no longer wanted.

use super::super::*;
use super::{Mishap, Visits, check_frame, in_time, with_counting};
use crate::error::Error;
use crate::tile::{Order, tiles};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

#[test]
fn a_slow_tile_holds_up_only_its_own_worker() {
    in_time(|| {
        // Static strategies leave the tiles behind a slow one to its worker, whatever happens.
        let asks = |s: &Schedule| !matches!(s.strategy, Strategy::Static | Strategy::StaticCyclic);
        for schedule in Schedule::all().filter(asks) {
            // A new master knows no costs: those of a frame on a busy machine would decide how many tiles a task has.
            with_counting(2, |master| {
                let frame = Visits::new(64, 64).with(0, 0, Mishap::Sleep(Duration::from_millis(300)));
                let tiles = tiles(64, 64, 8, Order::Scanline);
                let (_, stats) =
                    master.run_frame(schedule, frame, &tiles, &Control::unattended(), |_, _, _| {})?;
                let slow = stats.spans.iter().find(|span| (span.tile.x, span.tile.y) == (0, 0)).unwrap();
                // What its task holds, and the task behind it, is all that had to wait for the slow one.
                let late = stats.spans.iter().filter(|span| span.start > slow.end).count();
                let most = if schedule.strategy.shrinks() { 24 } else { 2 };
                assert!(late <= most, "{schedule:?}: {late} tiles waited");
                Ok(())
            })
            .unwrap();
        }
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
        with_counting(1, |master| {
            // A worker with several parcels does not wait until its report is read: it goes on unless it is stopped already.
            let goes_on = |s: &Schedule| s.strategy.parcels() > 1 && s.film == FilmMode::Shared;
            for schedule in Schedule::all().filter(goes_on) {
                let cancel = AtomicBool::new(false);
                let tiles = tiles(64, 64, 1, Order::Scanline);
                let mut ran = 0;
                std::thread::scope(|scope| {
                    scope.spawn(|| {
                        std::thread::sleep(Duration::from_millis(50));
                        cancel.store(true, Ordering::Relaxed);
                    });
                    // The worker sits on its first tile while the flag is set.
                    let frame = Visits::new(64, 64).with(0, 0, Mishap::Sleep(Duration::from_millis(400)));
                    let control = Control::new(&cancel, &|_| {});
                    let result = master.run_frame(schedule, frame, &tiles, &control, |_, _, _| ran += 1);
                    assert!(matches!(result, Err(Error::Interrupted)), "{schedule:?}");
                });
                assert_eq!(ran, 1, "{schedule:?}");
            }
            Ok(())
        })
        .unwrap();
    });
}
