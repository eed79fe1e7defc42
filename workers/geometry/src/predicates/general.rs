//! Predicates of dimensions 4, 5 and 6: a filter with the permanent as its error bound, then exact integers.
//!
//! **Statement.** Let `r_i = p_i - q`. The cofactor `o_i` is `(-1)^i det(r_j, j != i)`, and the in-sphere determinant is
//! `sum_i |r_i|^2 o_i`. The minors of the first `c` columns of a matrix follow from those of the first `c - 1`, by Laplace
//! expansion along the last column, for all sets of `c` lines. All cofactors come from one table of `2^(d + 1)` minors.
//!
//! **The filter.** The same recurrence over absolute values gives the permanent `M`: the sum of the absolute values of all
//! products of the expanded determinant. Every product passes at most `k` roundings. So the rounded determinant has the sign
//! of the exact one if its absolute value exceeds `1.05 k u M` (`u = 2^-53`; the proof of [`crate::filter`] with the permanent
//! for `n P`). The counts of roundings are sums:
//!
//! - a minor of `d` columns has `d` differences, `d` products and `d (d - 1) / 2` additions;
//! - a lift has a difference that counts twice, a square and `d - 1` additions;
//! - the product of both, and `d` additions of such terms.
//!
//! This gives `k = d (d + 3) / 2` for orientations and `k = d (d - 1) / 2 + 4 d + 3` for in-sphere determinants. The latter
//! also bounds the terms of a determinant with a column of lifts ([`plane`]): there are `d - 1` differences and a lift in the
//! minor, and one more difference. The permanent is rounded as often as the determinant, so `1.05` covers its error.
//!
//! **Underflow.** Differences are multiplied by a power of two such that the largest lies in `[1/2, 1)`. So no later factor
//! exceeds `d! d < 2^13`, nothing overflows, and the at most `2^11` operations lose less than `2^-1049` in total. The bound
//! grows by `2^-1000`.
//!
//! **The exact stage.** In units of the lattice of the call ([`super::lattice`]), differences are integers below `2^b`. Minors
//! lie below `d! 2^(d b)`, lifts below `d 2^(2b)`, and determinants below `(d + 1) d! d 2^((d + 2) b)`. For `D` limbs of a
//! difference, `b <= 64 D - 2`, and minors of `d D` limbs, lifts of `2 D` and determinants of `(d + 2) D` limbs hold these
//! bounds: `log2(7 * 720 * 6) < 15 < 2 (d + 2) D - 1`. Differences of 1, 2 and 7 limbs cover the range that [`crate::range`]
//! admits. If `b` is so small that all partial sums stay below `2^53`, rounded arithmetic is exact and replaces integers.
//!
//! **Work.** At most `(d + 1) 2^d` products: 80 for `d = 4`, and 448 for `d = 6`.
//!
//! **Departures.** The rank of some vectors is full iff one of their largest minors is not zero. No elimination is needed.

use super::lattice::{integer, is_exact, largest_unit, width};
use super::sign::Sign;
use super::wide::Int;
use crate::filter::Rounded;
use crate::point::{Array, Point};

/// The largest dimension.
pub(crate) const MOST_DIM: usize = 6;

/// The largest number of sets of lines of a matrix.
const SETS: usize = 1 << (MOST_DIM + 1);

/// `1.05 u`.
const SLACK: f64 = 1.05 * (f64::EPSILON / 2.0);

/// `2^-1000`.
pub(crate) const TINY: f64 = f64::from_bits((1023 - 1000) << 52);

/// For dimensions 4, 5 and 6, widths of differences for which orientations and all partial sums stay below `2^53`.
const EXACT_ORIENTATION: [u64; 3] = [12, 9, 7];
/// As [`EXACT_ORIENTATION`], for in-sphere determinants.
const EXACT_IN_SPHERE: [u64; 3] = [7, 5, 4];

/// Returns the factor `1.05 k u` of orientations.
const fn orientation_factor(d: usize) -> f64 {
    SLACK * ((d * (d + 3)) / 2) as f64
}

/// Returns the factor `1.05 k u` of in-sphere determinants and of planes.
pub(crate) const fn in_sphere_factor(d: usize) -> f64 {
    SLACK * ((d * (d - 1)) / 2 + 4 * d + 3) as f64
}

/// Numbers in which minors are computed.
trait Number: Copy {
    /// The entries of a matrix.
    type Entry;
    const ZERO: Self;
    const ONE: Self;
    /// Adds the product of a minor and an entry, or subtracts it.
    fn add_product(&mut self, is_negative: bool, minor: Self, entry: Self::Entry);
}

