//! A median, and how far it can be trusted.

use super::median;

/// The median of some rounds, and between which of them the true median lies with at least 99 % certainty: an interval of
/// order statistics, whatever the distribution. Of fewer than eight rounds, it is all that was seen (and that certain only
/// to 75 % with three, 94 % with five).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Spread {
    /// The middle value.
    pub median: f64,
    /// The true median is hardly below this ...
    pub low: f64,
    /// ... or above this.
    pub high: f64,
    /// Rounds.
    pub rounds: usize,
}

impl Spread {
    /// Of at least one value, none of them NaN.
    ///
    /// # Panics
    /// If there is none.
    pub fn of(values: &[f64]) -> Spread {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (rounds, left_out) = (sorted.len(), left_out(sorted.len()));
        Spread { median: median(values), low: sorted[left_out], high: sorted[rounds - 1 - left_out], rounds }
    }

    /// Exactly this.
    pub const fn exactly(value: f64) -> Spread {
        Spread { median: value, low: value, high: value, rounds: 1 }
    }

    /// Whether `value` is possible.
    pub fn has(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// The greater of the distances from the median to both ends.
    pub fn error(&self) -> f64 {
        (self.high - self.median).max(self.median - self.low)
    }
}

/// How many values at each end of `n` sorted ones may be left out, so that the median is between the others in 99 of 100
/// cases: it is not if at most that many of `n` coins show heads, or tails.
fn left_out(n: usize) -> usize {
    let (mut heads, mut probability) = (0, 0.5f64.powi(n as i32));
    let mut below = probability;
    while heads + 1 < n {
        probability *= (n - heads) as f64 / (heads + 1) as f64;
        below += probability;
        if 2.0 * below > 0.01 {
            return heads;
        }
        heads += 1;
    }
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_order_statistics() {
        // Sign test: of 8 values, none may go (2 * 9 / 256 = 7 % is too much); of 12, one (2 * 13 / 4096 = 0.6 %).
        let left = [1, 3, 5, 7, 8, 9, 11, 12, 15, 20].map(left_out);
        assert_eq!(left, [0, 0, 0, 0, 0, 0, 0, 1, 2, 3]);
        let values: Vec<f64> = (1..=13).rev().map(f64::from).collect();
        let spread = Spread::of(&values);
        assert_eq!(spread, Spread { median: 7.0, low: 2.0, high: 12.0, rounds: 13 });
        assert!(spread.has(2.0) && !spread.has(12.5));
        assert_eq!(spread.error(), 5.0);
    }

    #[test]
    fn the_true_median_is_inside_as_often_as_promised() {
        for rounds in [8, 12, 20] {
            let inside = (0..4000).filter(|&trial| {
                let value = |i: usize| f64::from(crate::math::hash_unit(trial, i as u64)).powi(3);
                // The median of a cube of a uniform number is 1/8.
                Spread::of(&(0..rounds).map(value).collect::<Vec<f64>>()).has(0.125)
            });
            let inside = inside.count();
            assert!(inside > 3950, "{inside} of 4000 with {rounds} rounds");
        }
    }
}
