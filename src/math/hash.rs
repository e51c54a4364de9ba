//! Random numbers that depend on nothing but what they are for.

/// A number in [0, 1) for a sample and one of its dimensions: a hash, so that nothing depends on the order in which
/// samples are taken (the finaliser of SplitMix64; Steele, Lea, Flood 2014).
pub fn hash_unit(sample: u64, dimension: u64) -> f32 {
    let z = sample.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ dimension.wrapping_mul(0xd1b5_4a32_d192_ed03);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 40) as f32 / (1u32 << 24) as f32
}
