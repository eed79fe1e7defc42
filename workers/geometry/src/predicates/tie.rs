//! The symbolic perturbation that decides where the in-sphere determinant is zero.
//!
//! **Statement.** See [`super`]. By multilinearity the determinant is `sum_i |p_i - q|^2 o_i`, where `o_i`
//! is the orientation of the cell with corner `i` replaced by the query `q`: its derivatives with respect
//! to the heights of the corners are the cofactors that every stage has at hand, and with respect to the
//! query's height it is minus the orientation of the cell. So the points of rank above all others *among
//! those with a derivative that is not zero* decide, and no orientation is computed again.
//!
//! **Work.** At most `DIM + 1` comparisons of points.

use super::sign::Sign;
use crate::point::{Point, lex_cmp};

/// Does the query conflict with the positively oriented `cell`, given its cofactors?
#[inline]
pub(super) fn conflicts<P: Point>(cell: &[P], q: P, cofactors: [Sign; 4]) -> bool {
    // Raising the query puts it outside: minus the cell's (positive) orientation.
    let (mut highest, mut verdict) = (q, false);
    for (corner, cofactor) in cell.iter().zip(cofactors) {
        if cofactor != Sign::Zero && lex_cmp(&highest, corner).is_lt() {
            (highest, verdict) = (*corner, cofactor == Sign::Positive);
        }
    }
    verdict
}
