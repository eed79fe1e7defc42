//! Periodic boxes for points of one dimension.

use septet_geometry::point::{Point, Position, Vector};
use septet_geometry::range::{Digits, not_finite, scale};
use septet_geometry::site::Weighted;
use septet_workers::config::cores::each_chunk_mut;

use crate::error::PeriodicError;
use crate::result::periodic::Steps;
use crate::spec::Periodic;

/// Number of rows that one core scales in turn.
const CHUNK: usize = 1 << 14;

/// The largest number of lengths between a point and the box.
const MOST_STEPS: f64 = (1u32 << 20) as f64;

/// A periodic box for points of one dimension.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    /// The length along each axis; infinite for an axis that is not periodic, and for the third axis of the plane.
    pub(super) lengths: [f64; 3],
    pub(super) origin: [f64; 3],
    wrap: bool,
    /// The exponent of the power of two by which all numbers were multiplied.
    exponent: i32,
}

impl Lattice {
    /// Checks a box.
    ///
    /// # Errors
    /// Fails if the box has another dimension, or if a number is not admitted.
    pub(super) fn of(periodic: &Periodic, dimension: usize) -> Result<Self, PeriodicError> {
        let Periodic { lengths: given, origin: corner, wrap } = periodic;
        let check = |what, given: usize| {
            let fits = given == dimension;
            if fits { Ok(()) } else { Err(PeriodicError::Dimension { what, given, dimension }) }
        };
        check("periodic box", given.len())?;
        if !corner.is_empty() {
            check("origin of the periodic box", corner.len())?;
        }
        let (mut lengths, mut origin) = ([f64::INFINITY; 3], [0.0; 3]);
        for (to, length) in lengths.iter_mut().zip(given).filter_map(|(to, length)| Some((to, (*length)?))) {
            if !(length.is_normal() && length > 0.0) {
                let (what, expected) = ("length of the periodic box", "a positive number");
                return Err(PeriodicError::Number { what, value: length, expected });
            }
            *to = length;
        }
        for (to, &value) in origin.iter_mut().zip(corner) {
            if !value.is_finite() {
                let (what, expected) = ("origin of the periodic box", "a finite number");
                return Err(PeriodicError::Number { what, value, expected });
            }
            *to = value + 0.0;
        }
        let lattice = Lattice { lengths, origin, wrap: *wrap, exponent: 0 };
        if lattice.axes().next().is_none() { Err(PeriodicError::Open) } else { Ok(lattice) }
    }

    /// Scales a box and its rows into the range of exact signs. Also removes the signs of zeros. Rows that are not finite stay
    /// as they are.
    ///
    /// # Errors
    /// Fails if the digits spread too far.
    pub(super) fn scaled<P: Position>(
        mut self,
        mut rows: Vec<Weighted<P>>,
    ) -> Result<(Self, Vec<Weighted<P>>), PeriodicError> {
        let digits = |row: &Weighted<P>| Digits::of(std::slice::from_ref(row));
        let own = [self.corner::<P>(false), self.corner(true)];
        let all = rows.iter().chain(&own).filter_map(digits).fold(Digits::NONE, Digits::join);
        let exponent = all.scaling().map_err(|bits| PeriodicError::Spread { bits })?;
        each_chunk_mut(&mut rows, CHUNK, |_, rows| {
            for row in rows.iter_mut().filter(|row| not_finite(*row).is_none()) {
                for axis in 0..P::DIM {
                    row.set_coord(axis, row.coord(axis) + 0.0);
                }
                row.set_weight(row.weight() + 0.0);
                *row = scale(*row, exponent);
            }
        });
        let [lengths, origin] = own.map(|corner| scale(corner, exponent));
        for axis in self.axes() {
            (self.lengths[axis], self.origin[axis]) = (lengths.coord(axis), origin.coord(axis));
        }
        self.exponent = exponent;
        Ok((self, rows))
    }

    /// Returns the lengths or the origin as a point. Axes that are not periodic have 0.
    fn corner<P: Position>(&self, is_origin: bool) -> Weighted<P> {
        let mut corner = Weighted::default();
        for axis in self.axes() {
            corner.set_coord(axis, if is_origin { self.origin[axis] } else { self.lengths[axis] });
        }
        corner
    }

