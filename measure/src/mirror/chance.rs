//! Numbers by chance, the same for the same seed.

/// A number between 0 and 1 that only depends on two others.
pub(super) fn chance(seed: u64, bits: u64) -> f64 {
    // The finalizer of SplitMix64. [Steele 2014, Fast splittable pseudorandom number generators, Fig. 17]
    let mut z = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ bits.wrapping_mul(0xd1b5_4a32_d192_ed03);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
