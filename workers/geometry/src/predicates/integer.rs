//! Stage 2: determinants in integers of fixed width, chosen for each call from its bits.
//!
//! **Statement.** In units of the call's lattice ([`super::lattice`]), differences are integers below `2^b`. The
//! expanded quantities, with all partial sums, have these bounds:
//!
//! | quantity | space: below | plane: below |
//! | --- | --- | --- |
//! | minor | `2^(2b + 1)` | `2^(2b + 1)`: the plane's orientation and cofactor |
//! | cofactor, the orientation in space | `6 * 2^(3b) < 2^(3b + 2.6)` | |
//! | lift | `3 * 2^(2b) < 2^(2b + 1.6)` | `2^(2b + 1)` |
//! | determinant | `4 * 3 * 6 * 2^(5b) < 2^(5b + 6.2)` | `3 * 2 * 2 * 2^(4b) < 2^(4b + 3.6)` |
//!
//! An integer of `N` limbs represents absolute values below `2^(64 N - 1)`. This gives three widths. Calls that need
//! more go to [`super::expansion`].
//!
//! | differences | in-sphere | in-circle | orientation |
//! | --- | --- | --- | --- |
//! | narrow | `b <= 24`: 128 bits | `b <= 30`: 128 bits | |
//! | single | `b <= 62`: 320 bits | `b <= 62`: 256 bits | `b <= 62`: 192 or 128 bits |
//! | double | `b <= 126`: 640 bits | `b <= 126`: 512 bits | `b <= 126`: 384 or 256 bits |
//!
//! **Weights.** Drops ([`super::weighted`]) are integers of at most `2^(2b)` in units of the squared lattice. Then lifts lie
//! below `2^(2b + 2)`, and determinants below `2^(5b + 6.6)` and `2^(4b + 4.2)`. These fit the same limbs. A third width
//! of 7 limbs, for differences of up to 446 bits, covers the range that [`crate::range`] admits.
//!
//! **Work.** At most 72 products (in-sphere). A product takes 1, 2 to 6, or 4 to 24 multiplications of limbs in the
//! three widths.
//!
//! **Source.** The determinants have the same forms as in stage 1. Levy, "Robustness and efficiency of geometric
//! programs: the Predicate Construction Kit" (2016), also proposes fixed widths instead of expansions.

use super::lattice::{integer, largest_unit, quick_integer, quick_unit, width};
use super::sign::Sign;
use super::wide::Int;
use crate::point::Point;

/// The exact signs of an in-sphere determinant and of its cofactors (see [`super::filter::Rounded`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Signs {
    pub det: Sign,
    pub cofactors: [Sign; 4],
}

pub(super) type Row<const D: usize> = [Int<D>; 3];

/// Computes the differences of `points` to `q` as integers. Unused rows and entries are 0.
#[inline]
pub(super) fn rows<P: Point, const D: usize>(
    points: &[P],
    q: P,
    integer: impl Fn(f64) -> Int<D>,
) -> [Row<D>; 4] {
    let mut rows = [[Int([0; D]); 3]; 4];
    for axis in 0..P::DIM {
        let place = |p: &P| {
            let high = integer(p.coord(axis));
            if P::IS_WEIGHTED { high.plus(integer(p.low(axis))) } else { high }
        };
        let base = place(&q);
        for (row, p) in rows.iter_mut().zip(points) {
            row[axis] = place(p).minus(base);
        }
    }
    rows
}

#[inline]
fn minor<const D: usize, const M: usize>(a: &Row<D>, b: &Row<D>) -> Int<M> {
    a[0].times::<D, M>(b[1]).minus(b[0].times::<D, M>(a[1]))
}

/// Computes `a.z bc - b.z ac + c.z ab`.
#[inline]
fn det3<const D: usize, const M: usize, const C: usize>(
    (a, bc): (&Row<D>, Int<M>),
    (b, ac): (&Row<D>, Int<M>),
    (c, ab): (&Row<D>, Int<M>),
) -> Int<C> {
    bc.times::<D, C>(a[2]).minus(ac.times::<D, C>(b[2])).plus(ab.times::<D, C>(c[2]))
}

/// Computes the squared length in `L` limbs. In the plane the third entry is not used.
#[inline]
fn lift<const D: usize, const L: usize>(a: &Row<D>, dimension: usize) -> Int<L> {
    let square = |x: Int<D>| x.times::<D, L>(x);
    let planar = square(a[0]).plus(square(a[1]));
    if dimension == 2 { planar } else { planar.plus(square(a[2])) }
}

/// The amounts by which the lifts of the corners are lowered.
pub(super) type Drops<const L: usize> = Option<[Int<L>; 4]>;

/// Computes the product of a cofactor and the lift of corner `i`, which is lowered if there are drops.
#[inline]
fn term<const D: usize, const M: usize, const C: usize, const N: usize>(
    cofactor: Int<C>,
    (i, row): (usize, &Row<D>),
    drops: &Drops<M>,
    dimension: usize,
) -> Int<N> {
    let square = lift::<D, M>(row, dimension);
    match drops {
        None => cofactor.times_natural::<M, N>(square),
        Some(drops) => cofactor.times::<M, N>(square.minus(drops[i])),
    }
}

