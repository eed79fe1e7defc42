//! The interface exchange of `triangulate`, which completes the stars of all owned points.
//!
//! **Statement.** Let `P` be the set of all points and `DT(X)` the perturbed, hence generic, Delaunay triangulation of
//! `X`. The *conflict region* of a cell is its closed circumball, or the closed half-space beyond its hull facet. It
//! contains every point in conflict with the cell ([`septet_geometry::conflict_region::ConflictRegion`]). The *region*
//! of a worker lies on its side of every separator on its path from the root of the tree. Let a worker own the points
//! `B` and hold any ghosts `G`. Suppose that every worker sends each `b` in its `B` to each worker whose region meets
//! the conflict region of a cell of `b` in `DT(B + G)`. Then:
//! 1. Every worker holds all neighbours in `DT(P)` of its owned points.
//! 2. In the triangulation of the points that it holds, each owned point has the same star as in `DT(P)`.
//!
//! *Proof of 1.* Let `ab` be an edge of `DT(P)`, `b` in `B`, and `a` owned by another worker `W`. It suffices to show
//! that `a` lies in the conflict region of a cell of `b`. The point `a` also lies in the region of `W` and in the box of
//! its points, so the two regions meet and `b` is sent to `W`. A Delaunay edge persists if other points are removed, so
//! `ab` is an edge of `DT(B + G + a)`.
//! - *`a` is in `G`.* Then `ab` is an edge of a cell of `DT(B + G)`. Its conflict region is closed and contains `a`.
//! - *`a` is not in `G`.* Then inserting `a` makes it adjacent to `b`. So `a` conflicts with a cell of `b`.
//!
//! *Proof of 2.* A vertex and its neighbours in `DT(P)` determine its star. Further points do not change this star.
//! QED.
//!
//! One exchange therefore suffices for any `G`. With the ghost layer as `G` ([`crate::direct::ghost_layer`]), most
//! cells of a subdomain triangulation are also cells of `DT(P)`. Few conflict regions extend beyond the halo balls of
//! their vertices, and a vertex was already sent to every worker that its halo ball meets. No worker receives a point
//! twice. A ghost that arrives in this exchange is skipped if it would have no owned neighbour
//! ([`SubdomainTriangulation::add`] has an exception for large cavities).
//!
//! **Weights.** With weights, `DT` is the regular triangulation, and the conflict region of a cell is that for sites of the
//! largest weight of all ranks. A hidden owned site has no cell and is not sent: it lies above the lower hull of some sites,
//! and the hull only sinks if sites are added, so it stays hidden. It therefore hides no site, and is no end of an edge `ab`.
//!
//! **Rounds.** One.
//!
//! **Work.** For each vertex at the interface, one clearance per level
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)). For each cell that the clearance of
//! its vertex does not exclude, one test per level, and two at each split that its conflict region reaches. In addition,
//! the insertion of the late ghosts; well-spaced sets have `O(n^(1-1/d))` of them.
//!
//! The certificate does not rely on this proof.

use std::cell::Cell;

use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::direct::copies::{Copies, charge_exchange, receive_copies};
use crate::direct::ghost_layer::GhostLayer;
use crate::direct::interface_cells::{InterfaceCells, Outgoing, reaches};
use crate::direct::regions::Regions;
use crate::direct::subdomain_triangulation::SubdomainTriangulation;
use crate::machine::context::Context;
use crate::state::bits::ones;
use crate::state::ghosts::Ghosts;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::Split;

/// Sends the vertices of cells that extend beyond the ghost layer to the workers whose regions these cells reach.
/// Returns the ghosts that arrived, as local indices.
pub(crate) async fn interface<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    triangulation: Option<&SubdomainTriangulation<P>>,
    layer: GhostLayer<P>,
) -> Result<Vec<u32>, TransportError> {
    cx.enter(Phase::Seam)?;
    let (margins, regions, mut copies) = layer.into_parts();
    let mut tests = Sweep::default();
    if let Some(own) = triangulation.filter(|_| !subdomain.path().is_empty()) {
        let mut cells = InterfaceCells::new(subdomain.path(), own, table.positions(), &margins);
        (0..own.slots()).for_each(|_| tests.visit());
        cells.scan(|out| add_vertices(&out, &regions, &mut copies, &mut tests));
    }
    drop((margins, regions));
    copies.send(cx, table);
    drop(copies);
    let mut arrived = Vec::new();
    while cx.exchange().await? {
        receive_copies(cx, table, &mut arrived);
    }
    charge_exchange(cx, subdomain.root(), tests, arrived.len());
    Ok(arrived)
}

/// Adds the vertices of an outgoing cell to the copies for all workers whose regions the cell reaches.
fn add_vertices<P: Point>(out: &Outgoing<P>, regions: &Regions<P>, copies: &mut Copies, tests: &mut Sweep) {
    let visits = Cell::new(0u32);
    let reaches = |split: &Split<P>, side| {
        visits.set(visits.get() + 1);
        reaches(split, &out.region, side)
    };
    for level in ones(out.levels) {
        regions.each_reached(level, &reaches, &mut |worker| {
            for at in ones(u64::from(out.sent)) {
                copies.add(out.cell.as_ref()[at], worker);
            }
        });
    }
    (0..visits.get()).for_each(|_| tests.visit());
}

/// Inserts the ghosts of the interface exchange. The triangulation then contains the stars of all owned points.
pub(crate) async fn insert<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    mut triangulation: Option<SubdomainTriangulation<P>>,
    ghosts: &mut Ghosts,
    arrived: Vec<u32>,
) -> Result<Option<SubdomainTriangulation<P>>, TransportError> {
    cx.enter(Phase::Hulls)?;
    if let Some(own) = &mut triangulation {
        let at = subdomain.root();
        let _span = cx.site().subproblem(Phase::Hulls, at, "insert ghosts", arrived.len() as u64);
        let operations = own.add(&arrived, table.positions(), &cx.config().stop);
        if cx.config().shown.charges_direct() {
            let mut cost = cx.own_cost();
            operations.charge(&mut cost);
            cx.charge(Account::member(Phase::Hulls, at), cost, arrived.len() as u64);
        }
        ghosts.add_to_first(arrived);
    }
    while cx.exchange().await? {}
    Ok(triangulation)
}
