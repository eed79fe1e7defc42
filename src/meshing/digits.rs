//! The digits of the coordinates of a file.
//!
//! **Statement.** A file gives each coordinate with a certain number of decimal digits. Its *step* is the distance
//! between two adjacent numbers with these digits, near the largest coordinate. For a fixed number of decimals, this is
//! the last decimal. For a fixed number of significant digits, it is the last digit of the largest coordinate. If a
//! coordinate needs 16 digits or more, it was not rounded to decimals, and the step is that of doubles.
//!
//! The shortest decimal form that gives the same double determines the digits of a coordinate. Zeros at the end of a
//! number in the file are not counted. Therefore all coordinates are considered together, and the step is at most
//! [`COARSEST`] of the extent: coordinates 0 and 1 do not mean that the file has a step of 1.
//!
//! The step decides which facets count as flat ([`crate::flats`]), but no sign and no topology.
//!
//! **Work and depth.** One conversion to decimals for each coordinate.

use septet_geometry::point::Point;

use crate::bvh::Bounds;

/// The largest step, relative to the extent.
const COARSEST: f64 = 2e-6;

/// The number of digits from which a coordinate counts as not rounded.
const FULL: i32 = 16;

/// Returns the step of the coordinates of points, in their unit. It is 0 if all coordinates are equal.
pub fn step_of<P: Point>(points: &[P]) -> f64 {
    let mut largest = 0.0f64;
    let (mut lowest, mut most, mut highest) = (i32::MAX, 0, i32::MIN);
    for x in points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i))) {
        if let Some((digits, exponent)) = decimals(x) {
            largest = largest.max(x.abs());
            lowest = lowest.min(exponent - digits + 1);
            (most, highest) = (most.max(digits), highest.max(exponent));
        }
    }
    let bounds = Bounds::of(points.iter().copied());
    let extent = (0..P::DIM).map(|i| bounds.high.coord(i) - bounds.low.coord(i)).fold(0.0, f64::max);
    let binary = largest.next_up() - largest;
    let step = if most >= FULL || lowest == i32::MAX {
        binary
    } else {
        10f64.powi(lowest.max(highest - most + 1)).max(binary)
    };
    step.min(COARSEST * extent)
}

/// Returns the number of digits of a number that is not zero, and the exponent of its first digit.
fn decimals(x: f64) -> Option<(i32, i32)> {
    if x == 0.0 || !x.is_finite() {
        return None;
    }
    let text = format!("{x:e}");
    let (digits, exponent) = text.split_once('e')?;
    let count = digits.bytes().filter(u8::is_ascii_digit).count();
    Some((i32::try_from(count).ok()?, exponent.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn steps_follow_the_digits() {
        let step = |points: &[[f64; 3]]| {
            let points: Vec<DVec3> = points.iter().map(|&p| DVec3::from(p)).collect();
            step_of(&points)
        };
        assert_eq!(step(&[[0.0, 0.123_456, 0.5], [1.0, 0.25, -1.732_051]]), 1e-6);
        assert_eq!(step(&[[0.012_345_678, 1.234_567_8, 0.0], [1.0, 0.25, -1.732_051]]), 1e-7);
        // The limit applies to coarse numbers.
        assert_eq!(step(&[[0.0; 3], [1.0, 1.0, 1.0]]), COARSEST);
        assert!(step(&[[0.1 + 0.2, 1.0 / 3.0, 0.0], [1.0, 0.0, 0.0]]) < 1e-15);
        assert_eq!(step(&[[1.0; 3], [1.0; 3]]), 0.0);
    }
}
