//! Queries on the way to other ranks.

use std::collections::BTreeMap;

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, QueryBatch};

use crate::machine::context::Context;
use crate::neighbours::search::Search;
use crate::state::subdomain::{Subdomain, Way};

/// Replicas of balls that leave this rank, in batches by node and receiver.
pub(crate) struct QueryRouter<P> {
    rank: Rank,
    search: Search,
    batches: BTreeMap<(NodeId, Rank), OutgoingBatch<P>>,
}

/// Queries for one node and receiver.
struct OutgoingBatch<P> {
    batch: QueryBatch<P>,
    /// The group of the last query.
    last_group: u64,
}

/// A replica of a ball, which leaves this rank.
pub(crate) struct Replica<P> {
    /// The sender's index of the ball, which the replies name.
    pub(crate) slot: u32,
    pub(crate) centre: P,
    pub(crate) radius2: f64,
    /// The group of the ball. Consecutive balls of one leaf have the same group.
    pub(crate) group: u64,
}

impl<P: Point> QueryRouter<P> {
    /// Creates a router of `rank` without queries.
    pub(crate) fn new(rank: Rank, search: Search) -> Self {
        QueryRouter { rank, search, batches: BTreeMap::new() }
    }

    /// Adds a replica of a ball for each of its ways out of the path.
    pub(crate) fn add(&mut self, subdomain: &Subdomain<P>, ways: &[Way], ball: &Replica<P>) {
        for &way in ways {
            let receiver = subdomain.beyond(way, self.rank);
            let Search { probe, wanted, .. } = self.search;
            let OutgoingBatch { batch, last_group } =
                self.batches.entry(receiver).or_insert_with(|| OutgoingBatch {
                    batch: QueryBatch { probe, wanted, ..QueryBatch::default() },
                    last_group: ball.group,
                });
            match batch.groups.last_mut() {
                Some(size) if *last_group == ball.group => *size += 1,
                _ => batch.groups.push(1),
            }
            *last_group = ball.group;
            batch.slots.push(ball.slot);
            batch.centres.push(ball.centre);
            batch.radii2.push(ball.radius2);
        }
    }

    /// Sends all batches.
    pub(crate) fn send(self, cx: &mut Context<P>) {
        cx.route(self.batches.into_iter().map(|(receiver, out)| (receiver, Body::Query(out.batch))));
    }
}
