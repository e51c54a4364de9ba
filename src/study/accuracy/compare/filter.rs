//! Filters that are a product of one along rows and one along columns.

/// A plane of numbers, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) size: [usize; 2],
    pub(super) values: Vec<f32>,
}

/// Weights of the neighbours of a number, from the one before the others to the one behind them; an odd number of them.
pub(super) type Weights = Vec<f64>;

/// Weights `of` each distance from `-radius` to `radius`.
pub(super) fn weights(radius: usize, of: impl Fn(f64) -> f64) -> Weights {
    let radius = radius as i32;
    (-radius..=radius).map(|distance| of(f64::from(distance))).collect()
}

/// The bell of this standard deviation, without a factor.
pub(super) fn bell(deviation: f64) -> impl Fn(f64) -> f64 {
    move |distance| (-distance * distance / (2.0 * deviation * deviation)).exp()
}

/// Weights that sum to 1.
pub(super) fn normalised(weights: Weights) -> Weights {
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

impl Plane {
    pub(super) fn new(size: [usize; 2], values: impl IntoIterator<Item = f32>) -> Plane {
        let values: Vec<f32> = values.into_iter().collect();
        debug_assert_eq!(values.len(), size[0] * size[1]);
        Plane { size, values }
    }

    /// Filtered along rows by `across` and along columns by `down`; beyond the edges, the number at the edge goes on.
    pub(super) fn filtered(&self, across: &Weights, down: &Weights) -> Plane {
        self.along(across, 0).along(down, 1)
    }

    fn along(&self, weights: &Weights, axis: usize) -> Plane {
        let [width, height] = self.size;
        let radius = weights.len() / 2;
        let stride = [1, width][axis];
        let mut values = Vec::with_capacity(self.values.len());
        for y in 0..height {
            for x in 0..width {
                let (at, side) = ([x, y][axis], self.size[axis]);
                let first = y * width + x - at * stride;
                let value = |i: usize| {
                    let place = (at + i).saturating_sub(radius).min(side - 1);
                    f64::from(self.values[first + place * stride])
                };
                let sum: f64 = weights.iter().enumerate().map(|(i, weight)| weight * value(i)).sum();
                values.push(sum as f32);
            }
        }
        Plane { size: self.size, values }
    }

    /// A number for each pair of numbers in the same place.
    pub(super) fn with(&self, other: &Plane, of: impl Fn(f32, f32) -> f32) -> Plane {
        let values = self.values.iter().zip(&other.values).map(|(&a, &b)| of(a, b));
        Plane { size: self.size, values: values.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dot_becomes_the_weights_and_edges_go_on() {
        let (across, down) = (vec![1.0, 2.0, 4.0], vec![10.0, 1.0, 100.0]);
        let mut dot = Plane::new([5, 5], [0.0; 25]);
        dot.values[12] = 1.0;
        let spread = dot.filtered(&across, &down);
        // What lies before a number has the first weight, so that the dot's image is mirrored.
        assert_eq!(spread.values[6..9], [400.0, 200.0, 100.0]);
        assert_eq!(spread.values[11..14], [4.0, 2.0, 1.0]);
        assert_eq!(spread.values[16..19], [40.0, 20.0, 10.0]);
        let flat = Plane::new([2, 3], [3.0; 6]).filtered(&vec![0.25; 5], &vec![1.0]);
        assert_eq!(flat.values, [3.75; 6]);
    }

    #[test]
    fn a_normalised_bell_is_symmetric_and_sums_to_one() {
        let weights = normalised(weights(5, bell(1.5)));
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((weights[0] - weights[10]).abs() < 1e-15 && weights[5] > weights[4]);
        // exp(-1 / 4.5)
        assert!((weights[4] / weights[5] - 0.800_737_4).abs() < 1e-6);
    }
}
