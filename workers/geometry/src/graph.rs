//! Overlap, density and nearest-neighbour graphs of a neighbourhood system.
//!
//! **Statement.** Let `B_i` be balls with radii `r_i`.
//! - The `(alpha, k)`-overlap graph (paper, Definition 2.2) has the edge `ij` iff `B_i` meets `alpha B_j` and
//!   `alpha B_i` meets `B_j`. For `alpha >= 1` this means `|ij| <= alpha min(r_i, r_j) + max(r_i, r_j)`. Each ball
//!   extends to the `k`-th nearest neighbour of its centre.
//! - The `alpha`-density graph (Section 4.2) of nearest-neighbour balls has the edge `ij` iff
//!   `|ij| <= alpha min(r_i, r_j)`. The two-sided minimum is essential: with one-sided balls, the degree at a
//!   singularity is proportional to `n`.
//! - The `k`-nearest-neighbour graph (Section 4.5) of balls that extend to the `k`-th neighbour has the edge `ij` iff
//!   `|ij| <= max(r_i, r_j)`. Then one point is among the `k` nearest neighbours of the other, ties included.
//!
//! The divide and conquer, the direct construction and the tests evaluate each condition by the same expression, which
//! is symmetric in `i` and `j`. All of them therefore yield the same graph, edge by edge.
//!
//! **Departure.** Definition 2.2 has any k-ply system of balls. Balls to the `k`-th neighbour have ply at most
//! `tau_d k` ([`crate::neighbourhood`]), so `k` is the ply up to a constant, and the bounds of Section 2 keep their form.
//!
//! **Work and depth.** The direct construction tests `m^2` pairs in O(1) steps.

use crate::coordinate_arrays::{CoordinateArrays, PairVisitor};
use crate::cost::Cost;
use crate::lists::Lists;
use crate::point::{Point, dist2};

/// A supergraph of the Delaunay triangulation, with its parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Supergraph {
    /// The alpha-density graph of the nearest-neighbour balls.
    Density {
        /// Enlargement factor of the balls, at least 1.
        alpha: f64,
    },
    /// The (alpha, k)-overlap graph of the balls that extend to the k-th nearest neighbour.
    Overlap {
        /// Enlargement factor of the balls, at least 1.
        alpha: f64,
        /// Rank of the neighbour to which the balls extend, at least 1.
        k: u32,
    },
    /// The k-nearest-neighbour graph.
    Knn {
        /// Number of nearest neighbours, at least 1.
        k: u32,
    },
}

impl Supergraph {
    /// Returns `true` if two points at squared distance `d2`, whose balls have squared radii `a2` and `b2`, form an
    /// edge. The test is symmetric in the two points.
    #[inline]
    pub fn joins(self, d2: f64, a2: f64, b2: f64) -> bool {
        match self {
            Supergraph::Density { alpha } => d2 <= alpha * alpha * a2.min(b2),
            Supergraph::Overlap { alpha, .. } => d2.sqrt() <= alpha * a2.min(b2).sqrt() + a2.max(b2).sqrt(),
            Supergraph::Knn { .. } => d2 <= a2.max(b2),
        }
    }

    /// Returns an upper bound, rounded up, on the length of an edge from a point with squared radius `r2` to a point
    /// of a set whose largest squared radius is `max2`.
    pub fn reach(self, r2: f64, max2: f64) -> f64 {
        let up = 1.0 + 1e-12;
        match self {
            Supergraph::Density { alpha } => alpha * r2.min(max2).sqrt() * up,
            Supergraph::Overlap { alpha, .. } => {
                (alpha * r2.min(max2).sqrt() + r2.max(max2).sqrt()).min(alpha * r2.sqrt() + max2.sqrt()) * up
            }
            Supergraph::Knn { .. } => r2.max(max2).sqrt() * up,
        }
    }

    /// Returns the radius of the ball that decides whether a point belongs to the separator set of a sphere. Every
    /// edge that crosses the sphere has an endpoint whose ball of this radius meets it. In the density graph, both
    /// endpoints do.
    pub fn separator_radius(self, r2: f64) -> f64 {
        let up = 1.0 + 1e-12;
        match self {
            Supergraph::Density { alpha } | Supergraph::Overlap { alpha, .. } => alpha * r2.sqrt() * up,
            Supergraph::Knn { .. } => r2.sqrt() * up,
        }
    }

