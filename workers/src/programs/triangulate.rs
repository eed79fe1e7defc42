//! The direct path: each worker triangulates its subdomain as a whole.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::transport::TransportError;

use super::certify::certify;
use super::ground::Ground;
use crate::direct::ghost_layer::ghost_layer;
use crate::direct::interface::{insert, interface};
use crate::direct::subdomain_triangulation::triangulate_subdomain;
use crate::machine::context::Context;
use crate::result::collect::collect_cells;
use crate::result::merge::Instance;
use crate::share::Share;
use crate::stars::owned::Stars;

/// The supergraph whose crossings pictures show if the run does not use a supergraph.
const SHOWN: Supergraph = Supergraph::Density { alpha: 2.5 };

/// Computes the ghost layer, the subdomain triangulation, the interface exchange, the certificate and the cells.
pub(super) async fn triangulate<P: Point>(
    cx: &mut Context<P>,
    ground: Ground<P>,
    mut share: Share<P>,
) -> Result<Share<P>, TransportError> {
    let (population, heaviest) = (ground.population(), ground.heaviest());
    let (subdomain, mut table, mut frame) = ground.into_parts();
    share.choice.supergraph = cx.config().graph.wanted.fixed(population.count);
    let mut layer = ghost_layer(cx, &subdomain, &mut table, &mut frame).await?;
    let (triangulation, mut ghosts) =
        triangulate_subdomain(cx, &subdomain, &mut table, layer.take_ghosts(), (&frame, heaviest)).await?;
    let arrived = interface(cx, &subdomain, &mut table, triangulation.as_ref(), layer).await?;
    let triangulation = insert(cx, &subdomain, &table, triangulation, &mut ghosts, arrived).await?;
    let mut stars = Stars::from_subdomain(triangulation);
    let supergraph = share.choice.supergraph.unwrap_or(SHOWN);
    let instance = Instance { population, heaviest, supergraph };
    let certified = certify(cx, &subdomain, &mut table, &mut stars, instance).await?;
    collect_cells(cx, &subdomain, table, stars, &ghosts, certified, share).await
}