    /// Returns a number as the caller gave it.
    fn given(&self, number: f64) -> f64 {
        let half = self.exponent / 2;
        let two_to = |exponent: i32| 2.0f64.powi(-exponent);
        number * two_to(half) * two_to(self.exponent - half)
    }

    /// Returns the periodic axes.
    pub(super) fn axes(&self) -> impl Iterator<Item = usize> + Clone + use<> {
        let lengths = self.lengths;
        (0..3).filter(move |&axis| lengths[axis].is_finite())
    }

    /// Returns `true` if all `dimension` axes are periodic.
    pub(super) fn is_closed(&self, dimension: usize) -> bool {
        self.axes().count() == dimension
    }

    /// Returns the translation by these numbers of lengths. Exact if the numbers are at most [`MOST_STEPS`] and
    /// [`Lattice::base`] admitted them.
    pub(super) fn translation<P: Position>(&self, steps: Steps) -> P {
        let mut by = P::default();
        for axis in self.axes() {
            by.set_coord(axis, f64::from(steps[axis]) * self.lengths[axis]);
        }
        by
    }

    /// Returns the lengths from a point to its image in the half-open box. `index` is its position in the input.
    ///
    /// # Errors
    /// Fails if the point lies outside of the closed box and the box does not wrap, or if the number of lengths is too large
    /// for exact arithmetic.
    pub(super) fn base<P: Position>(&self, site: Weighted<P>, index: usize) -> Result<Steps, PeriodicError> {
        let mut steps = [0; 3];
        for axis in self.axes() {
            let (value, length) = (site.position().coord(axis), self.lengths[axis]);
            let low = self.origin[axis];
            let inner = |steps| self.place(value, steps, axis);
            let is_admitted = self.wrap || inner(0) != Place::Outside || inner(-1) == Place::AtLow;
            if !is_admitted {
                let [value, low, high] = [value, low, low + length].map(|number| self.given(number));
                return Err(PeriodicError::Outside { index, value, low, high, others: 0 });
            }
            let far = PeriodicError::Far { index, value: self.given(value), length: self.given(length) };
            let estimate = -((value - low) / length).floor();
            if estimate.abs() >= MOST_STEPS {
                return Err(far);
            }
            // The quotient is rounded, so the estimate may be wrong by one.
            let around = [0, -1, 1].map(|more| estimate as i32 + more);
            let found =
                around.into_iter().find(|&steps| inner(steps) != Place::Outside).ok_or(far.clone())?;
            // The images of the base site are one length farther.
            if ![found - 1, found, found + 1].into_iter().all(|steps| is_exact_multiple(steps, length)) {
                return Err(far);
            }
            steps[axis] = found;
        }
        Ok(steps)
    }

    /// Returns where the image of a coordinate lies. Exact if the translation is.
    fn place(&self, value: f64, steps: i32, axis: usize) -> Place {
        let (low, length) = (self.origin[axis], self.lengths[axis]);
        let by = f64::from(steps) * length;
        // The image is at least `low` iff `value + by >= low`, and below `low + length` iff `value + (by - length) < low`.
        let above_low = compare_sum(value, by, low);
        if above_low.is_lt() || compare_sum(value, f64::from(steps - 1) * length, low).is_ge() {
            return Place::Outside;
        }
        if above_low.is_eq() { Place::AtLow } else { Place::Inside }
    }
}

/// Compares `a + b` with `c`, exactly.
fn compare_sum(a: f64, b: f64, c: f64) -> std::cmp::Ordering {
    let sum = a + b;
    let of_b = sum - a;
    let low = (a - (sum - of_b)) + (b - of_b);
    // Rounding preserves the order except for ties. Adding zero removes the sign of a zero.
    (sum + 0.0).total_cmp(&(c + 0.0)).then((low + 0.0).total_cmp(&0.0))
}

/// Returns `true` if a number of lengths is a float.
fn is_exact_multiple(steps: i32, length: f64) -> bool {
    let significand = length.to_bits() & ((1 << 52) - 1) | 1 << 52;
    let product = u128::from(significand) * u128::from(steps.unsigned_abs());
    let digits = u128::BITS - product.leading_zeros();
    steps == 0 || digits - product.trailing_zeros() <= f64::MANTISSA_DIGITS
}

/// The place of an image relative to the half-open box, along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Inside,
    /// On the lower face, which belongs to the box.
    AtLow,
    Outside,
}
