//! Balls that leave for other ranks' parts of the tree.

use std::collections::BTreeMap;

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, QueryBatch};

use crate::machine::context::Context;
use crate::neighbours::ask::Ask;
use crate::state::subdomain::{Shared, Way};

/// Replicas that leave, batched by child and member.
pub(crate) struct QueryRouter<P> {
    rank: Rank,
    ask: Ask,
    /// With the group that the last query was of.
    batches: BTreeMap<(NodeId, Rank), (QueryBatch<P>, u64)>,
}

/// A ball that leaves.
pub(crate) struct Replica<P> {
    /// The name under which its answers return.
    pub(crate) slot: u32,
    pub(crate) centre: P,
    pub(crate) radius2: f64,
    /// The same for all balls of one leaf, which follow each other.
    pub(crate) group: u64,
}

impl<P: Point> QueryRouter<P> {
    /// None yet, from this rank.
    pub(crate) fn new(rank: Rank, ask: Ask) -> Self {
        QueryRouter { rank, ask, batches: BTreeMap::new() }
    }

    /// Adds a ball, which leaves by these ways out of the path.
    pub(crate) fn add(&mut self, path: &[Shared<P>], ways: &[Way], ball: &Replica<P>) {
        for way in ways {
            let shared = &path[way.level];
            let to = shared.member_below(self.rank, way.side);
            let key = (shared.id().child(way.side), to);
            let (batch, last) = self.batches.entry(key).or_insert_with(|| {
                let Ask { probe, wanted, .. } = self.ask;
                (QueryBatch { probe, wanted, ..QueryBatch::default() }, ball.group)
            });
            match batch.groups.last_mut() {
                Some(size) if *last == ball.group => *size += 1,
                _ => batch.groups.push(1),
            }
            *last = ball.group;
            batch.slots.push(ball.slot);
            batch.centres.push(ball.centre);
            batch.radii2.push(ball.radius2);
        }
    }

    /// Sends them all.
    pub(crate) fn send(self, cx: &mut Context<P>) {
        for ((node, to), (batch, _)) in self.batches {
            cx.send(to, node, 0, Body::Query(batch));
        }
    }
}
