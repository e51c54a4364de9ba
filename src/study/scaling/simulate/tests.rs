//! The simulator where its answer is known.

use super::*;
use crate::schedule::CostMap;
use crate::schedule::{FilmMode, Idle, SharedCore};
use crate::study::scaling::costs::NOTHING;
use crate::tile::{Order, Tile, tiles};

const FREE: Costs = NOTHING;
const SHARED: SharedCore = NOTHING.shared;

/// Every pixel costs one, in tiles of 4x4.
fn frame(schedule: Schedule, workers: usize, side: u32, costs: &Costs) -> FrameStats {
    stream(schedule, workers, Flow::ONE, side, costs)
}

fn stream(schedule: Schedule, workers: usize, flow: Flow, side: u32, costs: &Costs) -> FrameStats {
    let tiles = tiles(side, side, 4, Order::Hilbert);
    let replay = |end| {
        let plan = Plan::new(schedule.strategy, workers, end, &tiles, &CostMap::default());
        let seconds = plan.tiles.iter().map(|tile| tile.len() as f64).collect();
        Replay { plan, seconds }
    };
    simulate(schedule, &vec![1.0; workers], flow, replay, costs)
}

/// A stream of tiles of 4x4 that cost so much, which are never cut.
fn given(strategy: Strategy, workers: usize, flow: Flow, seconds: &[f64], costs: &Costs) -> FrameStats {
    let side = seconds.len().isqrt() as u32 * 4;
    let tiles = tiles(side, side, 4, Order::Hilbert);
    let replay = |end| {
        let plan = Plan::new(strategy, workers, end, &tiles, &CostMap::default());
        Replay { plan, seconds: seconds.to_vec() }
    };
    simulate(Schedule { strategy, film: FilmMode::Shared }, &vec![1.0; workers], flow, replay, costs)
}

#[test]
fn every_tile_runs_once_and_no_worker_does_two_things_at_once() {
    let costs = Costs {
        to_master: 0.3,
        to_worker: 0.3,
        send: 0.1,
        reply: 0.1,
        collect: 0.2,
        steal: 0.1,
        cores: 1,
        ..FREE
    };
    for schedule in Schedule::all() {
        for workers in [1, 2, 7, 300] {
            let stats = frame(schedule, workers, 64, &costs);
            let mut tiles: Vec<Tile> = stats.spans.iter().map(|span| span.tile).collect();
            tiles.sort_by_key(|tile| (tile.y, tile.x));
            tiles.dedup();
            assert_eq!((tiles.len(), stats.spans.len()), (256, 256), "{schedule:?} {workers}");
            for worker in 0..workers {
                let mut own: Vec<&Span> = stats.spans.iter().filter(|s| s.worker == worker).collect();
                own.sort_by(|a, b| a.start.total_cmp(&b.start));
                assert!(own.windows(2).all(|pair| pair[0].end <= pair[1].start + 1e-9), "{schedule:?}");
            }
            assert!(stats.spans.iter().all(|span| span.end <= stats.seconds + 1e-9));
        }
    }
}

#[test]
fn where_nothing_costs_anything_equal_tiles_are_shared_evenly() {
    for schedule in Schedule::all() {
        for workers in [1, 2, 4, 16, 256] {
            let stats = frame(schedule, workers, 64, &FREE);
            let ideal = 64.0 * 64.0 / workers as f64;
            assert!((stats.seconds - ideal).abs() < 1e-6, "{schedule:?} {workers}: {}", stats.seconds);
        }
    }
}

#[test]
fn one_dear_tile_is_the_bound_that_stealing_reaches_and_static_does_not() {
    let seconds: Vec<f64> = (0..256).map(|i| if i < 64 { 4.0 } else { 1.0 }).collect();
    let time = |strategy| given(strategy, 4, Flow::ONE, &seconds, &FREE).seconds;
    // 448 in all; the first quarter of them takes 256.
    assert!((time(Strategy::Static) - 256.0).abs() < 1e-6);
    assert!(time(Strategy::Stealing) <= 112.0 + 4.0);
    assert!(time(Strategy::Dynamic) <= 112.0 + 4.0);
}

