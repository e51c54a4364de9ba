//! Rows where the simulator's own streams are taken for measured ones.

use super::super::Flow;
use super::*;
use crate::schedule::{FilmMode, SharedCore, Span, Strategy};
use crate::tile::{self, Order};

const SHARED: SharedCore = SharedCore {
    send: 0.012,
    latency: 0.009,
    interrupt: 0.015,
    switch: 0.008,
    reply: 0.01,
    back: 0.02,
    wait: 0.07,
    work: [0.0; 2],
    late: 0.0,
    delay: 0.0,
};

/// Costs of about the size of real ones, in milliseconds.
const COSTS: Costs = Costs {
    prepare: 0.02,
    send: 0.014,
    reply: 0.014,
    to_master: 0.03,
    late: 0.0,
    delay: 0.0,
    to_worker: 0.03,
    collect: 0.005,
    collect_tile: 0.0,
    tile: 0.0,
    steal: 0.0,
    // Nothing is late: when that falls is a matter of chance.
    shared: SHARED,
    copying: SHARED,
    per_byte: 4e-7,
    copied: Some([3e-7, 2e-7]),
    cores: 2,
};

/// Efficiency of two workers of such slowness as the simulator alone has it, and as the study finds it predicted that
/// takes the simulator's streams for measured ones.
fn found(schedule: Schedule, slowness: [f64; 2]) -> [f64; 2] {
    let rows = rows(schedule, slowness, 1.0, &COSTS);
    assert_eq!((rows[0].efficiency, rows[0].inflation, rows[0].predicted), (1.0, 1.0, Some(1.0)));
    [rows[1].efficiency, rows[1].predicted.unwrap()]
}

/// Rows of one worker, two of such slowness, and four that are simulated with this inflation; the study takes messages for
/// as dear as `costs` where streams do not tell. In the second round everything takes longer, and more so in the third one.
fn rows(schedule: Schedule, slowness: [f64; 2], inflation: f64, costs: &Costs) -> Vec<ScalingRow> {
    let turn = |pace| Turn { pace, shared: 1.0, copied: 1.0 };
    rows_of(schedule, slowness, &COSTS, [1.0, 1.3, 1.7].map(turn), inflation, costs)
}

/// By which factor everything takes longer in a round; messages on a core that the master shares beside that; and copying there
/// beside the first.
struct Turn {
    pace: f64,
    shared: f64,
    copied: f64,
}

fn rows_of(
    schedule: Schedule,
    slowness: [f64; 2],
    truth: &Costs,
    turns: [Turn; 3],
    inflation: f64,
    costs: &Costs,
) -> Vec<ScalingRow> {
    let flow = Flow { frames: 2, in_flight: 2 };
    let base = tile::tiles(512, 512, 64, Order::Hilbert);
    let cost = |(i, &tile): (usize, &Tile)| Span {
        frame: 0,
        worker: 0,
        tile,
        start: 0.0,
        end: 0.2 + 0.01 * (i % 7) as f64,
    };
    let seen =
        FrameStats { frames: 1, spans: base.iter().enumerate().map(cost).collect(), ..FrameStats::default() };
    let tiles = TileCosts::new(&base, [&seen]);
    let measured = |workers| Measured { schedule, workers, streams: vec![] };
    let mut all = vec![measured(1), measured(2)];
    for Turn { pace, shared, copied } in turns {
        let one = tiles.simulate(schedule, &[pace], flow, &base, &truth.slower(pace));
        all[0].streams.extend([one.clone(), one]);
        let paces = slowness.map(|slowness| slowness * pace);
        let slower = truth.slower(mean(&paces));
        let slower = Costs {
            shared: slower.shared.slower(shared),
            copying: slower.copying.slower(shared),
            copied: slower.copied.map(|bytes| bytes.map(|byte| byte * copied)),
            ..slower
        };
        let two =
            tiles.simulate(schedule, &paces, flow.of(2, LONGEST_MEASURED), &base, &slower.of(schedule.film));
        all[1].streams.push(two);
    }
    let rounds = Rounds { all, ..Rounds::default() };
    let options = options(schedule, flow, inflation);
    let scene = Scene::default();
    let study = Study { scene: &scene, options: &options, costs, cores: 2, rounds: &rounds, base: &base };
    study.rows(schedule, &tiles)
}

