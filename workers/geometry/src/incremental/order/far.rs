//! Points that are far from all others.
//!
//! **Statement.** Let a box hold the middle four fifths of a sample on each axis, and let `s` be its longest side. A point
//! is far if one of its coordinates differs from the centre of the box by more than `1024 s`. If more than `n / 64 + 16`
//! points are far, the set has several scales, and no point counts as far.
//!
//! **Work.** O(n), and one sort of a sample with 256 to 2,048 expected points.
//!
//! The sample of the order consists of the points of early rounds, which are a function of the coordinates.

use super::ROUNDS;
use crate::point::Point;

/// The smallest number of points of which some can be far.
const FEWEST: u64 = 64;

/// The distance of a far point from the centre of the box, in sides of the box.
const FAR: f64 = 1024.0;

/// The smallest expected number of points in a sample.
const SAMPLE: usize = 256;

/// The points that are far from all others.
#[derive(Clone, Debug, PartialEq)]
pub struct FarPoints {
    /// Their positions, in ascending order. There is at least one.
    pub positions: Vec<u32>,
    /// The largest distance of a point from the centre, over the median distance of a sample.
    pub ratio: f64,
}

impl FarPoints {
    /// Returns the far points of a set, judged by a sample of evenly spaced positions.
    pub fn of<P: Point>(points: &[P]) -> Option<Self> {
        let n = points.len() as u64;
        FarPoints::judged(points, &FarPoints::sample(points, 0, n), n)
            .filter(|far| far.positions.len() as u64 <= FarPoints::most(n))
    }

    /// Returns the part of the sample of a set of `n` points that is in the block which starts at position `first`.
    pub fn sample<P: Point>(block: &[P], first: u64, n: u64) -> Vec<P> {
        let step = n.div_ceil(4 * SAMPLE as u64).max(1);
        let skipped = (step - first % step) % step;
        block.iter().skip(skipped as usize).step_by(step as usize).copied().collect()
    }

    /// Returns the far points of a block of a set of `n` points, judged by the sample of the set, and at most one more than
    /// [`FarPoints::most`]. If the blocks together have more than that, none counts as far.
    pub fn judged<P: Point>(block: &[P], sample: &[P], n: u64) -> Option<Self> {
        let positions = beyond((block, n), sample);
        let middle = Middle::of(sample).filter(|_| !positions.is_empty())?;
        let mut distances: Vec<f64> = sample.iter().map(|p| middle.distance(p)).collect();
        let (_, &mut median, _) = distances.select_nth_unstable_by(sample.len() / 2, f64::total_cmp);
        let largest = positions.iter().map(|&i| middle.distance(&block[i as usize])).fold(0.0, f64::max);
        Some(FarPoints { positions, ratio: largest / median })
    }

    /// Returns the largest number of far points of a set of `n` points.
    pub fn most(n: u64) -> u64 {
        n / 64 + 16
    }
}

/// Returns the positions of the points that are far from the others, in ascending order. `round` returns the round of a
/// point, given by its position.
pub(super) fn far_points<P: Point>(points: &[P], round: impl Fn(usize) -> u64) -> Vec<u32> {
    // Each round before the last has an eighth of the points of the next.
    let skipped = (points.len() / SAMPLE).max(1).ilog2() / 3;
    let last = ROUNDS - 1 - u64::from(skipped);
    let sample = points.iter().enumerate().filter(|(i, _)| round(*i) <= last).map(|(_, p)| *p);
    let n = points.len() as u64;
    let far = beyond((points, n), &sample.collect::<Vec<P>>());
    if far.len() as u64 > FarPoints::most(n) { Vec::new() } else { far }
}

/// Returns the positions of the points of a block that are far from the middle of the sample, and at most one more than a
/// set of `n` points may have.
fn beyond<P: Point>((block, n): (&[P], u64), sample: &[P]) -> Vec<u32> {
    let middle = Middle::of(sample).filter(|_| n >= FEWEST);
    let Some(middle) = middle else { return Vec::new() };
    let most = FarPoints::most(n) as usize;
    let far = (0u32..).zip(block).filter(|(_, p)| middle.is_far(p)).map(|(i, _)| i);
    far.take(most + 1).collect()
}

/// The box that holds the middle of a sample.
struct Middle<P> {
    centre: P,
    reach: f64,
}