#[test]
fn by_hand_dynamic_pays_a_round_trip_for_each_tile_and_overlap_does_not() {
    let costs = Costs { to_master: 1.0, to_worker: 1.0, ..FREE };
    let time = |strategy, film| frame(Schedule { strategy, film }, 1, 16, &costs).seconds;
    // 16 tiles of 16: the way to the worker, the tiles, the way to the master after each, and back between them.
    for film in FilmMode::ALL {
        assert!((time(Strategy::Dynamic, film) - (1.0 + 256.0 + 16.0 + 15.0)).abs() < 1e-6);
        // The task is there, but the parcel has to come back: blocking is not what overlap overlaps.
        assert!((time(Strategy::Overlap, film) - (1.0 + 256.0 + 16.0 + 15.0)).abs() < 1e-6);
        assert!((time(Strategy::NonBlocking, film) - (1.0 + 256.0 + 1.0)).abs() < 1e-6);
        assert!((time(Strategy::Stealing, film) - (1.0 + 256.0 + 1.0)).abs() < 1e-6);
    }
}

#[test]
fn a_master_that_copies_for_too_long_holds_everybody_up() {
    let costs = Costs { per_byte: 1.0, ..FREE };
    let bytes = 64.0 * 64.0 * 12.0;
    for schedule in Schedule::all() {
        let seconds = frame(schedule, 16, 64, &costs).seconds;
        match schedule.film {
            FilmMode::Messages => assert!(seconds >= bytes, "{schedule:?} {seconds}"),
            FilmMode::Shared => assert!(seconds < 300.0, "{schedule:?} {seconds}"),
        }
    }
}

#[test]
fn by_hand_pixels_cost_what_copying_them_costs_where_the_master_is() {
    let schedule = Schedule { strategy: Strategy::StaticCyclic, film: FilmMode::Messages };
    let costs = Costs { per_byte: 0.5, copied: Some([0.25, 0.125]), ..FREE };
    let reports = |cores| frame(schedule, 3, 16, &Costs { cores, ..costs }).master.reports;
    // Sixteen tiles of 192 bytes, five of them by the worker on the master's own core, if it has none of its own.
    assert_eq!((reports(4), reports(3)), (16.0 * 96.0, 11.0 * 48.0 + 5.0 * 24.0));
    let unknown = frame(schedule, 3, 16, &Costs { copied: None, cores: 3, ..costs });
    assert_eq!(unknown.master.reports, 16.0 * 96.0, "as dear as elsewhere");
}

#[test]
fn where_only_messages_take_time_every_moment_is_a_tile_or_a_known_wait() {
    let costs = Costs { to_master: 3.0, to_worker: 3.0, per_byte: 0.01, ..FREE };
    for schedule in Schedule::all() {
        for workers in [1, 2, 5] {
            let stats = frame(schedule, workers, 64, &costs);
            for worker in &stats.workers {
                let Idle { start, work, deliver, tail } = worker.idle;
                let sum = start + worker.busy_seconds + work + deliver + tail;
                assert!(
                    (sum - stats.seconds).abs() < 1e-6,
                    "{schedule:?} {workers}: {worker:?} {}",
                    stats.seconds
                );
            }
        }
    }
}

#[test]
fn by_hand_every_step_of_a_round_trip_takes_its_time() {
    let costs = Costs {
        prepare: 5.0,
        send: 1.0,
        reply: 1.0,
        to_master: 2.0,
        to_worker: 2.0,
        collect: 3.0,
        collect_tile: 0.5,
        tile: 0.25,
        ..FREE
    };
    let schedule = Schedule { strategy: Strategy::Dynamic, film: FilmMode::Shared };
    let seconds = frame(schedule, 1, 16, &costs).seconds;
    // Before the first tile: prepare, send, latency. A tile, its bookkeeping and report: 16 + 0.25 + (1 + 2) + 3.5.
    // Then whoever sleeps is woken, 1; and but for the last time the next task is 2 on its way.
    let (before, round) = (5.0 + 1.0 + 2.0, 16.0 + 0.25 + 3.0 + 3.5 + 1.0);
    assert!((seconds - (before + 16.0 * round + 15.0 * 2.0)).abs() < 1e-6, "{seconds}");
}

#[test]
fn by_hand_a_master_without_a_core_takes_that_of_its_worker() {
    let costs = Costs { collect: 3.0, shared: SharedCore { switch: 1.0, ..SHARED }, ..FREE };
    let schedule = Schedule { strategy: Strategy::NonBlocking, film: FilmMode::Shared };
    let time = |cores| frame(schedule, 1, 16, &Costs { cores, ..costs }).seconds;
    // It is woken by half a switch; after each tile but the last one it stands still for the report and a switch.
    assert!((time(1) - (0.5 + 256.0 + 15.0 * 4.0 + 3.0)).abs() < 1e-6, "{}", time(1));
    assert!((time(2) - (256.0 + 3.0)).abs() < 1e-6, "{}", time(2));
}

