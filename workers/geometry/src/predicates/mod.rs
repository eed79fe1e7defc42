//! Orientation and in-sphere signs, with ties broken by symbolic perturbation.
//!
//! **Statement.** The lifted height `|p|^2` of each point is raised by an infinitesimal. The higher the lexicographic
//! rank of a point, the larger its infinitesimal, by orders of magnitude. Under these heights, no `DIM + 2` points are
//! cospherical, and the Delaunay triangulation is unique.
//!
//! Suppose that the in-sphere determinant is exactly zero. Then its derivative with respect to the height of the
//! highest-ranked point decides. If that derivative is zero, the next point decides, and so on to the first nonzero
//! derivative. The derivative with respect to the height of the query is minus the orientation of the cell. The
//! derivative with respect to the height of a vertex of the cell is the orientation of the cell with that vertex
//! replaced by the query.
//!
//! **Source.** Edelsbrunner and Muecke 1990; Devillers and Teillaud 2011.
//!
//! **Work and depth.** O(1) each.
//!
//! The rank is the order of coordinates, so it needs no numbering and is the same on every worker. Every in-sphere test
//! evaluates the same function of the lifted heights.
//!
//! **Stages.** No stage changes a sign. Each stage passes the calls that it cannot decide to the next one.
//!
//! 1. [`filter`]: rounded arithmetic, with an error bound from the differences of the call.
//! 2. `lattice`: the same determinant without a bound, if the coordinates have so few digits that nothing was rounded
//!    (grids). Otherwise `integer`: integers of 128 to 640 bits, as the digits of the call require.
//! 3. `expansion`: expansions of doubles, within the range that [`crate::range`] admits.
//! 4. `tie`: the perturbation, from the cofactors of the stage that found a zero.
//!
//! In dimensions 4 to 6, `general` has all stages but the last.
//!
//! With weights ([`crate::site`]), the height of a point is `|p|^2 - w`. The filter knows weights and images, and integers
//! (`weighted`) replace stages 2 and 3.

mod count;
mod expansion;
pub(crate) mod general;
mod integer;
mod lattice;
mod sign;
mod tie;
mod weighted;
mod wide;

use std::cmp::Ordering;

pub use count::ExactTests;
use glam::DVec2;
use integer::Signs;
pub use sign::Sign;

pub use crate::filter;
use crate::filter::Rounded;
use crate::point::{Point, lex_cmp};
use crate::site::Weighted;

/// Computes the orientation of `DIM + 1` points: positive for counter-clockwise triangles and for tetrahedra with
/// `((p1-p0) x (p2-p0)) . (p3-p0) > 0`.
#[inline]
pub fn orientation<P: Point>(cell: &[P]) -> Sign {
    let cell = &cell[..=P::DIM];
    let rounded = P::rounded_orientation(cell);
    if rounded.is_certain() {
        return Sign::of(rounded.det);
    }
    exact_orientation(cell)
}

/// Widths of differences, in the plane and in space, for which determinants and all partial sums stay below `2^53` (see
/// `integer`).
const EXACT_ORIENTATION: [u64; 2] = [26, 16];
const EXACT_IN_SPHERE: [u64; 2] = [12, 9];

#[cold]
#[inline(never)]
fn exact_orientation<P: Point>(cell: &[P]) -> Sign {
    count::exact_test();
    // The determinant is recomputed, because passing it would slow down the calls that the filter decides.
    let rounded = P::rounded_orientation(cell);
    if P::DIM > 3 {
        return general::orientation(cell, rounded.reach);
    }
    if P::IS_WEIGHTED {
        return weighted::orientation(cell, rounded.reach);
    }
    if lattice::is_exact(cell, rounded.reach, EXACT_ORIENTATION[P::DIM - 2]) {
        return Sign::of(rounded.det);
    }
    if let Some(sign) = integer::orientation(cell, rounded.reach) {
        return sign;
    }
    expansion::orientation(cell)
}

/// Returns `true` if `q` lies inside the perturbed circumsphere of the positively oriented `cell`; with weights, if `q`
/// lies below the perturbed hyperplane through the lifted corners. The positions must be distinct; then the perturbation
/// breaks every tie.
///
/// Not inlined, because the filter would run out of registers among the variables of a caller.
#[inline(never)]
pub fn in_sphere<P: Point>(cell: &[P], q: P) -> bool {
    let cell = &cell[..=P::DIM];
    let rounded = P::rounded_in_sphere(cell, q);
    if rounded.is_certain() {
        return rounded.det > 0.0;
    }
    exact_in_sphere(cell, q, &rounded)
}

