//! The order of insertion.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::cost::Cost;
use crate::incremental::IncrementalError;
use crate::point::{Point, lex_cmp};
use crate::predicates::raises_dimension;

/// Largest number of points, as in [`crate::incremental`].
const MOST_POINTS: usize = 1 << 26;

/// The points in the order of insertion.
pub(super) struct Order<P> {
    /// The indices of the points in the given set.
    pub(super) indices: Vec<u32>,
    pub(super) positions: Vec<P>,
}

impl<P: Point> Order<P> {
    /// Draws a random order that starts with affinely independent points. The order is a function of the set and the
    /// seed, not of the numbering.
    ///
    /// Drawing and sorting the keys is charged, and so is the search for independent points. The check of the input is
    /// not charged. It sorts the points, as the check of the input of the paper's recursion does.
    pub(super) fn draw(points: &[P], seed: u64, cost: &mut Cost) -> Result<Self, IncrementalError> {
        let checked = checked(points)?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut keyed = cost.map(&checked, |&i| (rng.next_u64(), i));
        // Equal keys keep their lexicographic order.
        cost.sort(&mut keyed, |a, b| a.0.cmp(&b.0));
        let drawn = cost.map(&keyed, |&(_, i)| i);
        let mut frame: Vec<P> = Vec::new();
        let mut first: Vec<u32> = Vec::new();
        while frame.len() <= P::DIM {
            let independent = |&i: &u32| raises_dimension(&frame, points[i as usize]).then_some(i);
            let next = cost.reduce(&drawn, None, |found: Option<u32>, i| found.or_else(|| independent(i)));
            let Some(i) = next else {
                return Err(IncrementalError::Flat { dimension: frame.len() as isize - 1 });
            };
            first.push(i);
            frame.push(points[i as usize]);
        }
        let mut rest = cost.pack(&drawn, |i| !first.contains(i));
        first.append(&mut rest);
        let positions = cost.map(&first, |&i| points[i as usize]);
        Ok(Order { indices: first, positions })
    }
}

/// Checks that the points are distinct and finite. Returns their indices in lexicographic order.
fn checked<P: Point>(points: &[P]) -> Result<Vec<u32>, IncrementalError> {
    if points.len() > MOST_POINTS {
        return Err(IncrementalError::TooMany);
    }
    let finite = |p: &P| (0..P::DIM).all(|i| p.coord(i).is_finite());
    if let Some(point) = points.iter().position(|p| !finite(p)) {
        return Err(IncrementalError::NotFinite { point: point as u32 });
    }
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| lex_cmp(&points[a as usize], &points[b as usize]).then(a.cmp(&b)));
    let same = |w: &&[u32]| lex_cmp(&points[w[0] as usize], &points[w[1] as usize]).is_eq();
    match order.windows(2).find(same) {
        Some(pair) => Err(IncrementalError::Coincident { point: pair[1], vertex: pair[0] }),
        None => Ok(order),
    }
}