#[test]
fn by_hand_the_host_of_the_master_pays_for_the_reports_of_others_and_saves_its_own_wake_ups() {
    let shared = SharedCore::punctual(0.25, 0.125, 2.0, 0.5);
    let costs = Costs { collect: 1.0, shared, to_master: 0.5, to_worker: 0.5, cores: 2, ..FREE };
    // Two tiles each, a report at the end.
    let seconds = [4.0, 4.0, 40.0, 40.0];
    let stats = given(Strategy::StaticCyclic, 2, Flow::ONE, &seconds, &costs);
    let ends = |worker| stats.spans.iter().filter(move |s| s.worker == worker).map(|s| s.end - s.start);
    assert_eq!(ends(0).sum::<f64>(), 4.0 + 40.0, "nobody takes from it");
    let dynamic = given(Strategy::Dynamic, 2, Flow::ONE, &[10.0, 35.0, 10.0, 10.0], &costs);
    let of = |worker| dynamic.spans.iter().filter(move |s| s.worker == worker);
    // The other one comes three times while the host is on its one tile, and pays its shorter way there, and its way back.
    assert_eq!([of(0).count(), of(1).count()], [3, 1]);
    let starts: Vec<f64> = of(0).map(|span| span.start).collect();
    assert_eq!(starts, [0.5, 12.375, 24.25]);
    let next = given(Strategy::Dynamic, 2, Flow::ONE, &[10.0, 15.0, 10.0, 10.0], &costs);
    let last = next.spans.iter().find(|s| s.worker == 1 && s.start > 1.0).unwrap();
    // Half a switch, a tile, its own report, the next tile, and within that the other's report with the interruption.
    assert_eq!(last.start, 0.25 + 15.0 + (1.0 + 0.5));
    assert_eq!(last.end, last.start + 10.0 + (1.0 + 2.0), "taken from the tile after");
}

#[test]
fn by_hand_a_thief_takes_half_of_the_largest_rest() {
    // Four places each. The first worker is done at 4, when the others have one, three and two left.
    let seconds = [[1.0; 4], [1.9; 4], [10.0; 4], [2.5; 4]].concat();
    let stats = given(Strategy::Stealing, 4, Flow::ONE, &seconds, &FREE);
    let order = tiles(16, 16, 4, Order::Hilbert);
    let stolen = stats.spans.iter().filter(|span| span.worker == 0).nth(4).unwrap();
    assert_eq!((stolen.tile, stolen.start), (order[9], 4.0));
    // It took two of the three, so the next thief finds the third.
    let last = stats.spans.iter().find(|span| span.tile == order[11]).unwrap();
    assert!(last.worker == 1 && (last.start - 7.6).abs() < 1e-9, "{last:?}");
}

#[test]
fn a_steal_takes_its_time() {
    let seconds: Vec<f64> = (0..256).map(|i| if i < 128 { 4.0 } else { 1.0 }).collect();
    let run = |steal| given(Strategy::Stealing, 2, Flow::ONE, &seconds, &Costs { steal, ..FREE });
    assert!(run(0.0).workers.iter().any(|worker| worker.steals > 0));
    assert!(run(2.0).seconds > run(0.0).seconds);
}

#[test]
fn every_frame_of_a_stream_is_whole_and_not_too_many_are_in_flight() {
    let costs = Costs {
        to_master: 0.3,
        to_worker: 0.3,
        send: 0.1,
        reply: 0.1,
        collect: 0.2,
        steal: 0.1,
        prepare: 1.0,
        cores: 1,
        ..FREE
    };
    for schedule in Schedule::all() {
        for workers in [1, 2, 7, 300] {
            for (frames, in_flight) in [(1, 3), (5, 1), (5, 2), (4, 3)] {
                let stats = stream(schedule, workers, Flow { frames, in_flight }, 32, &costs);
                assert_eq!(
                    (stats.frames, stats.spans.len()),
                    (frames, frames * 64),
                    "{schedule:?} {workers}"
                );
                let of = |frame: usize| stats.spans.iter().filter(move |span| span.frame == frame);
                let end = |frame| of(frame).fold(0.0f64, |end, span| end.max(span.end));
                for frame in 0..frames {
                    let mut tiles: Vec<Tile> = of(frame).map(|span| span.tile).collect();
                    tiles.sort_by_key(|tile| (tile.y, tile.x));
                    tiles.dedup();
                    assert_eq!(tiles.len(), 64, "{schedule:?} {workers}");
                    let open = |earlier: &usize| of(frame).all(|span| span.start >= end(*earlier) - 1e-9);
                    assert!((0..frame.saturating_sub(in_flight - 1)).all(|earlier| open(&earlier)));
                }
            }
        }
    }
}

