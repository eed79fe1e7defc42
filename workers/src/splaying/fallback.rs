//! Rank 0 gathers and triangulates the region that splaying leaves open.
//!
//! **Statement.** A vertex is *open* if its star has a cell that another star lacks. If gathering the open vertices
//! did not suffice in an earlier pass, all vertices count as open. Rank 0 triangulates the *region*: the open
//! vertices and the vertices of their links. It returns to each open vertex its neighbours in this triangulation.
//! A vertex that is hidden in it gets the corners of a cell below it.
//! Splaying then continues with these neighbours as candidates, and proposes the cells that other stars lack
//! ([`crate::splaying::splay`]).
//!
//! **Rounds.** Two: the region to rank 0, the neighbours back.
//!
//! **Work and depth.** A vector step over the link facets of the open stars. Rank 0 sorts the region, triangulates it in
//! sequence, and reads the links of the open vertices in a vector step. Its depth is the number of cells that the
//! triangulation visits, removes and creates.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, OF_A_LINK, PointBatch, WANTED};
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::share::Certificate;
use crate::splaying::messages::GatheredPoint;
use crate::splaying::region::Region;
use crate::splaying::wire::take_points;
use crate::stars::check::Agreement;
use crate::stars::owned::Stars;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// Sends the open vertices and their links to rank 0. Returns the neighbours that rank 0 finds for the open vertices
/// of this rank.
pub(crate) async fn gather<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    (agreement, outcome): (&Agreement, Outcome),
    certificate: &mut Certificate,
) -> Result<Vec<GatheredPoint>, TransportError> {
    cx.enter(Phase::Fallback)?;
    stars.extract_links(table);
    let open: BTreeSet<u32> = if outcome == Outcome::GatherAll {
        table.owned().collect()
    } else {
        // The stars that lack a cell are not gathered, because the set must not depend on the owners of points. They receive
        // the cell in the next pass of splaying.
        agreement.disagreements().iter().map(|d| d.holder).collect()
    };
    charge_open(cx, subdomain.leaves(), stars, &open);
    cx.send_to_coordinator(Body::Gather(region(table, stars, &open)));
    let (mut gathered, mut whole) = (Vec::new(), Region::default());
    while cx.exchange().await? {
        if cx.is_coordinator() {
            whole.receive(cx, outcome, certificate);
        }
        take_points(cx, table, &mut gathered);
    }
    Ok(gathered)
}

/// Charges each leaf for the vector step that collects its open vertices and their links.
fn charge_open<P: Point>(cx: &mut Context<P>, leaves: &[Leaf<P>], stars: &Stars<P>, open: &BTreeSet<u32>) {
    let mut sweeps: BTreeMap<u32, Sweep> = BTreeMap::new();
    for &vertex in open {
        sweeps.entry(leaf_number(leaves, vertex)).or_default().visit_all(stars.link(vertex));
    }
    for (leaf, sweep) in sweeps {
        let mut cost = cx.own_cost();
        cost.charge_sweep(sweep);
        cx.charge(Account::member(Phase::Fallback, leaves[leaf as usize].id()), cost, sweep.items());
    }
}

/// Returns the open vertices and the other vertices of their links.
fn region<P: Point>(table: &Table<P>, stars: &Stars<P>, open: &BTreeSet<u32>) -> PointBatch<P> {
    let mut batch = PointBatch::default();
    let mut push = |v: u32, role: f64| {
        let i = v as usize;
        batch.push(table.ids()[i], table.positions()[i], table.owners()[i], role);
    };
    let mut links = BTreeSet::new();
    for &vertex in open {
        push(vertex, WANTED);
        links.extend(stars.link(vertex).iter().flat_map(AsRef::as_ref).copied());
    }
    links.remove(&INFINITE);
    links.difference(open).for_each(|&v| push(v, OF_A_LINK));
    batch
}
