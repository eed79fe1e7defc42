//! The program of every rank: one async function for each task, with a line for each phase.
//!
//! The coordinator runs the same functions. It leads the root. A phase calls [`Context::is_coordinator`] if the coordinator
//! has a special duty: frame, choice, decision, gathering and collection. Only the coordinator
//! gives the phase `load` the source of the points. It owns no points, because the group of the root has only the workers
//! (`partition::shared::root`). No phase relies on this.

mod certify;
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
use crate::partition::shared::{load, partition, root};
use crate::result::collect::collect_counts;
use ground::Ground;
use independent::independent_set;
use simulate::simulate;
use triangulate::triangulate;

/// Runs the program of the coordinator and returns the result of the run.
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

/// Runs the program of a worker.
pub(crate) async fn work<P: Point>(cx: Context<P>) -> Result<(), TransportError> {
    run(cx, None, Plan::new()).await.map(drop)
}

/// Runs the program of every rank: the rank receives its block of the points, finds its place in the tree, and runs its
/// task. The coordinator has a source of points, and a plan of the placement if there is one. Only the coordinator's
/// result is complete.
async fn run<P: Point>(
    mut cx: Context<P>,
    source: Option<&dyn Source<P>>,
    plan: Plan,
) -> Result<Share<P>, TransportError> {
    let cx = &mut cx;
    let input = load(cx, source).await?;
    let population = input.population();
    let (frame, block) = input.into_frame_and_block();
    let group = root(cx.config(), population.count);
    let (subdomain, table) = partition(cx, group, block, plan).await?;
    if cx.config().until == Some(Phase::Partition) {
        return collect_counts(cx, Share::default()).await;
    }
    finish(cx, Ground::new(subdomain, table, frame, population)).await
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
pub(crate) mod tests;
