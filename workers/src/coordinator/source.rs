//! The input of a run, as the coordinator distributes it.

use rayon::prelude::*;
use septet_geometry::point::Point;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::message::{Body, PointBatch, PointSum, UNKNOWN_RADIUS2};

use crate::machine::collectives::Group;
use crate::machine::context::Context;

/// The points of a run.
pub trait Source<P>: Sync {
    /// Returns the number of points and the sum of their hashes, which the certificate requires of the workers.
    fn population(&self) -> PointSum;

    /// Returns the frame: `d + 1` points that span the space, with their input indices.
    fn frame(&self) -> Vec<(u64, P)>;

    /// Returns the points of block `block`, if the input is divided into `blocks` equal parts in its order. The batch
    /// has some spare capacity for the ghosts that the worker will receive.
    fn block(&self, block: u32, blocks: u32) -> PointBatch<P>;
}

/// Sends every rank the number of points and the frame, and each member of `root` its block.
pub(crate) fn distribute<P: Point>(cx: &mut Context<P>, source: &dyn Source<P>, root: &Group) {
    let population = root.child.population;
    let mut frame = PointBatch::default();
    for (id, position) in source.frame() {
        frame.push(id, position, COORDINATOR, UNKNOWN_RADIUS2);
    }
    cx.send_to_all(|| Body::Start { population, frame: frame.clone() });
    let blocks = root.child.ranks;
    let blocks: Vec<PointBatch<P>> =
        (0..blocks).into_par_iter().map(|block| source.block(block, blocks)).collect();
    cx.scatter(root, 0, blocks.into_iter().map(Body::Block));
}