#[test]
fn with_frames_in_flight_nobody_waits_at_their_ends() {
    // One tile takes as long as all others together: 64 tiles, 63 and 63.
    let seconds: Vec<f64> = (0..64).map(|i| if i == 63 { 63.0 } else { 1.0 }).collect();
    let time =
        |in_flight| given(Strategy::Dynamic, 2, Flow { frames: 8, in_flight }, &seconds, &FREE).per_frame();
    // By hand: two share the 63 small tiles, 31.5 each on average; then one of them has the large one for itself.
    assert!((time(1) - (31.0 + 63.0)).abs() < 1.01, "{}", time(1));
    assert!(time(2) < 63.0 + 63.0 / 8.0 + 2.0, "{}", time(2));
}

#[test]
fn a_slow_worker_is_slow_in_its_tiles_and_nowhere_else() {
    let costs = Costs { to_master: 2.0, to_worker: 2.0, ..FREE };
    let replay = |_| {
        let tiles = tiles(16, 16, 4, Order::Hilbert);
        let plan = Plan::new(Strategy::StaticCyclic, 2, End::Awaited, &tiles, &CostMap::default());
        Replay { seconds: vec![16.0; plan.tiles.len()], plan }
    };
    let schedule = Schedule { strategy: Strategy::StaticCyclic, film: FilmMode::Shared };
    let stats = simulate(schedule, &[1.0, 1.5], Flow::ONE, replay, &costs);
    let busy: Vec<f64> = stats.workers.iter().map(|worker| worker.busy_seconds).collect();
    assert!((busy[0] - 128.0).abs() < 1e-6 && (busy[1] - 1.5 * 128.0).abs() < 1e-6, "{busy:?}");
    assert!((stats.seconds - (2.0 + 1.5 * 128.0 + 2.0)).abs() < 1e-6, "{}", stats.seconds);
}

#[test]
fn by_hand_its_own_reports_keep_the_host_between_tiles_and_those_of_others_within_them() {
    let shared = SharedCore::punctual(0.0, 0.0, 2.0, 0.5);
    let costs = Costs { collect: 1.0, shared, cores: 2, ..FREE };
    // The host reports after 10 and goes on 1.5 later; the other one reports at 30, within the host's second tile.
    let stats = given(Strategy::NonBlocking, 2, Flow::ONE, &[30.0, 10.0, 40.0, 5.0], &costs);
    let of = |worker| stats.spans.iter().filter(move |s| s.worker == worker);
    let host: Vec<(f64, f64)> = of(1).map(|span| (span.start, span.end)).collect();
    assert_eq!(host[0], (0.25, 10.25));
    assert_eq!(host[1].0, 11.75);
}

/// Tiles of these seconds, two tasks at once for each of two workers; so many wake-ups of the master are 9 late.
fn with_late_wake_ups(late: f64, seconds: &[f64]) -> FrameStats {
    let costs = Costs { shared: SharedCore { late, delay: 9.0, ..SHARED }, cores: 2, ..FREE };
    given(Strategy::NonBlocking, 2, Flow::ONE, seconds, &costs)
}

#[test]
fn by_hand_every_so_many_wake_ups_are_late_and_the_host_computes_meanwhile() {
    // The host has one long tile, the other one what is left but one.
    let seconds = [2.0, 90.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0];
    let starts = |late| -> Vec<f64> {
        let stats = with_late_wake_ups(late, &seconds);
        assert!(stats.spans.iter().any(|span| span.worker == 1 && span.end == 90.0));
        stats.spans.iter().filter(|span| span.worker == 0).map(|span| span.start).collect()
    };
    assert_eq!(starts(0.0), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0]);
    // The reports of two tiles lie there until 9 after the first one.
    assert_eq!(starts(1.0), [0.0, 2.0, 11.0, 13.0, 22.0, 24.0, 33.0]);
    // Only each second wake-up is late.
    assert_eq!(starts(0.5), [0.0, 2.0, 4.0, 13.0, 15.0, 17.0, 26.0]);
}

