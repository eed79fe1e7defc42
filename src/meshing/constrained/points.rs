//! Exact points on segments, and signs of determinants with them.
//!
//! **Statement.** A point is a vertex of the input, or `a + t (b - a)` for two vertices a, b and a double t. Every
//! coordinate of such a point is a whole multiple of a power of two, so signs are computed with integers. Rounded
//! coordinates decide most signs: their error is at most half a unit in the last place, and the bounds of
//! [`Points::orientation`] and [`Points::in_sphere`] contain it. Points of one plane of the input have orientation zero
//! without arithmetic.
//!
//! Ties are broken as in [`septet_geometry::predicates`]: the heights of input vertices are raised by infinitesimals in
//! lexicographic order. Points on segments follow with smaller ones, a later point with a smaller one than an earlier.
//! For input vertices alone, the tests are those of the geometry crate.
//!
//! **Work and depth.** O(1) each.

use glam::DVec3;
use num_bigint::BigInt;
use septet_geometry::point::lex_cmp;
use septet_geometry::predicates::{self, Sign};

use crate::exact::{determinant, rounded, split};

/// Half a unit in the last place of one.
const HALF_ULP: f64 = f64::EPSILON * 0.5;

/// Products below this number may have lost digits.
const UNDERFLOW: f64 = 1e-280;

/// Three integers times a power of two.
#[derive(Clone, Debug)]
struct Exact {
    whole: [BigInt; 3],
    exponent: i32,
}

impl Exact {
    fn of(p: DVec3) -> Self {
        let parts = p.to_array().map(split);
        let low = parts.iter().filter(|x| x.0 != 0).map(|x| x.1).min().unwrap_or(0);
        let whole = parts.map(|(m, e)| if m == 0 { BigInt::ZERO } else { BigInt::from(m) << (e - low) });
        Exact { whole, exponent: low }
    }

    /// Returns the integers for a smaller or equal exponent.
    fn at(&self, exponent: i32) -> Vec<BigInt> {
        self.whole.iter().map(|x| x << (self.exponent - exponent)).collect()
    }
}

/// The points of a recovery.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    /// The coordinates. Those of points on segments are rounded.
    pub(super) at: Vec<DVec3>,
    /// The points on segments, after all vertices of the input.
    exact: Vec<Exact>,
    /// The number of input vertices.
    given: usize,
    /// The ranks of the input vertices in lexicographic order.
    ranks: Vec<i64>,
    /// The planes of the input that contain each point, ascending.
    planes: Vec<Vec<u32>>,
}

impl Points {
    /// Creates the vertices of the input.
    pub(super) fn new(at: Vec<DVec3>, planes: Vec<Vec<u32>>) -> Self {
        let mut order: Vec<usize> = (0..at.len()).collect();
        order.sort_by(|&i, &j| lex_cmp(&at[i], &at[j]));
        let mut ranks = vec![0; at.len()];
        order.into_iter().zip(0..).for_each(|(i, rank)| ranks[i] = rank);
        Points { given: at.len(), at, exact: Vec::new(), ranks, planes }
    }

    pub(super) fn len(&self) -> usize {
        self.at.len()
    }

    /// Returns the number of input vertices.
    pub(super) fn given(&self) -> usize {
        self.given
    }

    fn rank(&self, v: u32) -> i64 {
        let v = v as usize;
        if v < self.given { self.ranks[v] } else { -(v as i64) }
    }

    fn exact(&self, v: u32) -> Exact {
        let v = v as usize;
        if v < self.given { Exact::of(self.at[v]) } else { self.exact[v - self.given].clone() }
    }

