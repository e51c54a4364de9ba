//! Numbers of twice the precision of f64, for the oracle: unevaluated sums of two (Dekker 1971; Joldes, Muller,
//! Popescu 2017). Relative error of each operation: below 2^-100.

use std::ops::{Add, Mul, Neg, Sub};

/// `high + low`, where |low| is at most half a unit in the last place of `high`.
#[derive(Clone, Copy, Debug)]
pub(in crate::study) struct Double {
    high: f64,
    low: f64,
}

fn two_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    let part = high - a;
    Double { high, low: (a - (high - part)) + (b - part) }
}

fn two_product(a: f64, b: f64) -> Double {
    let high = a * b;
    Double { high, low: f64::mul_add(a, b, -high) }
}

impl Double {
    pub(in crate::study) fn to_f64(self) -> f64 {
        self.high
    }

    pub(in crate::study) fn abs(self) -> Double {
        if self.high < 0.0 { -self } else { self }
    }

    /// A quotient; only its relative error of 2^-98 matters here.
    pub(in crate::study) fn divided_by(self, other: Double) -> Double {
        let first = self.high / other.high;
        let rest = self - other * Double::from(first);
        let second = rest.high / other.high;
        two_sum(first, second)
    }
}

impl From<f64> for Double {
    fn from(high: f64) -> Double {
        Double { high, low: 0.0 }
    }
}

impl From<f32> for Double {
    fn from(value: f32) -> Double {
        f64::from(value).into()
    }
}

impl Add for Double {
    type Output = Double;

    fn add(self, other: Double) -> Double {
        let (high, low) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let sum = two_sum(high.high, high.low + low.high);
        two_sum(sum.high, sum.low + low.low)
    }
}

impl Neg for Double {
    type Output = Double;

    fn neg(self) -> Double {
        Double { high: -self.high, low: -self.low }
    }
}

impl Sub for Double {
    type Output = Double;

    fn sub(self, other: Double) -> Double {
        self + -other
    }
}

impl Mul for Double {
    type Output = Double;

    fn mul(self, other: Double) -> Double {
        let product = two_product(self.high, other.high);
        two_sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }
}

#[cfg(test)]
mod tests {
    use super::Double;

    #[test]
    fn what_f64_loses_is_kept() {
        let one = Double::from(1.0);
        let tiny = Double::from(2.0f64.powi(-80));
        assert_eq!((one + tiny - one).to_f64(), 2.0f64.powi(-80));
        assert_eq!(((one + tiny) * (one - tiny) - one).to_f64(), 0.0);
        let odd = Double::from(1.0 + f64::EPSILON);
        assert_eq!((odd * odd - one).to_f64(), 2.0 * f64::EPSILON + f64::EPSILON * f64::EPSILON);
        assert!((one.divided_by(Double::from(3.0)) * Double::from(3.0) - one).to_f64().abs() < 1e-31);
    }
}
