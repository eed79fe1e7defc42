//! The constants of `lower-bounds`: the operations that each phase cannot avoid.
//!
//! **Derivation.** Every floor is a sum of terms. A term is a natural size times the price of the primitives that the
//! guide names for the phase ("Work and depth" and "Prices" of `src/guide/machine.md`). The code of the phases is not
//! used.
//!
//! - `partition`. An attempt at a node packs the samples (3), broadcasts the separator and finds sides (2), and counts them
//!   (1). Then the node splits its points (4). These are 10 operations per point of a split node, and 10 steps. A draw
//!   sorts the samples, and visits all pairs of samples (3 operations per pair, 3 steps). A node draws a quarter of its
//!   points, between 36 and 100, so a sort has at least 6 steps. A leaf sorts its points.
//! - `radii`, `knn-radii`. All pairs within a leaf: 3 per pair, 3 steps. Lists also sort the pairs, in at least 6 steps, and
//!   move them: 10 per pair.
//! - `neighbours`, `knn`. At each node, a replication of its balls (6 per ball, 6 steps) and a combination of the results of
//!   balls that go to both children (4 per ball). Two lists of [`LIST`] neighbours are merged in 5 steps over both. At a
//!   leaf, all pairs of visiting balls and points (3 per pair, 3 steps; 10 per pair for lists). A node without such balls combines nothing, so only replications count as steps.
//! - `summaries`. A reduction over the points of a leaf (1 per point, 1 step), and over the two children of a node (2, 1
//!   step).
//! - `separator-sets`. A comparison of the two children (2, 1 step), and a replication of the points that go down (6 per
//!   point, 6 steps).
//! - `graph`. All pairs of owned points and members of a leaf: 3 per pair, 3 steps.
//! - `hulls`. A sweep over the link facets for each candidate, 2 per facet. The first candidates meet links that are smaller
//!   than the final one, so a candidate counts 1.6 per facet of the final link. Candidates follow each other.
//! - `check`. A sum and two look-ups of each link facet: 3 sweeps, 6 per facet, 6 steps.
//! - `merge`. A sweep over the vertices of the link facets (2 per vertex, 2 steps), and a reduction over the two children of
//!   a node (2, 1 step).
//! - `independent`. In each half round, an undecided point sweeps its list to decide, and again to inform its neighbours.
//!   These are 4 sweeps per round: 8 per entry, 8 steps. A pack keeps the undecided points (3 per point, 3 steps).
//!
//! The probes have no floor: a result does not need them.

use super::sweeps::LIST;

/// The share of a sum that a phase must reach. The samples of a node are random, and their number varies by a few percent.
/// Balls have their final radii here, and larger ones in the machine.
pub(super) const SHARE: f64 = 0.9;

/// A size or a depth that a phase cannot avoid, from points, cells, surfaces and sites alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Natural {
    /// 1.
    One,
    /// The number of points.
    Points,
    /// The number of nodes that were split.
    Splits,
    /// The number of levels below the root.
    Levels,
    /// The points of all split nodes.
    PointsTimesLevels,
    /// Pairs of samples of all split nodes.
    PairsOfSamples,
    /// `L m` for the m points of each leaf; the sum.
    SortsInLeaves,
    /// Ordered pairs of points of one leaf.
    PairsInLeaves,
    /// Balls at all split nodes.
    BallsAtNodes,
    /// Balls that go to both children, over all split nodes.
    BallsToBoth,
    /// Pairs of a ball that visits a leaf and a point of the leaf.
    PairsWithVisitors,
    /// Points that edges may take to a split node, over all split nodes.
    PointsAtNodes,
    /// Pairs of an owned point of a leaf and a point that is owned there or has an edge there.
    PairsWithMembers,
    /// The facets of the links of all points, `d + 1` for each cell.
    LinkFacets,
    /// The vertices of these facets, with the point of the link.
    VerticesOfFacets,
    /// For each point, its neighbours in the graph times the facets of its link; the sum.
    CandidatesTimesFacets,
    /// The largest number of neighbours in the graph.
    LargestDegree,
    /// The lengths of the lists of undecided points, over all rounds.
    OpenEdges,
    /// Undecided points, over all rounds.
    OpenPoints,
    /// Rounds of local priorities.
    Rounds,
}