    /// Returns the name of the supergraph on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Supergraph::Density { .. } => "density",
            Supergraph::Overlap { .. } => "overlap",
            Supergraph::Knn { .. } => "knn",
        }
    }

    /// Returns the rank of the neighbour to which the balls extend: `k`, or 1.
    pub fn ball_order(self) -> u32 {
        match self {
            Supergraph::Overlap { k, .. } | Supergraph::Knn { k } => k,
            Supergraph::Density { .. } => 1,
        }
    }
}

/// Finds the graph neighbours of every row among the columns, testing all pairs. Rows, columns and neighbours are
/// positions in the table.
pub fn graph_direct<P: Point>(
    rule: Supergraph,
    table: &[P],
    radii2: &[f64],
    rows: &[u32],
    cols: &[u32],
    cost: &mut Cost,
) -> Lists<u32> {
    let at = |&i: &u32| table[i as usize];
    let ends = |numbers: &[u32]| numbers.iter().map(|&i| (radii2[i as usize], i)).collect::<Vec<_>>();
    let points: Vec<P> = rows.iter().map(at).collect();
    let columns = CoordinateArrays::of(cols.iter().map(at));
    let (rows, cols) = (ends(rows), ends(cols));
    let largest2 = cols.iter().map(|c| c.0).fold(0.0, f64::max);
    let mut edges = Edges {
        rule,
        rows,
        cols,
        largest2,
        row: (0.0, 0),
        limit2: 0.0,
        list: Vec::new(),
        lists: Lists::default(),
    };
    cost.all_pairs_to_lists(&points, &columns, &mut edges);
    edges.lists
}

/// Collects the graph neighbours of each row. Rows and columns are pairs of squared radius and position.
struct Edges {
    rule: Supergraph,
    rows: Vec<(f64, u32)>,
    cols: Vec<(f64, u32)>,
    /// Largest squared radius of the columns. No edge of a row is longer than the row's reach into a ball of this
    /// radius, so one comparison excludes most pairs.
    largest2: f64,
    row: (f64, u32),
    limit2: f64,
    list: Vec<u32>,
    lists: Lists<u32>,
}

impl PairVisitor for Edges {
    fn begin(&mut self, row: usize) -> f64 {
        self.row = self.rows[row];
        let reach = self.rule.reach(self.row.0, self.largest2);
        self.limit2 = reach * reach * (1.0 + 1e-12);
        self.limit2
    }

    #[inline]
    fn visit(&mut self, column: usize, d2: f64) -> f64 {
        let (r2, number) = self.cols[column];
        if self.rule.joins(d2, self.row.0, r2) && self.row.1 != number {
            self.list.push(number);
        }
        self.limit2
    }

    fn end(&mut self, _: usize) {
        self.lists.push(self.list.drain(..));
    }
}

/// Computes the density of an embedding (Section 2): the maximum, over all vertices, of the longest edge relative to
/// the distance of the nearest neighbour. `edges` are pairs of positions, and `radii2` are the squared
/// nearest-neighbour distances.
pub fn embedding_density<P: Point>(points: &[P], radii2: &[f64], edges: &[(u32, u32)]) -> f64 {
    edges
        .iter()
        .map(|&(i, j)| {
            let d2 = dist2(points[i as usize], points[j as usize]);
            (d2 / radii2[i as usize].min(radii2[j as usize])).sqrt()
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_symmetric_and_reach_covers_them() {
        let rules = [
            Supergraph::Density { alpha: 2.5 },
            Supergraph::Overlap { alpha: 2.5, k: 1 },
            Supergraph::Knn { k: 8 },
        ];
        let values = [1e-6, 0.3, 1.0, 1.7, 40.0];
        for rule in rules {
            for &d2 in &values {
                for &a2 in &values {
                    for &b2 in &values {
                        assert_eq!(rule.joins(d2, a2, b2), rule.joins(d2, b2, a2));
                        if rule.joins(d2, a2, b2) {
                            for &max2 in values.iter().filter(|&&m| m >= b2) {
                                assert!(d2.sqrt() <= rule.reach(a2, max2), "{rule:?} {d2} {a2} {b2} {max2}");
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_overlap_edge_that_one_sided_sets_lose() {
        // In this counterexample, the enlarged ball of the edge's inner endpoint does not cross the line.
        let rule = Supergraph::Overlap { alpha: 2.0, k: 1 };
        let (i, j) = (1.05f64, 0.0f64);
        assert!(rule.joins((i - j) * (i - j), 0.05 * 0.05, 1.05 * 1.05));
        assert!(i - rule.separator_radius(0.05 * 0.05) > 0.5);
        assert!(j + rule.separator_radius(1.05 * 1.05) > 0.5);
    }
}