/// A rounded determinant and its permanent.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Minor {
    pub(crate) value: f64,
    pub(crate) size: f64,
}

impl Number for Minor {
    type Entry = f64;
    const ZERO: Self = Minor { value: 0.0, size: 0.0 };
    const ONE: Self = Minor { value: 1.0, size: 1.0 };
    #[inline]
    fn add_product(&mut self, is_negative: bool, minor: Self, entry: f64) {
        let product = minor.value * entry;
        self.value = if is_negative { self.value - product } else { self.value + product };
        self.size += minor.size * entry.abs();
    }
}

/// An integer of `C` limbs, for entries of `D` limbs.
#[derive(Clone, Copy)]
struct Exact<const D: usize, const C: usize>(Int<C>);

impl<const D: usize, const C: usize> Number for Exact<D, C> {
    type Entry = Int<D>;
    const ZERO: Self = Exact(Int([0; C]));
    const ONE: Self = {
        let mut limbs = [0; C];
        limbs[0] = 1;
        Exact(Int(limbs))
    };
    #[inline]
    fn add_product(&mut self, is_negative: bool, Exact(minor): Self, entry: Int<D>) {
        let product = minor.times::<D, C>(entry);
        self.0 = if is_negative { self.0.minus(product) } else { self.0.plus(product) };
    }
}

/// Computes the minors of the first columns of a matrix, for all sets of at most `columns` of its lines. The entry of a set
/// is at the number whose bits are its lines.
#[inline]
fn minors<T: Number>(lines: usize, columns: usize, entry: impl Fn(usize, usize) -> T::Entry) -> [T; SETS] {
    let mut all = [T::ZERO; SETS];
    all[0] = T::ONE;
    for set in 1usize..1 << lines {
        let size = set.count_ones() as usize;
        if size > columns {
            continue;
        }
        let mut sum = T::ZERO;
        // The sign of the last entry of the last column is positive.
        let (mut is_negative, mut rest) = (size.is_multiple_of(2), set);
        while rest != 0 {
            let line = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            sum.add_product(is_negative, all[set & !(1 << line)], entry(line, size - 1));
            is_negative = !is_negative;
        }
        all[set] = sum;
    }
    all
}

/// Returns the set of all of `lines` lines but one.
const fn without(lines: usize, line: usize) -> usize {
    ((1 << lines) - 1) & !(1 << line)
}

/// Returns the power of two that brings numbers up to `largest` below 1. It is 1 for zero and out of range.
pub(crate) fn scale_of(largest: f64) -> f64 {
    let biased = largest.to_bits() >> 52;
    // The largest number is at most `2^(biased - 1022)`.
    if (64..1984).contains(&biased) { f64::from_bits((1023 + 1022 - biased) << 52) } else { 1.0 }
}

/// The differences of some points to a base, scaled, and the largest of them before scaling.
struct Differences<P: Point> {
    rows: P::Corners,
    reach: f64,
    scale: f64,
}

impl<P: Point> Differences<P> {
    fn of(points: &[P], base: P) -> Self {
        let mut rows = P::Corners::from_fn(|i| points.get(i).map_or(P::default(), |&p| p - base));
        let mut reach = 0.0f64;
        for row in rows.as_ref() {
            for axis in 0..P::DIM {
                reach = reach.max(row.coord(axis).abs());
            }
        }
        let scale = scale_of(reach);
        for row in rows.as_mut() {
            *row = *row * scale;
        }
        Differences { rows, reach, scale }
    }

    #[inline]
    fn entry(&self, line: usize, column: usize) -> f64 {
        self.rows.as_ref()[line].coord(column)
    }

    /// Computes the minors of the first `lines` rows.
    fn minors(&self, lines: usize) -> [Minor; SETS] {
        minors(lines, P::DIM, |line, column| self.entry(line, column))
    }

    /// Computes the in-sphere determinant and its permanent, and the cofactors.
    fn in_sphere(&self) -> (Minor, [f64; MOST_DIM + 1]) {
        let (minors, lines) = (self.minors(P::DIM + 1), P::DIM + 1);
        let (mut sum, mut cofactors) = (Minor::ZERO, [0.0; MOST_DIM + 1]);
        for (i, cofactor) in cofactors.iter_mut().enumerate().take(lines) {
            let minor = minors[without(lines, i)];
            sum.add_product(!i.is_multiple_of(2), minor, self.rows.as_ref()[i].norm2());
            *cofactor = if i.is_multiple_of(2) { minor.value } else { -minor.value };
        }
        (sum, cofactors)
    }
}

fn rounded(minor: Minor, factor: f64, reach: f64) -> Rounded {
    Rounded { det: minor.value, bound: factor * minor.size + TINY, cofactors: [0.0; 4], reach }
}

