//! Orientation and in-sphere signs, with ties broken by symbolic perturbation.
//!
//! **Statement.** The lifted height `|p|^2` of each point is raised by an infinitesimal that is the
//! larger, by orders, the higher the point's lexicographic rank. Under these heights no `DIM + 2`
//! points are cospherical and the Delaunay triangulation is unique (Edelsbrunner and Muecke 1990;
//! Devillers and Teillaud 2011). When the in-sphere determinant is exactly zero, the derivative with
//! respect to the height of the highest-ranked point decides, then the next, down to the first that
//! is not zero. The derivative with respect to the query's height is minus the orientation of the
//! cell, that of a cell's vertex the orientation with that vertex replaced by the query.
//!
//! **Work and depth.** O(1) each.
//!
//! The signs come from the `robust` crate (Shewchuk 1997), exact within the range that
//! [`crate::range::RangeGuard`] admits. The rank is by coordinates, so that it needs no numbering and
//! is the same on every worker. The side test is one function of lifted heights.

use std::cmp::Ordering;

use crate::point::{Point, lex_cmp};

/// The sign of a determinant; never a float, never a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sign {
    /// Less than zero.
    Negative,
    /// Exactly zero.
    Zero,
    /// Greater than zero.
    Positive,
}

impl Sign {
    /// The sign of a float whose sign is exact.
    #[inline]
    pub fn of(x: f64) -> Self {
        if x > 0.0 {
            Sign::Positive
        } else if x < 0.0 {
            Sign::Negative
        } else {
            Sign::Zero
        }
    }
}

/// Orientation of `DIM + 1` points: positive for counter-clockwise triangles and for tetrahedra with
/// `((p1-p0) x (p2-p0)) . (p3-p0) > 0`.
#[inline]
pub fn orientation<P: Point>(cell: &[P]) -> Sign {
    Sign::of(P::orient_raw(cell))
}

/// Does `q` lie inside the circumsphere of the positively oriented `cell`, ties broken by
/// perturbation? The points must be distinct; then the answer is never a tie.
#[inline]
pub fn in_sphere<P: Point>(cell: &[P], q: P) -> bool {
    match Sign::of(P::insphere_raw(cell, q)) {
        Sign::Positive => true,
        Sign::Negative => false,
        Sign::Zero => in_sphere_tie(cell, q),
    }
}

/// The perturbed sign when the in-sphere determinant is exactly zero.
#[cold]
fn in_sphere_tie<P: Point>(cell: &[P], q: P) -> bool {
    let n = P::DIM + 1;
    let mut points = [q; 5];
    points[..n].copy_from_slice(&cell[..n]);
    let mut order = [0usize, 1, 2, 3, 4];
    let order = &mut order[..=n];
    order.sort_unstable_by(|&i, &j| lex_cmp(&points[j], &points[i]));
    for &i in order.iter() {
        if i == n {
            // Raising the query puts it outside: minus the cell's (positive) orientation.
            return false;
        }
        let mut replaced = [q; 4];
        replaced[..n].copy_from_slice(&points[..n]);
        replaced[i] = q;
        match orientation(&replaced[..n]) {
            Sign::Positive => return true,
            Sign::Negative => return false,
            Sign::Zero => {}
        }
    }
    false
}

/// Does `q` conflict with an infinite cell? `cell` has the infinite vertex in `slot`; `finite` is the
/// positively oriented cell on the other side of its finite facet. The answer is the orientation with
/// `q` in the place of infinity, and on a tie the perturbed in-sphere test of the finite neighbour
/// (which, `q` being coplanar with the facet, is the perturbed in-circle test in its plane: every
/// cell on that facet gives the same answer).
#[inline]
pub fn conflicts_infinite<P: Point>(cell: &[P], slot: usize, finite: &[P], q: P) -> bool {
    let mut replaced = [q; 4];
    let n = P::DIM + 1;
    replaced[..n].copy_from_slice(&cell[..n]);
    replaced[slot] = q;
    match orientation(&replaced[..n]) {
        Sign::Positive => true,
        Sign::Negative => false,
        Sign::Zero => in_sphere(finite, q),
    }
}

/// Is `a` lexicographically smaller than `b`?
#[inline]
pub fn lex_less<P: Point>(a: &P, b: &P) -> bool {
    lex_cmp(a, b) == Ordering::Less
}

