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
//! Both cores send, as workers do, and walk through memory, as tiles do: the system's own code and data for waking somebody
//! are then not in the innermost caches, either. Now and then the system finds that the reader had enough for a while, the
//! sooner the more it has to do for a message, and lets who computes go on to the end of a time slice. Then a message is late.

mod bench;

use crate::math::median;
pub use bench::Load;
use bench::{Bench, LATE, Trip};

/// Of who goes on after sending there are so many times as many messages: what is late is rare.
const MORE: usize = 3;
/// Messages that are taken together: several of them are late.
const AT_A_TIME: usize = 250;

/// As in the picture above, in seconds. Of messages that were alone, and in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedCore {
    /// Whoever wakes the reader from another core.
    pub send: f64,
    /// From then on until the reader goes on.
    pub latency: f64,
    /// The one that computed there, and stood still meanwhile.
    pub interrupt: f64,
    /// The one that computed there, if it was who woke the reader, and waits for the answer: there and back.
    pub switch: f64,
    /// The reader, to wake the sender on the other core for the answer.
    pub reply: f64,
    /// From then on until the sender goes on.
    pub back: f64,
    /// For how long the sender waited for all that. Who waits for longer is on a core that sleeps deeper.
    pub wait: f64,
    /// What the reader did for a message from the other core, and from its own.
    pub work: [f64; 2],
    /// Share of messages that are late where who computes does not wait for answers.
    pub late: f64,
    /// By how much they are, on average.
    pub delay: f64,
}

impl SharedCore {
    /// Where nothing is ever late, and answers to other cores are as dear as where the reader has a core of its own.
    pub const fn punctual(send: f64, latency: f64, interrupt: f64, switch: f64) -> SharedCore {
        let (reply, back, wait) = (0.0, 0.0, 0.0);
        let (work, late, delay) = ([0.0; 2], 0.0, 0.0);
        SharedCore { send, latency, interrupt, switch, reply, back, wait, work, late, delay }
    }

    /// The same where everything takes `factor` times as long. A time slice is still a time slice.
    pub fn slower(self, factor: f64) -> SharedCore {
        SharedCore {
            send: self.send * factor,
            latency: self.latency * factor,
            interrupt: self.interrupt * factor,
            switch: self.switch * factor,
            reply: self.reply * factor,
            back: self.back * factor,
            wait: self.wait * factor,
            work: self.work.map(|work| work * factor),
            ..self
        }
    }
}

/// Measures them with `rounds` messages and more from `other` to a thread on `core`, where another thread computes and sends as
/// many; the reader has `load` to do for each. `None` if threads cannot be pinned to these CPUs.
///
/// # Panics
/// If `rounds` is 0.
pub fn shared_core_seconds(rounds: usize, core: usize, other: usize, load: &dyn Load) -> Option<SharedCore> {
    let (theirs, own) = Bench::new(load, true).messages(rounds, core, other)?;
    let (unanswered, _) = Bench::new(load, false).messages(MORE * rounds, core, other)?;
    let usual = |part: fn(&Trip) -> f64| -> Vec<f64> {
        theirs.iter().filter(|trip| trip.is_usual()).map(part).collect()
    };
    let of_own = |part: fn(&Trip) -> f64| -> Vec<f64> {
        own.iter().filter(|trip| trip.is_usual()).map(part).collect()
    };
    let latencies: Vec<f64> = unanswered.iter().filter(|trip| trip.asleep).map(|trip| trip.latency).collect();
    let late: Vec<f64> = latencies.iter().map(|&latency| f64::from(u8::from(latency > LATE))).collect();
    let delays: Vec<f64> = latencies.into_iter().filter(|&latency| latency > LATE).collect();
    let late = typical(&late);
    Some(SharedCore {
        send: typical(&usual(|trip| trip.send)),
        latency: typical(&usual(|trip| trip.latency)),
        interrupt: typical(&usual(|trip| trip.gap - trip.work - trip.reply)).max(0.0),
        switch: typical(&of_own(|trip| trip.wait - trip.work)).max(0.0),
        reply: typical(&usual(|trip| trip.reply)),
        back: typical(&usual(|trip| trip.back)).max(0.0),
        wait: typical(&usual(|trip| trip.wait)),
        work: [typical(&usual(|trip| trip.work)), typical(&of_own(|trip| trip.work))],
        late,
        delay: if late > 0.0 { mean(&delays) } else { 0.0 },
    })
}

/// The mean where the machine is as it mostly is: the median of the means of so many at a time. 0 of none.
fn typical(seconds: &[f64]) -> f64 {
    match seconds {
        [] => 0.0,
        _ => median(&seconds.chunks(AT_A_TIME).map(mean).collect::<Vec<f64>>()),
    }
}

fn mean(seconds: &[f64]) -> f64 {
    seconds.iter().sum::<f64>() / seconds.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn every_part_is_seen_or_nothing_is() {
        let cpus: Vec<usize> =
            core_affinity::get_core_ids().unwrap_or_default().iter().map(|core| core.id).collect();
        let [core, other, ..] = cpus[..] else { return };
        let shared = shared_core_seconds(50, core, other, &Duration::from_micros(10)).unwrap();
        let SharedCore { send, latency, interrupt, switch, reply, back, wait, work, late, delay } = shared;
        // On a busy machine it may be that no message is alone.
        for seconds in [send, latency, interrupt, switch, reply, back, wait] {
            assert!((0.0..1.0).contains(&seconds), "{shared:?}");
        }
        assert!(wait == 0.0 || wait > 1e-5, "{shared:?}");
        assert!(work.into_iter().all(|work| work == 0.0 || work >= 1e-5), "{shared:?}");
        assert!((0.0..=1.0).contains(&late) && if late > 0.0 { delay > LATE } else { delay == 0.0 });
        assert_eq!(shared_core_seconds(1, usize::MAX, other, &Duration::ZERO), None, "no such CPU");
    }

    #[test]
    fn what_is_typical_is_a_mean_that_a_noisy_while_does_not_change() {
        assert_eq!(typical(&[]), 0.0);
        assert_eq!(typical(&[1.0, 2.0, 6.0]), 3.0);
        let mut seconds = [[1.0, 3.0]; 4 * AT_A_TIME].concat();
        seconds[AT_A_TIME..3 * AT_A_TIME].fill(1e9);
        assert_eq!(typical(&seconds), 2.0);
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
    }
}
