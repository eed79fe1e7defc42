//! Queries of balls for points in the leaves of other workers, and the replies.

use bincode::{Decode, Encode};
use bytemuck::Pod;

use super::PointBatch;
use crate::codec::Bulk;

/// Queries of balls for points.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct QueryBatch<P> {
    /// The sender's slot of each query, which its reply repeats.
    pub slots: Bulk<u32>,
    /// Centres.
    pub centres: Bulk<P>,
    /// Squared radii.
    pub radii2: Bulk<f64>,
    /// Lengths of the runs of consecutive queries that belong to one leaf.
    pub groups: Bulk<u32>,
    /// Whether a query follows only the side of its centre (the punt). If `false`, it follows both sides that the
    /// ball reaches.
    pub probe: bool,
    /// Number of nearest points wanted, including ties.
    pub wanted: u32,
}

impl<P> QueryBatch<P> {
    /// Returns `true` if the lengths of the arrays are consistent.
    pub fn is_consistent(&self) -> bool {
        let queries = self.slots.len();
        self.centres.len() == queries && self.radii2.len() == queries && adds_up(&self.groups, queries)
    }
}

/// Returns `true` if the counts add up to `sum`.
fn adds_up(counts: &[u32], sum: usize) -> bool {
    counts.iter().map(|&count| u64::from(count)).sum::<u64>() == sum as u64
}

/// Replies to queries: one list per slot. The lists of a group refer to the same points.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct ReplyBatch<P> {
    /// The receiver's slot of each list.
    pub slots: Bulk<u32>,
    /// Length of each list.
    pub counts: Bulk<u32>,
    /// Number of lists in each group.
    pub groups: Bulk<u32>,
    /// Number of points of each group.
    pub sizes: Bulk<u32>,
    /// All lists, one after the other: positions among the points of the group.
    pub places: Bulk<u32>,
    /// The points of all groups, one after the other.
    pub points: PointBatch<P>,
}

impl<P: Copy> ReplyBatch<P> {
    /// Returns `true` if the lengths of the arrays are consistent and every list refers to points of its group.
    pub fn is_consistent(&self) -> bool {
        let fits = self.counts.len() == self.slots.len()
            && self.sizes.len() == self.groups.len()
            && adds_up(&self.groups, self.slots.len())
            && adds_up(&self.counts, self.places.len())
            && adds_up(&self.sizes, self.points.len())
            && self.points.is_consistent();
        let (mut counts, mut places) = (self.counts.iter(), self.places.0.as_slice());
        fits && self.groups.iter().zip(&self.sizes.0).all(|(&queries, &size)| {
            let items: usize = counts.by_ref().take(queries as usize).map(|&count| count as usize).sum();
            let (own, rest) = places.split_at(items);
            places = rest;
            own.iter().fold(0, |most, &place| place.max(most)) < size || own.is_empty()
        })
    }
}
