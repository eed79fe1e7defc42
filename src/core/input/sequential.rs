//! The preparation of an input without a machine, for baselines.
//!
//! **Statement.** The points, their order and their rows are those that a machine prepares
//! ([`septet_workers::input`]).
//!
//! **Work and depth.** A sort of the points, on one core.

use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::predicates::affine_frame;
use septet_geometry::range::{all_finite, scale, scale_exponent};

use crate::error::Error;
use crate::result::outcome::{Accounting, LeftOut};

/// The distinct points of an input.
#[derive(Clone, Debug)]
pub struct Distinct<P> {
    /// Coordinates in the exact range, in the order of the rows.
    pub positions: Vec<P>,
    /// The row of each point, the smallest among coincident points.
    pub rows: Vec<u64>,
    /// The rows by their use.
    pub points: Accounting,
    /// The rows that are not points.
    pub left_out: LeftOut,
    /// Dimension of the affine hull; -1 for no points.
    pub dimension: isize,
}

/// Prepares points.
///
/// # Errors
/// Fails if a point is not finite (unless such points are skipped), or if the spread of the coordinates is too large
/// for exact signs.
pub fn distinct<P: Point>(points: &[P], skip_invalid: bool) -> Result<Distinct<P>, Error> {
    if !skip_invalid {
        all_finite(points)?;
    }
    let is_finite = |i: &usize| (0..P::DIM).all(|k| points[*i].coord(k).is_finite());
    let (mut order, refused): (Vec<usize>, Vec<usize>) = (0..points.len()).partition(is_finite);
    let finite: Vec<P> = order.iter().map(|&i| points[i]).collect();
    let exponent = scale_exponent(&finite)?;
    let place = |i: usize| scale(points[i] + P::splat(0.0), exponent);
    order.sort_unstable_by(|&a, &b| lex_cmp(&place(a), &place(b)).then(a.cmp(&b)));
    let (mut rows, mut duplicates) = (Vec::new(), Vec::new());
    for equal in order.chunk_by(|&a, &b| lex_cmp(&place(a), &place(b)).is_eq()) {
        rows.push(equal[0] as u64);
        duplicates.extend(equal[1..].iter().map(|&i| (i as u64, equal[0] as u64)));
    }
    rows.sort_unstable();
    duplicates.sort_unstable();
    let positions: Vec<P> = rows.iter().map(|&row| place(row as usize)).collect();
    let refused: Vec<u64> = refused.into_iter().map(|i| i as u64).collect();
    let accounting = Accounting {
        input: points.len() as u64,
        used: rows.len() as u64,
        duplicate: duplicates.len() as u64,
        refused: refused.len() as u64,
        hidden: None,
    };
    let dimension = affine_frame(&positions).0;
    Ok(Distinct {
        positions,
        rows,
        points: accounting,
        left_out: LeftOut { duplicates, refused, ..LeftOut::default() },
        dimension,
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use septet_geometry::range::RangeError;

    use super::*;

    #[test]
    fn coincident_points_have_one_representative() {
        let p = |x: f64| DVec2::new(x, 0.5);
        let points = [p(1.0), p(0.0), p(1.0), p(-0.0), p(2.0), DVec2::new(0.0, 1.0), p(1.0)];
        let ready = distinct(&points, false).unwrap();
        assert_eq!(ready.rows, [0, 1, 4, 5]);
        assert_eq!(ready.left_out.duplicates, [(2, 0), (3, 1), (6, 0)]);
        assert_eq!(ready.dimension, 2);
        assert_eq!(distinct::<DVec2>(&[], false).unwrap().dimension, -1);
    }

    #[test]
    fn points_that_are_not_finite_are_refused_or_dropped() {
        let points = [DVec2::ZERO, DVec2::new(f64::NAN, 0.0), DVec2::ONE];
        let error = distinct(&points, false).unwrap_err();
        assert!(matches!(error, Error::Points(RangeError::NotFinite { index: 1, .. })));
        let ready = distinct(&points, true).unwrap();
        assert_eq!((ready.rows, ready.left_out.refused), (vec![0, 2], vec![1]));
    }
}
