//! The preparation of input points for the machine.
//!
//! Coincident points are found, -0.0 becomes 0.0, and a power of two scales the coordinates into the exact range. A frame
//! of affinely independent points spans the set.
//!
//! **Work and depth.** Vector steps over blocks of points, on all cores; coincident points are found as in
//! [`crate::input::coincide`]. Points that need no change are not copied.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::predicates::smallest_outside;
use septet_geometry::range::{Digits, RangeError, all_finite, scale};
use septet_protocol::message::PointSum;

use crate::error::Error;
use crate::input::coincide::coincidences;
use crate::result::run::Accounting;

/// Number of points in a block, which one core reads in turn.
const BLOCK: usize = 1 << 14;

/// A point set ready for the machine.
#[derive(Debug)]
pub struct Prepared<'a, P: Point> {
    /// Distinct points, scaled, in input order. They are borrowed if no point changed.
    pub positions: Cow<'a, [P]>,
    /// Input index of each position, the smallest among coincident points. `None` if the indices are 0, 1, 2, ...
    ids: Option<Vec<u64>>,
    /// Coincident points: the index of each, and the smallest index with the same coordinates.
    pub duplicates: Vec<(u64, u64)>,
    /// Indices of points that were dropped because they were not finite.
    pub refused: Vec<u64>,
    /// The exponent of the power of two by which coordinates were multiplied.
    pub(crate) exponent: i32,
    /// Dimension of the affine hull; -1 for no points.
    pub dimension: isize,
    /// Positions (in `positions`) of affinely independent points that span the affine hull.
    pub(crate) frame: Vec<usize>,
    /// Squared radii of the balls of sites; empty if nearest neighbours define the balls.
    pub(crate) radii2: Vec<f64>,
    /// The number of points and the sum of their hashes, after the first request.
    sum: OnceLock<PointSum>,
}

impl<P: Point> Prepared<'_, P> {
    /// Returns distinct sites, scaled by two to the power `exponent`, with the squared radii of their balls.
    pub(crate) fn of_sites(positions: Vec<P>, radii2: Vec<f64>, exponent: i32) -> Self {
        Prepared {
            positions: Cow::Owned(positions),
            ids: None,
            duplicates: Vec::new(),
            refused: Vec::new(),
            exponent,
            dimension: P::DIM as isize,
            frame: Vec::new(),
            radii2,
            sum: OnceLock::new(),
        }
    }

    /// Returns the number of `input` points that are vertices, and the points that are not vertices.
    pub fn accounting(&self, input: usize) -> Accounting {
        Accounting {
            input: input as u64,
            used: self.positions.len() as u64,
            duplicates: self.duplicates.clone(),
            refused: self.refused.clone(),
        }
    }

    /// Returns `true` if the points do not span the space.
    pub(crate) fn is_flat(&self) -> bool {
        self.dimension < P::DIM as isize
    }

    /// Returns the number of points and the sum of their hashes.
    pub(crate) fn sum(&self) -> PointSum {
        *self.sum.get_or_init(|| self.hashed())
    }

    fn hashed(&self) -> PointSum {
        let ranges = (0..self.positions.len()).into_par_iter().step_by(BLOCK);
        let block = |start: usize| {
            let points = &self.positions[start..self.positions.len().min(start + BLOCK)];
            PointSum::of(self.ids(start..start + points.len()).zip(points.iter().copied()))
        };
        ranges.map(block).reduce(PointSum::default, PointSum::join)
    }

    /// Returns the input index of a point.
    pub fn id(&self, at: usize) -> u64 {
        self.ids.as_ref().map_or(at as u64, |ids| ids[at])
    }

    /// Returns the input indices of a range of points.
    pub(crate) fn ids(&self, range: Range<usize>) -> impl Iterator<Item = u64> {
        range.map(|at| self.id(at))
    }
}

/// Prepares points.
///
/// # Errors
/// Fails if a point is not finite (unless such points are skipped), or if the spread of the coordinates is too large
/// for exact signs. The error has input indices.
pub fn prepare<P: Point>(points: &[P], skip_invalid: bool) -> Result<Prepared<'_, P>, Error> {
    let (mut digits, negative_zero) = digits_of(points);
    let (mut clean, mut ids) = (Cow::Borrowed(points), None);
    let mut refused = Vec::new();
    if digits.is_none() {
        if !skip_invalid {
            all_finite(points)?;
        }
        let bad = |&i: &u64| (0..P::DIM).any(|k| !points[i as usize].coord(k).is_finite());
        let kept: Vec<u64>;
        (refused, kept) = (0..points.len() as u64).partition(bad);
        clean = Cow::Owned(kept.iter().map(|&i| points[i as usize]).collect());
        digits = Digits::of(&clean);
        ids = Some(kept);
    }
    if negative_zero {
        clean.to_mut().par_iter_mut().for_each(|p| *p = without_negative_zero(*p));
    }
    let digits = digits.unwrap_or(Digits::NONE);
    let exponent = digits.exponent(&clean).map_err(|e| renumber(e, ids.as_deref()))?;
    let name = |i: u32| ids.as_ref().map_or(u64::from(i), |ids| ids[i as usize]);
    let again = coincidences(&clean);
    let duplicates = again.iter().map(|&(i, of)| (name(i), name(of))).collect();
    if !again.is_empty() {
        let mut repeats = again.iter().map(|d| d.0).peekable();
        let first: Vec<u32> = (0..clean.len() as u32).filter(|&i| repeats.next_if_eq(&i).is_none()).collect();
        ids = Some(first.iter().map(|&i| name(i)).collect());
        clean = Cow::Owned(first.iter().map(|&i| clean[i as usize]).collect());
    }
    if exponent != 0 {
        clean.to_mut().par_iter_mut().for_each(|p| *p = scale(*p, exponent));
    }
    let frame = affine_frame(&clean);
    let dimension = frame.len() as isize - 1;
    Ok(Prepared {
        positions: clean,
        ids,
        duplicates,
        refused,
        exponent,
        dimension,
        frame,
        radii2: Vec::new(),
        sum: OnceLock::new(),
    })
}