#[test]
fn by_hand_a_master_on_a_core_of_its_own_is_late_as_well() {
    let run = |late| {
        let costs = Costs { send: 0.25, to_master: 0.75, late, delay: 8.0, ..FREE };
        given(Strategy::NonBlocking, 1, Flow::ONE, &[2.0; 9], &costs)
    };
    let starts = |late| -> Vec<f64> { run(late).spans.iter().map(|span| span.start).collect() };
    // The first report wakes the master at 3, or 11; the second one lies there.
    assert_eq!(starts(1.0)[..4], [0.0, 2.25, 11.0, 13.25]);
    // Only each second wake-up: that of the first report at 3, of the second one at 5.25, or 13.25.
    assert_eq!(starts(0.5)[..4], [0.0, 2.25, 4.5, 13.25]);
    let reports = run(1.0).reports;
    assert_eq!((reports.awaited, reports.late), (5, 5));
    assert_eq!((reports.latency_sum, reports.late_sum), (5.0 * 9.0, 5.0 * 9.0));
    let reports = run(0.0).reports;
    assert_eq!((reports.awaited, reports.late, reports.latency_sum), (9, 0, 9.0));
}

#[test]
fn by_hand_who_reports_while_the_master_is_about_to_wake_up_does_not_wake_it_again() {
    let costs = Costs { send: 4.0, to_master: 3.0, ..FREE };
    let stats =
        given(Strategy::NonBlocking, 2, Flow::ONE, &[10.0, 12.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0], &costs);
    let of = |worker| -> Vec<f64> {
        stats.spans.iter().filter(|span| span.worker == worker).map(|span| span.start).collect()
    };
    // Both are answered at 17. The first one is done with its second tile at 23, the other one at 21, and goes on after waking
    // the master, until 25.
    assert_eq!((&of(0)[..3], &of(1)[..3]), (&[0.0, 14.0, 23.0][..], &[0.0, 12.0, 25.0][..]));
}

#[test]
fn a_late_master_has_its_turn_once_the_tile_of_its_host_has_ended() {
    // The report at 2 is handled at 3, and gives the other one its third tile. Of those at 4 and 9 the host, on its second tile until
    // 33, takes no notice; they are handled at 13, that at 18 at 27.
    let stats = with_late_wake_ups(1.0, &[2.0, 3.0, 2.0, 30.0, 5.0, 5.0, 5.0, 5.0, 5.0]);
    let of = |worker| stats.spans.iter().filter(move |span| span.worker == worker).map(|span| span.start);
    assert_eq!(of(0).collect::<Vec<f64>>(), [0.0, 2.0, 4.0, 13.0, 18.0, 27.0]);
    assert_eq!(of(1).collect::<Vec<f64>>(), [0.0, 3.0, 33.0]);
}

#[test]
fn a_host_that_waits_for_every_answer_gives_a_late_master_its_turn_after_its_tile() {
    let late = SharedCore { late: 1.0, delay: 9.0, ..SHARED };
    let starts = |strategy, seconds: &[f64]| {
        let costs = Costs { shared: late, cores: 2, ..FREE };
        let spans = given(strategy, 2, Flow::ONE, seconds, &costs).spans;
        let mut starts: Vec<f64> = spans.iter().filter(|s| s.worker == 0).map(|s| s.start).collect();
        starts.sort_by(f64::total_cmp);
        starts
    };
    // The report at 2 is handled when the host's tile ends, or 9 later.
    assert_eq!(starts(Strategy::Dynamic, &[2.0, 5.0, 2.0, 5.0]), [0.0, 5.0]);
    assert_eq!(starts(Strategy::Dynamic, &[2.0, 50.0, 2.0, 5.0]), [0.0, 11.0, 22.0]);
    // Alone on the machine: the master has a core.
    let costs = Costs { shared: late, ..FREE };
    assert_eq!(given(Strategy::NonBlocking, 1, Flow::ONE, &[1.0; 4], &costs).seconds, 4.0);
}

