//! The determinants of the verifier, over any ring, and their exact signs.
//!
//! **Statement.** For points `p_0 .. p_d` of `R^d`, the orientation is `det(p_i - p_0)`. It is positive for
//! counter-clockwise triangles and for tetrahedra with `((p1-p0) x (p2-p0)) . (p3-p0) > 0`. For a
//! positively oriented cell and a query `q`, the in-sphere form is the determinant of the rows
//! `(p_i - q, |p_i - q|^2)`. Its sign is chosen so that it is positive if and only if `q` lies strictly
//! inside the circumsphere. With weights, the last column is `|p_i - q|^2 - w_i + w_q`. Subtracting from `|x|^2 - w` an
//! affine function of `x` gives this column, with 0 for `q`. So the form is positive if and only if the lift of `q` is
//! strictly below the hyperplane through the lifts of the cell.
//!
//! **Source.** The forms are classical (Guibas and Stolfi 1985). A finite `f64` is a dyadic number
//! `m 2^e`. Multiplying all coordinates of one call by a common power of two makes them integers, and
//! multiplies a homogeneous form by a positive number. If the power is `2^k` for coordinates, it is `4^k` for weights.
//!
//! **Work.** O(1) ring operations. If all differences are below `2^b`, [`bits`] bounds every partial sum of a form. If the
//! bound allows, `i64` or `i128` hold the sums without overflow. Otherwise [`BigInt`] holds them, for any spread of
//! exponents that `f64` allows (about 2,100 bits).

use std::array::from_fn;
use std::cmp::Ordering;

use num_bigint::BigInt;

use super::dyadic::{sign_of, span, split, whole};
use super::minors::Minors;
use super::place::Place;
use super::ring::Ring;

/// A position and a weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Site<P> {
    /// The position.
    pub place: P,
    /// The weight, a squared length.
    pub weight: f64,
}

#[inline]
fn det2<R: Ring>(a: &[R], b: &[R], i: usize, j: usize) -> R {
    a[i].times(&b[j]).minus(&a[j].times(&b[i]))
}

#[inline]
fn det3<R: Ring>(a: &[R], b: &[R], c: &[R]) -> R {
    let first = a[0].times(&det2(b, c, 1, 2));
    let second = a[1].times(&det2(b, c, 0, 2));
    let third = a[2].times(&det2(b, c, 0, 1));
    first.minus(&second).plus(&third)
}

/// Returns the squared length of a row.
#[inline]
pub(super) fn norm<R: Ring, const D: usize>(a: &[R; D]) -> R {
    let planar = a[0].times(&a[0]).plus(&a[1].times(&a[1]));
    a[2..].iter().fold(planar, |sum, x| sum.plus(&x.times(x)))
}

/// Returns the form of `K` rows of differences from a base point. `D` is at least 2. Above 3, minors compute it.
///
/// For `K = D`, it is the orientation of the base point and the points of the rows. For `K = D + 1`, it is the in-sphere
/// form of the cell of the rows and the base point.
#[inline]
pub(super) fn form<R: Ring, const D: usize, const K: usize>(rows: &[[R; D]; K]) -> R {
    match (D, K) {
        (2, 2) => det2(&rows[0], &rows[1], 0, 1),
        (3, 3) => det3(&rows[0], &rows[1], &rows[2]),
        _ if K == D => Minors::of(rows).determinant().unwrap_or_else(|| rows[0][0].clone()),
        _ => lifted(rows, &from_fn(|i| norm(&rows[i]))),
    }
}

/// Returns the in-sphere form of `K = D + 1` rows of differences with these numbers in the last column.
#[inline]
pub(super) fn lifted<R: Ring, const D: usize, const K: usize>(rows: &[[R; D]; K], last: &[R; K]) -> R {
    if D > 3 {
        let minors = Minors::of(rows);
        let term = |i: usize| last[i].times(minors.without(i, K));
        let odd = |sum: R, i: usize| if i % 2 == 1 { sum.minus(&term(i)) } else { sum.plus(&term(i)) };
        return (1..K).fold(term(0), odd);
    }
    let (a, b, c) = (&rows[0], &rows[1], &rows[2]);
    if D == 2 {
        let first = last[0].times(&det2(b, c, 0, 1));
        let second = last[1].times(&det2(a, c, 0, 1));
        let third = last[2].times(&det2(a, b, 0, 1));
        first.minus(&second).plus(&third)
    } else {
        let d = &rows[3];
        let first = last[0].times(&det3(b, c, d));
        let second = last[1].times(&det3(a, c, d));
        let third = last[2].times(&det3(a, b, d));
        let fourth = last[3].times(&det3(a, b, c));
        first.minus(&second).plus(&third).minus(&fourth)
    }
}

