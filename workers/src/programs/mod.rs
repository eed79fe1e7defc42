//! What a worker runs: one async function for each task, a line for each phase.

mod independent;
mod simulate;
mod triangulate;

use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use crate::config::Task;
use crate::machine::context::Context;
use crate::partition::shared::{Input, load, partition};
use crate::result::collect::collect_counts;
use independent::independent_set;
use simulate::simulate;
use triangulate::triangulate;

/// The program of a worker: its block of the points, its place in the tree, then the task.
pub(crate) async fn work<P: Point>(mut cx: Context<P>) -> Result<(), TransportError> {
    let cx = &mut cx;
    let Input { population, frame, block } = load(cx).await?;
    let (subdomain, table) = partition(cx, population, block).await?;
    if cx.config.until == Some(Phase::Partition) {
        return collect_counts(cx).await;
    }
    match cx.config.task {
        Task::Independent { fixed } => independent_set(cx, subdomain, table, frame, fixed).await,
        Task::Delaunay if cx.config.counted => simulate(cx, subdomain, table, frame, population).await,
        Task::Delaunay => triangulate(cx, subdomain, table, frame, population).await,
    }
}