impl Natural {
    pub(super) fn name(self) -> &'static str {
        match self {
            Natural::One => "1",
            Natural::Points => "points",
            Natural::Splits => "split nodes",
            Natural::Levels => "levels",
            Natural::PointsTimesLevels => "points of split nodes",
            Natural::PairsOfSamples => "pairs of samples",
            Natural::SortsInLeaves => "sorts in leaves",
            Natural::PairsInLeaves => "pairs in leaves",
            Natural::BallsAtNodes => "balls at nodes",
            Natural::BallsToBoth => "balls to both children",
            Natural::PairsWithVisitors => "pairs of visiting balls and points",
            Natural::PointsAtNodes => "points at nodes",
            Natural::PairsWithMembers => "pairs of owned points and members",
            Natural::LinkFacets => "link facets",
            Natural::VerticesOfFacets => "vertices of link facets",
            Natural::CandidatesTimesFacets => "candidates times link facets",
            Natural::LargestDegree => "the largest degree",
            Natural::OpenEdges => "entries of undecided points",
            Natural::OpenPoints => "undecided points",
            Natural::Rounds => "rounds",
        }
    }
}

/// The runs that have a floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Runs {
    /// Density graphs of well-spaced sets. They contain all edges of the triangulation, so the stars that are built are
    /// those of the cells.
    WellSpaced,
    /// Density graphs of all sets.
    Graphs,
    /// Nearest-neighbour lists.
    Lists,
    /// Independent sets of sites.
    Sites,
}

/// Operations for each item of a natural size.
pub(super) type Term = (f64, Natural);

/// The floors of the work and of the depth of a phase: sums of terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floor {
    pub(super) phase: &'static str,
    pub(super) runs: Runs,
    pub(super) work: &'static [Term],
    pub(super) depth: &'static [Term],
}

const fn floor(runs: Runs, phase: &'static str, work: &'static [Term], depth: &'static [Term]) -> Floor {
    Floor { phase, runs, work, depth }
}

/// Pairs: broadcast, step, reduction.
/// Steps of a merge of two lists of [`LIST`] neighbours, `ceil(log2 24)`.
const MERGE: f64 = 5.0;

const OF_PAIRS: &[Term] = &[(3.0, Natural::One)];

/// The steps of a descent.
const OF_DESCENT: &[Term] = &[(6.0, Natural::Levels), (3.0, Natural::One)];

/// The floors of the phases of the paper with a natural size, and of the check.
pub(super) const FLOORS: [Floor; 12] = [
    floor(
        Runs::Graphs,
        "partition",
        &[(10.0, Natural::PointsTimesLevels), (3.0, Natural::PairsOfSamples), (1.0, Natural::SortsInLeaves)],
        &[(19.0, Natural::Levels)],
    ),
    floor(Runs::Graphs, "radii", &[(3.0, Natural::PairsInLeaves)], OF_PAIRS),
    floor(
        Runs::Graphs,
        "neighbours",
        &[(6.0, Natural::BallsAtNodes), (4.0, Natural::BallsToBoth), (3.0, Natural::PairsWithVisitors)],
        OF_DESCENT,
    ),
    floor(
        Runs::Graphs,
        "summaries",
        &[(1.0, Natural::Points), (2.0, Natural::Splits)],
        &[(1.0, Natural::Levels), (1.0, Natural::One)],
    ),
    floor(Runs::Lists, "knn-radii", &[(10.0, Natural::PairsInLeaves)], OF_PAIRS),
    floor(
        Runs::Lists,
        "knn",
        &[
            (6.0, Natural::BallsAtNodes),
            (4.0 + 2.0 * LIST as f64 * MERGE, Natural::BallsToBoth),
            (10.0, Natural::PairsWithVisitors),
        ],
        OF_DESCENT,
    ),
    floor(
        Runs::Graphs,
        "separator-sets",
        &[(2.0, Natural::Splits), (6.0, Natural::PointsAtNodes)],
        &[(7.0, Natural::Levels)],
    ),
    floor(Runs::Graphs, "graph", &[(3.0, Natural::PairsWithMembers)], OF_PAIRS),
    floor(
        Runs::Sites,
        "independent",
        &[(8.0, Natural::OpenEdges), (3.0, Natural::OpenPoints)],
        &[(11.0, Natural::Rounds)],
    ),
    floor(
        Runs::WellSpaced,
        "hulls",
        &[(1.6, Natural::CandidatesTimesFacets)],
        &[(1.0, Natural::LargestDegree)],
    ),
    floor(Runs::WellSpaced, "check", &[(6.0, Natural::LinkFacets)], &[(6.0, Natural::One)]),
    floor(
        Runs::Graphs,
        "merge",
        &[(2.0, Natural::VerticesOfFacets), (2.0, Natural::Splits)],
        &[(1.0, Natural::Levels), (2.0, Natural::One)],
    ),
];
