//! Logarithms out of `+`, `*`, `/` and bit operations alone.
//!
//! `std`'s call the platform's libm, which may differ from machine to machine; images must not.

use std::f32::consts::LOG2_E;

/// log2 of a positive, normal number, to about 2e-7 of 1 + the result, by the series of atanh on [sqrt(1/2), sqrt(2)].
///
/// For 0, subnormal and negative numbers, infinity and NaN the result is finite and has no meaning.
pub fn log2(x: f32) -> f32 {
    // x = m * 2^e with m in [sqrt(1/2), sqrt(2)).
    let e = (x.to_bits() as i32).wrapping_sub(0x3f35_04f3) >> 23;
    let m = f32::from_bits((x.to_bits() as i32).wrapping_sub(e << 23) as u32);
    let r = (m - 1.0) / (m + 1.0);
    let r2 = r * r;
    let ln = r * ((((2.0 / 9.0 * r2 + 2.0 / 7.0) * r2 + 2.0 / 5.0) * r2 + 2.0 / 3.0) * r2 + 2.0);
    e as f32 + ln * LOG2_E
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_right_over_the_whole_range() {
        for step in 0..200_000u32 {
            let x = f32::from_bits(0x0080_0000 + step * 10_611);
            let exact = f64::from(x).log2();
            let error = (f64::from(log2(x)) - exact).abs();
            assert!(error <= 2.0e-7 * (1.0 + exact.abs()), "{x}: {error}");
        }
        assert_eq!([1.0, 2.0, 0.125, 1024.0].map(log2), [0.0, 1.0, -3.0, 10.0]);
        assert!([0.0, -1.0, 1.0e-40, f32::INFINITY].iter().all(|&x| log2(x).is_finite()));
    }
}
