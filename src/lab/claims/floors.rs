//! The constants of `lower-bounds`: operations that every item of a natural size needs.
//!
//! - A *pair* needs its distance and a comparison.
//! - A *point at a level* needs its side, its rank on that side, and its move.
//! - A *ghost* needs a move.
//! - A *candidate* of a star needs a test against every facet of the final link.
//! - A *cell* belongs to the stars of at least three vertices.
//!
//! A level is at least one step, and a descent has a step down and a step up.

/// A size or a depth that a phase cannot avoid, from points, cells and the sizes of nodes alone.
#[derive(Clone, Copy, Debug)]
pub(super) enum Natural {
    /// 1.
    One,
    /// The number of points.
    Points,
    /// Ordered pairs of points of one leaf.
    PairsInLeaves,
    /// Pairs of an owned point and a member of its leaf.
    PairsWithMembers,
    /// The number of levels below the root.
    Levels,
    /// The points of all split nodes.
    PointsTimesLevels,
    /// Pairs of a ball that visits a leaf and a point of the leaf.
    PairsWithVisitors,
    /// Members of leaves that they do not own.
    Ghosts,
    /// The number of cells.
    Cells,
    /// For each point, its neighbours in the graph times the facets of its link; the sum.
    CandidatesTimesFacets,
    /// The largest number of neighbours in the graph.
    LargestDegree,
}

impl Natural {
    pub(super) fn name(self) -> &'static str {
        match self {
            Natural::One => "1",
            Natural::Points => "points",
            Natural::PairsInLeaves => "pairs in leaves",
            Natural::PairsWithMembers => "pairs of owned points and members",
            Natural::Levels => "levels",
            Natural::PointsTimesLevels => "points of all split nodes",
            Natural::PairsWithVisitors => "pairs of visiting balls and points",
            Natural::Ghosts => "ghosts",
            Natural::Cells => "cells",
            Natural::CandidatesTimesFacets => "candidates times link facets",
            Natural::LargestDegree => "the largest degree",
        }
    }
}

/// The lower bounds of a phase: the natural size of its work and its natural depth, and the operations of each item.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floor {
    pub(super) name: &'static str,
    /// Whether only runs with nearest-neighbour lists have the phase.
    pub(super) of_lists: bool,
    pub(super) work: Least,
    pub(super) depth: Least,
}

/// A number of operations for each item of a natural size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Least {
    pub(super) natural: Natural,
    pub(super) operations: f64,
}

const fn each(natural: Natural, operations: f64) -> Least {
    Least { natural, operations }
}

const fn floor(name: &'static str, work: Least, depth: Least) -> Floor {
    Floor { name, of_lists: false, work, depth }
}

/// The lower bounds of all phases of the paper.
pub(super) const FLOORS: [Floor; 10] = [
    floor("partition", each(Natural::PointsTimesLevels, 3.0), each(Natural::Levels, 3.0)),
    floor("radii", each(Natural::PairsInLeaves, 2.0), each(Natural::One, 2.0)),
    floor("neighbours", each(Natural::PairsWithVisitors, 2.0), each(Natural::Levels, 2.0)),
    floor("summaries", each(Natural::Points, 1.0), each(Natural::Levels, 1.0)),
    floor("separator-sets", each(Natural::Ghosts, 1.0), each(Natural::Levels, 1.0)),
    floor("graph", each(Natural::PairsWithMembers, 2.0), each(Natural::One, 2.0)),
    floor("hulls", each(Natural::CandidatesTimesFacets, 1.0), each(Natural::LargestDegree, 1.0)),
    floor("merge", each(Natural::Cells, 3.0), each(Natural::Levels, 1.0)),
    Floor {
        of_lists: true,
        ..floor("knn-radii", each(Natural::PairsInLeaves, 2.0), each(Natural::One, 2.0))
    },
    Floor {
        of_lists: true,
        ..floor("knn", each(Natural::PairsWithVisitors, 2.0), each(Natural::Levels, 2.0))
    },
];
