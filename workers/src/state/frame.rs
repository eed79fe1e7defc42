//! Points that span the space, and where they are at home. Rank 0 knows the points from the start; the ranks tell it which
//! of them they own, and it tells all. This runs beside the messages of another phase: `crate::direct::ghost_layer` or
//! [`crate::graph::summaries`].

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::machine::context::Context;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// Tells rank 0 which points of the frame are at home here.
pub(crate) fn report<P: Point>(
    cx: &mut Context<P>,
    table: &Table<P>,
    leaves: &[Leaf<P>],
    frame: &PointBatch<P>,
) {
    let mut owned_points = PointBatch::default();
    for at in table.owned_among(&frame.ids.0) {
        table.export(at, &mut owned_points);
        if let Some(recorder) = &mut cx.recorder {
            recorder.log.frame.push(leaf_number(leaves, at));
        }
    }
    if !owned_points.is_empty() {
        cx.send(COORDINATOR, NodeId::ROOT, 0, Body::Frame(owned_points));
    }
}

/// Learns where the points of the frame are at home.
pub(crate) fn learn<P: Point>(cx: &mut Context<P>, table: &mut Table<P>, frame: &mut PointBatch<P>) {
    for told in take(cx) {
        for (&id, &owner) in told.ids.iter().zip(&told.owners.0) {
            table.set_owner(id, owner);
        }
        *frame = told;
    }
}

/// What rank 0 does: collects the points, and tells all when it knows every one.
pub fn collect<P: Point>(cx: &mut Context<P>, known: &mut PointBatch<P>) {
    let before = known.len();
    for mut owned_points in take(cx) {
        known.append(&mut owned_points);
    }
    if before <= P::DIM && known.len() == P::DIM + 1 {
        for rank in 1..=cx.config.workers {
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
