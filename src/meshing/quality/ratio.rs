//! Guaranteed bounds of the radius-edge ratio.
//!
//! **Statement.** Let `e_1 .. e_d` be the edges from the first vertex of a cell. Let `v = sum_i |e_i|^2 n_i`, where
//! `n_i` is the signed cross product of the other edges, and let `w` be their determinant. Then `R = |v| / (2 |w|)`.
//! Let `u = 2^-53`, `M = prod |e_i|` and `S = M sum |e_i|`. The values computed here, marked by primes, satisfy
//! ```text
//! |v' - v| <= 20 u S,    |w' - w| <= 16 u M,    | |v|' / |v'| - 1 | and | l' / l - 1 | <= 6 u.
//! ```
//! So R/l lies between `(|v|' - 20 u S) / (2 (|w'| + 16 u M) l')` and `(|v|' + 20 u S) / (2 (|w'| - 16 u M) l')`. Each
//! bound is then moved outwards by a relative 32 u, to account for the rounding of the bound itself.
//!
//! *Proof.*
//! 1. A difference of coordinates has a relative error of at most u.
//! 2. A component of a cross product, `ab - cd`, has an error of at most `4.1 u (|ab| + |cd|)`. The error of the vector
//!    is at most `4.1 sqrt(3) u |x| |y| < 7.2 u |x| |y|`.
//! 3. `|e_i|^2` has a relative error of at most 5.1 u. Its product with the vector has an error of at most
//!    `(7.2 + 6.2) u |e_i|^2 |e_j| |e_k|`, and the sum of three products adds 2.1 u. The total is below 16 u S. In
//!    the plane, where n is a rotated edge, it is smaller.
//! 4. The determinant is an inner product with one such vector: `(7.2 + 4.1) u M`. In the plane it is `4.1 u M`.
//! 5. Norms add at most 2 + 1 + 1/2 roundings to the roundings of the inputs.
//!
//! The constants 20, 16 and 6 leave room for terms of order `u^2` and for the rounding of S and M. There is no
//! underflow or overflow, because the coordinates are in the range of `septet_geometry::range`. QED.
//!
//! If the bounds do not decide `R/l <= B`, [`at_most`] decides in integers.
//!
//! **Work and depth.** O(1).

use std::cmp::Ordering;

use num_bigint::BigInt;
use septet_geometry::measure::shortest_edge2;
use septet_geometry::point::Point;

use crate::exact::{determinant, integers, split};

/// `2^-53`.
const U: f64 = f64::EPSILON / 2.0;

/// A lower and an upper bound of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    /// The lower bound.
    pub lower: f64,
    /// The upper bound. It is infinite if rounding prevents a finite one.
    pub upper: f64,
}

/// Returns bounds of the radius-edge ratio of `DIM + 1` points with coordinates in the exact range.
pub fn ratio<P: Point>(cell: &[P]) -> Bracket {
    let mut rel = [P::default(); 3];
    let (mut product, mut sum) = (1.0, 0.0);
    for i in 0..P::DIM {
        rel[i] = cell[i + 1] - cell[0];
        let length = rel[i].norm2().sqrt();
        product *= length;
        sum += length;
    }
    let (w, v) = P::sphere_plane(&rel[..P::DIM]);
    let (size, w) = (v.norm2().sqrt(), w.abs());
    let (of_v, of_w) = (20.0 * U * product * sum, 16.0 * U * product);
    let length = shortest_edge2(cell).sqrt();
    let out = 32.0 * U;
    let lower = (size - of_v).max(0.0) / (2.0 * (w + of_w) * length) * (1.0 - out);
    let upper = (size + of_v) / (2.0 * (w - of_w) * length) * (1.0 + out);
    let open = w <= of_w || upper.is_nan();
    Bracket {
        lower: if lower.is_nan() { 0.0 } else { lower },
        upper: if open { f64::INFINITY } else { upper },
    }
}

/// Returns `true` if the radius-edge ratio is at most `bound`. The comparison is exact.
pub fn at_most<P: Point>(cell: &[P], bound: f64) -> bool {
    let Bracket { lower, upper } = ratio(cell);
    if upper <= bound || lower > bound || bound.is_nan() || bound <= 0.0 {
        return upper <= bound;
    }
    if bound == f64::INFINITY {
        return true;
    }
    // (R/l)^2 = |v|^2 / (4 w^2 l^2) in integers. The bound is m 2^e.
    let points = integers(&cell[..=P::DIM]);
    let minus = |a: &[BigInt], b: &[BigInt]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>();
    let norm2 = |a: &[BigInt]| a.iter().map(|x| x * x).sum::<BigInt>();
    let edges: Vec<Vec<BigInt>> = points[1..].iter().map(|p| minus(p, &points[0])).collect();
    let w = determinant(&points[..P::DIM], &points[P::DIM]);
    let v = norm2(&numerator(&edges));
    let pairs = (0..=P::DIM).flat_map(|i| (0..i).map(move |j| (i, j)));
    let shortest = pairs.map(|(i, j)| norm2(&minus(&points[i], &points[j]))).min().unwrap_or_default();
    let (m, e) = split(bound);
    let right: BigInt = BigInt::from(4) * &w * &w * shortest * m * m;
    let order = if e < 0 { (v << (-2 * e)).cmp(&right) } else { v.cmp(&(right << (2 * e))) };
    w != BigInt::ZERO && order != Ordering::Greater
}

/// Returns the vector v, up to sign.
fn numerator(edges: &[Vec<BigInt>]) -> Vec<BigInt> {
    let norm2 = |a: &[BigInt]| a.iter().map(|x| x * x).sum::<BigInt>();
    if let [a, b] = edges {
        let (aa, bb) = (norm2(a), norm2(b));
        return vec![&b[1] * &aa - &a[1] * &bb, &a[0] * &bb - &b[0] * &aa];
    }
    let cross = |a: &[BigInt], b: &[BigInt]| {
        let part = |i: usize, j: usize| &a[i] * &b[j] - &a[j] * &b[i];
        [part(1, 2), part(2, 0), part(0, 1)]
    };
    let mut sum = vec![BigInt::ZERO; 3];
    for i in 0..3 {
        let (factor, n) = (norm2(&edges[i]), cross(&edges[(i + 1) % 3], &edges[(i + 2) % 3]));
        for (sum, n) in sum.iter_mut().zip(n) {
            *sum += &factor * n;
        }
    }
    sum
}
