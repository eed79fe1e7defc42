//! A maximal independent set of a conflict graph.

use septet_geometry::point::Point;
use septet_protocol::transport::TransportError;

use super::ground::Ground;
use crate::config::Wanted;
use crate::graph::independent::{Sites, conflict_graphs, independent};
use crate::graph::summaries::summaries;
use crate::machine::context::Context;
use crate::result::collect::collect_counts;
use crate::share::Share;

/// Builds the conflict graph of the sites, whose radii are part of the input. Then runs rounds of local priorities.
pub(super) async fn independent_set<P: Point>(
    cx: &mut Context<P>,
    ground: Ground<P>,
    fixed: u64,
    mut share: Share<P>,
) -> Result<Share<P>, TransportError> {
    let Wanted::Fixed(rule) = cx.config().graph.wanted else {
        let reason = "a conflict graph has a fixed rule".to_string();
        return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
    };
    let population = ground.population().count;
    let (mut subdomain, mut table, mut frame) = ground.into_parts();
    share.choice.supergraph = Some(rule);
    summaries(cx, &mut subdomain, &mut table, &mut frame).await?;
    let graphs = conflict_graphs(cx, &subdomain, &mut table, rule).await?;
    let selection = independent(cx, subdomain.leaves(), &table, graphs, Sites { fixed, population }).await?;
    share.selected.members = selection.members(&table, fixed);
    share.selected.undecided = selection.into_undecided();
    collect_counts(cx, share).await
}