/// Computes the orientation of `DIM + 1` points, up to a positive factor.
pub(crate) fn rounded_orientation<P: Point>(cell: &[P]) -> Rounded {
    let differences = Differences::of(&cell[1..=P::DIM], cell[0]);
    let minor = differences.minors(P::DIM)[(1 << P::DIM) - 1];
    rounded(minor, orientation_factor(P::DIM), differences.reach)
}

/// Computes the in-sphere determinant, up to a positive factor. It has no cofactors.
pub(crate) fn rounded_in_sphere<P: Point>(cell: &[P], q: P) -> Rounded {
    let differences = Differences::of(&cell[..=P::DIM], q);
    rounded(differences.in_sphere().0, in_sphere_factor(P::DIM), differences.reach)
}

/// Computes [`Point::hull_normal`], up to a positive factor.
pub(crate) fn hull_normal<P: Point>(rel: &[P]) -> P {
    let d = P::DIM;
    let differences = Differences::of(&rel[..d - 1], P::default());
    let minors = minors::<Minor>(d, d - 1, |axis, row| differences.entry(row, axis));
    let mut normal = P::default();
    for axis in 0..d {
        let minor = minors[without(d, axis)].value;
        normal.set_coord(axis, if (axis + d).is_multiple_of(2) { -minor } else { minor });
    }
    normal
}

/// Computes [`Point::sphere_plane`], up to a positive factor.
pub(crate) fn sphere_plane<P: Point>(rel: &[P]) -> (f64, P) {
    let differences = Differences::of(&rel[..P::DIM], P::default());
    let rows = differences.rows;
    let (w, normal) = plane(|i| (rows.as_ref()[i], rows.as_ref()[i].norm2()));
    let mut v = P::default();
    for axis in 0..P::DIM {
        v.set_coord(axis, normal.as_ref()[axis].value);
    }
    (w.value * differences.scale, v)
}

/// Computes the sphere through the origin and the vectors of a facet. `vertex` returns each vector with its lift, the squared
/// length. Returns `(w, v)`: a point `r` lies inside iff `v . r - w |r|^2 > 0`, if the vectors are positively oriented. For
/// the vector 0 with the lift 1, which stands for infinity, this is the orientation with `r` in the place of that vector.
pub(crate) fn plane<P: Point>(vertex: impl Fn(usize) -> (P, f64)) -> (Minor, P::Axes<Minor>) {
    let d = P::DIM;
    // The lines are the axes and the lift.
    let minors = minors::<Minor>(d + 1, d, |line, row| {
        let (at, lift) = vertex(row);
        if line == d { lift } else { at.coord(line) }
    });
    let normal = P::Axes::from_fn(|axis| {
        let Minor { value, size } = if axis < d { minors[without(d + 1, axis)] } else { Minor::ZERO };
        Minor { value: if (axis + d).is_multiple_of(2) { -value } else { value }, size }
    });
    (minors[without(d + 1, d)], normal)
}

/// The exact signs of an in-sphere determinant and of its cofactors.
pub(super) struct Signs {
    pub(super) det: Sign,
    pub(super) cofactors: [Sign; MOST_DIM + 1],
}

/// Differences as integers, one row for each point.
type Rows<const D: usize> = [[Int<D>; MOST_DIM]; MOST_DIM + 1];

fn rows<P: Point, const D: usize>(points: &[P], base: P, unit: i32) -> Rows<D> {
    let mut rows = [[Int([0; D]); MOST_DIM]; MOST_DIM + 1];
    for (row, p) in rows.iter_mut().zip(points) {
        for (axis, entry) in row.iter_mut().enumerate().take(P::DIM) {
            *entry = integer::<D>(p.coord(axis), unit).minus(integer(base.coord(axis), unit));
        }
    }
    rows
}

/// Computes the determinant of the first `d` rows.
fn det<const D: usize, const C: usize>(rows: &Rows<D>, d: usize) -> Sign {
    minors::<Exact<D, C>>(d, d, |line, column| rows[line][column])[(1 << d) - 1].0.sign()
}

