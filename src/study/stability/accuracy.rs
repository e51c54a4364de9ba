//! Errors of depths and weights in units in the last place.

use super::oracle::{Fault, Opinion};

/// The oracle's opinion of many hits.
#[derive(Clone, Debug, Default)]
pub struct Accuracy {
    /// Hits and misses judged.
    pub judged: u64,
    /// Triangles hit that are not there.
    pub imagined: u64,
    /// Nearer triangles missed.
    pub missed: u64,
    /// Depths or weights more than one unit off.
    pub inaccurate: u64,
    /// Errors of t, u and v.
    errors: [Vec<f32>; 3],
}

/// Errors of one quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// How many were measured.
    pub samples: usize,
    /// Half of them are at most this large.
    pub median: f32,
    /// All but a thousandth are at most this large.
    pub p999: f32,
    /// The largest.
    pub max: f32,
}

impl Accuracy {
    pub(super) fn note(&mut self, opinion: &Opinion) {
        self.judged += 1;
        match opinion.fault {
            None => {}
            Some(Fault::Imagined) => self.imagined += 1,
            Some(Fault::Missed) => self.missed += 1,
            Some(Fault::Inaccurate) => self.inaccurate += 1,
        }
        for (all, error) in self.errors.iter_mut().zip(opinion.errors.iter().flatten()) {
            all.push(*error);
        }
    }

    /// Adds the opinions of another thread.
    pub fn merge(&mut self, other: Accuracy) {
        self.judged += other.judged;
        self.imagined += other.imagined;
        self.missed += other.missed;
        self.inaccurate += other.inaccurate;
        for (all, errors) in self.errors.iter_mut().zip(other.errors) {
            all.extend(errors);
        }
    }

    /// Promises broken.
    pub fn broken(&self) -> u64 {
        self.imagined + self.missed + self.inaccurate
    }

    /// Errors of t (in units of its last place), u and v (in units of 2^-24); `None` where nothing was measured.
    pub fn errors(&self) -> [Option<Errors>; 3] {
        self.errors.clone().map(|mut errors| {
            errors.sort_by(f32::total_cmp);
            let samples = errors.len();
            let at = |fraction: f64| errors[((samples - 1) as f64 * fraction).ceil() as usize];
            (samples > 0).then(|| Errors { samples, median: at(0.5), p999: at(0.999), max: at(1.0) })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_ranked() {
        let mut accuracy = Accuracy::default();
        for i in 0..1001 {
            accuracy.note(&Opinion { fault: None, errors: Some([i as f32, 1.0, 0.0]) });
        }
        let [t, u, _] = accuracy.errors();
        assert_eq!(t, Some(Errors { samples: 1001, median: 500.0, p999: 999.0, max: 1000.0 }));
        assert_eq!(u.map(|u| u.max), Some(1.0));
        assert_eq!((accuracy.judged, accuracy.broken()), (1001, 0));
    }
}
