//! Collects cells, members of independent sets, and ledgers on the coordinator.
//!
//! **Rounds.** Two. The ledger follows the results, because it bills their messages.

use septet_geometry::point::{Point, Simplex};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::Body;
use septet_protocol::transport::TransportError;

use crate::coordinator::Share;
use crate::graph::independent::Selection;
use crate::machine::context::Context;
use crate::result::certified::Certified;
use crate::result::merge::{Instance, OwnedCells, Results, classify};
use crate::result::view::send_view;
use crate::stars::owned::{Stars, StarsView};
use crate::state::bits::ones;
use crate::state::cells::finite_cell;
use crate::state::ghosts::Ghosts;
use crate::state::rows::{AdjacencyRows, INTERFACE};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::Leaf;

/// A message of cells is sent when it contains at least this number of indices.
pub const CELLS_PER_MESSAGE: usize = 1 << 20;

/// Collects the ledgers only.
pub(crate) async fn collect_counts<P: Point>(
    cx: &mut Context<P>,
    share: Share<P>,
) -> Result<Share<P>, TransportError> {
    cx.enter(Phase::Collect)?;
    collect(cx, share).await
}

/// Collects the members of an independent set, then the ledgers.
pub(crate) async fn collect_selected<P: Point>(
    cx: &mut Context<P>,
    table: &Table<P>,
    selection: Selection,
    fixed: u64,
    share: Share<P>,
) -> Result<Share<P>, TransportError> {
    cx.enter(Phase::Collect)?;
    cx.send_to_coordinator(selection.into_message(table, fixed));
    collect(cx, share).await
}

/// Collects the cells and the data for pictures, if the certificate passed, then the ledgers.
pub(crate) async fn collect_cells<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    mut table: Table<P>,
    mut stars: Stars<P>,
    ghosts: &Ghosts,
    certified: Certified,
    mut share: Share<P>,
) -> Result<Share<P>, TransportError> {
    cx.enter(Phase::Collect)?;
    let Instance { population, supergraph } = certified.instance();
    if certified.has_passed() {
        if cx.config().shown.view > 0 {
            add_picture_data(&mut table, &mut stars);
            let results = Results::new(subdomain, StarsView::new(&table, &stars), supergraph);
            send_view(cx, results, ghosts, population.count);
        }
        if cx.config().counted {
            send_cells(cx, subdomain, StarsView::new(&table, &stars), certified.owned_cells());
        } else if table.owned_len() > 0 {
            send_subdomain(cx, subdomain, table, stars);
        }
    }
    share.certified = certified.into_certificate();
    collect(cx, share).await
}

/// Sends the ledger to the coordinator after the messages with results have been billed. The coordinator receives all
/// results and ledgers. Only the coordinator returns a complete result.
async fn collect<P: Point>(cx: &mut Context<P>, mut share: Share<P>) -> Result<Share<P>, TransportError> {
    cx.exchange_if(true).await?;
    if cx.is_coordinator() {
        share.receive(cx)?;
    }
    send_ledger(cx);
    while cx.exchange().await? {
        if cx.is_coordinator() {
            share.receive(cx)?;
        }
    }
    if cx.is_coordinator() {
        if let Some(fault) = cx.config().fault {
            fault.distort(&mut share.counted.ledger);
        }
        cx.enter(Phase::Done)?;
    }
    Ok(share)
}

/// Sends the ledger, and files the record of charges.
fn send_ledger<P: Point>(cx: &mut Context<P>) {
    if let Some(fault) = cx.config().fault {
        fault.distort_worker(cx.ledger_mut());
    }
    cx.file_charges();
    let words = cx.ledger().to_words();
    cx.send_to_coordinator(Body::Ledger(Bulk(words)));
}

/// Computes the radii and links of a subdomain triangulation, which pictures show.
fn add_picture_data<P: Point>(table: &mut Table<P>, stars: &mut Stars<P>) {
    if let Some(triangulation) = stars.triangulation() {
        let radii2 = triangulation.nearest_edges();
        table.with_radii();
        table.owned_radii2_mut().copy_from_slice(&radii2);
        stars.copy_links();
    }
}

