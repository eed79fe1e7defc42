//! The frame: points that span the space, and their owners.
//!
//! Rank 0 selects the frame when it reads the input. Each rank reports which points of the frame it owns, and rank 0 then
//! sends all owners to all ranks. These messages travel with those of another phase: `crate::direct::ghost_layer` or
//! [`crate::graph::summaries`].

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::machine::context::Context;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// Reports to rank 0 which points of the frame this rank owns.
pub(crate) fn report<P: Point>(
    cx: &mut Context<P>,
    table: &Table<P>,
    leaves: &[Leaf<P>],
    frame: &PointBatch<P>,
) {
    let mut owned_points = PointBatch::default();
    for at in table.owned_among(&frame.ids.0) {
        table.export(at, &mut owned_points);
        if let Some(recorder) = cx.recorder() {
            recorder.log.frame.push(leaf_number(leaves, at));
        }
    }
    if !owned_points.is_empty() {
        cx.send(COORDINATOR, NodeId::ROOT, 0, Body::Frame(owned_points));
    }
}

/// Receives the owners of the frame's points.
pub(crate) fn receive<P: Point>(cx: &mut Context<P>, table: &mut Table<P>, frame: &mut PointBatch<P>) {
    for received in take(cx) {
        for (&id, &owner) in received.ids.iter().zip(&received.owners.0) {
            table.set_owner(id, owner);
        }
        *frame = received;
    }
}

/// Collects the reports on rank 0. Sends the frame to all ranks when the owners of all points are known.
pub fn collect<P: Point>(cx: &mut Context<P>, known: &mut PointBatch<P>) {
    let before = known.len();
    for mut owned_points in take(cx) {
        known.append(&mut owned_points);
    }
    if before <= P::DIM && known.len() == P::DIM + 1 {
        for rank in 1..=cx.config().workers {
            cx.send(rank, NodeId::ROOT, 0, Body::Frame(known.clone()));
        }
    }
}

fn take<P: Point>(cx: &mut Context<P>) -> Vec<PointBatch<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Frame(frame) => Some(std::mem::take(frame)),
        _ => None,
    })
}
