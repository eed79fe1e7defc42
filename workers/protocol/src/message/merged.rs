//! The merged result of a subproblem, and the sums by which the certificate identifies points and cells.

use bincode::{Decode, Encode};
use septet_geometry::hash::{hash_of_site, mix};
use septet_geometry::point::Point;

/// The merged result of a subproblem: the union of the results of its children.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Encode, Decode)]
pub struct Merged {
    /// Stars with a finite cell, and hidden sites, both by the exact kernel.
    pub stars: u64,
    /// Finite cells whose lexicographically smallest vertex the subproblem owns.
    pub cells: u64,
    /// Hull facets whose lexicographically smallest vertex the subproblem owns.
    pub hull_facets: u64,
    /// Vertices without a lexicographically smaller neighbour: 1 in a complete triangulation.
    pub minima: u64,
    /// Pairs of workers whose fingerprints differ, and local disagreements.
    pub disagreements: u64,
    /// Stars that splaying changed.
    pub repaired: u64,
    /// Unchanged stars whose circumspheres all lie in the ball of radius `alpha r` around their vertex.
    pub local: u64,
    /// Rounds of splaying, the largest over the parts.
    pub exchange_rounds: u64,
    /// The sum of the hashes of the owned points ([`PointSum`]).
    pub point_hash: u64,
    /// The sum of the hashes of the cells of all workers, in rows of local indices (`piece_hash` of the workers).
    pub cell_hash: u64,
}

/// A set of points as the certificate identifies it: their number, and the sum of their hashes, modulo `2^64`. The sum
/// does not depend on the order of the points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Encode, Decode)]
pub struct PointSum {
    /// Number of points.
    pub count: u64,
    /// The sum of the hashes of input index and coordinates, and those of weights and low parts.
    pub hash: u64,
}

impl PointSum {
    /// Returns the sum over points, given as pairs of input index and position.
    pub fn of<P: Point>(points: impl Iterator<Item = (u64, P)>) -> Self {
        let hash = |(id, x): (u64, P)| {
            let place = (0..P::DIM).fold(mix(0, id), |h, i| mix(h, x.coord(i).to_bits()));
            if P::IS_WEIGHTED { mix(place, hash_of_site(x)) } else { place }
        };
        points.fold(PointSum::default(), |sum, point| sum.join(PointSum { count: 1, hash: hash(point) }))
    }

    /// Returns the sum over two disjoint sets.
    #[must_use]
    pub fn join(self, other: PointSum) -> Self {
        PointSum { count: self.count + other.count, hash: self.hash.wrapping_add(other.hash) }
    }
}

/// The totals of some ranks at the end of a run, from which every rank decides on the result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Encode, Decode)]
pub struct Totals {
    /// The certificate, which the coordinator contributes.
    pub merged: Merged,
    /// Cells in the shares.
    pub cells: u64,
    /// The sum of their hashes, as in [`Merged::cell_hash`].
    pub cell_hash: u64,
    /// Hull facets of the cells with neighbours.
    pub hull_facets: u64,
    /// Rows of the input that are not vertices: refused rows and repeated rows.
    pub left_out: u64,
    /// The sum of the hashes of all messages sent, minus that of all messages received, before the totals. Zero if all
    /// messages of all ranks arrived.
    pub balance: u64,
}

impl Totals {
    /// Returns the totals of two disjoint sets of ranks.
    #[must_use]
    pub fn join(mut self, other: Totals) -> Self {
        self.merged.join(&other.merged);
        self.cells += other.cells;
        self.cell_hash = self.cell_hash.wrapping_add(other.cell_hash);
        self.hull_facets += other.hull_facets;
        self.left_out += other.left_out;
        self.balance = self.balance.wrapping_add(other.balance);
        self
    }
}

impl Merged {
    /// Returns `true` if the result of the points of a run fulfils the four clauses of the certificate: the workers own
    /// exactly these points, every point has a star, all stars agree, and exactly one point has no lexicographically
    /// smaller neighbour.
    pub fn is_certified(&self, points: PointSum) -> bool {
        self.point_hash == points.hash
            && self.stars == points.count
            && self.disagreements == 0
            && self.minima == 1
    }

    /// Adds another result, disjoint from this one.
    pub fn join(&mut self, other: &Merged) {
        self.stars += other.stars;
        self.cells += other.cells;
        self.hull_facets += other.hull_facets;
        self.minima += other.minima;
        self.disagreements += other.disagreements;
        self.repaired += other.repaired;
        self.local += other.local;
        self.exchange_rounds = self.exchange_rounds.max(other.exchange_rounds);
        self.point_hash = self.point_hash.wrapping_add(other.point_hash);
        self.cell_hash = self.cell_hash.wrapping_add(other.cell_hash);
    }
}
