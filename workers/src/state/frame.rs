//! The frame: points that span the space, and their owners.
//!
//! The coordinator selects the frame when it reads the input. Each rank reports which points of the frame it owns, and the
//! coordinator then sends all owners to all ranks. These messages travel with those of another phase:
//! `crate::direct::ghost_layer` or [`crate::graph::summaries`].

use septet_geometry::point::Point;
use septet_protocol::message::{Body, Message, PointBatch};

use crate::machine::context::Context;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// Reports to the coordinator which points of the frame this rank owns.
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
        cx.send_to_coordinator(Body::Frame(owned_points));
    }
}

/// The owners of the frame's points, which the coordinator collects and all ranks receive.
#[derive(Debug)]
pub(crate) struct FrameOwners<P> {
    /// The points whose owners have reported. Used on the coordinator only.
    reported: PointBatch<P>,
}

impl<P> Default for FrameOwners<P> {
    fn default() -> Self {
        FrameOwners { reported: PointBatch::default() }
    }
}

impl<P: Point> FrameOwners<P> {
    /// Handles the messages of a round. The coordinator broadcasts the frame when the owners of all points are known. The
    /// other ranks store the owners and that frame.
    pub(crate) fn receive(&mut self, cx: &mut Context<P>, table: &mut Table<P>, frame: &mut PointBatch<P>) {
        let mut batches = take(cx);
        if cx.is_coordinator() {
            let before = self.reported.len();
            for owned in &mut batches {
                self.reported.append(owned);
            }
            if before <= P::DIM && self.reported.len() == P::DIM + 1 {
                *frame = self.reported.clone();
                cx.send_to_workers(|| Body::Frame(frame.clone()));
            }
            return;
        }
        for owned in batches {
            for (&id, &owner) in owned.ids.iter().zip(&owned.owners.0) {
                table.set_owner(id, owner);
            }
            *frame = owned;
        }
    }
}

fn take<P: Point>(cx: &mut Context<P>) -> Vec<PointBatch<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Frame(frame) => Some(std::mem::take(frame)),
        _ => None,
    })
}
