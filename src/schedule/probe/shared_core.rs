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

/// Measures them, round by round, so that other things can be measured between: what a machine with other guests is like
/// changes from minute to minute.
#[derive(Default)]
pub struct SharedCoreProbe {
    rounds: Vec<Round>,
}

/// Messages that were answered, from the other core and from the reader's own, and such whose sender goes on.
struct Round {
    theirs: Vec<Trip>,
    own: Vec<Trip>,
    unanswered: Vec<Trip>,
}

impl SharedCoreProbe {
    /// A round of `messages` messages and more from `other` to a thread on `core`, where another thread computes and sends as
    /// many; the reader has `load` to do for each. Nothing is measured if threads cannot be pinned to these CPUs.
    pub fn measure(&mut self, messages: usize, core: usize, other: usize, load: &dyn Load) {
        let round = || {
            let (theirs, own) = Bench::new(load, true).messages(messages, core, other)?;
            let (unanswered, _) = Bench::new(load, false).messages(MORE * messages, core, other)?;
            Some(Round { theirs, own, unanswered })
        };
        self.rounds.extend(round());
    }

    /// What they are in the median round; `None` if none was measured. What no message shows takes no time.
    pub fn costs(&self) -> Option<SharedCore> {
        let usual = |part: fn(&Trip) -> f64| self.typical(|round| &round.theirs, Trip::is_usual, part);
        let of_own = |part: fn(&Trip) -> f64| self.typical(|round| &round.own, Trip::is_usual, part);
        let unanswered =
            |of: fn(&Trip) -> bool, part: fn(&Trip) -> f64| self.typical(|round| &round.unanswered, of, part);
        let is_late = |trip: &Trip| f64::from(u8::from(trip.latency > LATE));
        (!self.rounds.is_empty()).then(|| SharedCore {
            send: usual(|trip| trip.send),
            latency: usual(|trip| trip.latency),
            interrupt: usual(|trip| trip.gap - trip.work - trip.reply).max(0.0),
            switch: of_own(|trip| trip.wait - trip.work).max(0.0),
            reply: usual(|trip| trip.reply),
            back: usual(|trip| trip.back).max(0.0),
            wait: usual(|trip| trip.wait),
            work: [usual(|trip| trip.work), of_own(|trip| trip.work)],
            late: unanswered(|trip| trip.asleep, is_late),
            delay: unanswered(|trip| trip.asleep && trip.latency > LATE, |trip| trip.latency),
        })
    }

    /// The median of the rounds' means of this part of those messages; 0 if there are none.
    fn typical(
        &self,
        messages: fn(&Round) -> &[Trip],
        of: impl Fn(&Trip) -> bool,
        part: impl Fn(&Trip) -> f64,
    ) -> f64 {
        let mean_of = |round: &Round| {
            let parts: Vec<f64> = messages(round).iter().filter(|trip| of(trip)).map(&part).collect();
            (!parts.is_empty()).then(|| mean(&parts))
        };
        let means: Vec<f64> = self.rounds.iter().filter_map(mean_of).collect();
        if means.is_empty() { 0.0 } else { median(&means) }
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
        let mut probe = SharedCoreProbe::default();
        (0..2).for_each(|_| probe.measure(25, core, other, &Duration::from_micros(10)));
        let shared = probe.costs().unwrap();
        let SharedCore { send, latency, interrupt, switch, reply, back, wait, work, late, delay } = shared;
        // On a busy machine it may be that no message is alone.
        for seconds in [send, latency, interrupt, switch, reply, back, wait] {
            assert!((0.0..1.0).contains(&seconds), "{shared:?}");
        }
        assert!(wait == 0.0 || wait > 1e-5, "{shared:?}");
        assert!(work.into_iter().all(|work| work == 0.0 || work >= 1e-5), "{shared:?}");
        assert!((0.0..=1.0).contains(&late) && if late > 0.0 { delay > LATE } else { delay == 0.0 });
        let mut nowhere = SharedCoreProbe::default();
        nowhere.measure(1, usize::MAX, other, &Duration::ZERO);
        assert_eq!(nowhere.costs(), None, "no such CPU");
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
    }
}
