//! Powers of whole vectors: the specular lobe.
//!
//! `std`'s `powf` calls the platform's libm lane by lane and may differ from machine to machine; this one uses only
//! `+`, `*` and bit operations, so every instruction set gives the same bits.

use crate::kernels::{F32, I32, Lanes};

/// x^y for x in [0, 1] and y >= 0, to about 2e-6 of the result for results above 1e-6 and y up to 1000; 0^0 = 1.
///
/// log2 by the series of atanh on [sqrt(1/2), sqrt(2)], exp2 by its Taylor polynomial on [-1/2, 1/2].
#[inline(always)]
pub(super) fn power<S: Lanes<W>, const W: usize>(s: S, x: F32<S, W>, y: F32<S, W>) -> F32<S, W> {
    let tiny = F32::splat(s, 1.0e-30);
    let exponent = log2(s, x.max(tiny)) * y;
    // Results below 2^-100 count as nothing; the cut also keeps the exponent's bits in range.
    let result = exp2(s, exponent.max(F32::splat(s, -100.0)).min(F32::splat(s, 0.0)));
    let vanishes = exponent.le(F32::splat(s, -100.0));
    vanishes.select(F32::splat(s, 0.0), result)
}

#[inline(always)]
fn log2<S: Lanes<W>, const W: usize>(s: S, x: F32<S, W>) -> F32<S, W> {
    // x = m * 2^e with m in [sqrt(1/2), sqrt(2)).
    let shifted = x.bits() - I32::splat(s, 0x3f35_04f3);
    let e = (shifted.shr::<23>() ^ I32::splat(s, 0x100)) - I32::splat(s, 0x100);
    let m = (x.bits() - e.shl::<23>()).floats();
    let r = (m - F32::splat(s, 1.0)) / (m + F32::splat(s, 1.0));
    let r2 = r * r;
    let ln = r * polynomial(s, r2, &[2.0 / 9.0, 2.0 / 7.0, 2.0 / 5.0, 2.0 / 3.0, 2.0]);
    e.to_float() + ln * F32::splat(s, std::f32::consts::LOG2_E)
}

#[inline(always)]
pub(super) fn exp2<S: Lanes<W>, const W: usize>(s: S, x: F32<S, W>) -> F32<S, W> {
    // Arguments are at most 0: truncation after subtracting a half rounds to nearest.
    let whole = (x - F32::splat(s, 0.5)).trunc();
    let f = (x - whole.to_float()) * F32::splat(s, std::f32::consts::LN_2);
    let series = polynomial(s, f, &[1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0]);
    (series.bits() + whole.shl::<23>()).floats()
}

/// Coefficients from the highest power down, by Horner's rule.
#[inline(always)]
pub(super) fn polynomial<S: Lanes<W>, const W: usize>(s: S, x: F32<S, W>, coefficients: &[f32]) -> F32<S, W> {
    let mut sum = F32::splat(s, coefficients[0]);
    for &coefficient in &coefficients[1..] {
        sum = sum * x + F32::splat(s, coefficient);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{Isa, Kernel, Kernels, Simd};

    struct Power([f32; 16], [f32; 16]);

    impl Kernel for Power {
        type Output = [f32; 16];

        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> [f32; 16] {
            power::<S, 16>(s, F32::load(s, &self.0), F32::load(s, &self.1)).to_array()
        }
    }

    #[test]
    fn powers_are_right_and_the_same_on_every_isa() {
        let reference = Kernels::for_isa(Isa::Scalar).expect("scalar exists");
        for step in 0..4000u32 {
            let x: [f32; 16] = std::array::from_fn(|i| (step * 16 + i as u32) as f32 / 63999.0);
            let y: [f32; 16] =
                std::array::from_fn(|i| [0.0, 1.0, 2.5, 10.0, 32.0, 100.0, 500.0, 1000.0][i % 8]);
            let want = reference.run(Power(x, y));
            for isa in Isa::available() {
                let got = Kernels::for_isa(isa).expect("available").run(Power(x, y));
                assert_eq!(got.map(f32::to_bits), want.map(f32::to_bits), "{isa}");
            }
            for i in 0..16 {
                let exact = f64::from(x[i]).powf(f64::from(y[i]));
                let error = (f64::from(want[i]) - exact).abs();
                // The rounding of log2 x is multiplied by y.
                assert!(
                    error <= 3.0e-6 * exact * (1.0 + 0.05 * f64::from(y[i])) + 1.0e-9,
                    "{}^{}",
                    x[i],
                    y[i]
                );
            }
        }
    }
}
