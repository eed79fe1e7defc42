//! The exact order of crossings along a line, computed with big integers.
//!
//! **Statement.** The segment from `p` to `q` crosses the plane of a wall at the parameter `o(p) / (o(p) - o(q))`,
//! where `o` is the orientation determinant of the wall. Multiplied by a common power of two, the coordinates are
//! integers. The parameters are therefore fractions that can be compared exactly.
//!
//! **Work and depth.** O(1) operations on big integers per comparison.

use std::cmp::Ordering;

use num_bigint::BigInt;
use septet_geometry::point::Point;

/// Splits `x` into `m` and `e` with `x = m 2^e`.
pub(crate) fn split(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let (m, e) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    (if x < 0.0 { -m } else { m }, e)
}

/// Converts coordinates to integers, with a common power of two as factor.
pub fn integers<P: Point>(points: &[P]) -> Vec<Vec<BigInt>> {
    let parts = |p: &P| (0..P::DIM).map(|i| split(p.coord(i))).collect::<Vec<_>>();
    let all: Vec<Vec<(i64, i32)>> = points.iter().map(parts).collect();
    let low = all.iter().flatten().filter(|x| x.0 != 0).map(|x| x.1).min().unwrap_or(0);
    let whole = |&(m, e): &(i64, i32)| if m == 0 { BigInt::ZERO } else { BigInt::from(m) << (e - low) };
    all.iter().map(|p| p.iter().map(whole).collect()).collect()
}

/// Returns `x 2^exponent`, rounded. The result may be infinite or zero.
pub fn rounded(x: &BigInt, mut exponent: i32) -> f64 {
    // The lowest of 64 digits says whether a digit below it is set, so that the conversion rounds to the right side.
    let size = x.magnitude();
    let below = size.bits().saturating_sub(64);
    let high = (size >> below).iter_u64_digits().next().unwrap_or(0);
    let sticky = u64::from(size.trailing_zeros().is_some_and(|zeros| zeros < below));
    let mut value = (high | sticky) as f64;
    exponent += below as i32;
    while exponent != 0 {
        let step = exponent.clamp(-1000, 1000);
        value *= 2f64.powi(step);
        exponent -= step;
    }
    if *x < BigInt::ZERO { -value } else { value }
}

/// Returns the orientation determinant with the rows `wall[1..] - wall[0]` and `q - wall[0]`.
pub fn determinant(wall: &[Vec<BigInt>], q: &[BigInt]) -> BigInt {
    let minus = |a: &[BigInt]| a.iter().zip(&wall[0]).map(|(a, o)| a - o).collect::<Vec<_>>();
    let a = minus(&wall[1]);
    if wall.len() == 2 {
        let b = minus(q);
        return &a[0] * &b[1] - &a[1] * &b[0];
    }
    let (b, c) = (minus(&wall[2]), minus(q));
    &c[0] * (&a[1] * &b[2] - &a[2] * &b[1])
        + &c[1] * (&a[2] * &b[0] - &a[0] * &b[2])
        + &c[2] * (&a[0] * &b[1] - &a[1] * &b[0])
}

/// A parameter on a line: numerator and positive denominator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fraction(BigInt, BigInt);

impl Fraction {
    /// Returns the parameter at which the segment from `p` to `q` crosses the plane of `wall`. The ends lie on
    /// different sides of the plane.
    pub fn crossing<P: Point>(wall: &[P], p: P, q: P) -> Self {
        let mut all = wall.to_vec();
        all.extend([p, q]);
        let all = integers(&all);
        let (wall, ends) = all.split_at(wall.len());
        let (at_p, at_q) = (determinant(wall, &ends[0]), determinant(wall, &ends[1]));
        let span = &at_p - at_q;
        if span < BigInt::ZERO { Fraction(-at_p, -span) } else { Fraction(at_p, span) }
    }
}

impl PartialOrd for Fraction {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Fraction {
    fn cmp(&self, other: &Self) -> Ordering {
        (&self.0 * &other.1).cmp(&(&other.0 * &self.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};
    use septet_geometry::predicates::{Sign, orientation};

    #[test]
    fn crossings_compare_to_the_last_bit() {
        let wall = |z: f64| [DVec3::new(-1.0, -1.0, z), DVec3::new(3.0, -1.0, z), DVec3::new(-1.0, 3.0, z)];
        let (p, q) = (DVec3::new(0.1, 0.1, -1.0), DVec3::new(0.1, 0.2, 2.0));
        let at = |z| Fraction::crossing(&wall(z), p, q);
        assert!(at(0.3) < at(0.3 + 1e-16));
        assert_eq!(at(0.5), Fraction::crossing(&wall(0.5).map(|p| p * 1.0), p, q));
        assert!(at(-0.5) < at(0.0) && at(0.0) < at(1.9));
        let edge = |x: f64| [DVec2::new(x, -1.0), DVec2::new(x, 1.0)];
        let at = |x| Fraction::crossing(&edge(x), DVec2::new(-1.0, 0.0), DVec2::new(7.0, 0.25));
        assert!(at(0.0) < at(1e-300) && at(1e-300) < at(5.0));
    }

    #[test]
    fn the_determinant_has_the_sign_of_the_predicate() {
        let cell = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.25, 0.5, -2.0)];
        let all = integers(&cell);
        assert!(determinant(&all[..3], &all[3]) < BigInt::ZERO);
        assert_eq!(orientation(&cell), Sign::Negative);
        let cell = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let all = integers(&cell);
        assert!(determinant(&all[..2], &all[2]) > BigInt::ZERO);
        assert_eq!(orientation(&cell), Sign::Positive);
    }
}
