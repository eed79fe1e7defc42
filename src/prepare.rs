//! From input points to the machine's: coincident points found, -0.0 read as 0.0, coordinates brought into
//! the exact range by a power of two, a frame that spans the space.

use rayon::prelude::*;

use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::predicates::affine_frame;
use septet_geometry::range::{RangeError, scale, scale_exponent};
use septet_workers::view::shown_hash;

use crate::error::Error;

/// A point set ready for the machine.
#[derive(Debug)]
pub(crate) struct Prepared<P> {
    /// Distinct points, scaled, in input order.
    pub(crate) positions: Vec<P>,
    /// Their input indices: of coincident points the smallest.
    pub(crate) ids: Vec<u64>,
    /// Coincident points: index, and the smallest index with the same coordinates.
    pub(crate) duplicates: Vec<(u64, u64)>,
    /// Points dropped because they were not finite.
    pub(crate) refused: Vec<u64>,
    /// The coordinates were multiplied by two to this power.
    pub(crate) exponent: i32,
    /// Dimension of the affine hull, -1 for no points.
    pub(crate) dimension: isize,
    /// Positions (in `positions`) of affinely independent points that span it.
    pub(crate) frame: Vec<usize>,
    /// Squared radii of balls that are given; none where neighbours give them.
    pub(crate) radii2: Vec<f64>,
}

/// Prepares points.
///
/// # Errors
/// A point that is not finite (unless skipped), or coordinates that spread too far for exact signs; the
/// indices are the input's.
pub(crate) fn prepare<P: Point>(points: &[P], skip_invalid: bool) -> Result<Prepared<P>, Error> {
    let (mut kept, mut refused) = (Vec::with_capacity(points.len()), Vec::new());
    for (index, p) in points.iter().enumerate() {
        let bad = (0..P::DIM).map(|i| p.coord(i)).find(|c| !c.is_finite());
        match bad {
            None => kept.push(index as u64),
            Some(_) if skip_invalid => refused.push(index as u64),
            Some(value) => return Err(RangeError::NotFinite { index, value }.into()),
        }
    }
    let clean: Vec<P> = kept.iter().map(|&i| without_negative_zero(points[i as usize])).collect();
    let exponent = scale_exponent(&clean).map_err(|e| renumber(e, &kept))?;
    let (first, duplicates) = coincidences(&clean);
    let duplicates = duplicates.into_iter().map(|(i, of)| (kept[i as usize], kept[of as usize])).collect();
    let positions: Vec<P> = first
        .iter()
        .map(|&i| if exponent == 0 { clean[i as usize] } else { scale(clean[i as usize], exponent) })
        .collect();
    let ids = first.iter().map(|&i| kept[i as usize]).collect();
    let (dimension, frame) = affine_frame(&positions);
    Ok(Prepared { positions, ids, duplicates, refused, exponent, dimension, frame, radii2: Vec::new() })
}

pub(crate) fn without_negative_zero<P: Point>(mut p: P) -> P {
    for i in 0..P::DIM {
        p.set_coord(i, p.coord(i) + 0.0);
    }
    p
}

fn renumber(error: RangeError, kept: &[u64]) -> RangeError {
    match error {
        RangeError::Spread { bits, low, high } => {
            RangeError::Spread { bits, low: kept[low] as usize, high: kept[high] as usize }
        }
        RangeError::NotFinite { index, value } => {
            RangeError::NotFinite { index: kept[index] as usize, value }
        }
    }
}

/// The first of every group of coincident points, in order, and the others with their first.
///
/// Points are sorted by 32 bits of a hash of their coordinates; only points that share them are compared.
pub(crate) fn coincidences<P: Point>(points: &[P]) -> (Vec<u32>, Vec<(u32, u32)>) {
    let mut keys: Vec<u64> = points
        .par_iter()
        .zip(0..points.len() as u32)
        .map(|(p, i)| shown_hash(*p) & !u64::from(u32::MAX) | u64::from(i))
        .collect();
    keys.par_sort_unstable();
    let mut duplicates = Vec::new();
    for alike in keys.chunk_by(|a, b| a >> 32 == b >> 32).filter(|alike| alike.len() > 1) {
        let mut alike: Vec<u32> = alike.iter().map(|&key| key as u32).collect();
        alike.sort_unstable_by(|&a, &b| lex_cmp(&points[a as usize], &points[b as usize]).then(a.cmp(&b)));
        let same = |a: &u32, b: &u32| lex_cmp(&points[*a as usize], &points[*b as usize]).is_eq();
        for group in alike.chunk_by(same) {
            duplicates.extend(group[1..].iter().map(|&i| (i, group[0])));
        }
    }
    duplicates.sort_unstable();
    let mut repeats = duplicates.iter().map(|d| d.0).peekable();
    let firsts = (0..points.len() as u32).filter(|&i| repeats.next_if_eq(&i).is_none()).collect();
    (firsts, duplicates)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn coincident_points_have_one_representative() {
        let p = |x: f64| DVec2::new(x, 0.5);
        let points = [p(1.0), p(0.0), p(1.0), p(-0.0), p(2.0), DVec2::new(0.0, 1.0), p(1.0)];
        let ready = prepare(&points, false).unwrap();
        assert_eq!(ready.ids, [0, 1, 4, 5]);
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
        assert_eq!((ready.ids, ready.refused), (vec![0, 2], vec![1]));
    }
}
