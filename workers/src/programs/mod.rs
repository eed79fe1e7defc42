//! The program of every rank: one async function for each task, with a line for each phase.
//!
//! The coordinator runs the same functions. It leads the root, and phases ask [`Context::is_coordinator`] where it has a
//! duty of its own ([`crate::coordinator`]). It owns no points, because the group of the root has only the workers
//! ([`root`]). No phase relies on this.

mod ground;
mod independent;
mod simulate;
mod triangulate;

use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use crate::config::Task;
use crate::coordinator::{Share, Source};
use crate::machine::context::Context;
use crate::partition::leader::Plan;
use crate::partition::shared::{Input, load, partition, root};
use crate::result::collect::collect_counts;
use ground::Ground;
use independent::independent_set;
use simulate::simulate;
use triangulate::triangulate;

/// The program of the coordinator. Returns the result of the run.
///
/// # Errors
/// See [`Context::exchange`].
pub async fn coordinate<P: Point>(
    cx: Context<P>,
    source: &dyn Source<P>,
    plan: Plan,
) -> Result<Share<P>, TransportError> {
    run(cx, Some(source), plan).await
}

/// The program of a worker.
pub(crate) async fn work<P: Point>(cx: Context<P>) -> Result<(), TransportError> {
    run(cx, None, Plan::new()).await.map(drop)
}

/// The program of every rank: its block of the points, its place in the tree, then the task. The coordinator has a source
/// of points, and a plan of the placement if there is one. Only its result is complete.
async fn run<P: Point>(
    mut cx: Context<P>,
    source: Option<&dyn Source<P>>,
    plan: Plan,
) -> Result<Share<P>, TransportError> {
    let cx = &mut cx;
    let Input { population, frame, block } = load(cx, source).await?;
    let group = root(cx.config(), population);
    let (subdomain, table) = partition(cx, group, block, plan).await?;
    if cx.config().until == Some(Phase::Partition) {
        return collect_counts(cx, Share::default()).await;
    }
    finish(cx, Ground { subdomain, table, frame, population }).await
}

/// The task of the run, after the partition.
async fn finish<P: Point>(cx: &mut Context<P>, ground: Ground<P>) -> Result<Share<P>, TransportError> {
    match cx.config().task {
        Task::Independent { fixed } => independent_set(cx, ground, fixed).await,
        Task::Delaunay if cx.config().counted => simulate(cx, ground).await,
        Task::Delaunay => triangulate(cx, ground).await,
    }
}

#[cfg(test)]
mod tests;
