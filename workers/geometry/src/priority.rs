//! Priorities: a random order of points that is a function of the points.
//!
//! **Statement.** The priority of a point is a hash of a seed and the bits of its coordinates. The partition selects
//! its samples in the same way. The lexicographic order decides between equal hashes. The order is therefore total on
//! distinct points, and independent of indices, blocks and workers. For a set that was not chosen with knowledge of the
//! seed, it behaves like a random order.
//!
//! **Work.** O(1) for each priority and for each comparison.

use std::cmp::Ordering;

use crate::hash::mix;
use crate::point::{Point, lex_cmp};

/// Computes the hash of a point. It is below `u64::MAX`, which callers may use for points without a priority.
pub fn priority<P: Point>(seed: u64, x: P) -> u64 {
    // The constant distinguishes these hashes from the hashes of samples.
    let start = mix(mix(0, seed), 0x7072_696f_7269_7479);
    (0..P::DIM).fold(start, |h, i| mix(h, x.coord(i).to_bits())) >> 1
}

/// Compares priorities; the smaller one comes first.
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
