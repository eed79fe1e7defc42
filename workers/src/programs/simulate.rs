//! The paper's algorithm (Sections 4.3 to 4.6), as one worker takes part in it.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::message::PointBatch;
use septet_protocol::transport::TransportError;

use crate::config::{Correction, Wanted};
use crate::graph::selection::choice;
use crate::graph::summaries::summaries;
use crate::graph::supergraph::supergraph;
use crate::machine::context::Context;
use crate::neighbours::balls::nearest_balls;
use crate::neighbours::lists::nearest_lists;
use crate::result::certify::{Instance, certify};
use crate::result::collect::{collect_cells, collect_counts};
use crate::stars::hulls::local_hulls;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Balls to the nearest neighbours, the supergraph in separator sets, local hulls, the certificate, the cells.
pub(super) async fn simulate<P: Point>(
    cx: &mut Context<P>,
    mut subdomain: Subdomain<P>,
    mut table: Table<P>,
    mut frame: PointBatch<P>,
    population: u64,
) -> Result<(), TransportError> {
    if cx.config.until == Some(Phase::Neighbours) {
        nearest_balls(cx, &subdomain, &mut table).await?;
        return collect_counts(cx).await;
    }
    let rule = match cx.config.graph.wanted {
        Wanted::Fixed(rule) => rule,
        _ => choice(cx, &subdomain, &mut table, population).await?,
    };
    // Graphs of k nearest neighbours are not made of the balls to the nearest one.
    let k = if let Supergraph::Knn { k } = rule { Some(k) } else { None };
    if k.is_none() || cx.config.graph.correction == Correction::Naive {
        nearest_balls(cx, &subdomain, &mut table).await?;
    }
    summaries(cx, &mut subdomain, &mut table, &mut frame).await?;
    let nearest = match k {
        Some(k) => Some(nearest_lists(cx, &subdomain, &mut table, k).await?),
        None => None,
    };
    let (neighbours, ghosts) = supergraph(cx, &subdomain, &mut table, rule, nearest).await?.into_parts();
    let mut stars = local_hulls(cx, &subdomain, &mut table, neighbours, &ghosts, &frame).await?;
    let instance = Instance { population, supergraph: rule };
    let certified = certify(cx, &subdomain, &mut table, &mut stars, instance).await?;
    collect_cells(cx, &subdomain, table, stars, &ghosts, instance, certified).await
}
