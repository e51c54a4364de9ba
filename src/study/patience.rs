//! How long to repeat what is measured.

use std::time::Instant;

/// How long to measure.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Rounds at least.
    pub least: usize,
    /// Rounds at most.
    pub most: usize,
    /// No round begins after so many seconds, but those of the least number.
    pub seconds: f64,
}

impl Patience {
    /// Whether another round begins after `done` of them, the first of which began at `start`.
    pub(super) fn lasts(self, done: usize, start: Instant) -> bool {
        done < self.least || (done < self.most && start.elapsed().as_secs_f64() < self.seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_least_are_always_done_and_more_only_in_time() {
        let patience = Patience { least: 2, most: 4, seconds: 1e3 };
        let now = Instant::now();
        assert_eq!(
            [0, 1, 2, 3, 4, 5].map(|done| patience.lasts(done, now)),
            [true, true, true, true, false, false]
        );
        let hurried = Patience { seconds: 1e-3, ..patience };
        std::thread::sleep(Duration::from_millis(2));
        assert_eq!([0, 1, 2, 3, 4].map(|done| hurried.lasts(done, now)), [true, true, false, false, false]);
    }
}