#[test]
fn by_hand_a_host_goes_on_when_the_master_has_nothing_left_to_do() {
    let shared = SharedCore { switch: 0.5, ..SHARED };
    let starts = |stats: &FrameStats, worker| -> Vec<f64> {
        stats.spans.iter().filter(|span| span.worker == worker).map(|span| span.start).collect()
    };
    // The other one's report comes at 10.75, while the master is on the host's, from 10.25 on.
    let costs = Costs { collect: 1.0, shared, cores: 2, ..FREE };
    let stats = given(Strategy::Dynamic, 2, Flow::ONE, &[10.75, 10.0, 50.0, 50.0], &costs);
    assert_eq!((&starts(&stats, 0)[..], &starts(&stats, 1)[..]), (&[0.0, 12.25][..], &[0.25, 12.75][..]));
    // The host's comes at 13.25, while the master is on the first one's, and is answered at 18; the second one's came at 16,
    // and takes it 3 more, and 1 for the answer.
    let costs = Costs { collect: 3.0, reply: 1.0, shared, cores: 3, ..FREE };
    let mut seconds = [50.0; 9];
    seconds[..3].copy_from_slice(&[10.0, 14.0, 11.0]);
    let stats = given(Strategy::Dynamic, 3, Flow::ONE, &seconds, &costs);
    assert_eq!([0, 1, 2].map(|worker| starts(&stats, worker)[1]), [15.0, 22.0, 22.25]);
}

#[test]
fn by_hand_only_the_last_one_who_finishes_a_stolen_frame_wakes_the_master() {
    let costs = Costs { send: 4.0, to_master: 3.0, collect: 5.0, ..FREE };
    let time =
        |workers, seconds: &[f64]| given(Strategy::Stealing, workers, Flow::ONE, seconds, &costs).seconds;
    // Done at 20 and at 30; both reports are handled then.
    assert_eq!(time(2, &[10.0, 10.0, 10.0, 20.0]), 30.0 + (4.0 + 3.0) + 2.0 * 5.0);
    assert_eq!(time(1, &[10.0; 4]), 40.0 + (4.0 + 3.0) + 5.0);
    // Whoever is done first goes on with the next frame at once.
    let flow = Flow { frames: 2, in_flight: 2 };
    let stats = given(Strategy::Stealing, 2, flow, &[10.0, 10.0, 10.0, 20.0], &costs);
    let next = stats.spans.iter().find(|span| span.worker == 0 && span.frame == 1).unwrap();
    assert_eq!(next.start, 20.0);
}

#[test]
fn by_hand_who_waits_for_long_is_dear_to_wake() {
    let shared = SharedCore { reply: 1.0, back: 2.0, wait: 5.0, ..SHARED };
    let second = |collect, cores| {
        let costs = Costs { collect, reply: 10.0, to_worker: 20.0, shared, cores, ..FREE };
        let stats = given(Strategy::Dynamic, 2, Flow::ONE, &[2.0, 90.0, 2.0, 2.0], &costs);
        stats.spans.iter().filter(|span| span.worker == 0).nth(1).unwrap().start
    };
    // The first tile ends at 3 + 2, or where the master has a core of its own at 30 + 2.
    assert_eq!(second(4.0, 2), 5.0 + 4.0 + (1.0 + 2.0));
    assert_eq!(second(6.0, 2), 5.0 + 6.0 + (10.0 + 20.0));
    assert_eq!(second(4.0, usize::MAX), 32.0 + 4.0 + (10.0 + 20.0));
}

#[test]
fn a_master_that_had_its_turn_early_still_takes_its_time_for_every_report() {
    let costs =
        Costs { collect: 5.0, shared: SharedCore { late: 1.0, delay: 9.0, ..SHARED }, cores: 2, ..FREE };
    let stats =
        given(Strategy::NonBlocking, 2, Flow::ONE, &[2.0, 3.0, 2.0, 3.0, 2.0, 3.0, 2.0, 2.0, 2.0], &costs);
    let of = |worker| stats.spans.iter().filter(move |span| span.worker == worker);
    // Late from 2 until the host's tile ends at 3; then 5 for each report, in turn from the other one and the host.
    assert_eq!(of(0).map(|span| span.start).take(4).collect::<Vec<f64>>(), [0.0, 2.0, 8.0, 18.0]);
    // Two reports were handled before the host's second tile: nothing is taken from the third.
    assert_eq!(of(1).map(|span| span.start).take(2).collect::<Vec<f64>>(), [0.0, 13.0]);
    let third = of(1).nth(2).unwrap();
    assert_eq!((third.start, third.end), (16.0, 19.0));
}

