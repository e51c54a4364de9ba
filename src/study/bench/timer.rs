//! Running one mode once, on one or several threads.

use super::Engine;
use crate::{
    kernels::Visibility,
    schedule::{Machine, Placement, pin_current_thread},
};
use std::{
    sync::atomic::{AtomicUsize, Ordering},
    time::Instant,
};

/// One way to use an engine on one set of rays. The rays are cut into units, which threads take one by one.
pub(super) trait Mode: Sync {
    /// Whose mode it is.
    fn engine(&self) -> Engine;
    /// Instruction set, as far as known.
    fn isa(&self) -> String;
    /// Kernel and flags.
    fn kernel(&self) -> String;
    /// How hits are decided; `None` if that has no name here.
    fn visibility(&self) -> Option<Visibility> {
        None
    }
    /// Rays per call.
    fn width(&self) -> usize;
    /// Number of units.
    fn units(&self) -> usize;
    /// Brings buffers into the state before tracing.
    fn reset(&mut self) {}
    /// Gives up buffers that [`Mode::reset`] filled: those of all modes together may not fit into memory.
    fn release(&mut self) {}
    /// What one thread does with a unit; returns the number of hits.
    fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_>;
}

/// Seconds from the moment when all threads are ready to the moment when the last is done, and the number of hits.
pub(super) fn time(mode: &mut dyn Mode, threads: usize, pin: bool) -> (f64, u64) {
    let placement = Placement::new(Machine::get(), Some(threads), pin);
    mode.reset();
    let result = run(&*mode, &placement, threads);
    mode.release();
    result
}

fn run(mode: &dyn Mode, placement: &Placement, threads: usize) -> (f64, u64) {
    let next = AtomicUsize::new(0);
    let ready = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let handles: Vec<_> = placement
            .slots()
            .iter()
            .map(|&cpu| {
                let (next, ready) = (&next, &ready);
                scope.spawn(move || {
                    pin_current_thread(cpu);
                    let arrival = Arrival(ready);
                    let mut run = mode.worker();
                    arrival.meet(threads);
                    let start = Instant::now();
                    let mut hits = 0;
                    loop {
                        let unit = next.fetch_add(1, Ordering::Relaxed);
                        if unit >= mode.units() {
                            return (start, Instant::now(), hits);
                        }
                        hits += run(unit);
                    }
                })
            })
            .collect();
        let done: Vec<_> = handles
            .into_iter()
            .map(|handle| handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect();
        let start = done.iter().map(|thread| thread.0).min();
        let end = done.iter().map(|thread| thread.1).max();
        let seconds = start.zip(end).map_or(0.0, |(start, end)| (end - start).as_secs_f64());
        (seconds, done.iter().map(|thread| thread.2).sum())
    })
}

/// A thread on its way to where all meet. One that panics counts as arrived, so that nobody waits for it.
struct Arrival<'a>(&'a AtomicUsize);

impl Drop for Arrival<'_> {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::AcqRel);
    }
}

impl Arrival<'_> {
    /// Waits until `threads` threads are here. They spin: waking a sleeping thread takes as long as a hundred packets,
    /// and one that starts late would pass for bad scaling.
    fn meet(self, threads: usize) {
        let here = self.0;
        drop(self);
        let mut spins = 0u32;
        while here.load(Ordering::Acquire) < threads {
            spins += 1;
            // There may be fewer cores than threads.
            if spins.is_multiple_of(1024) { std::thread::yield_now() } else { std::hint::spin_loop() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{sync::mpsc::channel, time::Duration};

    /// Its first thread panics before it traces anything, if asked to.
    struct Fragile {
        threads: AtomicUsize,
        breaks: bool,
    }

    impl Mode for Fragile {
        fn engine(&self) -> Engine {
            Engine::Irt
        }

        fn isa(&self) -> String {
            String::new()
        }

        fn kernel(&self) -> String {
            String::new()
        }

        fn width(&self) -> usize {
            1
        }

        fn units(&self) -> usize {
            100
        }

        fn worker(&self) -> Box<dyn FnMut(usize) -> u64 + '_> {
            let first = self.threads.fetch_add(1, Ordering::Relaxed) == 0;
            assert!(!(first && self.breaks), "as asked");
            Box::new(|unit| unit as u64)
        }
    }

    /// Hits of a run, or `None` if it panicked.
    fn hits(breaks: bool) -> Option<u64> {
        let (sender, receiver) = channel();
        std::thread::spawn(move || {
            let timed = || time(&mut Fragile { threads: AtomicUsize::new(0), breaks }, 3, false).1;
            let _ = sender.send(std::panic::catch_unwind(timed).ok());
        });
        receiver.recv_timeout(Duration::from_secs(60)).expect("hangs")
    }

    #[test]
    fn every_unit_is_run_once_and_a_thread_that_breaks_holds_nobody_up() {
        assert_eq!(hits(false), Some(99 * 100 / 2));
        assert_eq!(hits(true), None);
    }
}
