//! Signs of orientation and in-sphere: an `f64` filter before the exact forms, and the tie rule.
//!
//! **Statement.** [`sign`] is the exact sign of the form of `others - base` (see [`super::exact`]).
//!
//! **The filter's bound.** Let `u = 2^-53` and let every rounded difference be at most `M_k` in size
//! on axis `k`. An exact difference is its rounded value times `1 + d`, `|d| <= u` (a subtraction of
//! floats cannot underflow inexactly). Expand the form into its monomials. Each passes, between the
//! exact value and the computed one, at most so many factors `1 + d`: one for each difference in it,
//! and one for each rounding on its way to the root of the expression:
//!
//! | form | differences | roundings | monomials, each at most | sum, times u |
//! |---|---|---|---|---|
//! | orientation, plane | 2 | 2: product, sum | 2 of `Mx My` | 8 |
//! | in-circle | 4 | 7: square, sum; product, sum; product; 2 sums | 6 of `Mx My L` | 66 |
//! | orientation, space | 3 | 5: product, sum, product, 2 sums | 6 of `Mx My Mz` | 48 |
//! | in-sphere | 5 | 12: square, 2 sums; 5 as above; product; 3 sums | 24 of `Mx My Mz L` | 408 |
//!
//! with `L = sum M_k^2` (the squares of one norm add up to at most `L`). The constants of [`bound`]
//! are larger by at least 2 %, which pays for the terms in `u^2` and for the rounding of the bound.
//! Underflow: all `M_k` are required to lie in `[2^-100, 2^100]`. Then nothing overflows, and a
//! product of `j <= 5` differences that underflows errs by at most `2^-1075` times the other factors
//! of its monomials: relative to the bound at most `2^-1075 / (u 2^(-100 j)) <= 2^-522`, which the
//! 2 % pay for, too. What lies outside the range goes to the exact form. An axis with `M_k = 0` has
//! only equal coordinates, and the form is exactly zero.
//!
//! **The tie rule** (Edelsbrunner and Muecke 1990; Devillers and Teillaud 2011). Heights `|p|^2` are
//! raised by infinitesimals, the larger by orders the higher the point's lexicographic rank. The
//! in-sphere form is linear in the heights, so the first point, by decreasing rank, whose derivative
//! is not zero decides: for the query minus the orientation of the cell, for a vertex of the cell
//! the orientation of the cell with the query in its place.

use std::array::from_fn;
use std::cmp::Ordering;

use super::exact::{exact_sign, form};

/// The smallest and the largest difference that the filter admits: `2^-100` and `2^100`.
const RANGE: (f64, f64) = (f64::from_bits((1023 - 100) << 52), f64::from_bits((1023 + 100) << 52));

/// The constant of the bound: see the table above.
const fn constant(d: usize, k: usize) -> f64 {
    let units = match (d, k) {
        (2, 2) => 9.0,
        (2, _) => 68.0,
        (_, 3) => 50.0,
        _ => 418.0,
    };
    units * (f64::EPSILON / 2.0)
}

/// The error bound for differences of at most `largest` per axis.
#[inline]
fn bound<const D: usize, const K: usize>(largest: &[f64; D]) -> f64 {
    let product: f64 = largest.iter().product();
    let squares: f64 = if K == D { 1.0 } else { largest.iter().map(|m| m * m).sum() };
    constant(D, K) * product * squares
}

/// The exact sign of the form of `others - base`: the orientation of `base, others` if `K = D`, the
/// in-sphere form of the cell `others` and the query `base` if `K = D + 1`.
#[inline]
pub(super) fn sign<const D: usize, const K: usize>(base: &[f64; D], others: &[[f64; D]; K]) -> Ordering {
    let rows: [[f64; D]; K] = from_fn(|i| from_fn(|k| others[i][k] - base[k]));
    let largest: [f64; D] = from_fn(|k| rows.iter().fold(0.0, |m: f64, row| m.max(row[k].abs())));
    if largest.contains(&0.0) {
        return Ordering::Equal;
    }
    if largest.iter().all(|m| (RANGE.0..=RANGE.1).contains(m)) {
        let value = form(&rows);
        let error = bound::<D, K>(&largest);
        if value > error {
            return Ordering::Greater;
        }
        if value < -error {
            return Ordering::Less;
        }
    }
    exact_sign(base, others)
}

/// The orientation of a cell of `N = D + 1` points.
#[inline]
pub(super) fn orientation<const D: usize, const N: usize>(cell: &[[f64; D]; N]) -> Ordering {
    let others: [[f64; D]; D] = from_fn(|i| cell[i + 1]);
    sign(&cell[0], &others)
}

/// The orientation of the cell with `q` in the place of vertex `slot`.
#[inline]
pub(super) fn replaced<const D: usize, const N: usize>(
    cell: &[[f64; D]; N],
    slot: usize,
    q: &[f64; D],
) -> Ordering {
    let mut cell = *cell;
    cell[slot] = *q;
    orientation(&cell)
}

/// The in-sphere sign: greater when `q` is strictly inside the sphere of the positive `cell`.
#[inline]
pub(super) fn in_sphere<const D: usize, const N: usize>(cell: &[[f64; D]; N], q: &[f64; D]) -> Ordering {
    sign(q, cell)
}

/// Lexicographic order by coordinates; they are finite, and `-0.0` has become `0.0`.
#[inline]
pub(super) fn lexicographic<const D: usize>(p: &[f64; D], q: &[f64; D]) -> Ordering {
    p.partial_cmp(q).unwrap_or(Ordering::Equal)
}

/// The perturbed in-sphere sign where the exact one is zero: is `q` inside?
pub(super) fn tie_inside<const D: usize, const N: usize>(cell: &[[f64; D]; N], q: &[f64; D]) -> bool {
    let mut slots: [usize; N] = from_fn(|i| i);
    slots.sort_unstable_by(|&i, &j| lexicographic(&cell[j], &cell[i]));
    for slot in slots {
        if lexicographic(&cell[slot], q).is_lt() {
            break;
        }
        match replaced(cell, slot, q) {
            Ordering::Equal => {}
            decided => return decided.is_gt(),
        }
    }
    // The query's turn: raising it puts it outside of a positively oriented cell.
    false
}