#[test]
fn the_host_does_not_go_on_before_its_own_report_is_handled() {
    let shared = SharedCore { late: 1.0, delay: 5.0, switch: 0.5, ..SHARED };
    let costs = Costs { collect: 1.0, shared, cores: 1, ..FREE };
    let spans = given(Strategy::NonBlocking, 1, Flow::ONE, &[10.0; 4], &costs).spans;
    assert_eq!((spans[1].start, spans[1].end), (11.75, 21.75), "first woken in 0.25");
}

#[test]
fn by_hand_answers_are_part_of_what_is_taken_from_the_host_and_a_wake_up_is_for_all_who_come() {
    let shared = SharedCore { interrupt: 2.0, ..SHARED };
    let costs = Costs { collect: 1.0, shared, cores: 2, ..FREE };
    let host = |costs: &Costs, workers, seconds: &[f64]| {
        let stats = given(Strategy::Dynamic, workers, Flow::ONE, seconds, costs);
        let of = |span: &&Span| span.worker == workers - 1;
        stats.spans.iter().filter(of).map(|span| span.end - span.start).collect::<Vec<f64>>()
    };
    // The other one's report at 10 is answered, which takes 3 more.
    let answered = Costs { reply: 3.0, ..costs };
    assert_eq!(host(&answered, 2, &[10.0, 15.0, 50.0, 7.0]), [15.0, 7.0 + 1.0 + 2.0 + 3.0]);
    // Two come at once at 10; one of them gets a tile, the host the last but one.
    let both = Costs { cores: 3, ..costs };
    let nine = [10.0, 10.0, 15.0, 50.0, 50.0, 7.0, 50.0, 50.0, 50.0];
    assert_eq!(host(&both, 3, &nine)[..2], [15.0, 7.0 + (1.0 + 2.0) + 1.0]);
}

#[test]
fn a_report_finds_the_core_as_it_is_when_it_is_sent() {
    let shared = SharedCore { latency: 1.0, ..SHARED };
    let costs = Costs { to_master: 7.0, shared, cores: 2, ..FREE };
    let time = |seconds: &[f64]| given(Strategy::Static, 2, Flow::ONE, seconds, &costs).seconds;
    // The host is done at 11 and waits when the other one, whose last tile began at 1, is done at 21; or it computes until 41.
    assert_eq!(time(&[1.0, 20.0, 1.0, 10.0]), 21.0 + 7.0);
    assert_eq!(time(&[1.0, 20.0, 1.0, 40.0]), 41.0);
}

#[test]
fn the_plan_of_an_overlapped_end_is_for_frames_that_others_follow_at_once() {
    // One tile, or four where the end is awaited.
    let replay = |end| {
        let tiles = tiles(8, 8, if end == End::Awaited { 4 } else { 8 }, Order::Hilbert);
        let plan = Plan::new(Strategy::Dynamic, 2, end, &tiles, &CostMap::default());
        Replay { seconds: vec![1.0; plan.tiles.len()], plan }
    };
    let schedule = Schedule { strategy: Strategy::Dynamic, film: FilmMode::Shared };
    for (in_flight, expected) in [(1, [4, 4, 4]), (2, [1, 1, 4])] {
        let stats = simulate(schedule, &[1.0; 2], Flow { frames: 3, in_flight }, replay, &FREE);
        let count = |frame| stats.spans.iter().filter(|span| span.frame == frame).count();
        assert_eq!([0, 1, 2].map(count), expected, "{in_flight} in flight");
    }
}

#[test]
fn by_hand_on_a_network_every_message_takes_its_latency_and_every_pixel_its_bits() {
    // The master's node has nothing else to do.
    let slow = Costs { to_master: 7.0, to_worker: 7.0, late: 1.0, delay: 9.0, cores: 1, ..FREE };
    let costs = slow.on_network(2.0, 16.0);
    let seconds = |film| frame(Schedule { strategy: Strategy::Dynamic, film }, 1, 16, &costs).seconds;
    // 16 tiles of 16 pixels, with 2 there and 2 back between them; 12 bytes per pixel at 2 bytes per second.
    let messages = 16.0 * (2.0 + 16.0 + 2.0);
    assert!((seconds(FilmMode::Shared) - messages).abs() < 1e-6);
    assert!((seconds(FilmMode::Messages) - (messages + 256.0 * 12.0 / 2.0)).abs() < 1e-6);
}
