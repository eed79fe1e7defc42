//! The input of a run, as the coordinator distributes it.

use rayon::prelude::*;
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId};
use septet_protocol::message::{Body, PointBatch};

use crate::machine::context::Context;

/// The points of a run.
pub trait Source<P>: Sync {
    /// Returns the number of points.
    fn population(&self) -> u64;

    /// Returns the frame: `d + 1` points that span the space, with their input indices.
    fn frame(&self) -> Vec<(u64, P)>;

    /// Returns the points of block `block`, if the input is divided into `blocks` equal parts in its order. The batch
    /// has some spare capacity for the ghosts that the worker will receive.
    fn block(&self, block: u32, blocks: u32) -> PointBatch<P>;
}

/// Sends each worker the frame and its block. Returns the number of points and the frame.
pub(crate) fn distribute<P: Point>(cx: &mut Context<P>, source: &dyn Source<P>) -> (u64, PointBatch<P>) {
    let population = source.population();
    let mut frame = PointBatch::default();
    for (id, position) in source.frame() {
        frame.push(id, position, COORDINATOR, f64::INFINITY);
    }
    let workers = cx.config().workers;
    let blocks: Vec<PointBatch<P>> =
        (0..workers).into_par_iter().map(|block| source.block(block, workers)).collect();
    for (rank, block) in (1..).zip(blocks) {
        cx.send(rank, NodeId::ROOT, 0, Body::Start { population, frame: frame.clone() });
        cx.send(rank, NodeId::ROOT, 0, Body::Block(block));
    }
    (population, frame)
}
