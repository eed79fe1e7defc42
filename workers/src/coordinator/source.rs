//! The input of a run, as rank 0 hands it out.

use rayon::prelude::*;
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase};
use septet_protocol::message::{Body, PointBatch};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;

/// Points to hand out.
pub trait Source<P>: Sync {
    /// Number of points.
    fn population(&self) -> u64;

    /// Points that span the space: `d + 1` of the points, with their input indices.
    fn frame(&self) -> Vec<(u64, P)>;

    /// The block of one of `blocks` parts of the points, in the order of the input, and room in it for as many more
    /// as the worker will receive.
    fn block(&self, block: u32, blocks: u32) -> PointBatch<P>;
}

/// Sends each worker the frame and its block. Returns the number of points.
pub(super) async fn hand_out<P: Point>(
    cx: &mut Context<P>,
    source: &dyn Source<P>,
) -> Result<u64, TransportError> {
    cx.enter(Phase::Load)?;
    let population = source.population();
    let mut frame = PointBatch::default();
    for (id, position) in source.frame() {
        frame.push(id, position, COORDINATOR, f64::INFINITY);
    }
    let workers = cx.config.workers;
    let blocks: Vec<PointBatch<P>> =
        (0..workers).into_par_iter().map(|block| source.block(block, workers)).collect();
    for (rank, block) in (1..).zip(blocks) {
        cx.send(rank, NodeId::ROOT, 0, Body::Start { population, frame: frame.clone() });
        cx.send(rank, NodeId::ROOT, 0, Body::Block(block));
    }
    while cx.exchange().await? {}
    Ok(population)
}
