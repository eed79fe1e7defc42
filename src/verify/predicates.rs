//! Signs of orientation and in-sphere: an `f64` filter before the exact forms, and the tie rule.
//!
//! **Statement.** [`sign`] is the exact sign of the form of `others - base` (see [`super::exact`]).
//!
//! **Bound of the filter.** Let `u = 2^-53`, and let every rounded difference on axis `k` be at most `M_k` in size. An exact
//! difference is its rounded value times `1 + d` with `|d| <= u`, because a subtraction of floats that underflows is exact.
//! Expand the form into its monomials. The computed value of a monomial differs from the exact one by factors `1 + d`. There
//! is one factor for each difference in it, and one for each rounding on its path to the root of the expression:
//!
//! | form | differences | roundings | monomials, each at most | sum, times u |
//! |---|---|---|---|---|
//! | orientation, plane | 2 | 2: product, sum | 2 of `Mx My` | 8 |
//! | in-circle | 4 | 7: square, sum; product, sum; product; 2 sums | 6 of `Mx My L` | 66 |
//! | orientation, space | 3 | 5: product, sum, product, 2 sums | 6 of `Mx My Mz` | 48 |
//! | in-sphere | 5 | 12: square, 2 sums; 5 as above; product; 3 sums | 24 of `Mx My Mz L` | 408 |
//! | in-circle, weights | 4 | 8: as without, and a sum | 6 of `Mx My (L + W)` | 72 |
//! | in-sphere, weights | 5 | 13: as without, and a sum | 24 of `Mx My Mz (L + W)` | 432 |
//! | orientation, `d > 3` | `d` | `r = d (d + 1) / 2 - 1` | `d!` of `P` | `d! (d + r)` |
//! | in-sphere, `d > 3` | `d + 2` | `r' = r + 2 d + 1` | `(d + 1)!` of `P L` | `(d + 1)! (d + 2 + r')` |
//!
//! Here `L = sum M_k^2`, `P` is the product of all `M_k`, and the squares of one norm add up to at most `L`. Every rounded difference of weights is at most
//! `W`. It counts as one difference, and it passes fewer roundings than a square. The constants of [`bound`] are larger
//! by at least 2 %. This margin covers the terms in `u^2` and the rounding of the bound.
//!
//! **Images** in a periodic box are rounded ([`super::place`]). Let the coordinates along axis `k` differ from the exact ones by
//! at most `s_k`, and let `S` be the largest of all `2 s_k / M_k`. Then a rounded difference is off by at most
//! `u M_k + 2 s_k <= (u + S) M_k`. A monomial of `g` differences and `r` roundings is off by at most
//! `(1 + u + S)^g (1 + u)^r - 1` times its bound. For `S <= 2^-20`, `g <= 8` and `r <= 34`, this is at most
//! `(g + r) u + g S`, and 0.1 % of it more. So the bound has `g S` times the number of monomials more, with a margin of 2 %
//! ([`differences`]). If `S` is larger, or if an axis has `M_k = 0` and `s_k > 0`, the exact form decides. Without rounding,
//! `S` is 0 and the bound is that of the table.
//!
//! **Underflow.** The filter requires all `M_k` to lie in `[2^-100, 2^100]`, so nothing overflows. A product of
//! `j <= 8` differences that underflows has an error of at most `2^-1075` times the other factors of its monomials.
//! Relative to the bound, this is at most `2^-1075 / (u 2^(-100 j)) <= 2^-222`, which the margin also covers.
//! A difference of weights may be small: a sum that underflows is exact, and its products are those of two differences.
//! It must be at most `2^200`. Differences outside this range use the exact form. An axis with `M_k = 0` has only equal coordinates, and the form
//! is exactly zero.
//!
//! **Tie rule** (Edelsbrunner and Muecke 1990; Devillers and Teillaud 2011). The heights `|p|^2 - w` are raised by
//! infinitesimals. A point of higher lexicographic rank has an infinitesimal that is larger by orders of magnitude.
//! The in-sphere form is linear in the heights. So the highest-ranked point whose derivative is not zero decides. For
//! the query, the derivative is minus the orientation of the cell. For a vertex of the cell, the derivative is the
//! orientation of the cell with the query instead of that vertex.

