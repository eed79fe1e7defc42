//! The decision on a certificate.
//!
//! **Statement.** The stars form one triangulation of the input if four conditions hold: the workers own the points of the
//! input, every point has a star, all stars agree, and exactly one point has no lexicographically smaller neighbour. The
//! proof is in `stars/proof.md`.

use septet_protocol::message::{Merged, PointSum};
use septet_protocol::outcome::Outcome;

/// Decides on the merged result of the points `population` after pass number `pass`.
pub(crate) fn decide(merged: Merged, population: PointSum, pass: u32) -> Outcome {
    if merged.point_hash != population.hash {
        // No gathering replaces wrong points.
        return Outcome::Failed;
    }
    match (merged.is_certified(population), pass) {
        (true, _) => Outcome::Passed,
        (false, 0) => Outcome::GatherUnresolved,
        (false, 1) => Outcome::GatherAll,
        _ => Outcome::Failed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_clause_is_needed_and_two_gatherings_are_tried() {
        let whole = Merged { stars: 9, minima: 1, point_hash: 77, ..Merged::default() };
        let points = PointSum { count: 9, hash: 77 };
        assert_eq!(decide(whole, points, 0), Outcome::Passed);
        let broken = [
            Merged { stars: 8, ..whole },
            Merged { disagreements: 1, ..whole },
            Merged { minima: 2, ..whole },
            Merged { minima: 0, ..whole },
        ];
        for merged in broken {
            let outcomes = [0, 1, 2].map(|pass| decide(merged, points, pass));
            assert_eq!(outcomes, [Outcome::GatherUnresolved, Outcome::GatherAll, Outcome::Failed]);
        }
        assert_eq!(decide(Merged { point_hash: 78, ..whole }, points, 0), Outcome::Failed);
    }
}
