//! Periodic boxes for points of one dimension.

use std::cmp::Ordering;

use septet_geometry::point::{Point, Position, Vector};
use septet_geometry::range::{Digits, not_finite, scale};
use septet_geometry::site::Weighted;
use septet_geometry::two_parts::TwoParts;
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

    /// Returns the digits of the box and of the rows that are finite.
    pub(super) fn digits<P: Position>(&self, rows: &[Weighted<P>]) -> Digits {
        let digits = |row: &Weighted<P>| Digits::of(std::slice::from_ref(row));
        let own = [self.corner::<P>(false), self.corner(true)];
        rows.iter().chain(&own).filter_map(digits).fold(Digits::NONE, Digits::join)
    }

    /// Scales a box and its rows by a power of two. Also removes the signs of zeros. Rows that are not finite stay as they are.
    pub(super) fn scaled<P: Position>(
        mut self,
        mut rows: Vec<Weighted<P>>,
        exponent: i32,
    ) -> (Self, Vec<Weighted<P>>) {
        each_chunk_mut(&mut rows, CHUNK, |_, rows| {
            for row in rows.iter_mut().filter(|row| not_finite(*row).is_none()) {
                for axis in 0..P::DIM {
                    row.set_coord(axis, row.coord(axis) + 0.0);
                }
                row.set_weight(row.weight() + 0.0);
                *row = scale(*row, exponent);
            }
        });
        let own = [self.corner::<P>(false), self.corner(true)];
        let [lengths, origin] = own.map(|corner| scale(corner, exponent));
        for axis in self.axes() {
            (self.lengths[axis], self.origin[axis]) = (lengths.coord(axis), origin.coord(axis));
        }
        self.exponent = exponent;
        (self, rows)
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

    /// Returns the image of a base site at these numbers of lengths, from -1 to 1, without rounding. [`Lattice::base`] admits
    /// only sites that have these images.
    pub(super) fn image<P: Position>(&self, base: Weighted<P>, steps: Steps) -> Weighted<P> {
        let mut by = P::default();
        for axis in self.axes() {
            by.set_coord(axis, f64::from(steps[axis]) * self.lengths[axis]);
        }
        base.translated(by).unwrap_or(base)
    }

    /// Returns the base site of a row: its image in the half-open box, and the numbers of lengths from the row to it. `index`
    /// is the position of the row in the input.
    ///
    /// # Errors
    /// Fails if the row lies outside of the closed box and the box does not wrap, or if an image of it is no sum of two floats.
    pub(super) fn base<P: Position>(
        &self,
        row: Weighted<P>,
        index: usize,
    ) -> Result<(Weighted<P>, Steps), PeriodicError> {
        let (mut base, mut steps) = (row, [0; 3]);
        for axis in self.axes() {
            let (value, length) = (row.coord(axis), self.lengths[axis]);
            let low = self.origin[axis];
            let (moved, found) = match self.place(row.parts(axis), axis) {
                Place::Inside => (row.parts(axis), 0),
                // The upper end of the box, as a float, may lie beyond it.
                Place::Outside if self.wrap || (low..=low + length).contains(&value) => {
                    let far =
                        PeriodicError::Far { index, value: self.given(value), length: self.given(length) };
                    self.wrapped(value, axis).ok_or(far)?
                }
                Place::AtHigh => (low.into(), -1),
                Place::Outside => {
                    let [value, low, high] = [value, low, low + length].map(|number| self.given(number));
                    return Err(PeriodicError::Outside { index, value, low, high, others: 0 });
                }
            };
            if [-length, length].into_iter().any(|by| moved.plus(by).is_none()) {
                return Err(PeriodicError::Far {
                    index,
                    value: self.given(value),
                    length: self.given(length),
                });
            }
            base.set_parts(axis, moved);
            steps[axis] = found;
        }
        Ok((base, steps))
    }

    /// Returns the image of a coordinate in the half-open box, and the number of lengths to it, if they are exact.
    fn wrapped(&self, value: f64, axis: usize) -> Option<(TwoParts, i32)> {
        let (low, length) = (self.origin[axis], self.lengths[axis]);
        let estimate = -((value - low) / length).floor();
        if estimate.abs() >= MOST_STEPS {
            return None;
        }
        // The quotient is rounded, so the estimate may be wrong by one.
        let around = [0, -1, 1].map(|more| estimate as i32 + more);
        let image = |steps| Some((TwoParts::from(value).plus_multiple(steps, length)?, steps));
        around.into_iter().filter_map(image).find(|(image, _)| self.place(*image, axis) == Place::Inside)
    }

    /// Returns where a coordinate lies. A number that the length cannot be subtracted from is outside.
    fn place(&self, value: TwoParts, axis: usize) -> Place {
        let (low, length) = (self.origin[axis], self.lengths[axis]);
        if value.compare(low).is_lt() {
            return Place::Outside;
        }
        match value.plus(-length).map(|value| value.compare(low)) {
            Some(Ordering::Less) => Place::Inside,
            Some(Ordering::Equal) => Place::AtHigh,
            Some(Ordering::Greater) | None => Place::Outside,
        }
    }
}

/// The place of a coordinate relative to the half-open box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Inside,
    /// On the upper face, whose image is the lower one.
    AtHigh,
    Outside,
}