use std::array::from_fn;
use std::cmp::Ordering;

use super::exact::{Site, exact_power, exact_sign, factorial, form, lifted, norm};
use super::place::Place;
use super::ring::Ring;

/// The smallest and the largest difference that the filter admits: `2^-100` and `2^100`.
const RANGE: (f64, f64) = (f64::from_bits((1023 - 100) << 52), f64::from_bits((1023 + 100) << 52));

/// The largest difference of weights that the filter admits: `2^200`.
const HEAVIEST: f64 = f64::from_bits((1023 + 200) << 52);

/// The largest slack relative to the differences that the filter admits: `2^-20`.
const SLACKEST: f64 = f64::from_bits((1023 - 20) << 52);

/// Returns the constant of the bound, from the table above with its margin.
const fn constant(d: usize, k: usize) -> f64 {
    let units = match (d, k) {
        (2, 2) => 9.0,
        (2, _) => 68.0,
        (3, 3) => 50.0,
        (3, _) => 418.0,
        _ => monomials(k) * (degree(d, k) + roundings(d, k)) * 1.02,
    };
    units * (f64::EPSILON / 2.0)
}

/// Returns the constant of the bound with weights.
const fn constant_with_weights(d: usize) -> f64 {
    let units = match d {
        2 => 74.0,
        3 => 442.0,
        _ => monomials(d + 1) * (degree(d, d + 1) + roundings(d, d + 1) + 1.0) * 1.02,
    };
    units * (f64::EPSILON / 2.0)
}

/// Returns the number of monomials of the form of `k` rows, where squares of one norm count as one.
const fn monomials(k: usize) -> f64 {
    factorial(k) as f64
}

/// Returns the number of differences in a monomial.
const fn degree(d: usize, k: usize) -> f64 {
    (if k == d { d } else { d + 2 }) as f64
}

/// Returns the number of roundings of a monomial above `d = 3`: those of [`super::minors`]; a square, `d - 1` sums, a product and
/// `d` sums.
const fn roundings(d: usize, k: usize) -> f64 {
    let minors = d * (d + 1) / 2 - 1;
    (if k == d { minors } else { minors + 2 * d + 1 }) as f64
}

/// Returns the number of monomials times the number of differences in each of them, with a margin of 2 %.
const fn differences(d: usize, k: usize) -> f64 {
    monomials(k) * degree(d, k) * 1.02
}

/// The coordinates of places relative to a base, rounded.
struct Relative<const D: usize, const K: usize> {
    rows: [[f64; D]; K],
    /// The largest difference along each axis.
    largest: [f64; D],
    /// A bound of `2 s_k / M_k` over all axes.
    slack: f64,
}

impl<const D: usize, const K: usize> Relative<D, K> {
    #[inline]
    fn of<P: Place<D>>(base: &P, other: impl Fn(usize) -> P) -> Self {
        let others: [P; K] = from_fn(other);
        let rows: [[f64; D]; K] = from_fn(|i| from_fn(|k| others[i].near()[k] - base.near()[k]));
        let largest: [f64; D] = from_fn(|k| rows.iter().fold(0.0, |m: f64, row| m.max(row[k].abs())));
        let mut slack = 0.0;
        if P::IS_PERIODIC {
            for (k, largest) in largest.iter().enumerate() {
                let most = others.iter().fold(base.slack(k), |m, place| m.max(place.slack(k)));
                if most > 0.0 {
                    slack = f64::max(slack, 2.0 * most / largest);
                }
            }
        }
        Relative { rows, largest, slack }
    }

    /// Returns `true` if the filter admits the differences.
    #[inline]
    fn is_admitted(&self) -> bool {
        self.slack <= SLACKEST && self.largest.iter().all(|m| (RANGE.0..=RANGE.1).contains(m))
    }

