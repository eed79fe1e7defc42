//! Balls that leave for other workers' parts of the tree.

use std::collections::BTreeMap;

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, QueryBatch};

use crate::neighbours::query::{Ask, Way};
use crate::worker::Worker;

/// Replicas that leave, batched by child and member.
pub(crate) struct Forwards<P> {
    ask: Ask,
    /// With the group that the last query was of.
    batches: BTreeMap<(NodeId, Rank), (QueryBatch<P>, u64)>,
}

impl<P: Point> Forwards<P> {
    pub(crate) fn new(ask: Ask) -> Self {
        Forwards { ask, batches: BTreeMap::new() }
    }

    /// Adds a ball's ways out; its pending entry is pushed next. Balls of one leaf have the same `group`, and follow
    /// each other.
    pub(crate) fn add(&mut self, worker: &Worker<P>, ways: &[Way], centre: P, radius2: f64, group: u64) {
        let slot = worker.engine.next_slot();
        let ask = worker.engine.ask();
        self.ask = ask;
        for &(i, side) in ways {
            let shared = &worker.subdomain.path[i];
            let to = shared.member_below(worker.rank, side);
            let key = (shared.id.child(side), to);
            let (batch, last) = self.batches.entry(key).or_insert_with(|| (QueryBatch::default(), group));
            match batch.groups.last_mut() {
                Some(size) if *last == group => *size += 1,
                _ => batch.groups.push(1),
            }
            *last = group;
            batch.slots.push(slot);
            batch.centres.push(centre);
            batch.radii2.push(radius2);
            (batch.probe, batch.wanted) = (ask.probe, ask.wanted);
        }
    }

    pub(crate) fn send(self, worker: &mut Worker<P>) {
        for ((node, to), (batch, _)) in self.batches {
            worker.out.send(to, node, 0, Body::Query(batch));
        }
    }
}
