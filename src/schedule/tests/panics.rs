//! Tiles and callbacks that panic.

use super::super::*;
use super::{Mishap, Visits, check_frame, in_time, with_counting};
use crate::error::Error;
use crate::tile::{Order, tiles};
use std::panic::{AssertUnwindSafe, catch_unwind};

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