/// Returns the digits of all coordinates, if all are finite, and whether one of them is -0.0. If
/// `Digits::upper_bound` fits the exact range, it is returned instead of the exact digits.
fn digits_of<P: Point>(points: &[P]) -> (Option<Digits>, bool) {
    let block = |points: &[P]| {
        let is_negative_zero = |x: f64| x.to_bits() == (-0.0f64).to_bits();
        let any = |found, p: &P| (0..P::DIM).fold(found, |found, i| found | is_negative_zero(p.coord(i)));
        (Digits::upper_bound(points), points.iter().fold(false, any))
    };
    let join = |a: Option<Digits>, b: Option<Digits>| a.zip(b).map(|(a, b)| a.join(b));
    let none = || Some(Digits::NONE);
    let blocks = || points.par_chunks(BLOCK);
    let (most, found) = blocks().map(block).reduce(|| (none(), false), |a, b| (join(a.0, b.0), a.1 | b.1));
    let digits = match most {
        Some(most) if !most.fits() => blocks().map(Digits::of).reduce(none, join),
        fits => fits,
    };
    (digits, found)
}

pub(crate) fn without_negative_zero<P: Point>(mut p: P) -> P {
    for i in 0..P::DIM {
        p.set_coord(i, p.coord(i) + 0.0);
    }
    p
}

fn renumber(error: RangeError, kept: Option<&[u64]>) -> RangeError {
    match (error, kept) {
        (RangeError::Spread { bits, low, high }, Some(kept)) => {
            RangeError::Spread { bits, low: kept[low] as usize, high: kept[high] as usize }
        }
        (error, _) => error,
    }
}

/// Computes `septet_geometry::predicates::affine_frame` by blocks. The smallest point of the set is the smallest of its
/// block.
fn affine_frame<P: Point>(points: &[P]) -> Vec<usize> {
    let mut frame: Vec<usize> = Vec::with_capacity(P::DIM + 1);
    while frame.len() <= P::DIM {
        let basis: Vec<P> = frame.iter().map(|&i| points[i]).collect();
        let of_block =
            |(block, points): (usize, &[P])| smallest_outside(&basis, points).map(|i| block * BLOCK + i);
        let smaller = |a: usize, b: usize| if lex_cmp(&points[b], &points[a]).is_lt() { b } else { a };
        let next = points.par_chunks(BLOCK).enumerate().filter_map(of_block).reduce_with(smaller);
        match next {
            Some(i) => frame.push(i),
            None => break,
        }
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use septet_geometry::predicates::affine_frame;

    #[test]
    fn coincident_points_have_one_representative() {
        let p = |x: f64| DVec2::new(x, 0.5);
        let points = [p(1.0), p(0.0), p(1.0), p(-0.0), p(2.0), DVec2::new(0.0, 1.0), p(1.0)];
        let ready = prepare(&points, false).unwrap();
        assert_eq!(ready.ids(0..4).collect::<Vec<_>>(), [0, 1, 4, 5]);
        assert_eq!(ready.duplicates, [(2, 0), (3, 1), (6, 0)]);
        assert_eq!(ready.dimension, 2);
        assert_eq!(prepare::<DVec2>(&[], false).unwrap().dimension, -1);
    }

    #[test]
    fn points_that_are_not_finite_are_refused_or_dropped() {
        let points = [DVec2::ZERO, DVec2::new(f64::NAN, 0.0), DVec2::ONE];
        let error = prepare(&points, false).unwrap_err();
        assert!(matches!(error, Error::Points(RangeError::NotFinite { index: 1, .. })));
        let ready = prepare(&points, true).unwrap();
        assert_eq!((ready.ids(0..2).collect(), &ready.refused), (vec![0, 2], &vec![1]));
    }

    #[test]
    fn clean_points_are_not_copied() {
        let points: Vec<DVec2> = (0..3000u32).map(|i| DVec2::new(i.into(), (i * i % 1009).into())).collect();
        let ready = prepare(&points, false).unwrap();
        assert!(matches!(ready.positions, Cow::Borrowed(_)));
        assert_eq!(ready.ids(7..9).collect::<Vec<_>>(), [7, 8]);
        assert_eq!((ready.dimension, ready.frame.clone()), affine_frame(&points));
        // Append a copy of every tenth point.
        let copies = points.iter().copied().step_by(10);
        let more: Vec<DVec2> = points.iter().copied().chain(copies).collect();
        let ready = prepare(&more, false).unwrap();
        assert_eq!(ready.positions[..], points[..]);
        let expected: Vec<(u64, u64)> = (0..300).map(|i| (3000 + i, 10 * i)).collect();
        assert_eq!(ready.duplicates, expected);
    }

    #[test]
    fn spreads_are_named_by_the_inputs_numbers() {
        let points = [DVec2::NAN, DVec2::ONE, DVec2::new(1e-150, 1.0), DVec2::new(1e150, 3.0)];
        let error = prepare(&points, true).unwrap_err();
        assert!(matches!(error, Error::Points(RangeError::Spread { low: 2, high: 3, .. })), "{error}");
    }
}
