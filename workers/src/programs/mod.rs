//! The program of every rank: one async function for each task, with a line for each phase.
//!
//! The coordinator runs the same functions. A phase calls [`Context::is_coordinator`] if the coordinator has a special
//! duty: frame, choice, decision and gathering. It owns no points, because the group of the root
//! has only the workers (`partition::shared::root`). No phase relies on this.

mod certify;
mod evaluation;
mod ground;
mod independent;
mod simulate;
mod triangulate;

use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use crate::config::{SetRule, Task};
use crate::input::Source;
use crate::input::load::load;
use crate::machine::context::Context;
use crate::partition::leader::Plan;
use crate::partition::shared::{partition, root};
use crate::result::collect::collect_counts;
use crate::share::Share;
use evaluation::evaluation;
use ground::Ground;
use independent::independent_set;
use simulate::simulate;
use triangulate::triangulate;

/// Runs the program of a rank: the rank reads its block of the points, finds its place in the tree, and runs its task.
/// `plan` is the plan of the placement, if there is one. Only the leader of the root uses it.
///
/// # Errors
/// See [`Context::exchange`].
pub async fn run<P: Point>(
    mut cx: Context<P>,
    source: &dyn Source<P>,
    plan: &Plan,
) -> Result<Share<P>, TransportError> {
    let cx = &mut cx;
    if let Task::Evaluation { phase } = cx.config().task {
        return evaluation(cx, source, phase).await;
    }
    let (share, ground) = begin(cx, source, plan).await?;
    match ground {
        Some(ground) => finish(cx, ground, share).await,
        None => collect_counts(cx, share).await,
    }
}

/// Loads the points and partitions them. There is no ground if the run ends here.
///
/// A function of its own, so that its values take no space in the phases that follow.
async fn begin<P: Point>(
    cx: &mut Context<P>,
    source: &dyn Source<P>,
    plan: &Plan,
) -> Result<(Share<P>, Option<Ground<P>>), TransportError> {
    let input = load(cx, source).await?;
    let population = input.population();
    let runs = input.is_ready() && cx.config().refusal::<P>(population.count).is_none();
    let (loaded, frame, block) = input.into_parts();
    let mut share = Share { loaded, ..Share::new(cx.rank()) };
    if !runs {
        return Ok((share, None));
    }
    let group = root(cx.config(), population.count);
    let plan = if cx.rank() == group.leader { plan.clone() } else { Plan::new() };
    let (subdomain, table) = partition(cx, group, block, plan).await?;
    // The recursion on sets with their own separators charges nodes by their places in that recursion. Other ranks may
    // charge the same nodes.
    let is_alone = cx.config().graph.sets != SetRule::Own;
    share.ledger.root = subdomain.own_root().filter(|_| is_alone);
    if cx.config().until == Some(Phase::Partition) {
        return Ok((share, None));
    }
    let heaviest = if P::IS_WEIGHTED { share.loaded.sites.heaviest } else { 0.0 };
    let ground = Ground::new(subdomain, table, frame, population).with_heaviest(heaviest);
    Ok((share, Some(ground)))
}

/// The task of the run, after the partition.
async fn finish<P: Point>(
    cx: &mut Context<P>,
    ground: Ground<P>,
    share: Share<P>,
) -> Result<Share<P>, TransportError> {
    match cx.config().task {
        Task::Independent { fixed } => independent_set(cx, ground, fixed, share).await,
        // Such a run has no points.
        Task::Evaluation { .. } => collect_counts(cx, share).await,
        Task::Delaunay { .. } if cx.config().by_stars::<P>() => simulate(cx, ground, share).await,
        Task::Delaunay { .. } => triangulate(cx, ground, share).await,
    }
}

#[cfg(test)]
pub(crate) mod tests;
