//! The digits of the coordinates of a file: how far rounding may have moved a point.
//!
//! **Statement.** The *step* of points is the distance between two adjacent numbers of their form, near the largest
//! coordinate. A file that writes s significant digits, with `e + 1` of them before the point of the largest coordinate,
//! has the step `10^(e+1-s)`. Rounding moves a coordinate by at most half a step. The shortest decimal text that gives
//! the same double determines the digits of a coordinate, and s is the largest number that any coordinate needs. Files
//! with a fixed number of decimals have the same step, because their largest coordinates have the most digits.
//!
//! Numbers in binary have the step of their last bit. All coordinates of a file in single precision are numbers of
//! single precision, and some need more digits than a text has. Numbers in double precision need `FULL` digits or more.
//!
//! A text with few digits is exact rather than rounded: coordinates 0 and 1 do not mean that the file has a step of 1.
//! So each use of a step has a limit, relative to the extent.
//!
//! The step decides which facets count as flat ([`crate::joining`], [`crate::repair`]), but no sign and no topology.
//!
//! **Work and depth.** One conversion to decimals for each coordinate.

use septet_geometry::point::Point;

use crate::bvh::Bounds;

/// The number of digits from which a coordinate counts as not rounded to decimals.
const FULL: i32 = 16;

/// The number of digits with which numbers of single precision are written. Those that need more were binary.
const SINGLE: i32 = 10;

/// The largest step for joining, relative to the extent.
const COARSEST: f64 = 2e-6;

/// The largest distance by which decimals count as rounded, relative to the extent.
const FINE: f64 = 1e-3;

/// The number of steps by which a point may be off. A rotation in floating point moves it by several.
const DECIMALS: f64 = 2.0;
const SINGLES: f64 = 4.0;
const DOUBLES: f64 = 8.0;

/// The form of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Decimal,
    Single,
    Double,
}

/// The digits of the coordinates of points, in their unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Digits {
    form: Form,
    /// The distance between adjacent numbers near the largest coordinate.
    step: f64,
    /// The distance between adjacent doubles there.
    double: f64,
    /// The largest extent along an axis.
    extent: f64,
}

impl Digits {
    /// Finds the digits of points.
    pub fn of<P: Point>(points: &[P]) -> Self {
        let (mut most, mut highest, mut largest, mut is_single) = (0, i32::MIN, 0.0f64, true);
        for x in points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i))) {
            if let Some((digits, exponent)) = decimals(x) {
                (most, highest) = (most.max(digits), highest.max(exponent));
                largest = largest.max(x.abs());
                is_single &= f64::from(x as f32) == x;
            }
        }
        let extent = Bounds::of(points.iter().copied()).extent();
        let extent = (0..P::DIM).map(|i| extent.coord(i)).fold(0.0, f64::max);
        let double = last_bit(largest, 52);
        let (form, step) = if is_single && most > SINGLE {
            (Form::Single, last_bit(largest, 23))
        } else if most >= FULL || most == 0 {
            (Form::Double, double)
        } else {
            (Form::Decimal, 10f64.powi(highest - most + 1).max(double))
        };
        Digits { form, step, double, extent }
    }

    /// Returns the step for joining facets. It is 0 if all coordinates are equal.
    pub fn step(&self) -> f64 {
        self.step.min(COARSEST * self.extent)
    }

    /// Returns the distance by which rounding may have moved the points.
    pub fn rounding(&self) -> f64 {
        let doubles = DOUBLES * self.double;
        let decimals = DECIMALS * self.step;
        match self.form {
            Form::Decimal if decimals <= FINE * self.extent => doubles.max(decimals),
            Form::Single => doubles.max(SINGLES * self.step),
            Form::Decimal | Form::Double => doubles,
        }
    }
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

/// Returns the value of the last of `bits` binary digits after the first, or 0 for 0.
fn last_bit(x: f64, bits: i32) -> f64 {
    let exponent = ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    if x == 0.0 { 0.0 } else { 2f64.powi(exponent - bits) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn steps_follow_the_digits() {
        let step = |points: &[[f64; 3]]| {
            let points: Vec<DVec3> = points.iter().map(|&p| DVec3::from(p)).collect();
            Digits::of(&points).step()
        };
        assert_eq!(step(&[[0.0, 0.123_456, 0.5], [1.0, 0.25, -1.732_051]]), 1e-6);
        assert_eq!(step(&[[0.012_345_678, 1.234_567_8, 0.0], [1.0, 0.25, -1.732_051]]), 1e-7);
        // The limit applies to coarse numbers.
        assert_eq!(step(&[[0.0; 3], [1.0, 1.0, 1.0]]), COARSEST);
        assert!(step(&[[0.1 + 0.2, 1.0 / 3.0, 0.0], [1.0, 0.0, 0.0]]) < 1e-15);
        assert_eq!(step(&[[f64::from(0.1f32), f64::from(0.3f32), 0.0], [1.0; 3]]), f64::from(f32::EPSILON));
        assert_eq!(step(&[[1.0; 3], [1.0; 3]]), 0.0);
    }

    #[test]
    fn digits_give_the_rounding() {
        let at = |x: f64, y: f64, z: f64| Digits::of(&[DVec3::ZERO, DVec3::new(x, y, z)]).rounding();
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-6, "{a:e} {b:e}");
        near(at(0.955_336, 0.295_520, 3.591_599), 2e-6);
        // Six digits of `%g`, the last near zero.
        near(at(0.382_683, 1.22465e-16, 123.456), 2e-3);
        near(at(500_000.123, 0.5, 1.0), 2e-3);
        // Few digits are exact.
        near(at(1.0, 2.0, 0.5), 8.0 * f64::EPSILON * 2.0);
        near(at(0.1f64 + 0.2, 1.0 / 3.0, 0.7), 8.0 * f64::EPSILON / 2.0);
        near(at(f64::from(0.1f32), f64::from(0.3f32), 0.75), 4.0 * f64::from(f32::EPSILON) / 2.0);
        assert_eq!(Digits::of::<DVec3>(&[]).rounding(), 0.0);
        assert_eq!(at(0.0, -0.0, 0.0), 0.0);
    }
}