    /// Returns the error bound of a form whose constant is `constant`, and whose last column is at most `last`.
    #[inline]
    fn bound(&self, constant: f64, last: f64) -> f64 {
        let product: f64 = self.largest.iter().product();
        (constant + differences(D, K) * self.slack) * product * last
    }

    /// Returns the sum of the squares of the largest differences.
    #[inline]
    fn squares(&self) -> f64 {
        self.largest.iter().map(|m| m * m).sum()
    }
}

/// Returns the sign of a value if it exceeds its error.
#[inline]
fn decided(value: f64, error: f64) -> Option<Ordering> {
    if value > error {
        Some(Ordering::Greater)
    } else if value < -error {
        Some(Ordering::Less)
    } else {
        None
    }
}

/// Returns the exact sign of the form of `others - base`.
///
/// For `K = D`, this is the orientation of `base, others`. For `K = D + 1`, it is the in-sphere form of the cell `others`
/// and the query `base`.
#[inline]
pub(super) fn sign<P: Place<D>, const D: usize, const K: usize>(base: &P, others: &[P; K]) -> Ordering {
    let relative = Relative::<D, K>::of(base, |i| others[i]);
    if relative.slack == 0.0 && relative.largest.contains(&0.0) {
        return Ordering::Equal;
    }
    if relative.is_admitted() {
        let last = if K == D { 1.0 } else { relative.squares() };
        if let Some(sign) = decided(form(&relative.rows), relative.bound(constant(D, K), last)) {
            return sign;
        }
    }
    exact_sign(base, others)
}

/// Returns the orientation of a cell of `N = D + 1` points.
#[inline]
pub(super) fn orientation<P: Place<D>, const D: usize, const N: usize>(cell: &[P; N]) -> Ordering {
    let others: [P; D] = from_fn(|i| cell[i + 1]);
    sign(&cell[0], &others)
}

/// Returns the orientation of the cell with `q` instead of the vertex in `slot`.
#[inline]
pub(super) fn replaced<P: Place<D>, const D: usize, const N: usize>(
    cell: &[P; N],
    slot: usize,
    q: &P,
) -> Ordering {
    let mut cell = *cell;
    cell[slot] = *q;
    orientation(&cell)
}

/// Returns the in-sphere sign: greater if `q` is strictly inside the circumsphere of the positive `cell`.
#[inline]
pub(super) fn in_sphere<P: Place<D>, const D: usize, const N: usize>(cell: &[P; N], q: &P) -> Ordering {
    sign(q, cell)
}

/// Returns the in-sphere sign with weights: greater if the lift of `q` is strictly below the hyperplane through the lifts of
/// the positive `cell`.
#[inline]
pub(super) fn power<P: Place<D>, const D: usize, const N: usize>(
    cell: &[Site<P>; N],
    q: &Site<P>,
) -> Ordering {
    let relative = Relative::<D, N>::of(&q.place, |i| cell[i].place);
    let weights: [f64; N] = from_fn(|i| cell[i].weight - q.weight);
    let heaviest = weights.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
    if heaviest <= HEAVIEST && relative.is_admitted() {
        let rows = &relative.rows;
        let value = lifted(rows, &from_fn(|i| norm(&rows[i]).minus(&weights[i])));
        let error = relative.bound(constant_with_weights(D), relative.squares() + heaviest);
        if let Some(sign) = decided(value, error) {
            return sign;
        }
    }
    exact_power(cell, q)
}

/// Returns `true` if `q` is inside the perturbed circumsphere. The exact in-sphere sign must be zero.
pub(super) fn tie_inside<P: Place<D>, const D: usize, const N: usize>(cell: &[P; N], q: &P) -> bool {
    let mut slots: [usize; N] = from_fn(|i| i);
    slots.sort_unstable_by(|&i, &j| cell[j].lexicographic(&cell[i]));
    for slot in slots {
        if cell[slot].lexicographic(q).is_lt() {
            break;
        }
        match replaced(cell, slot, q) {
            Ordering::Equal => {}
            decided => return decided.is_gt(),
        }
    }
    // The query decides: raising it moves it outside the circumsphere of a positive cell.
    false
}