/// Sends the cells that belong to owned points, as rows of ids.
fn send_cells<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    view: StarsView<'_, P>,
    owned_cells: &OwnedCells,
) {
    let ids = view.table().ids();
    let (mut cells, mut leaves) = (Vec::new(), Vec::new());
    let (mut sent, all) = (0, owned_cells.count() as usize * (P::DIM + 1));
    for leaf in subdomain.leaves() {
        if cells.is_empty() {
            // A message exceeds its limit by at most the cells of one leaf. These need far less than an eighth of the
            // limit.
            cells.reserve_exact((all - sent.min(all)).min(CELLS_PER_MESSAGE + CELLS_PER_MESSAGE / 8));
        }
        for vertex in leaf.owned() {
            each_owned_cell(view, owned_cells, vertex, |cell| {
                cells.extend(cell.as_ref().iter().map(|&v| ids[v as usize]));
                if cx.config().shown.with_leaves {
                    leaves.push(leaf.id().0);
                }
            });
        }
        // The cells of a leaf stay in one message.
        if cells.len() >= CELLS_PER_MESSAGE {
            sent += cells.len();
            send_message(cx, std::mem::take(&mut cells), std::mem::take(&mut leaves));
        }
    }
    if !cells.is_empty() {
        send_message(cx, cells, leaves);
    }
}

/// Calls `f` with the cells that belong to an owned point.
fn each_owned_cell<P: Point>(
    view: StarsView<'_, P>,
    owned_cells: &OwnedCells,
    vertex: u32,
    mut f: impl FnMut(&P::Cell),
) {
    let (positions, link) = (view.table().positions(), view.link(vertex));
    // Most cells of a star belong to another vertex. Merging has stored a bit for each of the first 64 facets.
    let (first, rest) = link.split_at(link.len().min(u64::BITS as usize));
    let known = ones(owned_cells.facets_of(vertex)).map(|at| &first[at]);
    let others = rest.iter().filter(|facet| classify(positions, vertex, facet).is_owned());
    known.chain(others).filter_map(|facet| finite_cell::<P>(vertex, facet)).for_each(|cell| f(&cell));
}

fn send_message<P: Point>(cx: &mut Context<P>, cells: Vec<u64>, leaves: Vec<u64>) {
    let body = Body::Cells { cells: Bulk(cells), leaves: Bulk(leaves) };
    cx.send_to_coordinator(body);
}

/// Sends the cells that belong to this rank, with their neighbours.
fn send_subdomain<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: Table<P>,
    mut stars: Stars<P>,
) {
    let cells = match stars.take_triangulation() {
        Some(triangulation) => triangulation.into_rows(),
        None => rows_of_links(StarsView::new(&table, &stars)),
    };
    let (rows, open) = cells.into_parts();
    let body = Body::Piece {
        leaf: subdomain.leaves().first().map_or(NodeId::ROOT, Leaf::id).0,
        ids: Bulk(table.into_ids()),
        rows: Bulk(rows),
        open: Bulk(open),
    };
    cx.send_to_coordinator(body);
}

/// Returns the cells that belong to this rank, from links. Matches facets to find neighbours. A facet without a match
/// gets the entry [`INTERFACE`], although it may be on the hull.
fn rows_of_links<P: Point>(view: StarsView<'_, P>) -> AdjacencyRows {
    let table = view.table();
    let mut cells = Vec::new();
    for vertex in table.owned() {
        let owned = view.link(vertex).iter().filter(|f| classify(table.positions(), vertex, f).is_owned());
        owned
            .filter_map(|facet| finite_cell::<P>(vertex, facet))
            .for_each(|cell| cells.extend_from_slice(cell.as_ref()));
    }
    let corners = P::DIM + 1;
    let mut facets: Vec<(P::Facet, u32)> = (0..cells.len())
        .map(|entry| {
            let mut facet = P::Facet::splat(0);
            let cell = &cells[entry / corners * corners..][..corners];
            let others = cell.iter().enumerate().filter(|&(slot, _)| slot != entry % corners);
            facet.as_mut().iter_mut().zip(others).for_each(|(to, (_, &v))| *to = v);
            facet.as_mut().sort_unstable();
            (facet, entry as u32)
        })
        .collect();
    facets.sort_unstable();
    let mut neighbours = vec![INTERFACE; cells.len()];
    for pair in facets.chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, a), (_, b)] = pair {
            neighbours[a as usize] = b / corners as u32;
            neighbours[b as usize] = a / corners as u32;
        }
    }
    let across = || neighbours.chunks_exact(corners);
    let open = (0..).zip(across()).filter(|(_, across)| across.contains(&INTERFACE)).map(|(cell, _)| cell);
    let rows = cells.chunks_exact(corners).zip(across());
    AdjacencyRows::new(
        rows.flat_map(|(cell, across)| cell.iter().chain(across)).copied().collect(),
        open.collect(),
    )
}
