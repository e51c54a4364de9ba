//! Variation without chance: every "random" number is a hash of what it is for.

/// A number in [0, 1) for item `index` of the kind `what`.
pub(super) fn unit(index: u32, what: u32) -> f32 {
    // The finaliser of lowbias32: every bit of the input reaches every bit of the output.
    let mut x = index.wrapping_mul(0x9e37_79b9) ^ what.wrapping_mul(0x85eb_ca6b).rotate_left(13);
    x = (x ^ (x >> 16)).wrapping_mul(0x21f0_aaad);
    x = (x ^ (x >> 15)).wrapping_mul(0x735a_2d97);
    x ^= x >> 15;
    (x >> 8) as f32 / (1 << 24) as f32
}

/// A number in [low, high) for item `index` of the kind `what`.
pub(super) fn between(low: f32, high: f32, index: u32, what: u32) -> f32 {
    low + (high - low) * unit(index, what)
}
