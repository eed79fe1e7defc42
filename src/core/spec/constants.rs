//! The constants of the partition tree: the samples and great circles of a draw, and the largest leaf.
//!
//! No result depends on them, but work, depth and time do. The program `constants` of `bench` counts the recursion for
//! other constants.

use septet_geometry::graph::Supergraph;
pub use septet_workers::config::Purpose;
use septet_workers::config::SetRule as SeparatorSets;

use crate::spec::graph::DEFAULT_ALPHA;

words!(Purpose {
    Counting "counting" "Little work and depth",
    Timing "timing" "Little time",
});

/// The constants of a counted run as requested. The purpose decides those that are `None`. The leaf size is part of
/// [`crate::spec::Tree`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Constants {
    /// The purpose.
    pub purpose: Purpose,
    /// Largest expected number of samples of a draw. Small subproblems have fewer samples.
    pub samples: Option<u64>,
    /// Number of great circles of a draw.
    pub tries: Option<u32>,
}

/// The constants that a run uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TreeConstants {
    pub(crate) samples: u64,
    pub(crate) tries: u32,
    /// Largest leaf, in points.
    pub(crate) leaf: u64,
}

/// Largest leaf for [`Purpose::Counting`], from the plane to dimension 6, if children share no separator points. It exceeds the
/// number of neighbours of a point.
const COUNTING_LEAF: [u64; 5] = [40, 60, 120, 240, 480];

impl TreeConstants {
    /// Returns the constants for a purpose. The children of a node share separator points by the rule `sets`, in this
    /// supergraph if it is known.
    pub(crate) fn of(
        purpose: Purpose,
        dimension: usize,
        sets: SeparatorSets,
        supergraph: Option<Supergraph>,
    ) -> Self {
        match (purpose, sets) {
            (Purpose::Counting, SeparatorSets::Ghost) => {
                TreeConstants { samples: 100, tries: 10, leaf: COUNTING_LEAF[dimension - 2] }
            }
            (Purpose::Counting, SeparatorSets::Both | SeparatorSets::Own | SeparatorSets::Smaller) => {
                TreeConstants { samples: 100, tries: 10, leaf: leaf_of_unions(dimension, supergraph) }
            }
            // Larger leaves use caches better.
            (Purpose::Timing, _) => {
                TreeConstants { samples: 400, tries: 10, leaf: leaf_of_unions(dimension, supergraph) }
            }
        }
    }
}

/// Returns the smallest leaf size at which separator sets do not fill the leaves, if the children of a node receive the
/// separator points of each other. Such a leaf has about 1,000 points in space at alpha 2.5 and 500 in the plane, and
/// grows with the volume of the alpha-balls, which is proportional to k if they extend to the k-th neighbour.
fn leaf_of_unions(dimension: usize, supergraph: Option<Supergraph>) -> u64 {
    let floor = if dimension == 2 { 500.0 } else { 1000.0 };
    let (alpha, k) = match supergraph {
        Some(Supergraph::Density { alpha }) => (alpha, 1),
        Some(Supergraph::Overlap { alpha, k }) => (alpha, k),
        Some(Supergraph::Knn { .. }) | None => (DEFAULT_ALPHA, 1),
    };
    let volume = (0..dimension).fold(1.0, |g: f64, _| g * (alpha / DEFAULT_ALPHA));
    (floor * (volume * f64::from(k)).max(1.0)).min(1e9) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_of_unions_grow_with_balls() {
        assert_eq!(leaf_of_unions(3, None), 1000);
        let density = |alpha| Some(Supergraph::Density { alpha });
        assert_eq!(leaf_of_unions(3, density(5.0)), 8000);
        assert_eq!(leaf_of_unions(2, density(5.0)), 2000);
        assert_eq!(leaf_of_unions(2, density(1.0)), 500);
        let overlap = |alpha, k| Some(Supergraph::Overlap { alpha, k });
        assert_eq!([1, 4].map(|k| leaf_of_unions(3, overlap(2.5, k))), [1000, 4000]);
        assert_eq!([1, 4].map(|k| leaf_of_unions(2, overlap(1.25, k))), [500, 500]);
        assert_eq!(leaf_of_unions(3, Some(Supergraph::Knn { k: 12 })), 1000);
        assert!((DEFAULT_ALPHA - 2.5).abs() < 1e-15);
    }

    #[test]
    fn only_unions_and_processors_need_large_leaves() {
        let leaf = |purpose, sets| TreeConstants::of(purpose, 3, sets, None).leaf;
        assert_eq!(leaf(Purpose::Counting, SeparatorSets::Ghost), COUNTING_LEAF[1]);
        assert_eq!(leaf(Purpose::Counting, SeparatorSets::Both), 1000);
        assert_eq!(leaf(Purpose::Counting, SeparatorSets::Smaller), 1000);
        assert_eq!(leaf(Purpose::Timing, SeparatorSets::Ghost), 1000);
    }
}
