//! Colour encoding. Everything inside irt is linear; sRGB exists only in 8-bit output.

/// Encodes a linear value as 8-bit sRGB (IEC 61966-2-1), rounding to nearest; values outside [0, 1] are clamped and
/// NaN becomes 0.
pub fn linear_to_srgb8(linear: f32) -> u8 {
    let l = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    let s = if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0 + 0.5) as u8
}

/// Linear values in [0, 1] of all 8-bit sRGB values (IEC 61966-2-1).
pub fn srgb8_to_linear() -> [f32; 256] {
    std::array::from_fn(|encoded| {
        let s = encoded as f64 / 255.0;
        let linear = if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_the_way_to_linear_and_back() {
        let table = srgb8_to_linear();
        for (encoded, &linear) in table.iter().enumerate() {
            assert_eq!(usize::from(linear_to_srgb8(linear)), encoded);
        }
        assert_eq!((table[0], table[255]), (0.0, 1.0));
    }

    #[test]
    fn no_libm_rounds_the_table_otherwise() {
        for (encoded, &linear) in srgb8_to_linear().iter().enumerate().skip(11).take(244) {
            let exact = ((encoded as f64 / 255.0 + 0.055) / 1.055).powf(2.4);
            // Distance to the nearest middle between two f32, in units of their distance.
            let unit = f64::from(f32::from_bits(linear.to_bits() + 1)) - f64::from(linear);
            let middle = 0.5 - ((exact - f64::from(linear)) / unit).abs();
            assert!(middle > 1.0e-5, "{encoded}: {middle}");
        }
    }
}
