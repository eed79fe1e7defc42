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
const FEWEST: usize = 64;

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
        let step = points.len().div_ceil(4 * SAMPLE).max(1);
        let sample: Vec<P> = points.iter().step_by(step).copied().collect();
        let positions = beyond(points, &sample);
        let middle = Middle::of(&sample).filter(|_| !positions.is_empty())?;
        let mut distances: Vec<f64> = sample.iter().map(|p| middle.distance(p)).collect();
        let (_, &mut median, _) = distances.select_nth_unstable_by(sample.len() / 2, f64::total_cmp);
        let largest = positions.iter().map(|&i| middle.distance(&points[i as usize])).fold(0.0, f64::max);
        Some(FarPoints { positions, ratio: largest / median })
    }
}

/// Returns the positions of the points that are far from the others, in ascending order. `round` returns the round of a
/// point, given by its position.
pub(super) fn far_points<P: Point>(points: &[P], round: impl Fn(usize) -> u64) -> Vec<u32> {
    // Each round before the last has an eighth of the points of the next.
    let skipped = (points.len() / SAMPLE).max(1).ilog2() / 3;
    let last = ROUNDS - 1 - u64::from(skipped);
    let sample = points.iter().enumerate().filter(|(i, _)| round(*i) <= last).map(|(_, p)| *p);
    beyond(points, &sample.collect::<Vec<P>>())
}

/// Returns the positions of the points that are far from the middle of the sample, or none if there are many.
fn beyond<P: Point>(points: &[P], sample: &[P]) -> Vec<u32> {
    let middle = Middle::of(sample).filter(|_| points.len() >= FEWEST);
    let Some(middle) = middle else { return Vec::new() };
    let most = points.len() / 64 + 16;
    let far = (0u32..).zip(points).filter(|(_, p)| middle.is_far(p)).map(|(i, _)| i);
    let far: Vec<u32> = far.take(most + 1).collect();
    if far.len() > most { Vec::new() } else { far }
}

/// The box that holds the middle of a sample.
struct Middle<P> {
    centre: P,
    reach: f64,
}

impl<P: Point> Middle<P> {
    /// Returns `None` if the sample is small, or if the box is a point.
    fn of(sample: &[P]) -> Option<Self> {
        if sample.len() < FEWEST / 2 {
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