    /// Adds the point `a + t (b - a)` between two input vertices, on these planes.
    pub(super) fn add(&mut self, [a, b]: [u32; 2], t: f64, planes: Vec<u32>) -> u32 {
        let (a, b, (m, e)) = (self.exact(a), self.exact(b), split(t));
        let low = a.exponent.min(b.exponent);
        let (a, b) = (a.at(low), b.at(low));
        // t is m 2^e with a negative e, because t is below 1.
        let whole = [0, 1, 2].map(|i| (&a[i] << -e) + BigInt::from(m) * (&b[i] - &a[i]));
        let made = Exact { whole, exponent: low + e };
        let [x, y, z] = [0, 1, 2].map(|i| rounded(&made.whole[i], made.exponent));
        self.at.push(DVec3::new(x, y, z));
        self.exact.push(made);
        self.planes.push(planes);
        self.at.len() as u32 - 1
    }

    fn integers<const N: usize>(&self, which: [u32; N]) -> Vec<Vec<BigInt>> {
        let all = which.map(|v| self.exact(v));
        let low = all.iter().map(|p| p.exponent).min().unwrap_or(0);
        all.iter().map(|p| p.at(low)).collect()
    }

    fn are_given(&self, which: &[u32]) -> bool {
        which.iter().all(|&v| (v as usize) < self.given)
    }

    /// Returns `true` if one plane of the input contains all points.
    fn share_plane(&self, which: &[u32]) -> bool {
        let lists = |p: &u32| which[1..].iter().all(|&v| self.planes[v as usize].binary_search(p).is_ok());
        self.planes[which[0] as usize].iter().any(lists)
    }

    /// Returns differences from the last point, a bound on the relative error of a product of them, and whether it is
    /// finite.
    fn rows<const N: usize>(&self, which: [u32; N], from: u32) -> ([DVec3; N], [f64; N], f64) {
        let o = self.at[from as usize];
        let rows = which.map(|v| self.at[v as usize] - o);
        let reach = rows.map(|r| r.abs().max_element());
        let largest = which.iter().map(|&v| self.at[v as usize].abs().max_element());
        let largest = largest.fold(o.abs().max_element(), f64::max);
        let least = reach.iter().copied().fold(f64::INFINITY, f64::min);
        // Both ends of a difference are rounded once.
        (rows, reach, 2.0 * HALF_ULP * largest / least)
    }

    /// Returns the sign of the orientation of four points.
    pub(super) fn orientation(&self, cell: [u32; 4]) -> Sign {
        if self.are_given(&cell) {
            return predicates::orientation(&cell.map(|v| self.at[v as usize]));
        }
        let [a, b, c, d] = cell;
        let ([u, v, w], reach, relative) = self.rows([b, c, d], a);
        let det = u.cross(v).dot(w);
        let bound = 6.0 * reach.iter().product::<f64>() * (16.0 * HALF_ULP + 4.0 * relative);
        if bound > UNDERFLOW && det.abs() > bound {
            return Sign::of(det);
        }
        if self.share_plane(&cell) {
            return Sign::Zero;
        }
        let all = self.integers(cell);
        sign(&determinant(&all[..3], &all[3]))
    }

    /// Returns `true` if an edge passes through the interior of a triangle.
    pub(super) fn crosses(&self, [p, q]: [u32; 2], [a, b, c]: [u32; 3]) -> bool {
        if [a, b, c].contains(&p) || [a, b, c].contains(&q) {
            return false;
        }
        let ends = [p, q].map(|x| self.orientation([a, b, c, x]));
        if ends[0] == ends[1] || ends.contains(&Sign::Zero) {
            return false;
        }
        let sides = [[a, b], [b, c], [c, a]].map(|[s, t]| self.orientation([p, q, s, t]));
        sides[0] != Sign::Zero && sides[0] == sides[1] && sides[1] == sides[2]
    }