/// Computes the in-sphere determinant of `d + 1` rows.
fn conflict<const D: usize, const C: usize, const L: usize, const N: usize>(
    rows: &Rows<D>,
    d: usize,
) -> Signs {
    let minors = minors::<Exact<D, C>>(d + 1, d, |line, column| rows[line][column]);
    let (mut sum, mut cofactors) = (Int([0; N]), [Sign::Zero; MOST_DIM + 1]);
    for (i, row) in rows.iter().enumerate().take(d + 1) {
        let Exact(minor) = minors[without(d + 1, i)];
        let squares = row[..d].iter().map(|x| x.times::<D, L>(*x));
        let product = minor.times_natural::<L, N>(squares.fold(Int([0; L]), Int::plus));
        let is_even = i.is_multiple_of(2);
        sum = if is_even { sum.plus(product) } else { sum.minus(product) };
        cofactors[i] = if is_even { minor.sign() } else { minor.sign().opposite() };
    }
    Signs { det: sum.sign(), cofactors }
}

/// Returns `true` if some minor of the first `n` rows with `n` of the first `d` columns is not zero.
fn has_rank<const D: usize, const C: usize>(rows: &Rows<D>, n: usize, d: usize) -> bool {
    let minors = minors::<Exact<D, C>>(d, n, |axis, row| rows[row][axis]);
    (1usize..1 << d).any(|set| set.count_ones() as usize == n && minors[set].0.sign() != Sign::Zero)
}

/// Calls a function of differences with the numbers of limbs for the dimension.
macro_rules! with_limbs {
    ($d:expr, $points:expr, $base:expr, ($bits:expr, $unit:expr), |$rows:ident| $f:ident($($more:expr),*)) => {{
        macro_rules! of_width {
            ($limbs:literal, $four:tt, $five:tt, $six:tt) => {{
                let $rows = &rows::<P, $limbs>($points, $base, $unit);
                match $d {
                    4 => limbs!($f, $rows, $limbs, $four, ($($more),*)),
                    5 => limbs!($f, $rows, $limbs, $five, ($($more),*)),
                    _ => limbs!($f, $rows, $limbs, $six, ($($more),*)),
                }
            }};
        }
        match $bits {
            ..=62 => of_width!(1, (4, 2, 6), (5, 2, 7), (6, 2, 8)),
            63..=126 => of_width!(2, (8, 4, 12), (10, 4, 14), (12, 4, 16)),
            _ => of_width!(7, (28, 14, 42), (35, 14, 49), (42, 14, 56)),
        }
    }};
}

macro_rules! limbs {
    (conflict, $rows:ident, $d:literal, ($c:literal, $l:literal, $n:literal), ($($more:expr),*)) => {
        conflict::<$d, $c, $l, $n>($rows, $($more),*)
    };
    ($f:ident, $rows:ident, $d:literal, ($c:literal, $l:literal, $n:literal), ($($more:expr),*)) => {
        $f::<$d, $c>($rows, $($more),*)
    };
}

/// Computes the exact orientation of a cell whose differences are at most `reach`.
pub(super) fn orientation<P: Point>(cell: &[P], reach: f64) -> Sign {
    let (d, others, base) = (P::DIM, &cell[1..=P::DIM], cell[0]);
    if is_exact(cell, reach, EXACT_ORIENTATION[d - 4]) {
        return Sign::of(Differences::of(others, base).minors(d)[(1 << d) - 1].value);
    }
    let unit = largest_unit(cell);
    with_limbs!(d, others, base, (width(reach, unit), unit), |rows| det(d))
}

/// Computes the exact signs for a cell and a query whose differences are at most `reach`.
pub(super) fn in_sphere<P: Point>(cell: &[P], q: P, reach: f64) -> Signs {
    let digits = EXACT_IN_SPHERE[P::DIM - 4];
    if is_exact(&[q], reach, digits) && is_exact(cell, reach, digits) {
        let (det, cofactors) = Differences::of(cell, q).in_sphere();
        return Signs { det: Sign::of(det.value), cofactors: cofactors.map(Sign::of) };
    }
    let unit = largest_unit(&[q]).min(largest_unit(cell));
    with_limbs!(P::DIM, cell, q, (width(reach, unit), unit), |rows| conflict(P::DIM))
}

/// Returns `true` if `q` lies outside the affine hull of the affinely independent `basis` of at most `DIM` points. Exact.
pub(super) fn is_outside<P: Point>(basis: &[P], q: P) -> bool {
    let (n, d) = (basis.len(), P::DIM);
    let differences = Differences::of(basis, q);
    let minors = minors::<Minor>(d, n, |axis, row| differences.entry(row, axis));
    let factor = orientation_factor(d);
    let is_certain = |minor: &Minor| minor.value.abs() > factor * minor.size + TINY;
    if (1usize..1 << d).any(|set| set.count_ones() as usize == n && is_certain(&minors[set])) {
        return true;
    }
    let unit = largest_unit(&[q]).min(largest_unit(basis));
    with_limbs!(d, basis, q, (width(differences.reach, unit), unit), |rows| has_rank(n, d))
}
