//! The state of a rank between the partition and its task.

use septet_protocol::message::PointBatch;

use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// A rank after the partition.
pub(super) struct Ground<P> {
    /// The part of the tree that the rank holds.
    pub(super) subdomain: Subdomain<P>,
    /// The points of the rank.
    pub(super) table: Table<P>,
    /// Points that span the space.
    pub(super) frame: PointBatch<P>,
    /// The number of points of all ranks.
    pub(super) population: u64,
}
