//! A 64-bit hash, and the random generator of the tests. Samples, priorities and orders use the hash, so they depend on
//! the data and not on indices or workers.

use crate::point::Point;

/// Applies the finalizer of splitmix64 (Steele, Lea and Flood 2014), a bijection in which every output bit depends on
/// all input bits.
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

/// Returns the hash of a point's coordinates.
#[inline]
pub fn hash_of_place<P: Point>(x: P) -> u64 {
    let bits = (0..P::DIM).map(|i| x.coord(i).to_bits());
    bits.fold(0x5E97_E75E_97E7_5E97, |hash, bits| finalise(hash ^ bits))
}

/// Returns the hash of a point's coordinates and its weight, if it has one.
#[inline]
pub fn hash_of_site<P: Point>(x: P) -> u64 {
    let hash = hash_of_place(x);
    if !P::IS_WEIGHTED {
        return hash;
    }
    let low_parts = (0..P::DIM).map(|i| x.low(i));
    low_parts.chain([x.weight()]).fold(hash, |hash, part| finalise(hash ^ part.to_bits()))
}

/// The random generator of the tests: xorshift64* (Vigna 2016).
#[derive(Clone, Debug)]
pub struct Draw(u64);

impl Draw {
    /// Starts the sequence of a seed.
    pub fn new(seed: u64) -> Self {
        // The state must not be zero.
        Draw((seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678_9abc_def1).max(1))
    }

    /// Returns the next word.
    pub fn word(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Returns the next number in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns the next number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.word() >> 11) as usize % n
    }

    /// Shuffles the items.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }

    /// Returns the next point of the unit cube or square.
    pub fn point<P: Point>(&mut self) -> P {
        let mut p = P::splat(0.0);
        for i in 0..P::DIM {
            p.set_coord(i, self.unit());
        }
        p
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_in_range_and_depend_on_the_seed() {
        let [mut draw, mut same, mut other] = [1, 1, 2].map(Draw::new);
        let drawn: Vec<f64> = (0..1000).map(|_| draw.unit()).collect();
        assert!(drawn.iter().all(|x| (0.0..1.0).contains(x)));
        assert!((drawn.iter().sum::<f64>() / 1000.0 - 0.5).abs() < 0.05);
        assert!(drawn.iter().all(|&x| x == same.unit()));
        assert!(drawn.iter().any(|&x| x != other.unit()));
        let mut items: Vec<usize> = (0..100).collect();
        draw.shuffle(&mut items);
        assert!(!items.is_sorted());
        items.sort_unstable();
        assert!(items.into_iter().eq(0..100));
    }

    /// Compares with the first numbers of splitmix64 from the seed 1234567 (Vigna's reference implementation).
    #[test]
    fn mixing_is_splitmix64() {
        let step = 0x9e37_79b9_7f4a_7c15_u64;
        let drawn = [0, 1, 2].map(|i| mix(0, step.wrapping_mul(i).wrapping_add(1_234_567)));
        assert_eq!(drawn, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }
}
