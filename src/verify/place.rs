//! Positions: points of the input, and their images in a periodic box.
//!
//! **Statement.** A [`Place`] is the exact sum of some floats along each axis. For a point alone, it is one float. For the image
//! `x + k L` of a point, [`Image`] holds three floats `near + rest[0] + rest[1]` whose exact sum is `x + k L`:
//! 1. `k L = high + low` exactly. `L` is `m 2^e` with `m < 2^53`, and `|k| < 2^30` ([`FARTHEST`]). So `k m` has at most
//!    83 bits, `high` is this integer rounded to 53 bits, and `low` the difference, of at most 30 bits.
//! 2. `x + high = sum + rest[0]` and `sum + low = near + rest[1]` exactly (two-sum, Knuth). Sums of floats do not underflow, and
//!    [`super::soup`] keeps all numbers below `2^900`, so they do not overflow.
//!
//! So `|near - (x + k L)|` is at most `|rest[0]| + |rest[1]|`, which [`Place::slack`] bounds. If no sum is rounded, both
//! are 0.
//!
//! **Source.** Two-sum: Knuth, *The Art of Computer Programming*, volume 2, 4.2.2.
//!
//! **Work.** O(1) for each axis.

use std::array::from_fn;
use std::cmp::Ordering;

use super::dyadic::{split, sum_sign, two_to};

/// The largest number in a file of offsets, and the largest number of lengths between a point and the box at
/// the first point. Translations are
/// sums of at most 15 of them, and smaller than `2^30`.
pub(super) const FARTHEST: i32 = 1 << 26;

/// A translation of the lattice of a box: a whole number of lengths along each axis.
pub(super) trait Steps: Copy + Ord + Send + Sync {
    /// No translation.
    const ZERO: Self;
    /// Returns the sum of two translations.
    fn plus(self, other: Self) -> Self;
    /// Returns the difference of two translations.
    fn minus(self, other: Self) -> Self;
    /// Returns the translation by `steps` lengths along one axis.
    fn along(axis: usize, steps: i32) -> Self;
}

/// Without a box, there is one translation.
impl Steps for () {
    const ZERO: Self = ();
    #[inline]
    fn plus(self, (): Self) -> Self {}
    #[inline]
    fn minus(self, (): Self) -> Self {}
    #[inline]
    fn along(_: usize, _: i32) -> Self {}
}

impl<const D: usize> Steps for [i32; D] {
    const ZERO: Self = [0; D];
    #[inline]
    fn plus(self, other: Self) -> Self {
        from_fn(|axis| self[axis].wrapping_add(other[axis]))
    }
    #[inline]
    fn minus(self, other: Self) -> Self {
        from_fn(|axis| self[axis].wrapping_sub(other[axis]))
    }
    #[inline]
    fn along(axis: usize, steps: i32) -> Self {
        from_fn(|k| if k == axis { steps } else { 0 })
    }
}

/// A vertex of a cell: a row of the input, and the translation of its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Vertex<S> {
    pub row: u32,
    pub steps: S,
}

impl<S: Steps> Vertex<S> {
    /// Returns the translated vertex.
    #[inline]
    pub fn moved(self, by: S) -> Self {
        Vertex { steps: self.steps.plus(by), ..self }
    }

    /// Sorts vertices, and translates them such that the first one has no translation. Translated lists of distinct vertices
    /// become equal, because their order is the same. Returns the translation of the first one.
    #[inline]
    pub fn settle(vertices: &mut [Self]) -> S {
        vertices.sort_unstable();
        let first = vertices.first().map_or(S::ZERO, |vertex| vertex.steps);
        for vertex in vertices {
            vertex.steps = vertex.steps.minus(first);
        }
        first
    }
}

/// A position in `R^D`.
pub(super) trait Place<const D: usize>: Copy + Send + Sync {
    /// The translations of the box.
    type Steps: Steps;
    /// Whether there is a box.
    const IS_PERIODIC: bool;
    /// Returns the image of a point. The length of an open axis is 0.
    fn of(point: &[f64; D], steps: Self::Steps, lengths: &[f64; D]) -> Self;
    /// Returns the numbers of lengths of a translation along each axis.
    fn steps_of(offsets: &[i32]) -> Self::Steps;
    /// Returns the rounded coordinates.
    fn near(&self) -> &[f64; D];
    /// Returns a bound of the distance of a rounded coordinate to the exact one.
    fn slack(&self, axis: usize) -> f64;
    /// Returns the floats whose exact sum is a coordinate.
    fn parts(&self, axis: usize) -> [f64; 3];

