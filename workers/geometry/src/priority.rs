//! Priorities: a random order of points that is a function of the points.
//!
//! **Statement.** A point's priority is a hash of a seed and the bits of its coordinates, as the samples of the
//! partition are chosen; equal hashes are decided by the lexicographic order. So the order is total on distinct
//! points, looks random to a set that was not made for it, and does not depend on numbers, blocks or workers.

use std::cmp::Ordering;

use crate::hash::mix;
use crate::point::{Point, lex_cmp};

/// The hash: below `u64::MAX`, so that one number is left for those that have no priority any more.
pub fn priority<P: Point>(seed: u64, x: P) -> u64 {
    // The purpose tells these hashes from those of samples.
    let start = mix(mix(0, seed), 0x7072_696f_7269_7479);
    (0..P::DIM).fold(start, |h, i| mix(h, x.coord(i).to_bits())) >> 1
}

/// The order of priorities: the smaller goes first.
pub fn compare<P: Point>(a: (u64, P), b: (u64, P)) -> Ordering {
    a.0.cmp(&b.0).then_with(|| lex_cmp(&a.1, &b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn priorities_differ_by_seed_and_by_every_coordinate() {
        let points: Vec<DVec2> =
            (0..10_000).map(|i| DVec2::new(f64::from(i % 100), f64::from(i / 100))).collect();
        let mut all: Vec<u64> = points.iter().map(|&x| priority(3, x)).collect();
        let again: Vec<u64> = points.iter().map(|&x| priority(4, x)).collect();
        assert!(all.iter().zip(&again).all(|(a, b)| a != b));
        let first = all[0];
        let below = all.iter().filter(|&&p| p < 1 << 62).count();
        assert!((4500..5500).contains(&below), "{below}");
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), points.len());
        assert!(compare((first, points[0]), (first, points[1])).is_lt());
        assert!(compare((first + 1, points[0]), (first, points[1])).is_gt());
    }
}