/// The dimension of the affine hull of `points` (`-1` for none) and the positions of a frame that
/// spans it: the lexicographically smallest point, then greedily, in lexicographic order, every
/// point that raises the dimension. The frame does not depend on the order of `points`.
pub fn affine_frame<P: Point>(points: &[P]) -> (isize, Vec<usize>) {
    let mut frame: Vec<usize> = Vec::with_capacity(P::DIM + 1);
    while frame.len() <= P::DIM {
        let basis: Vec<P> = frame.iter().map(|&i| points[i]).collect();
        // The smallest so far is tested seldom: a look at the order comes first.
        let mut next: Option<usize> = None;
        for (i, x) in points.iter().enumerate() {
            let smaller = next.is_none_or(|best| lex_cmp(x, &points[best]).is_lt());
            if smaller && raises_dimension(&basis, *x) {
                next = Some(i);
            }
        }
        match next {
            Some(i) => frame.push(i),
            None => break,
        }
    }
    (frame.len() as isize - 1, frame)
}

/// Is `q` outside the affine hull of the affinely independent `basis` (at most `DIM` points)? Exact.
pub fn raises_dimension<P: Point>(basis: &[P], q: P) -> bool {
    match basis.len() {
        0 => true,
        1 => lex_cmp(&basis[0], &q) != Ordering::Equal,
        n if n == P::DIM => {
            let mut cell: Vec<P> = basis.to_vec();
            cell.push(q);
            orientation(&cell) != Sign::Zero
        }
        // Two points in space: collinear iff all three coordinate projections are.
        _ => [(0, 1), (1, 2), (2, 0)].iter().any(|&(i, j)| {
            let at = |p: &P| robust::Coord { x: p.coord(i), y: p.coord(j) };
            robust::orient2d(at(&basis[0]), at(&basis[1]), at(&q)) != 0.0
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    #[test]
    fn orientation_follows_the_file_convention() {
        let cell = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        assert_eq!(orientation(&cell), Sign::Positive);
        assert_eq!(orientation(&[DVec2::ZERO, DVec2::X, DVec2::Y]), Sign::Positive);
        assert!(in_sphere(&cell, DVec3::splat(0.4)));
        assert!(!in_sphere(&cell, DVec3::splat(2.0)));
        assert!(in_sphere(&[DVec2::ZERO, DVec2::X, DVec2::Y], DVec2::splat(0.4)));
    }

    #[test]
    fn ties_are_antisymmetric_across_a_facet() {
        // Square corners are cocircular: exactly one diagonal must win, seen from either side.
        let (a, b, c, d) = (DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y);
        let first = in_sphere(&[a, b, c], d);
        let second = in_sphere(&[a, c, d], b);
        assert_eq!(first, second);
        assert_ne!(first, in_sphere(&[a, b, d], c));
    }

    #[test]
    fn half_space_form_agrees_with_the_predicates() {
        let rel = [DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.2, 1.1, 0.0), DVec3::new(0.0, 0.3, 0.9)];
        let (w, v) = DVec3::sphere_plane(&rel);
        let cell = [DVec3::ZERO, rel[0], rel[1], rel[2]];
        assert_eq!(orientation(&cell), Sign::Positive);
        for q in [DVec3::splat(0.4), DVec3::splat(1.5), DVec3::new(-0.1, 0.5, 0.2)] {
            assert_eq!(w * q.dot(q) - v.dot(q) < 0.0, in_sphere(&cell, q));
        }
        let n = DVec3::hull_normal(&rel[..2]);
        let q = DVec3::new(0.3, -0.2, 0.7);
        assert_eq!(n.dot(q) > 0.0, orientation(&[DVec3::ZERO, rel[0], rel[1], q]) == Sign::Positive);
        let n2 = DVec2::hull_normal(&[DVec2::new(1.0, 0.5)]);
        assert!(n2.dot(DVec2::Y) > 0.0);
    }

    #[test]
    fn frames_do_not_depend_on_order() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0, DVec3::Y, DVec3::X + DVec3::Y];
        assert_eq!(affine_frame(&points).0, 2);
        assert_eq!(affine_frame(&points[..3]).0, 1);
        assert_eq!(affine_frame::<DVec3>(&[]).0, -1);
    }
}