/// Returns the degree of the form, and the binary logarithm, rounded up, of the number of its monomials.
///
/// The numbers are 2, 6, 12 (three minors of two monomials, times two squares) and 72 (four minors of six, times three).
/// With weights, the last two are 18 and 96, because a difference of weights counts as one more square. The logarithm
/// holds for both. Above `d = 3`, the numbers are `d!` and `(d + 1)! (d + 1)`.
const fn size(d: usize, k: usize) -> (u32, u32) {
    match (d, k) {
        (2, 2) => (2, 1),
        (2, _) => (4, 5),
        (3, 3) => (3, 3),
        (3, _) => (5, 7),
        _ if k == d => (d as u32, logarithm(factorial(d))),
        _ => (d as u32 + 2, logarithm(factorial(k) * k as u64)),
    }
}

/// Returns `n!`.
pub(super) const fn factorial(n: usize) -> u64 {
    if n == 0 { 1 } else { n as u64 * factorial(n - 1) }
}

/// Returns the binary logarithm, rounded up to one that is larger.
const fn logarithm(n: u64) -> u32 {
    u64::BITS - n.leading_zeros()
}

/// Returns `bits` such that every partial sum of the form is below `2^bits` if all differences are below `2^b`, and those
/// of weights are below `4^b`.
const fn bits(d: usize, k: usize, b: u32) -> u32 {
    let (degree, terms) = size(d, k);
    degree * b + terms
}

/// Converts places to integers: multiplies all coordinates by one common power of two.
pub(super) fn integers<P: Place<D>, const D: usize>(places: &[P]) -> Vec<[BigInt; D]> {
    let parts = || places.iter().flat_map(|place| (0..D).flat_map(|k| place.parts(k)));
    let (low, _) = span(parts().map(split));
    let coordinate = |place: &P, k: usize| place.parts(k).iter().map(|&part| whole(part, low)).sum();
    places.iter().map(|place| from_fn(|k| coordinate(place, k))).collect()
}

/// Returns `true` if the rounded coordinates are exact.
#[inline]
fn is_exact<P: Place<D>, const D: usize>(place: &P) -> bool {
    !P::IS_PERIODIC || (0..D).all(|axis| place.slack(axis) == 0.0)
}

/// Computes the exact sign of the form of `others - base`.
pub(super) fn exact_sign<P: Place<D>, const D: usize, const K: usize>(base: &P, others: &[P; K]) -> Ordering {
    if !is_exact(base) || !others.iter().all(is_exact) {
        return wide_sign(base, others);
    }
    let origin: [(i64, i32); D] = from_fn(|k| split(base.near()[k]));
    let parts: [[(i64, i32); D]; K] = from_fn(|i| from_fn(|k| split(others[i].near()[k])));
    let (low, high) = span(origin.iter().chain(parts.iter().flatten()).copied());
    // The span is computed in `i64`, so that no spread of exponents overflows it.
    if i64::from(high) - i64::from(low) > 62 {
        return wide_sign(base, others);
    }
    let small = |(m, e): (i64, i32)| if m == 0 { 0 } else { m << (e - low) };
    let rows: [[i64; D]; K] = from_fn(|i| from_fn(|k| small(parts[i][k]) - small(origin[k])));
    let largest = rows.iter().flatten().map(|x| x.unsigned_abs()).max().unwrap_or(0);
    let need = bits(D, K, 64 - largest.leading_zeros());
    if need <= 63 {
        form(&rows).cmp(&0)
    } else if need <= 127 {
        form(&rows.map(|r| r.map(i128::from))).cmp(&0)
    } else {
        sign_of(&form(&rows.map(|r| r.map(BigInt::from))))
    }
}

