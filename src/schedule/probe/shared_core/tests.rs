//! The probe with tiles that spin.

use super::*;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Tiles that take 20 us, and one that panics.
struct Waiting;

impl TileTask for Waiting {
    type Frame = usize;
    type Scratch = ();
    type Output = Option<(usize, Tile)>;

    fn scratch(&self, _worker: usize) {}

    fn run(&self, &frame: &usize, tile: Tile, (): &mut (), output: &mut Option<(usize, Tile)>) {
        assert!(tile.x < 5, "the tile that panics");
        spin(Duration::from_micros(20));
        *output = Some((frame, tile));
    }
}

fn spin(time: Duration) {
    let start = Instant::now();
    while start.elapsed() < time {}
}

fn tile(x: u32) -> Tile {
    Tile { x, y: 0, width: 1, height: 1 }
}

/// Two CPUs, if there are as many.
fn cpus() -> Option<[usize; 2]> {
    let cores = core_affinity::get_core_ids().unwrap_or_default();
    Some([cores.first()?.id, cores.get(1)?.id])
}

#[test]
fn every_part_is_seen_and_every_output_collected_with_its_frame_and_tile() {
    let Some(cpus) = cpus() else { return };
    let collected = Mutex::new(vec![]);
    let collect = |&frame: &usize, tile, output: &mut Option<(usize, Tile)>| {
        spin(Duration::from_micros(10));
        collected.lock().unwrap().push((Some((frame, tile)), *output));
    };
    let load = Load { task: &Waiting, frames: &[0, 1], tiles: &[0, 1, 2].map(tile), collect: &collect };
    let mut probe = SharedCoreProbe::default();
    let mut begun = vec![];
    for _ in 0..2 {
        probe.measure(&load, 25, cpus);
        begun.push(probe.next);
    }
    assert!(begun[0] >= 25 * (1 + MORE) && begun[1] >= begun[0] + 25 * (1 + MORE), "{begun:?}");
    let sent: usize = probe.rounds.iter().map(|r| r.theirs.len() + r.unanswered.len()).sum();
    assert_eq!(sent, 2 * 25 * (1 + MORE));
    let collected = collected.into_inner().unwrap();
    assert!(collected.len() > sent, "those of the reader's own core, too");
    assert!(collected.iter().all(|(is, told)| is == told), "{collected:?}");
    for (frame, x) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)] {
        assert!(collected.iter().any(|&(is, _)| is == Some((frame, tile(x)))), "{frame} {x}");
    }
    let shared = probe.costs().unwrap();
    let SharedCore { send, latency, interrupt, switch, reply, back, wait, work, late, delay } = shared;
    // On a busy machine it may be that no message is alone.
    for seconds in [send, latency, interrupt, switch, reply, back, wait] {
        assert!((0.0..1.0).contains(&seconds), "{shared:?}");
    }
    assert!(wait == 0.0 || wait > 1e-5, "{shared:?}");
    assert!(work.into_iter().all(|work| work == 0.0 || work >= 1e-5), "{shared:?}");
    assert!((0.0..=1.0).contains(&late) && if late > 0.0 { delay > LATE } else { delay == 0.0 });
}

#[test]
fn who_computes_stands_still_for_as_long_as_the_reader_works() {
    let Some(cpus) = cpus() else { return };
    let collect = |_: &usize, _, _: &mut _| spin(Duration::from_millis(1));
    let load = Load { task: &Waiting, frames: &[0], tiles: &[tile(0)], collect: &collect };
    let mut probe = SharedCoreProbe::default();
    probe.measure(&load, 5, cpus);
    let gaps: Vec<f64> = probe.rounds[0].theirs.iter().map(|trip| trip.gap).collect();
    // On a busy machine who computes may have a turn while the reader works.
    assert!(gaps.len() == 5 && gaps.iter().any(|&gap| gap > 0.9e-3), "{gaps:?}");
}

#[test]
fn where_nothing_can_be_measured_it_ends_without_figures() {
    let Some(cpus) = cpus() else { return };
    let ends = |tiles: &[Tile], cpus, last: u32| {
        let collect = |_: &usize, tile: Tile, _: &mut _| assert_ne!(tile.x, last, "the reader panics");
        let mut probe = SharedCoreProbe::default();
        probe.measure(&Load { task: &Waiting, frames: &[0], tiles, collect: &collect }, 9, cpus);
        assert_eq!(probe.costs(), None);
    };
    ends(&[tile(0)], [cpus[0], usize::MAX], 9);
    ends(&[tile(0)], [usize::MAX, cpus[1]], 9);
    ends(&[0, 1, 2, 3, 4, 5, 1, 1].map(tile), cpus, 9);
    ends(&[0, 1, 2, 3, 4, 0, 1].map(tile), cpus, 4);
}

/// Messages that took so long to be read, by a reader who had nothing else to do.
fn trips(latencies: &[f64]) -> Vec<Trip> {
    let trip = |&latency| Trip {
        send: 1e-6,
        latency,
        work: 2e-6,
        reply: 3e-6,
        back: 4e-6,
        wait: 20e-6,
        gap: 9e-6,
        asleep: true,
        alone: true,
    };
    latencies.iter().map(trip).collect()
}

#[test]
fn the_median_round_counts_and_in_it_the_mean() {
    let round = |latencies: &[f64]| Round {
        theirs: trips(latencies),
        own: trips(&[]),
        unanswered: trips(&[1e-6, 1e-6, 1e-3, 3e-3]),
    };
    // A noisy while is not typical; what is late does not count; nor does a round in which nothing was seen.
    let probe = SharedCoreProbe {
        rounds: vec![round(&[1e-6, 3e-6]), round(&[]), round(&[2e-4]), round(&[1e-6, 5e-6, 1e-3])],
        next: 0,
    };
    let shared = probe.costs().unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    near(shared.latency, 3e-6);
    near(shared.interrupt, 4e-6);
    near(shared.switch, 0.0);
    near(shared.work[0], 2e-6);
    near(shared.work[1], 0.0);
    near(shared.late, 0.5);
    near(shared.delay, 2e-3);
    assert_eq!(SharedCoreProbe::default().costs(), None);
}

#[test]
fn on_a_slower_core_everything_takes_longer_but_a_time_slice() {
    let all = |k: f64| SharedCore {
        send: k,
        latency: 2.0 * k,
        interrupt: 3.0 * k,
        switch: 4.0 * k,
        reply: 5.0 * k,
        back: 6.0 * k,
        wait: 7.0 * k,
        work: [8.0 * k, 9.0 * k],
        late: 0.5,
        delay: 3.0,
    };
    assert_eq!(all(1.0).slower(2.0), all(2.0));
    assert_eq!(SharedCore::median(&[all(3.0), all(1.0), all(2.0)]), Some(all(2.0)));
    assert_eq!(SharedCore::median(&[]), None);
}
