//! The digits of coordinates: how far rounding may have moved a point.
//!
//! **Statement.** A file that writes `s` significant digits moves a coordinate of `e + 1` digits before the point by at
//! most half a unit `10^(e+1-s)`. The number `s` is the largest number of digits that any coordinate needs, and `e`
//! belongs to the largest one, so the unit holds for all. Numbers in binary have the unit of their last bit: that of
//! single precision if all are such numbers and need more digits than a text has, else that of double precision.
//!
//! A text with few digits is exact rather than rounded. Its unit counts only below a thousandth of the extent.
//!
//! **Work and depth.** O(1) for each coordinate.

use septet_geometry::point::Point;

use crate::bvh::Bounds;

/// The number of units by which a point may be off. A rotation in floating point moves it by several.
const UNITS: f64 = 2.0;
const BITS: f64 = 8.0;

/// The part of the extent above which digits count as exact.
const FINE: f64 = 1e-3;

/// The number of digits with which numbers of single precision are written. Those that need more were binary.
const SINGLE_DIGITS: i32 = 10;

/// Returns the distance by which rounding may have moved the points, in their unit.
pub fn rounding<P: Point>(points: &[P]) -> f64 {
    let (mut digits, mut largest, mut is_single) = (0, 0.0f64, true);
    for x in points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i))).filter(|x| x.is_finite()) {
        digits = digits.max(significant(x));
        largest = largest.max(x.abs());
        is_single &= f64::from(x as f32) == x;
    }
    if largest == 0.0 {
        return 0.0;
    }
    let doubles = BITS * last_bit(largest, 52);
    if is_single && digits > SINGLE_DIGITS {
        return doubles.max(BITS / 2.0 * last_bit(largest, 23));
    }
    let unit = 10f64.powi(exponent(largest) + 1 - digits);
    let extent = Bounds::of(points.iter().copied()).extent();
    let extent = (0..P::DIM).map(|i| extent.coord(i)).fold(0.0, f64::max);
    if UNITS * unit <= FINE * extent { doubles.max(UNITS * unit) } else { doubles }
}

/// Returns the number of significant decimal digits of the shortest text that gives this number.
fn significant(x: f64) -> i32 {
    if x == 0.0 {
        return 0;
    }
    let text = format!("{:e}", x.abs());
    text.bytes().take_while(|b| *b != b'e').filter(u8::is_ascii_digit).count() as i32
}

/// Returns the decimal exponent of the first digit.
fn exponent(x: f64) -> i32 {
    let text = format!("{x:e}");
    text.split('e').nth(1).and_then(|e| e.parse().ok()).unwrap_or(0)
}

/// Returns the value of the last of `bits` binary digits after the first.
fn last_bit(x: f64, bits: i32) -> f64 {
    let exponent = ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    2f64.powi(exponent - bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn digits_give_the_rounding() {
        let at = |x: f64, y: f64, z: f64| rounding(&[DVec3::ZERO, DVec3::new(x, y, z)]);
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-6, "{a:e} {b:e}");
        near(at(0.955_336, 0.295_520, 3.591_599), 2e-6);
        // Six digits of `%g`, the last near zero.
        near(at(0.382_683, 1.22465e-16, 123.456), 2e-3);
        near(at(500_000.123, 0.5, 1.0), 2e-3);
        // Few digits are exact.
        near(at(1.0, 2.0, 0.5), 8.0 * f64::EPSILON * 2.0);
        near(at(0.1f64 + 0.2, 1.0 / 3.0, 0.7), 8.0 * f64::EPSILON / 2.0);
        near(at(f64::from(0.1f32), f64::from(0.3f32), 0.75), 4.0 * f64::from(f32::EPSILON) / 2.0);
        assert_eq!(rounding::<DVec3>(&[]), 0.0);
        assert_eq!(at(0.0, -0.0, 0.0), 0.0);
    }
}
