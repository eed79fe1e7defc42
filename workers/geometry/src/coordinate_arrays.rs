//! Points as arrays of coordinates: the distances of one point to many, eight at a time.
//!
//! **Statement.** Every distance equals the result of [`dist2`](crate::point::dist2), bit for bit. The lanes of
//! vector registers compute the same differences, squares and sums in the same order.
//!
//! **Work and depth.** A vector step over the pairs, charged by [`Cost::all_pairs`](crate::cost::Cost::all_pairs) and
//! by the sweeps over balls.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

use std::marker::PhantomData;
use std::ops::Range;

use crate::point::Point;
use crate::simd::widest;

/// Number of points whose distances are computed together.
pub(crate) const LANES: usize = 8;

/// Points as one array of coordinates for each axis.
#[derive(Clone, Debug)]
pub struct CoordinateArrays<P> {
    axes: [Vec<f64>; 3],
    /// The axes from the fourth on.
    further: Vec<Vec<f64>>,
    marker: PhantomData<P>,
}

/// Receives the columns near each row in [`Cost::all_pairs`](crate::cost::Cost::all_pairs).
pub trait PairVisitor {
    /// Begins a row. Returns its limit: the squared distance beyond which it needs no columns.
    fn begin(&mut self, row: usize) -> f64;
    /// Receives a column of the current row that is within the limit. Returns the new limit.
    fn visit(&mut self, column: usize, distance2: f64) -> f64;
    /// Receives the eight columns from `first` on, of which at least one is within the limit. Returns the new limit.
    #[inline(always)]
    fn visit_lanes(&mut self, first: usize, distances2: &[f64; LANES], limit2: f64) -> f64 {
        one_by_one(distances2, limit2, |lane, d2| self.visit(first + lane, d2))
    }
    /// Decides, after the last column of the row, whether the row is visited again. If the limit was too small,
    /// discards the columns received and returns a larger limit for the second visit.
    #[inline]
    fn retry(&mut self, _row: usize) -> Option<f64> {
        None
    }
    /// Ends the row.
    fn end(&mut self, row: usize);
}

/// Calls `near` for each distance within the limit. Each call returns the limit for the following distances.
#[inline(always)]
pub(crate) fn one_by_one(
    distances2: &[f64; LANES],
    mut limit2: f64,
    mut near: impl FnMut(usize, f64) -> f64,
) -> f64 {
    for (lane, &d2) in distances2.iter().enumerate() {
        if d2 <= limit2 {
            limit2 = near(lane, d2);
        }
    }
    limit2
}

