//! What single steps of the protocol cost on this machine, for simulations.

mod shared_core;

pub use shared_core::{Collect, Load, SharedCore, SharedCoreProbe};

use crossbeam_deque::Worker as Deque;
use std::sync::mpsc;
use std::time::Instant;

/// Seconds to take half of another worker's tiles: in the quieter quarter of `rounds` steals from a deque of 128 that another
/// thread has just filled.
///
/// # Panics
/// If `rounds` is 0.
pub fn steal_seconds(rounds: usize) -> f64 {
    let (victim, thief) = (Deque::new_fifo(), Deque::new_fifo());
    let stealer = victim.stealer();
    let ((filled, is_filled), (stolen, is_stolen)) = (mpsc::channel(), mpsc::channel());
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for _ in 0..rounds {
                (0..128).for_each(|place: usize| victim.push(place));
                if filled.send(()).is_err() || is_stolen.recv().is_err() {
                    return;
                }
                while victim.pop().is_some() {}
            }
        });
        quiet((0..rounds).map(|_| {
            let _ = is_filled.recv();
            let start = Instant::now();
            std::hint::black_box(stealer.steal_batch_with_limit_and_pop(&thief, usize::MAX).success());
            let seconds = start.elapsed().as_secs_f64();
            while thief.pop().is_some() {}
            let _ = stolen.send(());
            seconds
        }))
    })
}

/// Other processes can only make steps longer.
fn quiet(samples: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = samples.collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 4]
}
