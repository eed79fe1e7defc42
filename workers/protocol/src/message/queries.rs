//! Balls that look for points in other workers' leaves, and what they find.

use bincode::{Decode, Encode};
use bytemuck::Pod;

use super::PointBatch;
use crate::codec::Bulk;

/// Balls that look for points. `slots` are the sender's names of them.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct QueryBatch<P> {
    /// The sender's name of each query, returned with its answer.
    pub slots: Bulk<u32>,
    /// Centres.
    pub centres: Bulk<P>,
    /// Squared radii.
    pub radii2: Bulk<f64>,
    /// Numbers of queries that follow each other and are of balls of one leaf.
    pub groups: Bulk<u32>,
    /// Follow the centre's side only (the punt), instead of all that the ball reaches.
    pub probe: bool,
    /// How many nearest points are wanted, ties included.
    pub wanted: u32,
}

impl<P> QueryBatch<P> {
    /// Do the arrays fit together?
    pub fn is_consistent(&self) -> bool {
        let queries = self.slots.len();
        self.centres.len() == queries && self.radii2.len() == queries && adds_up(&self.groups, queries)
    }
}

/// Is this the sum of the counts?
fn adds_up(counts: &[u32], sum: usize) -> bool {
    counts.iter().map(|&count| u64::from(count)).sum::<u64>() == sum as u64
}

/// Answers to queries: a list a slot, of points that the lists of a group share.
#[derive(Clone, Debug, Default, PartialEq, Encode, Decode)]
#[bincode(encode_bounds = "P: Pod", decode_bounds = "P: Pod", borrow_decode_bounds = "P: Pod")]
pub struct ReplyBatch<P> {
    /// The receiver's name of each list.
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
    /// Do the arrays fit together, and does every list name points of its group?
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
