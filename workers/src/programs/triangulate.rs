//! The direct path: each worker triangulates its subdomain at once.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::transport::TransportError;

use super::Ground;
use crate::config::Wanted;
use crate::coordinator::Share;
use crate::direct::ghost_layer::{GhostLayer, halo};
use crate::direct::interface::{insert, interface};
use crate::direct::subdomain_triangulation::triangulate_subdomain;
use crate::machine::context::Context;
use crate::result::certify::{Instance, certify};
use crate::result::collect::collect_cells;
use crate::stars::owned::Stars;

/// The supergraph whose crossings pictures show if the run does not use one.
const SHOWN: Supergraph = Supergraph::Density { alpha: 2.5 };

/// The ghost layer, the subdomain triangulation, the interfaces, the certificate, the cells.
pub(super) async fn triangulate<P: Point>(
    cx: &mut Context<P>,
    Ground { subdomain, mut table, mut frame, population }: Ground<P>,
) -> Result<Share<P>, TransportError> {
    let mut share = Share::default();
    if let Wanted::Fixed(rule) = cx.config().graph.wanted {
        share.choice.supergraph = Some(rule);
    }
    let GhostLayer { margins, arrived } = halo(cx, &subdomain, &mut table, &mut frame).await?;
    let (piece, mut ghosts) = triangulate_subdomain(cx, &subdomain, &mut table, arrived, &frame).await?;
    let arrived = interface(cx, &subdomain, &mut table, piece.as_ref(), margins).await?;
    let piece = insert(cx, &subdomain, &table, piece, &mut ghosts, arrived).await?;
    let mut stars = Stars::default();
    stars.set_subdomain(piece);
    let instance = Instance { population, supergraph: share.choice.supergraph.unwrap_or(SHOWN) };
    let certified = certify(cx, &subdomain, &mut table, &mut stars, instance).await?;
    collect_cells(cx, &subdomain, (table, stars), &ghosts, instance, certified, share).await
}
