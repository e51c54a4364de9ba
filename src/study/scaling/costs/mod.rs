//! What messages, steals and tiles cost the scheduler: measured with tiles that do nothing (`empty`), seen in streams
//! of real ones, by one worker (`seen`) and by one on every core (`full`), and measured on a core that the master shares
//! (`shared`).

mod empty;
mod full;
mod seen;
mod shared;

pub use empty::overhead_per_tile;
pub(super) use shared::{MESSAGES, SharedCores};

use crate::math::median;
use crate::schedule::{FilmMode, SharedCore};

/// What the simulator charges, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// The master, to end a frame and to begin another.
    pub prepare: f64,
    /// A worker, to wake the master.
    pub send: f64,
    /// The master, to wake a worker.
    pub reply: f64,
    /// From a report's sending to the moment when the master, who waited for it, goes on.
    pub to_master: f64,
    /// Share of reports that a master on a core of its own reads late, though nobody computes there, ...
    pub late: f64,
    /// ... and how much later than usual.
    pub delay: f64,
    /// From an answer's sending to the moment when a worker that waited for it goes on.
    pub to_worker: f64,
    /// The master, for a report.
    pub collect: f64,
    /// The master, for each tile in a report.
    pub collect_tile: f64,
    /// A worker, for each tile beside running it.
    pub tile: f64,
    /// A worker, to take half of another's tiles.
    pub steal: f64,
    /// What messages cost where the master shares a core with a worker that computes.
    pub shared: SharedCore,
    /// The same for a master who copies a tile for each report.
    pub copying: SharedCore,
    /// The master, for each byte of pixels that it gets as a message, on a core of its own ...
    pub per_byte: f64,
    /// ... and on one where a worker computes, which it does not find asleep: of pixels from other cores, and from there. `None`
    /// if that could not be measured.
    pub copied: Option<[f64; 2]>,
    /// With at least this many workers the master has no core of its own.
    pub cores: usize,
}

impl Costs {
    /// The same on a cluster: a network of `latency` seconds and `bits` per second, and a node for the master alone.
    pub(super) fn on_network(self, latency: f64, bits: f64) -> Costs {
        let per_byte = self.per_byte + 8.0 / bits;
        Costs { to_master: latency, to_worker: latency, late: 0.0, per_byte, cores: usize::MAX, ..self }
    }

    /// The same on a machine with a core for each of `workers` workers, and none for the master.
    pub(super) fn on_cores(self, workers: usize) -> Costs {
        Costs { cores: workers, ..self }
    }

    /// The same where everything takes `factor` times as long. A time slice is still a time slice.
    pub(super) fn slower(self, factor: f64) -> Costs {
        Costs {
            prepare: self.prepare * factor,
            send: self.send * factor,
            reply: self.reply * factor,
            to_master: self.to_master * factor,
            late: self.late,
            delay: self.delay,
            to_worker: self.to_worker * factor,
            collect: self.collect * factor,
            collect_tile: self.collect_tile * factor,
            tile: self.tile * factor,
            steal: self.steal * factor,
            shared: self.shared.slower(factor),
            copying: self.copying.slower(factor),
            per_byte: self.per_byte * factor,
            copied: self.copied.map(|copied| copied.map(|byte| byte * factor)),
            cores: self.cores,
        }
    }

    /// The median of each of what streams of one worker can show; `None` of none.
    pub(super) fn median(all: &[Costs]) -> Option<Costs> {
        let of = |of: fn(&Costs) -> f64| median(&all.iter().map(of).collect::<Vec<f64>>());
        let &first = all.first()?;
        Some(Costs {
            prepare: of(|costs| costs.prepare),
            send: of(|costs| costs.send),
            reply: of(|costs| costs.reply),
            to_master: of(|costs| costs.to_master),
            late: of(|costs| costs.late),
            delay: of(|costs| costs.delay),
            to_worker: of(|costs| costs.to_worker),
            tile: of(|costs| costs.tile),
            collect: of(|costs| costs.collect),
            per_byte: of(|costs| costs.per_byte),
            ..first
        })
    }

    /// What the simulator is told for this film.
    pub(super) fn of(self, film: FilmMode) -> Costs {
        match film {
            FilmMode::Shared => self,
            FilmMode::Messages => Costs { shared: self.copying, ..self },
        }
    }
}

/// Where nothing takes any time, and the master has a core of its own.
pub(super) const NOTHING: Costs = Costs {
    prepare: 0.0,
    send: 0.0,
    reply: 0.0,
    to_master: 0.0,
    late: 0.0,
    delay: 0.0,
    to_worker: 0.0,
    collect: 0.0,
    collect_tile: 0.0,
    tile: 0.0,
    steal: 0.0,
    shared: SharedCore::punctual(0.0, 0.0, 0.0, 0.0),
    copying: SharedCore::punctual(0.0, 0.0, 0.0, 0.0),
    per_byte: 0.0,
    copied: None,
    cores: usize::MAX,
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_streams_show_is_taken_from_the_median_round_and_the_rest_from_any() {
        let round = |x: f64| Costs {
            send: x,
            reply: 10.0 * x,
            to_master: 20.0 - x,
            to_worker: 30.0 + x,
            collect: x * x,
            per_byte: -x,
            prepare: 7.0 * x,
            late: x / 4.0,
            delay: 4.0 - x,
            tile: 3.0 * x,
            steal: 7.0,
            ..NOTHING
        };
        let median = Costs::median(&[3.0, 1.0, 2.0].map(round)).unwrap();
        assert_eq!(median, round(2.0));
        assert_eq!(Costs::median(&[]), None);
    }

    #[test]
    fn on_a_slower_core_everything_takes_longer() {
        let costs = Costs {
            prepare: 1.0,
            send: 2.0,
            reply: 3.0,
            to_master: 4.0,
            late: 0.5,
            delay: 3.0,
            to_worker: 5.0,
            collect: 6.0,
            collect_tile: 7.0,
            tile: 8.0,
            steal: 9.0,
            shared: SharedCore::punctual(10.0, 11.0, 12.0, 13.0),
            copying: SharedCore::punctual(15.0, 16.0, 17.0, 18.0),
            per_byte: 14.0,
            copied: Some([19.0, 20.0]),
            cores: 2,
        };
        let twice = Costs {
            prepare: 2.0,
            send: 4.0,
            reply: 6.0,
            to_master: 8.0,
            late: 0.5,
            delay: 3.0,
            to_worker: 10.0,
            collect: 12.0,
            collect_tile: 14.0,
            tile: 16.0,
            steal: 18.0,
            shared: SharedCore::punctual(20.0, 22.0, 24.0, 26.0),
            copying: SharedCore::punctual(30.0, 32.0, 34.0, 36.0),
            per_byte: 28.0,
            copied: Some([38.0, 40.0]),
            cores: 2,
        };
        assert_eq!(costs.slower(2.0), twice);
    }
}