/// Returns the exact sign for any spread of exponents.
#[cold]
fn wide_sign<P: Place<D>, const D: usize, const K: usize>(base: &P, others: &[P; K]) -> Ordering {
    let mut all = others.to_vec();
    all.push(*base);
    let whole = integers(&all);
    let rows: [[BigInt; D]; K] = from_fn(|i| from_fn(|k| &whole[i][k] - &whole[K][k]));
    sign_of(&form(&rows))
}

/// Computes the exact sign of the in-sphere form with weights, of `N = D + 1` sites and the query `q`.
pub(super) fn exact_power<P: Place<D>, const D: usize, const N: usize>(
    cell: &[Site<P>; N],
    q: &Site<P>,
) -> Ordering {
    let all = || cell.iter().chain([q]);
    let parts = |site: &Site<P>| from_fn::<_, D, _>(|k| site.place.parts(k)).into_iter().flatten();
    let places = span(all().flat_map(parts).map(split));
    let weights = span(all().map(|site| split(site.weight)));
    // All coordinates are multiples of `2^low`, and all weights of `4^low`. The sizes are below `2^high` and `4^high`.
    let low = places.0.min(weights.0.div_euclid(2));
    let high = places.1.max(weights.1.div_euclid(2).saturating_add(1));
    if i64::from(high) - i64::from(low) > 62 || !all().all(|site| is_exact(&site.place)) {
        return wide_power(cell, q, low);
    }
    let small = |x: f64, low: i32| {
        let (m, e) = split(x);
        if m == 0 { 0 } else { i128::from(m) << (e - low) }
    };
    let coordinate = |site: &Site<P>, k: usize| small(site.place.near()[k], low);
    let rows: [[i128; D]; N] = from_fn(|i| from_fn(|k| coordinate(&cell[i], k) - coordinate(q, k)));
    let weights: [i128; N] = from_fn(|i| small(cell[i].weight, 2 * low) - small(q.weight, 2 * low));
    let length = |x: &i128| 128 - x.unsigned_abs().leading_zeros();
    let of_rows = rows.iter().flatten().map(length).max().unwrap_or(0);
    let of_weights = weights.iter().map(length).max().unwrap_or(0);
    if bits(D, N, of_rows.max(of_weights.div_ceil(2))) > 127 {
        return wide_power(cell, q, low);
    }
    lifted(&rows, &from_fn(|i| norm(&rows[i]).minus(&weights[i]))).cmp(&0)
}

/// Returns the exact sign with weights, for any spread of exponents. All parts of coordinates are multiples of `2^low`, and
/// all weights are multiples of `4^low`.
#[cold]
fn wide_power<P: Place<D>, const D: usize, const N: usize>(
    cell: &[Site<P>; N],
    q: &Site<P>,
    low: i32,
) -> Ordering {
    let coordinate =
        |site: &Site<P>, k: usize| -> BigInt { site.place.parts(k).iter().map(|&x| whole(x, low)).sum() };
    let row = |i: usize| from_fn(|k| coordinate(&cell[i], k) - coordinate(q, k));
    let rows: [[BigInt; D]; N] = from_fn(row);
    let weight = |x: f64| whole(x, 2 * low);
    let last: [BigInt; N] = from_fn(|i| norm(&rows[i]) - weight(cell[i].weight) + weight(q.weight));
    sign_of(&lifted(&rows, &last))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widths_agree() {
        // The last vertex of a unit cell is raised by amounts that need `i64`, `i128` and `BigInt`. The far corner of
        // the cube lies on the sphere before and inside it afterwards.
        let cell = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for bits in [8, 20, 50] {
            let mut raised = cell;
            raised[3][2] += 2f64.powi(-bits);
            assert_eq!(exact_sign(&[1.0; 3], &cell), Ordering::Equal);
            assert_eq!(exact_sign(&[1.0; 3], &raised), Ordering::Greater);
            assert_eq!(exact_sign(&[1.0, 1.0, 1.0 + 2f64.powi(-bits)], &raised), Ordering::Equal);
        }
        // With a spread of 1,950 bits, the query is off the plane by a tiny amount.
        let (far, near) = (2f64.powi(950), 2f64.powi(-1000));
        let flat = [[far, 0.0, 0.0], [0.0, far, 0.0], [far, far, near]];
        assert_eq!(exact_sign(&[0.0; 3], &flat), Ordering::Greater);
        assert_eq!(exact_sign(&[0.0, 0.0, near], &flat), Ordering::Greater);
    }
}
