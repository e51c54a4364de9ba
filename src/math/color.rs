//! Colour encoding. Everything inside irt is linear; sRGB exists only in 8-bit output.

/// Encodes a linear value as 8-bit sRGB (IEC 61966-2-1), rounding to nearest; values outside [0, 1] are clamped and
/// NaN becomes 0.
pub fn linear_to_srgb8(linear: f32) -> u8 {
    let l = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    let s = if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0 + 0.5) as u8
}