fn options(schedule: Schedule, flow: Flow, inflation: f64) -> ScalingOptions {
    ScalingOptions {
        render: crate::study::accuracy::options(),
        schedules: vec![schedule],
        workers: vec![1, 2, 4],
        rounds: 1,
        flow,
        inflation,
        network: None,
        thesis_scene: None,
    }
}

#[test]
fn what_the_simulator_made_it_predicts_though_workers_are_slow_and_the_master_interrupts_them() {
    for schedule in Schedule::all() {
        for slowness in [[1.0, 1.0], [1.0, 1.3], [1.4, 1.2]] {
            let [efficiency, predicted] = found(schedule, slowness);
            assert!(
                (efficiency - predicted).abs() < 0.01,
                "{schedule:?} {slowness:?}: {efficiency} {predicted}"
            );
        }
    }
}

#[test]
fn every_round_is_predicted_by_its_own_messages_and_copies() {
    let truth = Costs { collect: 0.1, ..COSTS };
    let turns = || {
        let turn = |(shared, copied)| Turn { pace: 1.0, shared, copied };
        [(3.0, 1.0), (1.5, 0.3), (0.5, 4.0)].map(turn)
    };
    for strategy in [Strategy::Dynamic, Strategy::Overlap] {
        for film in FilmMode::ALL {
            let schedule = Schedule { strategy, film };
            let row = rows_of(schedule, [1.5, 1.5], &truth, turns(), 1.0, &truth).remove(1);
            let apart = row.apart.unwrap();
            assert!(apart.low > -0.015 && apart.high < 0.015, "{schedule:?} {apart:?}");
        }
    }
}

#[test]
fn simulated_efficiency_is_against_the_usual_single_worker_and_obeys_inflation() {
    let efficiency = |inflation| {
        let row = rows(Schedule::default(), [1.0, 1.0], inflation, &COSTS).remove(2);
        assert!(row.simulated && row.workers == 4 && row.predicted.is_none(), "{row:?}");
        row.efficiency
    };
    // Stealing loses next to nothing, though two of three rounds were slow.
    let plain = efficiency(1.0);
    assert!(plain > 0.95 && plain < 1.01, "{plain}");
    let inflated = efficiency(2.0);
    assert!((inflated - plain / 2.0).abs() < 0.01, "{inflated} {plain}");
}

#[test]
fn a_simulator_with_dearer_steals_says_too_little_and_that_is_told() {
    let dear = Costs { steal: 2.0, ..COSTS };
    let row = rows(Schedule::default(), [1.0, 1.4], 1.0, &dear).remove(1);
    let (apart, predicted) = (row.apart.unwrap(), row.predicted.unwrap());
    assert!(apart.median < -0.01 && apart.low <= apart.median && apart.rounds == 3, "{row:?}");
    assert!((apart.median - (predicted - row.efficiency)).abs() < 0.01, "{row:?}");
}

#[test]
fn the_least_sample_is_found() {
    assert_eq!(least(&[3.0, 1.0, 2.0]), 1.0);
}

#[test]
fn where_a_round_tells_nothing_of_messages_they_are_as_slow_as_its_tiles() {
    let base = [0, 16].map(|x| Tile { x, y: 0, width: 16, height: 16 });
    let streams = |workers| {
        let span = |tile| Span { frame: 0, worker: 0, tile, start: 0.0, end: 1.0 };
        let stream = FrameStats { frames: 1, spans: base.map(span).to_vec(), ..FrameStats::default() };
        Measured { schedule: Schedule::default(), workers, streams: vec![stream; 6 / workers] }
    };
    let one = streams(1);
    let alone = Alone {
        measured: &one,
        slowness: vec![1.0, 2.0, 0.5],
        seconds: vec![],
        simulated: vec![],
        costs: Costs { copied: Some([3.0, 5.0]), ..COSTS },
        usual: 0.0,
    };
    let two = streams(2);
    let rounds = Round::all(&two, &alone, &TileCosts::new(&base, &one.streams));
    let told = |round: &Round| {
        let costs = round.costs(alone.costs, &round.slowness, Schedule::default());
        (round.slowness.clone(), costs.shared, costs.copied)
    };
    // The second worker has no tiles.
    let expected = [1.0, 0.5, 2.0].map(|slow| {
        let factor = (slow + 1.0) / 2.0;
        (vec![slow, 1.0], SHARED.slower(factor), Some([3.0 * factor, 5.0 * factor]))
    });
    assert_eq!(rounds.iter().map(told).collect::<Vec<_>>(), expected);
}

