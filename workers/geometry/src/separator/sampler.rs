//! The samples of a subproblem.
//!
//! **Statement.** A point is a sample if a hash of the [`DrawKey`] and its coordinate bits lies in the lowest fraction
//! `target / population` of all hashes. In a population of at most `target` points, every point is a sample. The
//! samples are a function of the key, the population and the set of points. They are independent of workers, blocks
//! and order.
//!
//! **Number.** [`node_samples`] gives the expected number for a draw: one in [`SHARE`] points, within limits. A draw
//! processes all pairs of samples. With a fixed number of samples, small subproblems would therefore dominate the work
//! of the tree.

use super::key::DrawKey;
use crate::hash::mix;
use crate::point::Point;

/// Expected number of samples for a bisecting draw from a large population ([`super::draw_bisecting`]).
pub const SAMPLE_TARGET: u64 = 400;
/// Smallest expected number of samples of [`node_samples`]: `(d + 3)^2` in space. The groups of a centrepoint of `D`
/// dimensions have `D + 2` points. This number of samples fills two levels of groups for `D = d + 1`.
pub const LEAST_SAMPLES: u64 = 36;
/// Largest expected number of samples of [`node_samples`], which one leader receives.
pub const MOST_SAMPLES: u64 = 1 << 20;
/// Number of points for each sample in a small population.
const SHARE: u64 = 4;

/// Returns the expected number of samples for a draw from `population` points: a quarter of the points, at most `most`
/// and [`MOST_SAMPLES`], and at least [`LEAST_SAMPLES`] if `most` permits.
pub fn node_samples(most: u64, population: u64) -> u64 {
    (population / SHARE).max(LEAST_SAMPLES).min(most).min(MOST_SAMPLES)
}

/// The test that selects the samples of one draw.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    start: u64,
    /// Points with hashes below this are samples. `None` if every point is a sample.
    threshold: Option<u64>,
}

impl Sampler {
    /// Creates the sampler of one draw with this expected number of samples. Samplers with the same key are nested: a
    /// larger target only adds samples.
    pub fn new(key: DrawKey, population: u64, target: u64) -> Self {
        let start = mix(mix(mix(0, key.seed), key.node), u64::from(key.attempt));
        let share = |n: u64| ((u128::from(target) << 64) / u128::from(n)) as u64;
        Sampler { start, threshold: (population > target).then(|| share(population)) }
    }

    /// Returns `true` if the point is a sample.
    #[inline]
    pub fn accepts<P: Point>(&self, x: P) -> bool {
        let Some(threshold) = self.threshold else { return true };
        let mut h = self.start;
        for i in 0..P::DIM {
            h = mix(h, x.coord(i).to_bits());
        }
        h < threshold
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_shrink_with_the_node() {
        let of = |population| node_samples(400, population);
        assert_eq!([1, 61, 144, 148, 1000, 1600, 1 << 40].map(of), [36, 36, 36, 37, 250, 400, 400]);
        assert_eq!([1, 1000, 1 << 40].map(|population| node_samples(9, population)), [9; 3]);
        assert_eq!(node_samples(u64::MAX, 1 << 40), MOST_SAMPLES);
    }
}
