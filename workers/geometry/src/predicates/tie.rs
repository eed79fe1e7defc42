//! The symbolic perturbation, which decides if the in-sphere determinant is zero.
//!
//! **Statement.** See [`super`]. The determinant is `sum_i |p_i - q|^2 o_i`, where `o_i` is the orientation of the cell
//! with corner `i` replaced by the query `q`. It is linear in each height. Its derivatives with respect to the heights
//! of the corners are the cofactors `o_i`, which every stage computes. Its derivative with respect to the height of the
//! query is minus the orientation of the cell. So the highest-ranked point *among those with a nonzero derivative*
//! decides, and no orientation is computed again.
//!
//! **Work.** At most `DIM + 1` comparisons of points.

use super::sign::Sign;
use crate::point::{Point, lex_cmp};

/// Returns `true` if the query conflicts with the positively oriented `cell`, given its cofactors.
#[inline]
pub(super) fn conflicts<P: Point>(cell: &[P], q: P, cofactors: &[Sign]) -> bool {
    // Raising the query moves it outside: the derivative is minus the positive orientation of the cell.
    let (mut highest, mut is_conflict) = (q, false);
    for (corner, &cofactor) in cell.iter().zip(cofactors) {
        if cofactor != Sign::Zero && lex_cmp(&highest, corner).is_lt() {
            (highest, is_conflict) = (*corner, cofactor == Sign::Positive);
        }
    }
    is_conflict
}