impl<P: Point> Middle<P> {
    /// Returns `None` if the sample is small, or if the box is a point.
    fn of(sample: &[P]) -> Option<Self> {
        if (sample.len() as u64) < FEWEST / 2 {
            return None;
        }
        let (mut centre, mut side) = (P::default(), 0.0f64);
        for axis in 0..P::DIM {
            let mut along: Vec<f64> = sample.iter().map(|p| p.coord(axis)).collect();
            along.sort_unstable_by(f64::total_cmp);
            let (low, high) = (along[along.len() / 10], along[along.len() * 9 / 10]);
            centre.set_coord(axis, low / 2.0 + high / 2.0);
            side = side.max(high - low);
        }
        (side > 0.0).then_some(Middle { centre, reach: FAR * side })
    }

    /// Returns the largest difference of a coordinate from the centre.
    fn distance(&self, p: &P) -> f64 {
        (0..P::DIM).map(|axis| (p.coord(axis) - self.centre.coord(axis)).abs()).fold(0.0, f64::max)
    }

    fn is_far(&self, p: &P) -> bool {
        self.distance(p) > self.reach
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::{insertion_order, insertion_round};
    use super::*;

    fn found(points: &[DVec2]) -> Vec<u32> {
        far_points(points, |i| insertion_round(&points[i]))
    }

    fn unit_square(n: u32) -> Vec<DVec2> {
        (0..n).map(|i| DVec2::new(f64::from(i * 37 % 10_007), f64::from(i * 619 % 9_973)) / 1e4).collect()
    }

    #[test]
    fn far_points_are_found() {
        for n in [64, 1_000, 9_000] {
            let mut points = unit_square(n);
            assert!(found(&points).is_empty());
            points.insert(5, DVec2::new(-3.4e38, 0.0));
            points.push(DVec2::new(0.0, 1e4));
            assert_eq!(found(&points), [5, n + 1]);
            let far = FarPoints::of(&points).unwrap();
            assert_eq!(far.positions, [5, n + 1]);
            assert!(far.ratio > 1e38 && far.ratio < 1e40, "{}", far.ratio);
        }
        assert!(found(&[DVec2::ZERO; 100]).is_empty());
        assert!(found(&[]).is_empty());
    }

    /// Blocks of a set find what the set finds.
    #[test]
    fn blocks_find_the_same_far_points() {
        let mut points = unit_square(9_000);
        points.insert(100, DVec2::splat(1e20));
        points.push(DVec2::splat(-1e30));
        let n = points.len() as u64;
        let whole = FarPoints::of(&points).unwrap();
        for size in [1, 7, 1_000, 5_000] {
            let blocks: Vec<&[DVec2]> = points.chunks(size).collect();
            let at = |block: usize| (block * size) as u64;
            let parts = blocks.iter().enumerate().flat_map(|(k, block)| FarPoints::sample(block, at(k), n));
            let sample: Vec<DVec2> = parts.collect();
            assert_eq!(sample, FarPoints::sample(&points, 0, n));
            let found = blocks.iter().enumerate().filter_map(|(k, block)| {
                let far = FarPoints::judged(block, &sample, n)?;
                Some((far.positions.into_iter().map(move |i| i + at(k) as u32), far.ratio))
            });
            let (positions, ratios): (Vec<_>, Vec<f64>) = found.unzip();
            assert!(positions.into_iter().flatten().eq(whole.positions.iter().copied()));
            assert_eq!(ratios.into_iter().fold(0.0, f64::max), whole.ratio);
        }
    }

    #[test]
    fn clusters_are_not_far() {
        let mut points = unit_square(1_000);
        points.extend(unit_square(100).into_iter().map(|p| p + DVec2::splat(1e9)));
        assert!(found(&points).is_empty());
    }

    /// Far points of two scales come last, the farthest at the end.
    #[test]
    fn far_points_are_inserted_last() {
        let mut points = unit_square(9_000);
        points.extend((1..=100u32).map(|i| DVec2::new(1e6 + f64::from(i), f64::from(i * i % 101))));
        points.push(DVec2::splat(1e30));
        let order = insertion_order(&points);
        let (near, far) = order.split_at(9_000);
        assert!(near.iter().all(|&i| i < 9_000) && far.last() == Some(&9_100), "{far:?}");
    }
}
