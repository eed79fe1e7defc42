//! The input of a run, as the ranks read it.

use septet_geometry::point::Point;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::message::{Body, PointBatch, PointSum, UNKNOWN_RADIUS2};

use crate::machine::context::Context;

/// The points of a run. Every host has a source, which holds at least the blocks of its own ranks.
pub trait Source<P>: Sync {
    /// Returns the number of points and the sum of their hashes, which the certificate requires of the workers. Only the
    /// coordinator reads it.
    fn population(&self) -> PointSum;

    /// Returns the frame: `d + 1` points that span the space, with their input indices. Only the host of the coordinator
    /// has it.
    fn frame(&self) -> Vec<(u64, P)>;

    /// Returns the points of block `block`, if the input is divided into `blocks` equal parts in its order. The batch
    /// has some spare capacity for the ghosts that the worker will receive.
    fn block(&self, block: u32, blocks: u32) -> PointBatch<P>;
}

/// Sends every rank the number of points and the frame.
pub(crate) fn announce<P: Point>(cx: &mut Context<P>, source: &dyn Source<P>) {
    let population = source.population().count;
    let mut frame = PointBatch::default();
    for (id, position) in source.frame() {
        frame.push(id, position, COORDINATOR, UNKNOWN_RADIUS2);
    }
    cx.send_to_all(|| Body::Start { population, frame: frame.clone() });
}
