//! Copies of owned points that a worker sends to other workers, which keep them as ghosts.

use std::collections::{BTreeMap, HashSet};
use std::hash::BuildHasherDefault;

use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, PointBatch};

use crate::machine::context::Context;
use crate::state::table::{IdHasher, Table};

/// The copies that a worker sends. Each worker receives each point at most once.
#[derive(Debug, Default)]
pub(super) struct Copies {
    /// A key ([`key`]) for each point and each of its receivers.
    sent: HashSet<u64, BuildHasherDefault<IdHasher>>,
    /// The points that wait, by receiver, as local indices.
    waiting: BTreeMap<Rank, Vec<u32>>,
}

/// Returns the key of a point and a receiver.
fn key(point: u32, receiver: Rank) -> u64 {
    u64::from(point) << 32 | u64::from(receiver)
}

impl Copies {
    /// Adds an owned point for a receiver, unless the receiver has it.
    pub(super) fn add(&mut self, point: u32, receiver: Rank) {
        if self.sent.insert(key(point, receiver)) {
            self.waiting.entry(receiver).or_default().push(point);
        }
    }

    /// Sends the points that wait.
    pub(super) fn send<P: Point>(&mut self, cx: &mut Context<P>, table: &Table<P>) {
        let waiting = std::mem::take(&mut self.waiting).into_iter();
        cx.send_each(0, waiting.map(|(receiver, points)| (receiver, Body::Copies(table.copies(&points)))));
    }
}

/// Adds the copies that arrived in this round to the table. Appends the indices of new ghosts to `arrived`.
pub(super) fn receive_copies<P: Point>(cx: &mut Context<P>, table: &mut Table<P>, arrived: &mut Vec<u32>) {
    let batches = cx.take(|m| match &mut m.body {
        Body::Copies(points) => Some((m.from, std::mem::take(points))),
        _ => None,
    });
    for (from, PointBatch { ids, positions, .. }) in batches {
        table.reserve_ghosts(ids.len());
        for (&id, &position) in ids.iter().zip(&positions.0) {
            let (index, is_new) = table.receive(id, position, from);
            if is_new {
                arrived.push(index);
            }
        }
    }
}

/// Charges an exchange of copies in the current phase, if the run charges the direct path: a vector step over the `tests`
/// that decide what is sent, and the delivery of the points that arrived.
pub(super) fn charge_exchange<P: Point>(cx: &mut Context<P>, root: NodeId, tests: Sweep, arrived: usize) {
    if !cx.config().shown.charges_direct() {
        return;
    }
    let mut cost = cx.own_cost();
    cost.charge_sweep(tests);
    let mut points = Sweep::default();
    (0..arrived).for_each(|_| points.visit());
    cost.charge_delivery(points);
    let items = cost.work();
    cx.charge(Account::member(cx.phase(), root), cost, items);
}