impl<P: Point> CoordinateArrays<P> {
    /// Copies the coordinates of some points, in their order.
    #[expect(clippy::needless_pass_by_value, reason = "iterators are small, and cloned")]
    pub fn of(points: impl Iterator<Item = P> + Clone) -> Self {
        let column = |axis: usize| -> Vec<f64> { points.clone().map(|x| x.coord(axis)).collect() };
        let axes = std::array::from_fn(|axis| if axis < P::DIM { column(axis) } else { Vec::new() });
        CoordinateArrays { axes, further: (3..P::DIM).map(column).collect(), marker: PhantomData }
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.axes[0].len()
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Calls `near` for every point of the range within the limit, in order. The arguments are its position relative to
    /// the start of `range` and its squared distance. Each call returns the limit for the following points.
    #[inline]
    pub fn each_within(
        &self,
        range: Range<usize>,
        centre: P,
        limit2: f64,
        mut near: impl FnMut(usize, f64) -> f64,
    ) {
        widest(
            #[inline(always)]
            || {
                self.each_block(range, centre, limit2, |first, distances2, limit2| {
                    one_by_one(distances2, limit2, |lane, d2| near(first + lane, d2))
                });
            },
        );
    }

    /// Passes the columns within the limit to the visitor, row after row.
    pub(crate) fn each_row(&self, rows: &[P], visitor: &mut impl PairVisitor) {
        widest(
            #[inline(always)]
            || {
                for (row, &at) in rows.iter().enumerate() {
                    let limit2 = visitor.begin(row);
                    self.each_block(0..self.len(), at, limit2, |first, distances2, limit2| {
                        visitor.visit_lanes(first, distances2, limit2)
                    });
                    visitor.end(row);
                }
            },
        );
    }

    /// Calls `near` for each block of eight points of which at least one is within the limit. The arguments are the
    /// position of the first point and the eight squared distances. Each call returns the limit for the following
    /// blocks. NaN fills the last block.
    #[inline(always)]
    fn each_block(
        &self,
        range: Range<usize>,
        centre: P,
        mut limit2: f64,
        mut near: impl FnMut(usize, &[f64; LANES], f64) -> f64,
    ) {
        if P::DIM > 3 {
            return self.each_block_of_many_axes(range, centre, limit2, near);
        }
        let [x, y, z] = &self.axes;
        let z = if P::DIM == 2 { y } else { z };
        let (x, x_rest) = x[range.clone()].as_chunks::<LANES>();
        let (y, y_rest) = y[range.clone()].as_chunks::<LANES>();
        let (z, z_rest) = z[range].as_chunks::<LANES>();
        let last = P::DIM - 1;
        let at = [centre.coord(0), centre.coord(1), centre.coord(last)];
        let distance2 = |x: f64, y: f64, z: f64| {
            let (x, y, z) = (x - at[0], y - at[1], z - at[2]);
            if P::DIM == 2 { x * x + y * y } else { x * x + y * y + z * z }
        };
        let mut first = 0;
        for ((x, y), z) in x.iter().zip(y).zip(z) {
            let distances2: [f64; LANES] = std::array::from_fn(|i| distance2(x[i], y[i], z[i]));
            if distances2.iter().fold(false, |any, &d2| any | (d2 <= limit2)) {
                limit2 = near(first, &distances2, limit2);
            }
            first += LANES;
        }
        let mut distances2 = [f64::NAN; LANES];
        for (((d2, &x), &y), &z) in distances2.iter_mut().zip(x_rest).zip(y_rest).zip(z_rest) {
            *d2 = distance2(x, y, z);
        }
        if distances2.iter().fold(false, |any, &d2| any | (d2 <= limit2)) {
            near(first, &distances2, limit2);
        }
    }
}

impl<P: Point> CoordinateArrays<P> {
    /// As [`CoordinateArrays::each_block`], above three dimensions.
    #[inline(always)]
    fn each_block_of_many_axes(
        &self,
        range: Range<usize>,
        centre: P,
        mut limit2: f64,
        mut near: impl FnMut(usize, &[f64; LANES], f64) -> f64,
    ) {
        for first in (0..range.len()).step_by(LANES) {
            let lanes = LANES.min(range.len() - first);
            let mut distances2 = [0.0; LANES];
            for (axis, column) in self.axes.iter().chain(&self.further).enumerate() {
                let column = &column[range.start + first..][..lanes];
                add_squares(&mut distances2, column, centre.coord(axis));
            }
            distances2[lanes..].fill(f64::NAN);
            if distances2.iter().fold(false, |any, &d2| any | (d2 <= limit2)) {
                limit2 = near(first, &distances2, limit2);
            }
        }
    }
}

/// Adds the squares of the differences along one axis. The first square is added to 0, which does not round.
#[inline(always)]
pub(crate) fn add_squares(distances2: &mut [f64; LANES], column: &[f64], at: f64) {
    for (d2, x) in distances2.iter_mut().zip(column) {
        *d2 += (x - at) * (x - at);
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::incremental::tests::nasty::{KINDS, set};
    use crate::point::dist2;

    fn distances_are_those_of_pairs<P: Point>() {
        for kind in KINDS {
            let points = set::<P>(kind, 90, 3);
            let columns = CoordinateArrays::of(points.iter().copied());
            for (range, &centre) in (0..points.len()).map(|i| i / 2..points.len() - i / 3).zip(&points) {
                let all: Vec<f64> = points[range.clone()].iter().map(|&x| dist2(x, centre)).collect();
                let limit2 = all[all.len() / 2];
                let (mut found, mut expected) = (Vec::new(), Vec::new());
                columns.each_within(range, centre, limit2, |i, d2| {
                    found.push((i, d2));
                    limit2
                });
                expected.extend(all.into_iter().enumerate().filter(|&(_, d2)| d2 <= limit2));
                assert_eq!(found, expected, "{kind}");
            }
        }
    }

    #[test]
    fn distances_of_space_are_those_of_pairs() {
        distances_are_those_of_pairs::<DVec3>();
    }

    #[test]
    fn distances_of_the_plane_are_those_of_pairs() {
        distances_are_those_of_pairs::<DVec2>();
    }

    #[test]
    fn a_limit_may_fall_on_the_way() {
        let points: Vec<DVec2> = (0..40).map(|i| DVec2::new(f64::from(i * 17 % 40), 0.0)).collect();
        let columns = CoordinateArrays::of(points.iter().copied());
        let mut least = Vec::new();
        columns.each_within(0..40, DVec2::new(7.2, 0.0), f64::INFINITY, |i, d2| {
            least.push(i);
            d2
        });
        assert_eq!(points[*least.last().unwrap()].x, 7.0);
        assert!(least.len() < 10);
    }
}
