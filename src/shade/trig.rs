//! Sines, cosines and exponentials of whole vectors, the same on every instruction set: only `+`, `*` and bit operations.

use super::power::{exp2, polynomial};
use crate::kernels::{F32, I32, Lanes};

/// Sine and cosine of `turns` in [0, 1), where 1 is the whole circle; off by less than 1e-6.
///
/// Brought into an eighth of a turn on either side of the nearest quarter, then by Taylor's series.
#[inline(always)]
pub(super) fn sin_cos<S: Lanes<W>, const W: usize>(s: S, turns: F32<S, W>) -> [F32<S, W>; 2] {
    let quarter = (turns * F32::splat(s, 4.0) + F32::splat(s, 0.5)).trunc();
    let angle = (turns - quarter.to_float() * F32::splat(s, 0.25)) * F32::splat(s, std::f32::consts::TAU);
    let square = angle * angle;
    let sin = angle * polynomial(s, square, &[-1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0]);
    let cos = polynomial(s, square, &[1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0]);
    // sin(x + 90 degrees) = cos x, cos(x + 90 degrees) = -sin x, and so on round the circle.
    let odd = (quarter & I32::splat(s, 1)).eq(I32::splat(s, 1));
    let sine_sign = (quarter & I32::splat(s, 2)).shl::<30>();
    let cosine_sign = ((quarter + I32::splat(s, 1)) & I32::splat(s, 2)).shl::<30>();
    [odd.select(cos, sin).flip(sine_sign), odd.select(sin, cos).flip(cosine_sign)]
}

/// e^-x for x >= 0, to about 2e-6 of the result; 0 beyond x = 69.
#[inline(always)]
pub(super) fn decay<S: Lanes<W>, const W: usize>(s: S, x: F32<S, W>) -> F32<S, W> {
    let exponent = x * F32::splat(s, -std::f32::consts::LOG2_E);
    let vanishes = exponent.le(F32::splat(s, -100.0));
    let result = exp2(s, exponent.max(F32::splat(s, -100.0)).min(F32::splat(s, 0.0)));
    vanishes.select(F32::splat(s, 0.0), result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{Isa, Kernel, Kernels, Simd};

    struct All([f32; 16]);

    impl Kernel for All {
        type Output = [[f32; 16]; 3];

        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> [[f32; 16]; 3] {
            let x = F32::<S, 16>::load(s, &self.0);
            let [sin, cos] = sin_cos(s, x);
            [sin.to_array(), cos.to_array(), decay(s, x * F32::splat(s, 80.0)).to_array()]
        }
    }

    #[test]
    fn they_are_right_and_the_same_on_every_isa() {
        for step in 0..4096u32 {
            let x: [f32; 16] = std::array::from_fn(|i| (step * 16 + i as u32) as f32 / 65536.0);
            let want = Kernels::for_isa(Isa::Scalar).expect("scalar exists").run(All(x));
            for isa in Isa::available() {
                let got = Kernels::for_isa(isa).expect("available").run(All(x));
                assert_eq!(
                    got.map(|row| row.map(f32::to_bits)),
                    want.map(|row| row.map(f32::to_bits)),
                    "{isa}"
                );
            }
            for i in 0..16 {
                let angle = f64::from(x[i]) * std::f64::consts::TAU;
                let exact = [angle.sin(), angle.cos(), (-f64::from(x[i] * 80.0)).exp()];
                let off: [f64; 3] = std::array::from_fn(|k| (f64::from(want[k][i]) - exact[k]).abs());
                assert!(off[0] < 1.0e-6 && off[1] < 1.0e-6, "{} turns: {off:?}", x[i]);
                // 80 * log2(e) has about 7 bits before the point: 2^-17 of the result at the far end.
                assert!(off[2] < 1.0e-5 * exact[2] + 1.0e-29, "{}: {off:?}", x[i] * 80.0);
            }
        }
    }
}
