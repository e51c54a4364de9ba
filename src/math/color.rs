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

/// [`linear_to_srgb8`] by a table: the same bytes, some ten times as fast.
#[derive(Clone, Debug)]
pub struct SrgbTable {
    /// By the leading bits of a value: the byte of the least such value, and the bits of the least value beyond which the
    /// byte is one more; none of these ranges of values has three bytes. Side by side, so that they come from the same place
    /// in memory.
    steps: Box<[[u32; 2]; PLACES]>,
}

/// Values below this are black.
const LEAST: f32 = 1.0 / 8192.0;
/// Bits of a value that are left out of its place in the table.
const SHIFT: u32 = 16;
/// Places in the table, a power of two; those behind the value 1 are not used.
const PLACES: usize = 2048;

impl SrgbTable {
    /// Makes the table.
    pub fn new() -> SrgbTable {
        let (first, last) = (LEAST.to_bits() >> SHIFT, 1f32.to_bits() >> SHIFT);
        let mut steps = Box::new([[255, u32::MAX]; PLACES]);
        for place in first..=last {
            let (mut low, mut high) = (place << SHIFT, (place + 1) << SHIFT);
            let byte = linear_to_srgb8(f32::from_bits(low));
            // The least value of another byte; the end of the range if there is none.
            while low < high {
                let middle = low + (high - low) / 2;
                if linear_to_srgb8(f32::from_bits(middle)) > byte {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            steps[(place - first) as usize] = [byte.into(), low];
        }
        SrgbTable { steps }
    }

    /// What [`linear_to_srgb8`] returns.
    #[inline(always)]
    pub fn encode(&self, linear: f32) -> u8 {
        // As integers, positive values are in their own order, negative ones below them and NaN anywhere.
        let bits = if linear.is_nan() { 0 } else { linear.to_bits() as i32 };
        let bits = bits.clamp(LEAST.to_bits() as i32, 1f32.to_bits() as i32) as u32;
        let [byte, next] = self.steps[((bits >> SHIFT) - (LEAST.to_bits() >> SHIFT)) as usize % PLACES];
        (byte + u32::from(bits >= next)) as u8
    }
}

impl Default for SrgbTable {
    fn default() -> SrgbTable {
        SrgbTable::new()
    }
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

    #[test]
    fn the_table_gives_the_bytes_of_the_formula() {
        let table = SrgbTable::new();
        // Every 61st value between 2^-16 and 4, and both sides of each change of byte.
        let mut values: Vec<u32> = (0x3780_0000..0x4080_0000).step_by(61).collect();
        for byte in 0..255u8 {
            let (mut low, mut high) = (0, 1f32.to_bits());
            while low < high {
                let middle = low + (high - low) / 2;
                if linear_to_srgb8(f32::from_bits(middle)) > byte { high = middle } else { low = middle + 1 }
            }
            values.extend([low - 1, low, low + 1]);
        }
        for value in values.into_iter().map(f32::from_bits) {
            assert_eq!(table.encode(value), linear_to_srgb8(value), "{value:e}");
        }
        for odd in [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MIN_POSITIVE, f32::MAX] {
            assert_eq!(table.encode(odd), linear_to_srgb8(odd), "{odd}");
        }
    }
}