    /// Compares coordinates, exactly.
    fn compare(&self, other: &Self, axis: usize) -> Ordering {
        let difference = self.near()[axis] - other.near()[axis];
        let slack = self.slack(axis) + other.slack(axis);
        if slack == 0.0 || difference.abs() > 2.0 * slack {
            return difference.partial_cmp(&0.0).unwrap_or(Ordering::Equal);
        }
        sum_sign(&[self.parts(axis), other.parts(axis).map(|part| -part)].concat())
    }

    /// Compares positions in lexicographic order, exactly.
    fn lexicographic(&self, other: &Self) -> Ordering {
        (0..D).fold(Ordering::Equal, |order, axis| order.then_with(|| self.compare(other, axis)))
    }

    /// Returns `true` if two coordinates differ by more than a length. Exact.
    fn is_farther(&self, other: &Self, axis: usize, length: f64) -> bool {
        let difference = (self.near()[axis] - other.near()[axis]).abs();
        let slack = self.slack(axis) + other.slack(axis);
        let margin = 2.0 * slack + 4.0 * f64::EPSILON * (difference + length);
        if (difference - length).abs() > margin {
            return difference > length;
        }
        let sign = |from: &Self, to: &Self| {
            let parts = [to.parts(axis), from.parts(axis).map(|part| -part), [-length, 0.0, 0.0]];
            sum_sign(parts.as_flattened())
        };
        sign(self, other).is_gt() || sign(other, self).is_gt()
    }
}

/// A point of the input.
impl<const D: usize> Place<D> for [f64; D] {
    type Steps = ();
    const IS_PERIODIC: bool = false;

    #[inline]
    fn of(point: &[f64; D], (): (), _: &[f64; D]) -> Self {
        *point
    }
    #[inline]
    fn steps_of(_: &[i32]) {}
    #[inline]
    fn near(&self) -> &[f64; D] {
        self
    }
    #[inline]
    fn slack(&self, _: usize) -> f64 {
        0.0
    }
    #[inline]
    fn parts(&self, axis: usize) -> [f64; 3] {
        [self[axis], 0.0, 0.0]
    }
    #[inline]
    fn lexicographic(&self, other: &Self) -> Ordering {
        // The coordinates are finite and never `-0.0`.
        self.partial_cmp(other).unwrap_or(Ordering::Equal)
    }
}

/// An image of a point in a periodic box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image<const D: usize> {
    near: [f64; D],
    rest: [[f64; D]; 2],
}

/// Returns the rounded sum and its error. Exact.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let of_b = sum - a;
    [sum, (a - (sum - of_b)) + (b - of_b)]
}

/// Returns two floats whose exact sum is a whole number of lengths.
fn multiple(steps: i32, length: f64) -> [f64; 2] {
    let (m, e) = split(length);
    let whole = i128::from(m) * i128::from(steps);
    let high = whole as f64;
    let low = (whole - high as i128) as f64;
    [high, low].map(|part| part * two_to(e))
}

impl<const D: usize> Place<D> for Image<D> {
    type Steps = [i32; D];
    const IS_PERIODIC: bool = true;

    fn of(point: &[f64; D], steps: [i32; D], lengths: &[f64; D]) -> Self {
        let mut image = Image { near: *point, rest: [[0.0; D]; 2] };
        for axis in (0..D).filter(|&axis| steps[axis] != 0) {
            let [high, low] = multiple(steps[axis], lengths[axis]);
            let [sum, first] = two_sum(point[axis], high);
            let [near, second] = two_sum(sum, low);
            image.near[axis] = near + 0.0;
            (image.rest[0][axis], image.rest[1][axis]) = (first, second);
        }
        image
    }

    fn steps_of(offsets: &[i32]) -> [i32; D] {
        from_fn(|axis| offsets.get(axis).copied().unwrap_or_default())
    }

    fn near(&self) -> &[f64; D] {
        &self.near
    }

    fn slack(&self, axis: usize) -> f64 {
        // The factor exceeds the rounding of the sum and of the product.
        let [first, second] = [self.rest[0][axis], self.rest[1][axis]];
        if first == 0.0 && second == 0.0 {
            return 0.0;
        }
        ((first.abs() + second.abs()) * (1.0 + 4.0 * f64::EPSILON)).max(f64::MIN_POSITIVE)
    }

    fn parts(&self, axis: usize) -> [f64; 3] {
        [self.near[axis], self.rest[0][axis], self.rest[1][axis]]
    }
}
