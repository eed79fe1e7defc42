//! The rows of a rank, from the survey to the points of the machine.
//!
//! **Statement.** Rows with a coordinate that is not finite are removed, -0.0 becomes 0.0, and a power of two scales all
//! coordinates into the exact range. The power depends on the digits of all rows ([`septet_geometry::range`]).
//!
//! **Work and depth.** Vector steps over the rows. They are not charged.

use septet_geometry::point::Point;
use septet_geometry::range::{Digits, not_finite, scale};
use septet_protocol::codec::Bulk;
use septet_protocol::message::{PointBatch, RefusedRow, Survey};

use crate::input::source::{Rows, with_room};
use crate::machine::context::Context;

/// Number of rows that one core surveys in turn.
const CHUNK: usize = 1 << 14;

impl<P: Point> Rows<P> {
    /// Surveys the rows: their number, the rows that are not finite, and the digits of the others. If `exactly` is set, the
    /// digits are those in use. Otherwise, there may be more of them.
    pub(super) fn survey(&self, cx: &Context<P>, exactly: bool) -> Survey {
        let chunks: Vec<(u64, &[P])> =
            (self.first..).step_by(CHUNK).zip(self.positions.chunks(CHUNK)).collect();
        let surveys = cx.map(&chunks, |&(first, points)| surveyed(first, points, exactly));
        surveys.into_iter().fold(Survey::default(), Survey::join)
    }

    /// Prepares the rows with this survey, multiplied by 2 to the power `exponent`. Returns the points, and the numbers of
    /// the rows that are not finite.
    pub(super) fn prepare(self, survey: &Survey, exponent: i32) -> (PointBatch<P>, Vec<u64>) {
        let Rows { first, mut positions, sizes } = self;
        let mut ids = Vec::with_capacity(with_room(positions.len()));
        ids.extend(first..first + positions.len() as u64);
        if exponent != 0 || survey.negative_zeros > 0 {
            for x in &mut positions {
                *x = scaled(without_negative_zero(*x), exponent);
            }
        }
        let radius2 = |&size: &f64| squared_radius(scaled(P::splat(size), exponent).coord(0));
        let radii2 = Bulk(sizes.iter().map(radius2).collect());
        let mut points = PointBatch { radii2, ..PointBatch::in_transit(ids, positions) };
        let mut refused = Vec::new();
        if survey.refused > 0 {
            let keeps: Vec<bool> = points.positions.iter().map(is_finite).collect();
            refused.extend((first..).zip(&keeps).filter(|(_, keeps)| !**keeps).map(|(row, _)| row));
            points.keep(&keeps);
        }
        (points, refused)
    }
}

fn is_finite<P: Point>(x: &P) -> bool {
    not_finite(x).is_none()
}

/// Surveys some rows, whose first has the number `first`.
fn surveyed<P: Point>(first: u64, points: &[P], exactly: bool) -> Survey {
    let bound = if exactly { None } else { Digits::upper_bound(points) };
    let negative_zeros = negative_zeros(points);
    if let Some(digits) = bound.filter(|digits| digits.fits()) {
        return Survey {
            rows: points.len() as u64,
            first,
            last: first + (points.len() as u64).saturating_sub(1),
            negative_zeros,
            digits: digits.ends(),
            ..Survey::default()
        };
    }
    (first..)
        .zip(points)
        .fold(Survey { negative_zeros, ..Survey::default() }, |all, (row, x)| all.join(of_row(row, x)))
}

fn negative_zeros<P: Point>(points: &[P]) -> u64 {
    let is_one = |x: f64| u64::from(x.to_bits() == (-0.0f64).to_bits());
    points.iter().map(|x| (0..P::DIM).map(|i| is_one(x.coord(i))).sum::<u64>()).sum()
}

/// Surveys one row exactly, except for negative zeros.
fn of_row<P: Point>(row: u64, x: &P) -> Survey {
    let mut survey =
        Survey { rows: 1, first: row, last: row, lowest_row: row, highest_row: row, ..Survey::default() };
    if let Some(digits) = Digits::of(std::slice::from_ref(x)) {
        survey.digits = digits.ends();
    } else {
        let value = not_finite(x).unwrap_or(f64::NAN);
        survey.refused = 1;
        survey.first_refused = Some(RefusedRow { row, value });
    }
    survey
}

fn without_negative_zero<P: Point>(mut x: P) -> P {
    for i in 0..P::DIM {
        x.set_coord(i, x.coord(i) + 0.0);
    }
    x
}

fn scaled<P: Point>(x: P, exponent: i32) -> P {
    if exponent == 0 { x } else { scale(x, exponent) }
}

/// Returns the largest float below the square of a size, so that `d2 <= radius2` iff `d2 < size * size`.
///
/// If the square overflows, the result is the largest float, which no squared distance in the range exceeds. If it
/// underflows to 0, the result is 0, which is less than the squared distance of any two sites.
pub fn squared_radius(size: f64) -> f64 {
    (size * size).next_down().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squared_radii_make_the_comparison_strict() {
        for size in [1e-300, 1e-20, 0.1, 1.0, 3.0, 1e20, 1e200] {
            let (square, r2) = (size * size, squared_radius(size));
            for d2 in [square, square.next_down(), square.next_up(), 1e-130, 1.0, 1e120] {
                if d2.is_finite() && d2 > 0.0 {
                    assert_eq!(d2 <= r2, d2 < square, "{size} {d2}");
                }
            }
        }
    }
}
