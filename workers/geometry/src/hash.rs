//! A 64-bit hash for samples, priorities and orders, which depend on the data and not on indices or workers.

/// The finalizer of splitmix64 (Steele, Lea and Flood 2014): a bijection in which every output bit depends on all input
/// bits.
#[inline]
pub fn finalise(z: u64) -> u64 {
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Adds a value to a hash: one step of splitmix64 from their exclusive or.
#[inline]
pub fn mix(hash: u64, value: u64) -> u64 {
    finalise((hash ^ value).wrapping_add(0x9e37_79b9_7f4a_7c15))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the first numbers of splitmix64 from the seed 1234567 (Vigna's reference implementation).
    #[test]
    fn mixing_is_splitmix64() {
        let step = 0x9e37_79b9_7f4a_7c15_u64;
        let drawn = [0, 1, 2].map(|i| mix(0, step.wrapping_mul(i).wrapping_add(1_234_567)));
        assert_eq!(drawn, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }
}
