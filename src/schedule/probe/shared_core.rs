//! What messages cost where the one who gets them shares a core with one who computes: master and worker, if there is no
//! core for each.
//!
//! ```text
//!   another core  ..computes..[post]..computes......................
//!   the core      ..computes.......|wake, read|work|park|..computes..
//!                             send  latency
//!                                 <---- interrupt + work -->
//! ```
//!
//! Both cores send, as workers do, and the reader has about as much to do for a message as a master who copies a tile: now and
//! then the system finds that it had enough for a while, and lets who computes go on to the end of a time slice. Then a message
//! is late.

use crate::math::median;
use crate::schedule::mail::Inbox;
use crate::schedule::message::Report;
use crate::schedule::pin::{Pinned, pin_current_thread};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// What the reader has to do for a message.
const WORK: Duration = Duration::from_micros(20);
/// How long everybody computes between two messages.
const BETWEEN: Duration = Duration::from_micros(150);
/// A message is late if it was not read after so many seconds: several times what waking takes, and a part of any time slice.
const LATE: f64 = 3e-4;
/// A reader that is not given its turn for so long is not waited for, in nanoseconds.
const LONGEST: u64 = 20_000_000;

/// As in the picture above, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedCore {
    /// Whoever wakes the reader from another core.
    pub send: f64,
    /// From then on until the reader goes on.
    pub latency: f64,
    /// The one that computed there, and stood still meanwhile.
    pub interrupt: f64,
    /// The one that computed there, if it was who woke the reader: there and back.
    pub switch: f64,
    /// Share of messages that are late.
    pub late: f64,
    /// By how much they are, on average.
    pub delay: f64,
}

impl SharedCore {
    /// Where nothing is ever late.
    pub fn punctual(send: f64, latency: f64, interrupt: f64, switch: f64) -> SharedCore {
        SharedCore { send, latency, interrupt, switch, late: 0.0, delay: 0.0 }
    }
}

/// Measures them with `rounds` messages from `other` to a thread on `core`, where another thread computes and sends as many; of
/// each the median, and how many are late. `None` if threads cannot be pinned to these CPUs.
///
/// # Panics
/// If `rounds` is 0.
pub fn shared_core_seconds(rounds: usize, core: usize, other: usize) -> Option<SharedCore> {
    let (theirs, own) = Bench::new().messages(rounds, core, other)?;
    // The middle, not a quiet moment: now and then the reader is awake already, and nobody has to wake it.
    let part = |i: usize| median(&theirs.iter().map(|message| message[i]).collect::<Vec<f64>>());
    let late: Vec<f64> = theirs.iter().map(|message| message[1]).filter(|&latency| latency > LATE).collect();
    Some(SharedCore {
        send: part(0),
        latency: part(1),
        interrupt: (part(2) - WORK.as_secs_f64()).max(0.0),
        switch: (median(&own) - WORK.as_secs_f64()).max(0.0),
        late: late.len() as f64 / rounds as f64,
        delay: late.iter().sum::<f64>() / late.len().max(1) as f64,
    })
}

/// Who sends.
const THEIRS: usize = 0;
const OWN: usize = 1;

struct Bench {
    inbox: Inbox<()>,
    origin: Instant,
    over: AtomicBool,
    /// When the last message of either sender was read, in nanoseconds, or 0, ...
    read_at: [AtomicU64; 2],
    /// ... and when the work for it was done.
    done_at: [AtomicU64; 2],
    /// The longest time in nanoseconds for which who computes on the core stood still, but for its own messages.
    gap: AtomicU64,
}

impl Bench {
    fn new() -> Bench {
        Bench {
            inbox: Inbox::new(),
            origin: Instant::now(),
            over: AtomicBool::new(false),
            read_at: [AtomicU64::new(0), AtomicU64::new(0)],
            done_at: [AtomicU64::new(0), AtomicU64::new(0)],
            gap: AtomicU64::new(0),
        }
    }

