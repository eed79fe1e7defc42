//! The frame: points that span the space, and their owners.
//!
//! The ranks agree on the frame when they prepare the input. Each rank reports which points of the frame it owns, and the
//! coordinator then sends all owners to all ranks, through a tree. These messages travel with those of another phase:
//! `crate::direct::ghost_layer` or [`crate::graph::summaries`].

use septet_geometry::point::Point;
use septet_protocol::message::{Body, Message, PointBatch};

use crate::machine::context::Context;
use crate::state::table::Table;

/// Reports to the coordinator which points of the frame this rank owns.
pub(crate) fn report<P: Point>(cx: &mut Context<P>, table: &Table<P>, frame: &PointBatch<P>) {
    let mut owned_points = PointBatch::default();
    for at in table.owned_among(&frame.ids.0) {
        table.export(at, &mut owned_points);
    }
    if !owned_points.is_empty() {
        cx.send_to_coordinator(Body::Frame(owned_points));
    }
}

/// The owners of the frame's points, which the coordinator collects and all ranks receive.
#[derive(Debug)]
pub(crate) struct FrameOwners<P> {
    /// The points whose owners have reported. Empty except on the coordinator.
    reported: PointBatch<P>,
}

impl<P> Default for FrameOwners<P> {
    fn default() -> Self {
        FrameOwners { reported: PointBatch::default() }
    }
}

impl<P: Point> FrameOwners<P> {
    /// Handles the messages of a round. The coordinator collects reports until it knows the owners of all points of the
    /// frame, and sends these points to every rank. Every rank stores them and their owners.
    pub(crate) fn receive(&mut self, cx: &mut Context<P>, table: &mut Table<P>, frame: &mut PointBatch<P>) {
        for mut points in take(cx) {
            // After the last report, the coordinator receives only its own message to all ranks.
            if cx.is_coordinator() && self.reported.len() <= P::DIM {
                self.reported.append(&mut points);
                if self.reported.len() == P::DIM + 1 {
                    cx.send_to_all(|| Body::Frame(self.reported.clone()));
                }
                continue;
            }
            for (&id, &owner) in points.ids.iter().zip(&points.owners.0) {
                table.set_owner(id, owner);
            }
            *frame = points;
            cx.pass_on(|| Body::Frame(frame.clone()));
        }
    }
}

fn take<P: Point>(cx: &mut Context<P>) -> Vec<PointBatch<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Frame(frame) => Some(std::mem::take(frame)),
        _ => None,
    })
}
