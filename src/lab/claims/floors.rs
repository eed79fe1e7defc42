//! The constants of `lower-bounds`: the operations that each phase cannot avoid.
//!
//! **Derivation.** Every floor is a sum of terms. A term is a *natural size* ([`Natural`]), such as the number of pairs
//! in leaves, times a price. The price is that of the primitives that the guide names for the phase ("Work and depth"
//! and "Prices" of `src/guide/machine.md`). The derivation does not use the code of the phases. Below, a number in
//! parentheses is both the operations per item and the steps.
//!
//! - `partition`. An attempt at a node packs the samples (3), broadcasts the separator and finds the sides of the
//!   points (2), and counts the sides (1). Then the node splits its points (4). These are 10 operations per point of a
//!   split node, and 10 steps. A draw sorts the samples, and visits all pairs of samples (3 operations per pair, 3
//!   steps). The number of samples is a quarter of the points, but at least 36 and at most 100. So the sort has at
//!   least 6 steps. A leaf sorts its points.
//! - `radii`, `knn-radii`. All pairs within a leaf: 3 operations per pair, 3 steps. Lists also sort the pairs (at least
//!   6) and move them (1): 10 operations per pair in total.
//! - `neighbours`, `knn`. At each node, a replication of its balls: 6 operations per ball, 6 steps. For each ball that
//!   goes to both children, a combination of both results: 4 operations. A node without such balls combines nothing, so
//!   only replications count as steps. Two lists of [`LIST`] neighbours are merged in 5 steps over both lists. At a
//!   leaf, all pairs of visiting balls and points: 3 operations per pair, 3 steps; for lists, 10 operations per pair.
//! - `summaries`. A reduction over the points of a leaf: 1 operation per point, 1 step. A reduction over the two
//!   children of a node: 2 operations, 1 step.
//! - `separator-sets`. A comparison of the two children: 2 operations, 1 step. A replication of the points that go
//!   down: 6 operations per point, 6 steps.
//! - `graph`. All pairs of an owned point and a member of a leaf: 3 operations per pair, 3 steps. The members are the
//!   owned points and the ghosts.
//! - `hulls`. A sweep over the link facets for each candidate: 2 operations per facet. The first candidates meet links
//!   that are smaller than the final one, so a candidate counts 1.6 operations per facet of the final link. Candidates
//!   are added in sequence, so each counts at least one step.
//! - `check`. A sum of each link facet, and a delivery of its cell. A leaf has at least 64 link facets, so the delivery has at
//!   least 10 steps: with the sweep of the sum, 12 operations per facet, 12 steps.
//! - `merge`. A sweep over the vertices of the link facets: 2 operations per vertex, 2 steps. A reduction over the two
//!   children of a node: 2 operations, 1 step.
//! - `independent`. In each half round, an undecided point sweeps its list of neighbours to decide, and again to inform
//!   them. These are 4 sweeps per round: 8 operations per entry, 8 steps. A pack keeps the undecided points: 3
//!   operations per point, 3 steps.
//!
//! The probes have no floor, because the result can be computed without them. `own-sets` has none, because its sets are known
//! only from the run.

use super::sweeps::LIST;

/// The share of its floor that a phase must reach. The samples of a node are random, and their number varies by a few
/// percent. Balls have their final radii here, and larger ones in the machine.
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
    /// `ceil(log2 m) m` for the m points of a leaf, summed over the leaves.
    SortsInLeaves,
    /// Ordered pairs of points of one leaf.
    PairsInLeaves,
    /// Balls that reach a split node, summed over all split nodes.
    BallsAtNodes,
    /// Balls that go to both children of a split node, summed over all split nodes.
    BallsToBoth,
    /// Pairs of a ball that visits a leaf and a point of the leaf.
    PairsWithVisitors,
    /// Points that a split node owns or that may have an edge into it, summed over all split nodes.
    PointsAtNodes,
    /// Pairs of an owned point of a leaf and a point that is owned there or may have an edge into the leaf.
    PairsWithMembers,
    /// The facets of the links of all points, `d + 1` for each cell.
    LinkFacets,
    /// The vertices of these facets, and for each facet the point of the link.
    VerticesOfFacets,
    /// The neighbours of a point in the graph times the facets of its link, summed over the points.
    CandidatesTimesFacets,
    /// The largest number of neighbours in the graph.
    LargestDegree,
    /// The lengths of the neighbour lists of undecided points, summed over all rounds.
    OpenEdges,
    /// The numbers of undecided points, summed over all rounds.
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
    /// Density graphs of well-spaced sets. They contain all edges of the triangulation, so the local hulls are the
    /// stars of the triangulation.
    WellSpaced,
    /// Density graphs of all sets.
    Graphs,
    /// Nearest-neighbour lists.
    Lists,
    /// Independent sets of sites.
    Sites,
}

/// A number of operations or steps per item, and the natural size that counts the items.
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

/// Steps of a merge of two lists of [`LIST`] neighbours, `ceil(log2 24)`.
const MERGE: f64 = 5.0;

/// The steps of all pairs: broadcast, step, reduction.
const OF_PAIRS: &[Term] = &[(3.0, Natural::One)];

/// The steps of a descent: a replication at each level, then all pairs at a leaf.
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
    floor(Runs::WellSpaced, "check", &[(12.0, Natural::LinkFacets)], &[(12.0, Natural::One)]),
    floor(
        Runs::Graphs,
        "merge",
        &[(2.0, Natural::VerticesOfFacets), (2.0, Natural::Splits)],
        &[(1.0, Natural::Levels), (2.0, Natural::One)],
    ),
];
