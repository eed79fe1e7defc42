//! Rank 0, the coordinator: it hands out the input, leads the root of the tree, judges certificates and takes the
//! result. It is one async function like every rank, and takes part in the same phases.

mod region;
mod selection;
mod share;
mod source;
mod verdict;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Phase;
use septet_protocol::message::{Body, PointBatch};
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::config::{Correction, Task, Wanted};
use crate::graph::{sharing, summaries};
use crate::machine::context::Context;
use crate::neighbours::bottom_up::first_level;
use crate::partition::leader::Plan;
use crate::partition::{self, Group};
use crate::state::frame;

pub use share::{CellRows, Certified, Choice, Counted, PieceRows, Selected, Share};
pub use source::Source;

/// The program of rank 0. Returns the result of the run.
///
/// # Errors
/// See [`Context::exchange`].
pub async fn coordinate<P: Point>(
    mut cx: Context<P>,
    source: &dyn Source<P>,
    plan: Plan,
) -> Result<Share<P>, TransportError> {
    let cx = &mut cx;
    let population = source::hand_out(cx, source).await?;
    let led = partition::lead_root(cx, population, plan).await?;
    let mut share = Share::default();
    if cx.config.until != Some(Phase::Partition) {
        match cx.config.task {
            Task::Independent { .. } => independent_set(cx, &led, &mut share).await?,
            Task::Delaunay if cx.config.counted => simulate(cx, &led, population, &mut share).await?,
            Task::Delaunay => triangulate(cx, &led, &mut share).await?,
        }
    }
    share::collect(cx, &mut share).await?;
    cx.enter(Phase::Done)?;
    share.counted.ledger.merge(cx.ledger());
    Ok(share)
}

/// The paper's algorithm.
async fn simulate<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    population: u64,
    share: &mut Share<P>,
) -> Result<(), TransportError> {
    if cx.config.until == Some(Phase::Neighbours) {
        return neighbour_balls(cx).await;
    }
    let (rule, why) = match cx.config.graph.wanted {
        Wanted::Fixed(rule) => (rule, None),
        _ => selection::decide(cx, population).await?,
    };
    share.choice = Choice { supergraph: Some(rule), why };
    let knn = matches!(rule, Supergraph::Knn { .. });
    if !knn || cx.config.graph.correction == Correction::Naive {
        neighbour_balls(cx).await?;
    }
    summaries::lead_root(cx, led).await?;
    if knn {
        for phase in [Phase::KnnRadii, Phase::KnnProbe, Phase::Knn] {
            quiet(cx, phase).await?;
        }
    }
    sharing::lead_root(cx, led, rule).await?;
    share.edges = edges(cx).await?;
    quiet(cx, Phase::Hulls).await?;
    certify(cx, led, share).await
}

/// The direct path.
async fn triangulate<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    share: &mut Share<P>,
) -> Result<(), TransportError> {
    if let Wanted::Fixed(rule) = cx.config.graph.wanted {
        share.choice.supergraph = Some(rule);
    }
    cx.enter(Phase::Halo)?;
    let mut known = PointBatch::default();
    while cx.exchange().await? {
        frame::collect(cx, &mut known);
    }
    for phase in [Phase::Pieces, Phase::Seam, Phase::Hulls] {
        quiet(cx, phase).await?;
    }
    certify(cx, led, share).await
}

/// A maximal independent set.
async fn independent_set<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    share: &mut Share<P>,
) -> Result<(), TransportError> {
    let Wanted::Fixed(rule) = cx.config.graph.wanted else {
        let reason = "a conflict graph has a fixed rule".to_string();
        return Err(TransportError::WorkerFailed { rank: cx.rank, reason });
    };
    share.choice.supergraph = Some(rule);
    summaries::lead_root(cx, led).await?;
    sharing::lead_root(cx, led, rule).await?;
    share.edges = edges(cx).await?;
    quiet(cx, Phase::Independent).await
}

/// The balls to the nearest neighbours, by the descent or level by level.
async fn neighbour_balls<P: Point>(cx: &mut Context<P>) -> Result<(), TransportError> {
    quiet(cx, Phase::Radii).await?;
    if cx.config.graph.correction == Correction::Naive {
        for _ in 0..=first_level(&cx.config) {
            quiet(cx, Phase::Neighbours).await?;
        }
        return Ok(());
    }
    quiet(cx, Phase::Probe).await?;
    quiet(cx, Phase::Neighbours).await
}

/// The edges of the supergraph, if the workers send them.
async fn edges<P: Point>(cx: &mut Context<P>) -> Result<Vec<u64>, TransportError> {
    cx.enter(Phase::Graph)?;
    let mut edges = Vec::new();
    while cx.exchange().await? {
        let parts = cx.take(|m| match &mut m.body {
            Body::Edges(Bulk(part)) => Some(std::mem::take(part)),
            _ => None,
        });
        edges.extend(parts.into_iter().flatten());
    }
    Ok(edges)
}

/// Certificates, until one passes or nothing is left to try.
async fn certify<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    share: &mut Share<P>,
) -> Result<(), TransportError> {
    quiet(cx, Phase::Check).await?;
    for pass in 0.. {
        quiet(cx, Phase::Repair).await?;
        quiet(cx, Phase::Certificate).await?;
        let (outcome, merged) = verdict::merge(cx, led, pass).await?;
        share.certified.add(merged);
        match outcome {
            Outcome::Passed | Outcome::Failed => break,
            more => region::gather(cx, more, &mut share.certified).await?,
        }
    }
    Ok(())
}

/// A phase in which rank 0 has nothing to do.
async fn quiet<P: Point>(cx: &mut Context<P>, phase: Phase) -> Result<(), TransportError> {
    cx.enter(phase)?;
    while cx.exchange().await? {}
    Ok(())
}