pub(super) fn in_circle<const D: usize, const M: usize, const N: usize>(
    [a, b, c, _]: &[Row<D>; 4],
    drops: &Drops<M>,
) -> Signs {
    let cofactors = [minor::<D, M>(b, c), minor(c, a), minor(a, b)];
    let term = |i: usize, row: &Row<D>| term::<D, M, M, N>(cofactors[i], (i, row), drops, 2);
    let det = term(0, a).plus(term(1, b)).plus(term(2, c));
    let [first, second, third] = cofactors.map(Int::sign);
    Signs { det: det.sign(), cofactors: [first, second, third, Sign::Zero] }
}

pub(super) fn in_sphere<const D: usize, const M: usize, const C: usize, const N: usize>(
    [a, b, c, d]: &[Row<D>; 4],
    drops: &Drops<M>,
) -> Signs {
    let (ab, bc, cd) = (minor::<D, M>(a, b), minor(b, c), minor(c, d));
    let (da, ac, bd) = (minor(d, a), minor(a, c), minor(b, d));
    let zero = Int([0; M]);
    let abc = det3::<D, M, C>((a, bc), (b, ac), (c, ab));
    let bcd = det3::<D, M, C>((b, cd), (c, bd), (d, bc));
    // Row (c, d, a): the minor of its first and last entry is ca = -ac. The others are analogous.
    let cda = det3::<D, M, C>((c, da), (d, zero.minus(ac)), (a, cd));
    let dab = det3::<D, M, C>((d, ab), (a, zero.minus(bd)), (b, da));
    let term = |cofactor: Int<C>, i: usize, row: &Row<D>| term::<D, M, C, N>(cofactor, (i, row), drops, 3);
    let inside = term(bcd, 0, a).plus(term(dab, 2, c));
    let outside = term(cda, 1, b).plus(term(abc, 3, d));
    let det = inside.minus(outside).sign();
    Signs { det, cofactors: [bcd.sign(), cda.sign().opposite(), dab.sign(), abc.sign().opposite()] }
}

/// Returns the number of trailing zero bits that all entries have. The unit could be larger by two to the power of
/// this number.
#[inline]
fn spare(rows: &[Row<1>; 4]) -> u32 {
    rows.as_flattened().iter().fold(1 << 63, |bits, x| bits | x.0[0]).trailing_zeros()
}

/// Computes the exact signs for a cell and a query whose differences are at most `reach`. Returns `None` if they need
/// more than 126 bits.
pub(super) fn conflict<P: Point>(cell: &[P], q: P, reach: f64) -> Option<Signs> {
    // This length is known at compile time, so the compiler unrolls loops over it.
    let cell = &cell[..=P::DIM];
    let narrow = if P::DIM == 2 { 30 } else { 24 };
    let unit = quick_unit(&[q]).min(quick_unit(cell));
    let bits = width(reach, unit);
    if bits <= 62 {
        let rows = rows(cell, q, |x| quick_integer(x, unit));
        let spare = spare(&rows);
        if bits - spare as i32 <= narrow {
            return Some(conflict_narrow::<P>(&rows.map(|row| row.map(|x| x.shifted_down(spare)))));
        }
        return Some(conflict_single::<P>(&rows));
    }
    let unit = largest_unit(&[q]).min(largest_unit(cell));
    let bits = width(reach, unit);
    if bits <= narrow {
        Some(conflict_narrow::<P>(&rows(cell, q, |x| integer(x, unit))))
    } else if bits <= 62 {
        Some(conflict_single::<P>(&rows(cell, q, |x| integer(x, unit))))
    } else if bits <= 126 {
        Some(conflict_double::<P>(&rows(cell, q, |x| integer(x, unit))))
    } else {
        None
    }
}

pub(super) fn conflict_narrow<P: Point>(rows: &[Row<1>; 4]) -> Signs {
    if P::DIM == 2 { in_circle::<1, 1, 2>(rows, &None) } else { in_sphere::<1, 1, 2, 2>(rows, &None) }
}

pub(super) fn conflict_single<P: Point>(rows: &[Row<1>; 4]) -> Signs {
    if P::DIM == 2 { in_circle::<1, 2, 4>(rows, &None) } else { in_sphere::<1, 2, 3, 5>(rows, &None) }
}

pub(super) fn conflict_double<P: Point>(rows: &[Row<2>; 4]) -> Signs {
    if P::DIM == 2 { in_circle::<2, 4, 8>(rows, &None) } else { in_sphere::<2, 4, 6, 10>(rows, &None) }
}

pub(super) fn orient<const D: usize, const M: usize, const C: usize>(
    [a, b, c, _]: &[Row<D>; 4],
    dimension: usize,
) -> Sign {
    if dimension == 2 {
        return minor::<D, M>(a, b).sign();
    }
    // The last point is the base, so the orientation is minus the determinant of the rows.
    det3::<D, M, C>((a, minor(b, c)), (b, minor(a, c)), (c, minor(a, b))).sign().opposite()
}

/// Computes the exact orientation of a cell whose differences are at most `reach`. Returns `None` if they need more
/// than 126 bits.
pub(super) fn orientation<P: Point>(cell: &[P], reach: f64) -> Option<Sign> {
    let (others, base) = (&cell[..P::DIM], cell[P::DIM]);
    let unit = quick_unit(cell);
    if width(reach, unit) <= 62 {
        return Some(orient::<1, 2, 3>(&rows(others, base, |x| quick_integer(x, unit)), P::DIM));
    }
    let unit = largest_unit(cell);
    match width(reach, unit) {
        ..=62 => Some(orient::<1, 2, 3>(&rows(others, base, |x| integer(x, unit)), P::DIM)),
        63..=126 => Some(orient::<2, 4, 6>(&rows(others, base, |x| integer(x, unit)), P::DIM)),
        _ => None,
    }
}