    /// Returns `true` if the perturbed sphere of a positive cell contains the point.
    pub(super) fn in_sphere(&self, cell: [u32; 4], q: u32) -> bool {
        if self.are_given(&cell) && (q as usize) < self.given {
            let at = cell.map(|v| self.at[v as usize]);
            return predicates::in_sphere(&at, self.at[q as usize]);
        }
        let (rows, reach, relative) = self.rows(cell, q);
        let of = cofactors(rows, |a, b, c| a.cross(b).dot(c));
        let det: f64 = rows.iter().zip(of).map(|(r, o)| r.length_squared() * o).sum();
        let terms = 18.0 * reach.iter().product::<f64>() * reach.iter().sum::<f64>();
        if terms > UNDERFLOW && det.abs() > terms * (24.0 * HALF_ULP + 6.0 * relative) {
            return det > 0.0;
        }
        self.exact_in_sphere(cell, q)
    }

    #[cold]
    fn exact_in_sphere(&self, cell: [u32; 4], q: u32) -> bool {
        let [a, b, c, d] = cell;
        let all = self.integers([a, b, c, d, q]);
        let rows = [0, 1, 2, 3].map(|i| [0, 1, 2].map(|k| &all[i][k] - &all[4][k]));
        let of = cofactors([0, 1, 2, 3], |i, j, k| determinant_of([&rows[i], &rows[j], &rows[k]]));
        let height = |r: &[BigInt; 3]| &r[0] * &r[0] + &r[1] * &r[1] + &r[2] * &r[2];
        let det: BigInt = rows.iter().zip(&of).map(|(r, o)| height(r) * o).sum();
        match sign(&det) {
            Sign::Positive => true,
            Sign::Negative => false,
            Sign::Zero => {
                let (mut highest, mut inside) = (self.rank(q), false);
                for (&corner, o) in cell.iter().zip(&of) {
                    if *o != BigInt::ZERO && self.rank(corner) > highest {
                        (highest, inside) = (self.rank(corner), *o > BigInt::ZERO);
                    }
                }
                inside
            }
        }
    }
}

/// Returns the orientations of a cell with each corner replaced by the origin.
fn cofactors<T: Copy, D: std::ops::Neg<Output = D>>(
    [a, b, c, d]: [T; 4],
    det: impl Fn(T, T, T) -> D,
) -> [D; 4] {
    [det(b, c, d), -det(a, c, d), det(a, b, d), -det(a, b, c)]
}

fn determinant_of([a, b, c]: [&[BigInt; 3]; 3]) -> BigInt {
    &c[0] * (&a[1] * &b[2] - &a[2] * &b[1])
        + &c[1] * (&a[2] * &b[0] - &a[0] * &b[2])
        + &c[2] * (&a[0] * &b[1] - &a[1] * &b[0])
}

fn sign(x: &BigInt) -> Sign {
    match x.sign() {
        num_bigint::Sign::Minus => Sign::Negative,
        num_bigint::Sign::NoSign => Sign::Zero,
        num_bigint::Sign::Plus => Sign::Positive,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Points {
        let at = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.1, 0.7, 0.3)];
        Points::new(at, vec![Vec::new(); 5])
    }

    #[test]
    fn points_on_an_edge_have_no_volume_with_it() {
        let mut points = tetrahedron();
        let p = points.add([3, 4], 1.0 / 3.0, Vec::new());
        assert_eq!(points.orientation([3, 4, p, 0]), Sign::Zero);
        assert_eq!(points.orientation([0, 1, 2, p]), Sign::Positive);
        let q = points.add([3, 4], 1.0 / 3.0 + f64::EPSILON / 4.0, Vec::new());
        assert_eq!(points.orientation([p, q, 3, 0]), Sign::Zero);
        assert!(points.orientation([0, 1, p, q]) != Sign::Zero, "the two points differ by their last digits");
    }

    #[test]
    fn spheres_contain_points_of_their_chords() {
        let mut points = tetrahedron();
        let inner = points.add([1, 2], 0.1, Vec::new());
        assert!(points.in_sphere([0, 1, 2, 3], inner));
        let p = points.add([0, 1], 0.5, Vec::new());
        assert_eq!(points.orientation([p, 1, 2, 3]), Sign::Positive);
        assert!(!points.in_sphere([p, 1, 2, 3], 0));
    }
}
