//! A maximal independent set of a conflict graph, as one worker takes part in it.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::message::PointBatch;
use septet_protocol::transport::TransportError;

use crate::config::Wanted;
use crate::graph::independent::{conflict_graphs, independent};
use crate::graph::summaries::summaries;
use crate::machine::context::Context;
use crate::result::collect::collect_selected;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// The conflict graph of the sites, whose radii came with them, then rounds of local priorities.
pub(super) async fn independent_set<P: Point>(
    cx: &mut Context<P>,
    mut subdomain: Subdomain<P>,
    mut table: Table<P>,
    mut frame: PointBatch<P>,
    fixed: u64,
) -> Result<(), TransportError> {
    summaries(cx, &mut subdomain, &mut table, &mut frame).await?;
    let rule = if let Wanted::Fixed(rule) = cx.config.graph.wanted {
        rule
    } else {
        Supergraph::Density { alpha: 1.0 }
    };
    let graphs = conflict_graphs(cx, &subdomain, &mut table, rule).await?;
    let selection = independent(cx, subdomain.leaves(), &table, graphs, fixed).await?;
    collect_selected(cx, &table, selection, fixed).await
}
