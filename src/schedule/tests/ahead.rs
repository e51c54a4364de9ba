//! What the master knows before, deals ahead, and is told in between.

use super::super::*;
use super::{Counting, Mishap, Visits, in_time, with_counting};
use crate::tile::{Order, Tile, tiles};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// The tiles of a frame that sleeps at (x, y) for so long, in the order in which one worker ran them.
fn order(master: &mut Master<Counting<'_>>, [x, y]: [u32; 2], sleep: u64) -> Vec<Tile> {
    let schedule = Schedule { strategy: Strategy::CostGuided, film: FilmMode::Shared };
    let frame = Visits::new(64, 64).with(x, y, Mishap::Sleep(Duration::from_millis(sleep)));
    let tiles = tiles(64, 64, 16, Order::Scanline);
    let (_, stats) = master.run_frame(schedule, frame, &tiles, &Control::unattended(), |_, _, _| {}).unwrap();
    stats.spans.iter().map(|span| span.tile).collect()
}

#[test]
fn the_dearest_tile_of_the_last_frame_is_dealt_first_and_older_frames_are_forgotten() {
    in_time(|| {
        with_counting(1, |master| {
            order(master, [16, 0], 200);
            let second = order(master, [32, 48], 60)[0];
            assert_eq!((second.x, second.y), (16, 0));
            let third = order(master, [0, 0], 0)[0];
            assert_eq!((third.x, third.y), (32, 48));
            Ok(())
        })
        .unwrap();
    });
}

/// As many frames as are left.
struct Left(usize);

impl Source<Counting<'_>> for Left {
    fn next(&mut self) -> Option<Visits> {
        self.0 = self.0.checked_sub(1)?;
        Some(Visits::new(256, 256))
    }

    fn more(&self) -> bool {
        self.0 > 0
    }

    fn collect(&mut self, _: &Visits, _: Tile, _: &mut usize) {}

    fn done(&mut self, frame: Visits) {
        assert!(frame.whole());
    }
}

#[test]
fn only_the_end_that_another_frame_overlaps_is_not_cut() {
    in_time(|| {
        for (in_flight, cut) in [(1, [true, true]), (2, [false, true])] {
            with_counting(4, |master| {
                let schedule = Schedule { strategy: Strategy::Refinement, film: FilmMode::Shared };
                let tiles = tiles(256, 256, 64, Order::Hilbert);
                let stats =
                    master.run_stream(schedule, in_flight, &tiles, &Control::unattended(), &mut Left(2))?;
                let of = |frame| stats.spans.iter().filter(|span| span.frame == frame).count();
                assert_eq!([0, 1].map(|frame| of(frame) > tiles.len()), cut, "{in_flight} in flight");
                Ok(())
            })
            .unwrap();
        }
    });
}

#[test]
fn a_worker_has_its_next_task_while_the_master_is_busy_with_the_last_one() {
    in_time(|| {
        for film in FilmMode::ALL {
            with_counting(1, |master| {
                let schedule = Schedule { strategy: Strategy::NonBlocking, film };
                let tiles = tiles(16, 8, 8, Order::Scanline);
                let mut first = true;
                let collect = |frame: &Visits, _: Tile, _: &mut usize| {
                    let deadline = Instant::now() + Duration::from_secs(60);
                    while first && !frame.whole() {
                        assert!(Instant::now() < deadline, "{film}: the second tile does not come");
                        std::thread::yield_now();
                    }
                    first = false;
                };
                master.run_frame(schedule, Visits::new(16, 8), &tiles, &Control::unattended(), collect)?;
                Ok(())
            })
            .unwrap();
        }
    });
}

#[test]
fn results_are_told_before_a_long_task_ends() {
    in_time(|| {
        with_counting(1, |master| {
            // With its only parcel on the way, the worker waits: at the first report nothing but the slow tile is done.
            let schedule = Schedule { strategy: Strategy::Static, film: FilmMode::Shared };
            let frame = Visits::new(64, 64).with(0, 0, Mishap::Sleep(Duration::from_millis(100)));
            let tiles = tiles(64, 64, 8, Order::Scanline);
            let mut visited = vec![];
            let collect = |frame: &Visits, _: Tile, _: &mut usize| {
                visited.push(frame.count.iter().filter(|count| count.load(Ordering::Relaxed) > 0).count());
            };
            master.run_frame(schedule, frame, &tiles, &Control::unattended(), collect)?;
            assert_eq!(visited[0], 64);
            Ok(())
        })
        .unwrap();
    });
}
