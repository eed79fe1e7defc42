//! The state of a rank between the partition and its task.

use septet_protocol::message::{PointBatch, PointSum};

use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// A rank after the partition.
pub(super) struct Ground<P> {
    /// The part of the tree that the rank holds.
    subdomain: Subdomain<P>,
    /// The points of the rank.
    table: Table<P>,
    /// Points that span the space.
    frame: PointBatch<P>,
    /// The points of all ranks.
    population: PointSum,
}

impl<P> Ground<P> {
    /// Collects the state of a rank.
    pub(super) fn new(
        subdomain: Subdomain<P>,
        table: Table<P>,
        frame: PointBatch<P>,
        population: PointSum,
    ) -> Self {
        Ground { subdomain, table, frame, population }
    }

    /// Returns the number of points of all ranks, and on the coordinator the sum of their hashes.
    pub(super) fn population(&self) -> PointSum {
        self.population
    }

    /// Returns the subdomain, the points of the rank, and the points that span the space.
    pub(super) fn into_parts(self) -> (Subdomain<P>, Table<P>, PointBatch<P>) {
        (self.subdomain, self.table, self.frame)
    }
}
