//! The exact stage of points with weights and of images.
//!
//! **Statement.** The determinant is `sum_i (|p_i - q|^2 - (w_i - w_q)) o_i` ([`super::tie`]): each weight lowers the lift
//! of its corner by a *drop*. The cofactors are those without weights. Let `2^g` divide all coordinates, and let
//! `2^(2g)` divide all weights. In these units, differences and drops are integers, and [`super::integer`] computes the
//! determinant. Its widths hold for differences below `2^b` and drops of at most `2^(2b)`.
//!
//! **Range.** [`crate::range`] counts a weight as a square, so `b` is at most 411, and the widest integers always suffice.
//!
//! **Work.** As in [`super::integer`]; microseconds for a call in the widest integers.

use super::integer::{Drops, Row, Signs, in_circle, in_sphere, orient, rows};
use super::lattice::{integer, largest_unit, unit_of, width};
use super::sign::Sign;
use super::wide::Int;
use crate::point::Point;
use crate::site::largest_low;

/// The cell and the query of a call, in units of the lattice.
struct Call<'a, P> {
    cell: &'a [P],
    q: P,
    /// Exponent of the unit of lengths; weights have twice this exponent.
    unit: i32,
}

impl<P: Point> Call<'_, P> {
    /// Returns the differences and the drops as integers of `D` and `M` limbs.
    fn integers<const D: usize, const M: usize>(&self) -> ([Row<D>; 4], Drops<M>) {
        let weight = |p: &P| integer::<M>(p.weight(), 2 * self.unit);
        let base = weight(&self.q);
        let mut drops = [Int([0; M]); 4];
        for (drop, corner) in drops.iter_mut().zip(self.cell) {
            *drop = weight(corner).minus(base);
        }
        (rows(self.cell, self.q, |x| integer(x, self.unit)), Some(drops))
    }

    fn signs<const D: usize, const M: usize, const C: usize, const S: usize, const N: usize>(&self) -> Signs {
        let (rows, drops) = self.integers::<D, M>();
        if P::DIM == 2 { in_circle::<D, M, S>(&rows, &drops) } else { in_sphere::<D, M, C, N>(&rows, &drops) }
    }
}

/// Returns the width of differences of up to `reach`. Rounded differences of images have errors of up to four roundings, so
/// an exact difference may be the next power of two.
fn width_of<P: Point>(points: &[P], reach: f64, unit: i32) -> i32 {
    let low = largest_low(points);
    if low == 0.0 { width(reach, unit) } else { width(reach + 4.0 * low, unit) + 1 }
}

/// Computes the exact orientation of a cell whose differences are at most `reach`.
pub(super) fn orientation<P: Point>(cell: &[P], reach: f64) -> Sign {
    let (others, base) = (&cell[..P::DIM], cell[P::DIM]);
    let unit = largest_unit(cell);
    match width_of(cell, reach, unit) {
        ..=62 => orient::<1, 2, 3>(&rows(others, base, |x| integer(x, unit)), P::DIM),
        63..=126 => orient::<2, 4, 6>(&rows(others, base, |x| integer(x, unit)), P::DIM),
        _ => orient::<7, 14, 21>(&rows(others, base, |x| integer(x, unit)), P::DIM),
    }
}

/// Computes the exact signs for a cell and a query whose differences are at most `reach`.
pub(super) fn conflict<P: Point>(cell: &[P], q: P, reach: f64) -> Signs {
    let cell = &cell[..=P::DIM];
    let weights = cell.iter().chain([&q]).map(|p| unit_of(p.weight()).div_euclid(2)).min();
    let unit = largest_unit(&[q]).min(largest_unit(cell)).min(weights.unwrap_or(i32::MAX));
    let drop = cell.iter().fold(0.0, |most: f64, p| most.max((p.weight() - q.weight()).abs()));
    // A drop below `2^k` is at most `2^(2b)` if `2b >= k`.
    let of_drops = (width(drop, 2 * unit) + 1).div_euclid(2);
    let call = Call { cell, q, unit };
    match width_of(cell, reach, unit).max(width_of(&[q], reach, unit)).max(of_drops) {
        ..=62 => call.signs::<1, 2, 3, 4, 5>(),
        63..=126 => call.signs::<2, 4, 6, 8, 10>(),
        _ => call.signs::<7, 14, 21, 28, 35>(),
    }
}
