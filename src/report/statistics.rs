//! Statistics of repeated measurements.

use crate::math::median;
use serde::Serialize;

/// Median and extremes. The median, because a measurement is disturbed in one direction only.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// The middle value; the mean of the two middle ones if their number is even.
    pub median: f64,
    /// The smallest value.
    pub min: f64,
    /// The largest value.
    pub max: f64,
}

impl Statistics {
    /// Statistics of `samples`; `None` if there is none or one is NaN.
    pub fn of(samples: &[f64]) -> Option<Statistics> {
        if samples.is_empty() || samples.iter().any(|s| s.is_nan()) {
            return None;
        }
        let min = samples.iter().copied().fold(f64::INFINITY, f64::min);
        let max = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some(Statistics { median: median(samples), min, max })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_or_between_the_two_middle_values() {
        assert_eq!(Statistics::of(&[3.0, 1.0, 2.0]), Some(Statistics { median: 2.0, min: 1.0, max: 3.0 }));
        assert_eq!(
            Statistics::of(&[4.0, 1.0, 2.0, 3.0]),
            Some(Statistics { median: 2.5, min: 1.0, max: 4.0 })
        );
        assert_eq!(Statistics::of(&[5.0]), Some(Statistics { median: 5.0, min: 5.0, max: 5.0 }));
    }

    #[test]
    fn nothing_and_nan_have_no_statistics() {
        assert_eq!(Statistics::of(&[]), None);
        assert_eq!(Statistics::of(&[1.0, f64::NAN]), None);
    }
}
