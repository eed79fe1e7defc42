//! The direct path: each worker triangulates its piece at once, as one worker takes part in it.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::message::PointBatch;
use septet_protocol::transport::TransportError;

use crate::config::Wanted;
use crate::direct::ghost_layer::ghost_layer;
use crate::direct::interface::{insert, interface};
use crate::direct::subdomain_triangulation::triangulate_subdomain;
use crate::machine::context::Context;
use crate::result::certify::{Instance, certify};
use crate::result::collect::collect_cells;
use crate::stars::owned::Stars;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// The supergraph by which pictures show crossings where the run has none.
const SHOWN: Supergraph = Supergraph::Density { alpha: 2.5 };

/// A ghost layer, the piece, the interfaces between pieces, the certificate, the cells.
pub(super) async fn triangulate<P: Point>(
    cx: &mut Context<P>,
    subdomain: Subdomain<P>,
    mut table: Table<P>,
    mut frame: PointBatch<P>,
    population: u64,
) -> Result<(), TransportError> {
    let mut layer = ghost_layer(cx, &subdomain, &mut table, &mut frame).await?;
    let (triangulation, mut ghosts) =
        triangulate_subdomain(cx, &subdomain, &mut table, layer.take_ghosts(), &frame).await?;
    let arrived = interface(cx, &subdomain, &mut table, triangulation.as_ref(), layer).await?;
    let triangulation = insert(cx, &subdomain, &table, triangulation, &mut ghosts, arrived).await?;
    let mut stars = Stars::from_subdomain(triangulation);
    let supergraph = if let Wanted::Fixed(rule) = cx.config.graph.wanted { rule } else { SHOWN };
    let instance = Instance { population, supergraph };
    let certified = certify(cx, &subdomain, &mut table, &mut stars, instance).await?;
    collect_cells(cx, &subdomain, table, stars, &ghosts, instance, certified).await
}