#[cold]
#[inline(never)]
fn exact_in_sphere<P: Point>(cell: &[P], q: P, rounded: &Rounded) -> bool {
    count::exact_test();
    if P::DIM > 3 {
        let general::Signs { det, cofactors } = general::in_sphere(cell, q, rounded.reach);
        return det == Sign::Positive || det == Sign::Zero && tie::conflicts(cell, q, &cofactors);
    }
    let signs = in_sphere_signs(cell, q, rounded);
    match signs.det {
        Sign::Positive => true,
        Sign::Negative => false,
        Sign::Zero => tie::conflicts(cell, q, &signs.cofactors),
    }
}

fn in_sphere_signs<P: Point>(cell: &[P], q: P, rounded: &Rounded) -> Signs {
    if P::IS_WEIGHTED {
        return weighted::conflict(cell, q, rounded.reach);
    }
    let digits = EXACT_IN_SPHERE[P::DIM - 2];
    if lattice::is_exact(&[q], rounded.reach, digits) && lattice::is_exact(cell, rounded.reach, digits) {
        return Signs { det: Sign::of(rounded.det), cofactors: rounded.cofactors.map(Sign::of) };
    }
    if let Some(signs) = integer::conflict(cell, q, rounded.reach) {
        return signs;
    }
    expansion::conflict(cell, q)
}

/// Returns `true` if `q` conflicts with an infinite cell. `cell` has the infinite vertex in `slot`, and `finite` is the
/// positively oriented cell on the other side of its finite facet.
///
/// The answer is the orientation with `q` at the slot of infinity. If that is zero, `q` lies in the hyperplane of the
/// facet, and the perturbed in-sphere test of the finite neighbour decides. It equals the perturbed in-circle test in
/// that hyperplane, so every cell on the facet gives the same answer.
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

/// Returns `true` if `a` is lexicographically smaller than `b`.
#[inline]
pub fn lex_less<P: Point>(a: &P, b: &P) -> bool {
    lex_cmp(a, b) == Ordering::Less
}

/// Returns the dimension of the affine hull of `points` (`-1` for no points), and the positions of an affine frame of
/// the hull. The frame starts with the lexicographically smallest point. Then each point that raises the dimension is
/// added greedily, in lexicographic order. The set of frame points does not depend on the order of `points`.
pub fn affine_frame<P: Point>(points: &[P]) -> (isize, Vec<usize>) {
    let mut frame: Vec<usize> = Vec::with_capacity(P::DIM + 1);
    while frame.len() <= P::DIM {
        let basis: Vec<P> = frame.iter().map(|&i| points[i]).collect();
        match smallest_outside(&basis, points) {
            Some(i) => frame.push(i),
            None => break,
        }
    }
    (frame.len() as isize - 1, frame)
}

/// Returns the position of the lexicographically smallest of the `points` outside the affine hull of `basis`, and the
/// first position if several coincide.
pub fn smallest_outside<P: Point>(basis: &[P], points: &[P]) -> Option<usize> {
    // The order is compared first, because few points are smaller than all earlier ones.
    let mut next: Option<usize> = None;
    let mut first = f64::INFINITY;
    for (i, x) in points.iter().enumerate() {
        let is_smaller = x.coord(0) <= first && next.is_none_or(|best| lex_cmp(x, &points[best]).is_lt());
        if is_smaller && raises_dimension(basis, *x) {
            next = Some(i);
            first = x.coord(0);
        }
    }
    next
}

/// Returns `true` if `q` lies outside the affine hull of the affinely independent `basis` of at most `DIM` points.
/// Exact.
pub fn raises_dimension<P: Point>(basis: &[P], q: P) -> bool {
    match basis.len() {
        0 => true,
        1 => lex_cmp(&basis[0], &q) != Ordering::Equal,
        // Some minor of full rank decides.
        _ if P::DIM > 3 => general::is_outside(basis, q),
        n if n == P::DIM => {
            let mut cell = [q; 4];
            cell[..n].copy_from_slice(basis);
            orientation(&cell[..=n]) != Sign::Zero
        }
        // A line in space: three points are collinear iff their three coordinate projections are.
        _ if P::IS_WEIGHTED => [(0, 1), (1, 2), (2, 0)].iter().any(|&(i, j)| {
            let at = |p: &P| Weighted::projected(p, [i, j]);
            orientation(&[at(&basis[0]), at(&basis[1]), at(&q)]) != Sign::Zero
        }),
        _ => [(0, 1), (1, 2), (2, 0)].iter().any(|&(i, j)| {
            let at = |p: &P| DVec2::new(p.coord(i), p.coord(j));
            orientation(&[at(&basis[0]), at(&basis[1]), at(&q)]) != Sign::Zero
        }),
    }
}

#[cfg(test)]
mod tests;
