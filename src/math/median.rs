//! The middle of samples.

/// The middle value of finite or infinite `samples`; the mean of the two middle ones if their number is even.
///
/// # Panics
/// If there is none.
pub fn median(samples: &[f64]) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[half] } else { f64::midpoint(sorted[half - 1], sorted[half]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_or_between_the_two_middle_values() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0])), (2.0, 2.5));
        assert_eq!((median(&[5.0]), median(&[4.0, 1.0, 2.0, 3.0])), (5.0, 2.5));
    }
}
