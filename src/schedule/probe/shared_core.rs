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
//! Both cores send, as workers do, and run tiles of a scene between. What it costs to wake somebody depends on what tiles leave
//! of the system's own code and data in the caches, and of the hypervisor's: on a virtual machine it takes twice as long where
//! all of a core's second-level cache was read meanwhile as where it was not. Now and then the system finds that the reader had
//! enough for a while, the sooner the more it has to do for a message, and lets who computes go on to the end of a time slice.
//! Then a message is late.

mod bench;

use crate::math::median;
use crate::schedule::TileTask;
use crate::schedule::stats::LATE;
use crate::tile::Tile;
use bench::{Bench, Trip};

/// Of who goes on after sending there are so many times as many messages: what is late is rare.
const MORE: usize = 3;

/// What is done with the output of a tile of a frame.
pub type Collect<'a, T> = dyn Fn(&<T as TileTask>::Frame, Tile, &mut <T as TileTask>::Output) + Sync + 'a;

/// What is computed, and sent.
pub struct Load<'a, T: TileTask> {
    /// Runs tiles, each any number of times.
    pub task: &'a T,
    /// At least one; their tiles are run one frame after another.
    pub frames: &'a [T::Frame],
    /// At least one, of each frame.
    pub tiles: &'a [Tile],
    /// What the reader does with a tile's output.
    pub collect: &'a Collect<'a, T>,
}

impl<T: TileTask> Load<'_, T> {
    /// The frame and the tile at a place; behind the last frame follows the first one.
    fn at(&self, place: usize) -> (&T::Frame, Tile) {
        let (frame, tile) = (place / self.tiles.len(), place % self.tiles.len());
        (&self.frames[frame % self.frames.len()], self.tiles[tile])
    }
}

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

    /// The median of each of them; `None` of none.
    pub fn median(all: &[SharedCore]) -> Option<SharedCore> {
        let of = |of: fn(&SharedCore) -> f64| median(&all.iter().map(of).collect::<Vec<f64>>());
        (!all.is_empty()).then(|| SharedCore {
            send: of(|shared| shared.send),
            latency: of(|shared| shared.latency),
            interrupt: of(|shared| shared.interrupt),
            switch: of(|shared| shared.switch),
            reply: of(|shared| shared.reply),
            back: of(|shared| shared.back),
            wait: of(|shared| shared.wait),
            work: [of(|shared| shared.work[0]), of(|shared| shared.work[1])],
            late: of(|shared| shared.late),
            delay: of(|shared| shared.delay),
        })
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
    /// Where the next round begins, so that all tiles get their turn.
    next: usize,
}

/// Messages that were answered, from the other core and from the reader's own, and such whose sender goes on.
struct Round {
    theirs: Vec<Trip>,
    own: Vec<Trip>,
    unanswered: Vec<Trip>,
}

impl SharedCoreProbe {
    /// A round of `each` messages and more from the first of these CPUs to a thread on the second, where another thread
    /// computes and sends as many; fewer if tiles take long. Nothing is measured if threads cannot be pinned to them.
    ///
    /// # Panics
    /// If there is no frame or no tile.
    pub fn measure<T: TileTask>(&mut self, load: &Load<'_, T>, each: usize, cpus: [usize; 2]) {
        let mut trips = |count, waits| {
            let bench = Bench::new(load, self.next, waits);
            let trips = bench.messages(count, cpus);
            self.next = bench.next();
            trips
        };
        let Some((theirs, own)) = trips(each, true) else { return };
        let Some((unanswered, _)) = trips(MORE * each, false) else { return };
        self.rounds.push(Round { theirs, own, unanswered });
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
mod tests;
