//! Rank 0, the coordinator: it hands out the input, leads the root of the tree, judges certificates and takes the
//! result. It is one async function like every rank, and takes part in the same phases.

mod choice;
mod region;
mod share;
mod source;
mod verdict;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Phase;
use septet_protocol::message::Body;
use septet_protocol::transport::TransportError;

use crate::config::{Correction, SetRule, Task, Wanted};
use crate::machine::context::Context;
use crate::partition::leader::{Leader, Plan, by_node};
use crate::partition::{self, Group};
use crate::schedule::{Outcome, first_level};
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
            Task::Delaunay => triangulate(cx, &led, population, &mut share).await?,
        }
    }
    share::collect(cx, &mut share).await?;
    cx.enter(Phase::Done)?;
    share.counted.ledger.merge(&cx.ledger);
    Ok(share)
}

/// The paper's algorithm.
async fn simulate<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    population: u64,
    share: &mut Share<P>,
) -> Result<(), TransportError> {
    let until_neighbours = cx.config.until == Some(Phase::Neighbours);
    share.choice = match cx.config.wanted {
        Wanted::Fixed(rule) => Choice { supergraph: Some(rule), why: None },
        _ if until_neighbours => Choice::default(),
        _ => choice::decide(cx, population).await?,
    };
    let rule = share.choice.supergraph;
    let measured = until_neighbours || cx.config.correction == Correction::Naive;
    let knn = matches!(rule, Some(Supergraph::Knn { .. }));
    if measured || !knn {
        neighbour_balls(cx).await?;
    }
    if until_neighbours {
        return Ok(());
    }
    crate::graph::summaries::lead_root(cx, led).await?;
    if knn {
        for phase in [Phase::KnnRadii, Phase::KnnProbe, Phase::Knn] {
            quiet(cx, phase).await?;
        }
    }
    separator_sets(cx, led, rule).await?;
    share.edges = edges(cx).await?;
    quiet(cx, Phase::Hulls).await?;
    certify(cx, led, population, share).await
}

/// The direct path.
async fn triangulate<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    population: u64,
    share: &mut Share<P>,
) -> Result<(), TransportError> {
    if let Wanted::Fixed(rule) = cx.config.wanted {
        share.choice.supergraph = Some(rule);
    }
    cx.enter(Phase::Halo)?;
    let mut known = Default::default();
    while cx.exchange().await? {
        frame::collect(cx, &mut known);
    }
    for phase in [Phase::Pieces, Phase::Seam, Phase::Hulls] {
        quiet(cx, phase).await?;
    }
    certify(cx, led, population, share).await
}

/// A maximal independent set.
async fn independent_set<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    share: &mut Share<P>,
) -> Result<(), TransportError> {
    if let Wanted::Fixed(rule) = cx.config.wanted {
        share.choice.supergraph = Some(rule);
    }
    crate::graph::summaries::lead_root(cx, led).await?;
    separator_sets(cx, led, share.choice.supergraph).await?;
    share.edges = edges(cx).await?;
    quiet(cx, Phase::Independent).await
}

/// The balls to the nearest neighbours, by the descent or level by level.
async fn neighbour_balls<P: Point>(cx: &mut Context<P>) -> Result<(), TransportError> {
    quiet(cx, Phase::Radii).await?;
    if cx.config.correction == Correction::Naive {
        for _ in 0..=first_level(&cx.config) {
            quiet(cx, Phase::Neighbours).await?;
        }
        return Ok(());
    }
    quiet(cx, Phase::Probe).await?;
    quiet(cx, Phase::Neighbours).await
}

/// Leads the root's separator sets.
async fn separator_sets<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    supergraph: Option<Supergraph>,
) -> Result<(), TransportError> {
    cx.enter(Phase::Sets)?;
    let density = matches!(supergraph, Some(Supergraph::Density { .. }));
    let smaller = cx.config.sets == SetRule::Smaller;
    let rule = if smaller && !density { SetRule::Both } else { cx.config.sets };
    let mut leader = leader_of(led);
    while cx.exchange().await? {
        let (out, _, inbox) = cx.parts();
        let counts = by_node(inbox, |m| match &mut m.body {
            Body::SetCounts(counts) => Some(std::mem::take(&mut counts.0)),
            _ => None,
        });
        for (node, all) in counts {
            leader.on_set_counts(node, &all, rule, out);
        }
    }
    Ok(())
}

pub(crate) fn leader_of<P: Point>(led: &[Group]) -> Leader<P> {
    let mut leader = Leader::default();
    for group in led {
        leader.lead(group.node, group.child.population, group.child.first, group.child.ranks);
    }
    leader
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
    population: u64,
    share: &mut Share<P>,
) -> Result<(), TransportError> {
    quiet(cx, Phase::Check).await?;
    for pass in 0.. {
        quiet(cx, Phase::Repair).await?;
        quiet(cx, Phase::Certificate).await?;
        let merged = verdict::merge(cx, led, pass).await?;
        let Some(merged) = merged else { continue };
        let outcome = verdict::judge(merged, population, pass);
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