    fn now(&self) -> u64 {
        self.origin.elapsed().as_nanos() as u64
    }

    /// Of each message from the other core: seconds to send it, from then until it is read, and for which the one that computes
    /// stood still. Of each message of that one, for how long it stood still.
    fn messages(&self, rounds: usize, core: usize, other: usize) -> Option<(Vec<[f64; 3]>, Vec<f64>)> {
        let pinned = |cpu| matches!(pin_current_thread(Some(cpu)), Pinned::Cpu(_));
        std::thread::scope(|scope| {
            let reader = scope.spawn(|| pinned(core).then(|| self.read()));
            let own = scope.spawn(|| pinned(core).then(|| self.compute()));
            let send = || pinned(other).then(|| (0..rounds).map(|_| self.send()).collect());
            let theirs = scope.spawn(send).join().ok().flatten();
            self.over.store(true, Relaxed);
            // So that the reader sees it.
            self.inbox.post(Report::Lost { worker: OWN });
            let own = own.join().ok().flatten().filter(|own| !own.is_empty());
            reader.join().ok().flatten().and(theirs.zip(own))
        })
    }

    fn read(&self) {
        let mut taken = VecDeque::new();
        while !self.over.load(Relaxed) {
            self.inbox.take(&mut taken, Duration::from_millis(100));
            for message in taken.drain(..) {
                if let Report::Lost { worker } = message {
                    self.read_at[worker].store(self.now(), Relaxed);
                    self.wait(WORK);
                    self.done_at[worker].store(self.now(), Relaxed);
                }
            }
        }
    }

    /// Computes and sends, until it is over.
    fn compute(&self) -> Vec<f64> {
        let mut own = vec![];
        let mut last = self.now();
        let mut next = last;
        while !self.over.load(Relaxed) {
            let now = self.now();
            self.gap.fetch_max(now - last, Relaxed);
            last = now;
            if now > next {
                let sent = self.post(OWN);
                while self.done_at[OWN].load(Relaxed) == 0 && self.now() < sent + LONGEST {}
                last = self.now();
                own.push((last - sent) as f64 * 1e-9);
                next = last + BETWEEN.as_nanos() as u64;
            }
        }
        own
    }

    fn send(&self) -> [f64; 3] {
        self.wait(BETWEEN);
        self.gap.store(0, Relaxed);
        let sent = self.post(THEIRS);
        let posted = self.now();
        while self.done_at[THEIRS].load(Relaxed) == 0 && self.now() < sent + LONGEST {}
        let read = self.read_at[THEIRS].load(Relaxed).max(posted);
        // Until who was interrupted computes again.
        self.wait(BETWEEN / 4);
        [posted - sent, read - posted, self.gap.load(Relaxed)].map(|nanos| nanos as f64 * 1e-9)
    }

    /// Returns when it began.
    fn post(&self, sender: usize) -> u64 {
        self.read_at[sender].store(0, Relaxed);
        self.done_at[sender].store(0, Relaxed);
        let sent = self.now();
        self.inbox.post(Report::Lost { worker: sender });
        sent
    }

    fn wait(&self, time: Duration) {
        let end = self.now() + time.as_nanos() as u64;
        while self.now() < end {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_seen_or_nothing_is() {
        let cpus: Vec<usize> =
            core_affinity::get_core_ids().unwrap_or_default().iter().map(|core| core.id).collect();
        let [core, other, ..] = cpus[..] else { return };
        let SharedCore { send, latency, interrupt, switch, late, delay } =
            shared_core_seconds(5, core, other).unwrap();
        // On a busy machine it may be that nobody computes while a message is read, so nobody is interrupted.
        assert!(
            send > 0.0 && [latency, interrupt, switch].iter().all(|seconds| (0.0..1.0).contains(seconds))
        );
        assert!((0.0..=1.0).contains(&late) && if late > 0.0 { delay > LATE } else { delay == 0.0 });
        assert_eq!(shared_core_seconds(1, usize::MAX, other), None, "no such CPU");
    }
}