#[test]
fn what_is_usual_is_found_in_rounds_in_which_everything_takes_longer() {
    let base = tile::tiles(512, 512, 64, Order::Hilbert);
    let span = |&tile: &Tile| Span { frame: 0, worker: 0, tile, start: 0.0, end: 0.3 };
    let seen = FrameStats { frames: 1, spans: base.iter().map(span).collect(), ..FrameStats::default() };
    let tiles = TileCosts::new(&base, [&seen]);
    let flow = Flow { frames: 4, in_flight: 2 };
    let schedule = Schedule { strategy: Strategy::Dynamic, film: FilmMode::Messages };
    let truth = Costs { shared: SharedCore { interrupt: 0.0, ..SHARED }, copying: SHARED, ..COSTS };
    let round = |pace| tiles.simulate(schedule, &[pace; 2], flow, &base, &truth.slower(pace));
    let full = Measured { schedule, workers: 2, streams: vec![round(2.0), round(4.0), round(3.0)] };
    let found = truth.as_in(&full, &tiles);
    let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.15;
    assert!(near(found.shared.send, SHARED.send) && near(found.shared.back, SHARED.back), "{found:?}");
    let (copied, expected) = (found.copied.unwrap(), COSTS.copied.unwrap());
    assert!((0..2).all(|i| near(copied[i], expected[i])), "{copied:?}");
}

#[test]
fn the_closest_slowness_is_kept_where_none_explains_what_was_seen() {
    let near = |found: &[f64], expected: &[f64]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-3), "{found:?}");
    };
    // The second worker appears slower by what is taken from it.
    near(&closest(&[1.2, 1.8], |slow| vec![slow[0], slow[1] + 0.3]), &[1.2, 1.5]);
    // From 1.2 on another rhythm sets in, and never is 1.3 found: nearest to it is what lies just below.
    let jumps = |slow: &[f64]| vec![if slow[0] < 1.2 { slow[0] } else { 1.3 * slow[0] }];
    let found = closest(&[1.3], jumps)[0];
    assert!((1.1..1.2).contains(&found), "{found}");
    // Where it gets worse with every step, the first one was best.
    let mut worse = 1.0;
    let found = closest(&[1.0], |_| {
        worse *= 1.1;
        vec![worse]
    });
    assert_eq!(found, [1.0]);
}

#[test]
fn one_workers_streams_are_simulated_by_themselves() {
    // The second of two streams is on a core where messages take three times as long.
    let schedule = Schedule { strategy: Strategy::NonBlocking, film: FilmMode::Messages };
    let base = tile::tiles(512, 512, 64, Order::Hilbert);
    let span = |&tile: &Tile| Span { frame: 0, worker: 0, tile, start: 0.0, end: 0.1 };
    let seen = FrameStats { frames: 1, spans: base.iter().map(span).collect(), ..FrameStats::default() };
    let tiles = TileCosts::new(&base, [&seen]);
    let flow = Flow { frames: 2, in_flight: 2 };
    let truth = Costs { per_byte: 8e-7, ..COSTS };
    let streams: Vec<FrameStats> =
        [1.0, 3.0].map(|dear| tiles.simulate(schedule, &[1.0], flow, &base, &truth.slower(dear))).to_vec();
    let measured = Measured { schedule, workers: 1, streams };
    let rounds = Rounds::default();
    let options = options(schedule, flow, 1.0);
    let scene = Scene::default();
    let study =
        Study { scene: &scene, options: &options, costs: &COSTS, cores: 2, rounds: &rounds, base: &base };
    let alone = Alone::new(&measured, None, &study, &tiles);
    let off = alone.simulated[0] / alone.seconds[0] - 1.0;
    assert!(off.abs() < 0.02, "{off}");
}

#[test]
fn copying_costs_what_it_did_in_streams_with_a_worker_on_every_core() {
    for strategy in [Strategy::Stealing, Strategy::Static] {
        let schedule = Schedule { strategy, film: FilmMode::Messages };
        let efficiencies = |known: Costs| {
            let rows = rows(schedule, [1.0, 1.0], 1.0, &known);
            [rows[1].predicted.unwrap(), rows[2].efficiency]
        };
        let right = efficiencies(COSTS);
        // Measured beside them, it may have been ten times as dear.
        let told = efficiencies(Costs {
            copied: COSTS.copied.map(|copied| copied.map(|byte| 10.0 * byte)),
            ..COSTS
        });
        assert!((0..2).all(|i| (right[i] - told[i]).abs() < 0.01), "{strategy:?} {right:?} {told:?}");
    }
}
