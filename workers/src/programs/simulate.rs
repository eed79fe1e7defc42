//! The paper's algorithm (Sections 4.3 to 4.6).

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use super::certify::certify;
use super::ground::Ground;
use crate::config::Correction;
use crate::graph::selection::choice;
use crate::graph::summaries::summaries;
use crate::graph::supergraph::supergraph;
use crate::machine::context::Context;
use crate::neighbours::balls::nearest_balls;
use crate::neighbours::lists::{ListSearch, nearest_lists};
use crate::result::collect::{collect_cells, collect_counts};
use crate::result::merge::Instance;
use crate::share::{Choice, Share};
use crate::stars::hulls::local_hulls;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Computes nearest-neighbour balls, the supergraph in separator sets, local hulls, the certificate and the cells.
pub(super) async fn simulate<P: Point>(
    cx: &mut Context<P>,
    ground: Ground<P>,
    mut share: Share<P>,
) -> Result<Share<P>, TransportError> {
    let (population, heaviest) = (ground.population(), ground.heaviest());
    let (mut subdomain, mut table, mut frame) = ground.into_parts();
    if cx.config().until == Some(Phase::Neighbours) {
        nearest_balls(cx, &subdomain, &mut table).await?;
        if cx.config().shown.with_edges {
            share.radii2 =
                table.owned().map(|i| (table.ids()[i as usize], table.radii2()[i as usize])).collect();
        }
        return collect_counts(cx, share).await;
    }
    share.choice = match cx.config().graph.wanted.fixed(population.count) {
        Some(rule) => Choice { supergraph: Some(rule), why: None },
        None => choice(cx, &subdomain, &mut table, (population.count, heaviest)).await?,
    };
    let Some(rule) = share.choice.supergraph else {
        let reason = "phase choice ended without a choice".to_string();
        return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
    };
    neighbour_balls(cx, &subdomain, &mut table, rule).await?;
    summaries(cx, &mut subdomain, &mut table, &mut frame).await?;
    let nearest = match rule {
        Supergraph::Knn { k } => {
            Some(nearest_lists(cx, &subdomain, &mut table, ListSearch::of_graph(k)).await?)
        }
        Supergraph::Density { .. } | Supergraph::Overlap { .. } => None,
    };
    let mut graph = supergraph(cx, &subdomain, &mut table, rule, nearest).await?;
    (share.edges, share.sets) = (graph.take_edges(), graph.take_sets());
    if cx.config().until == Some(Phase::Graph) {
        return collect_counts(cx, share).await;
    }
    let (neighbours, ghosts) = graph.into_parts();
    let mut stars = local_hulls(cx, &subdomain, &mut table, neighbours, &ghosts, &frame).await?;
    let instance = Instance { population, heaviest, supergraph: rule };
    let certified = certify(cx, &subdomain, &mut table, &mut stars, instance).await?;
    collect_cells(cx, &subdomain, table, stars, &ghosts, certified, share).await
}

/// Finds the neighbour balls of a supergraph. Graphs of k nearest neighbours do not use them. The baseline corrects them
/// nevertheless, for a comparison of all supergraphs.
async fn neighbour_balls<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    rule: Supergraph,
) -> Result<(), TransportError> {
    let order = match rule {
        Supergraph::Knn { .. } if cx.config().graph.correction == Correction::Descent => return Ok(()),
        Supergraph::Knn { .. } | Supergraph::Density { .. } => 1,
        Supergraph::Overlap { k, .. } => cx.config().fault.map_or(k, |fault| fault.ball_order(k)),
    };
    if order == 1 {
        return nearest_balls(cx, subdomain, table).await;
    }
    nearest_lists(cx, subdomain, table, ListSearch::of_balls(order)).await.map(drop)
}
