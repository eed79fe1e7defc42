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
    /// The largest weight of all ranks; 0 without weights.
    heaviest: f64,
}

impl<P> Ground<P> {
    /// Collects the state of a rank.
    pub(super) fn new(
        subdomain: Subdomain<P>,
        table: Table<P>,
        frame: PointBatch<P>,
        population: PointSum,
    ) -> Self {
        Ground { subdomain, table, frame, population, heaviest: 0.0 }
    }

    /// Sets the largest weight of all ranks.
    pub(super) fn with_heaviest(self, heaviest: f64) -> Self {
        Ground { heaviest, ..self }
    }

    /// Returns the largest weight of all ranks; 0 without weights.
    pub(super) fn heaviest(&self) -> f64 {
        self.heaviest
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
