//! Collection of cells, members and ledgers on the coordinator.
//!
//! **Rounds.** Two: the results of every worker, then its ledger, which bills the results.

use septet_geometry::point::{Point, Simplex};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::Body;
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::coordinator::Share;
use crate::direct::subdomain_triangulation::SEAM;
use crate::graph::independent::Selection;
use crate::machine::context::Context;
use crate::result::certify::{Certified, Instance};
use crate::result::merge::{OwnedCells, Results, look_at_facet};
use crate::result::view::send_view;
use crate::stars::owned::{Chart, Stars};
use crate::state::bits::ones;
use crate::state::cells::{finite_cell, smallest_of};
use crate::state::subdomain::{Ghosts, Subdomain};
use crate::state::table::Table;

/// Indices in a message of cells before it is sent.
pub const CELLS_PER_MESSAGE: usize = 1 << 20;

/// Collects the counts alone.
pub(crate) async fn collect_counts<P: Point>(
    cx: &mut Context<P>,
    share: Share<P>,
) -> Result<Share<P>, TransportError> {
    cx.enter(Phase::Collect)?;
    collect(cx, share).await
}

/// Collects the members that joined an independent set, then the ledgers.
pub(crate) async fn collect_selected<P: Point>(
    cx: &mut Context<P>,
    table: &Table<P>,
    selection: Selection,
    fixed: u64,
    share: Share<P>,
) -> Result<Share<P>, TransportError> {
    cx.enter(Phase::Collect)?;
    if !cx.is_coordinator() {
        cx.to_coordinator(selection.into_message(table, fixed));
    }
    collect(cx, share).await
}

/// Collects the cells if they are certified, and what is shown; then the ledgers.
pub(crate) async fn collect_cells<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    (mut table, mut stars): (Table<P>, Stars<P>),
    ghosts: &Ghosts,
    instance: Instance,
    certified: Certified,
    mut share: Share<P>,
) -> Result<Share<P>, TransportError> {
    cx.enter(Phase::Collect)?;
    if certified.outcome == Outcome::Passed && !cx.is_coordinator() {
        if cx.config().shown.view > 0 {
            show_subdomain(&mut table, &mut stars);
            let chart = Chart { table: &table, stars: &stars };
            send_view(
                cx,
                Results { subdomain, chart, supergraph: instance.supergraph },
                ghosts,
                instance.population,
            );
        }
        if cx.config().counted {
            send_cells(cx, subdomain, Chart { table: &table, stars: &stars }, &certified.cells_here);
        } else if table.owned > 0 {
            send_subdomain(cx, subdomain, table, stars);
        }
    }
    share.certified = certified.certificate;
    collect(cx, share).await
}

/// Sends the ledger to the coordinator after the results before it are billed. The coordinator takes all results. Returns
/// the complete result on the coordinator.
async fn collect<P: Point>(cx: &mut Context<P>, mut share: Share<P>) -> Result<Share<P>, TransportError> {
    cx.exchange_if(true).await?;
    if cx.is_coordinator() {
        share.receive(cx)?;
    } else {
        send_ledger(cx);
    }
    while cx.exchange().await? {
        if cx.is_coordinator() {
            share.receive(cx)?;
        }
    }
    if cx.is_coordinator() {
        cx.enter(Phase::Done)?;
        share.counted.ledger.merge(cx.ledger());
    }
    Ok(share)
}

/// Sends the record of tasks, if there is one, and the ledger.
fn send_ledger<P: Point>(cx: &mut Context<P>) {
    if let Some(log) = cx.finish_record() {
        cx.to_coordinator(Body::Tasks(Box::new(log)));
    }
    if let Some(fault) = cx.config().fault {
        fault.distort(cx.ledger_mut());
    }
    let words = cx.ledger().to_words();
    cx.to_coordinator(Body::Ledger(Bulk(words)));
}

/// Pictures show radii and stars of a piece, too.
fn show_subdomain<P: Point>(table: &mut Table<P>, stars: &mut Stars<P>) {
    if let Some(piece) = stars.piece() {
        let radii2 = piece.nearest_edges();
        table.with_radii();
        table.radii2[..radii2.len()].copy_from_slice(&radii2);
        stars.show();
    }
}

/// Sends the cells that belong to the home points, as rows of ids.
fn send_cells<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    chart: Chart<'_, P>,
    cells_here: &OwnedCells,
) {
    let ids = &chart.table.ids;
    let (mut cells, mut owned_points) = (Vec::new(), Vec::new());
    let (mut sent, all) = (0, cells_here.cells as usize * (P::DIM + 1));
    for leaf in &subdomain.leaves {
        if cells.is_empty() {
            // Leaves are far smaller than what is left of a message that is full.
            cells.reserve_exact((all - sent.min(all)).min(CELLS_PER_MESSAGE + CELLS_PER_MESSAGE / 8));
        }
        let before = cells.len();
        for owned in leaf.owned() {
            owned_cells(chart, cells_here, owned, |cell| {
                cells.extend(cell.as_ref().iter().map(|&v| ids[v as usize]));
                if cx.config.shown.with_leaves {
                    owned_points.push(leaf.id.0);
                }
            });
        }
        // Leaves are small: their cells stay together, so the leaves' counts alone give the number of messages.
        let own = (cells.len() - before) / (P::DIM + 1);
        if let Some(recorder) = &mut cx.recorder {
            recorder.log.cells.push(own as u64);
        }
        if cells.len() >= CELLS_PER_MESSAGE {
            sent += cells.len();
            post_cells(cx, std::mem::take(&mut cells), std::mem::take(&mut owned_points));
        }
    }
    if !cells.is_empty() {
        post_cells(cx, cells, owned_points);
    }
}

/// Calls `f` with the cells that belong to a home point.
fn owned_cells<P: Point>(
    chart: Chart<'_, P>,
    cells_here: &OwnedCells,
    owned: u32,
    mut f: impl FnMut(&P::Cell),
) {
    let (positions, link) = (chart.table.positions.as_slice(), chart.stars.link(owned));
    // Most cells belong to another vertex. Merging has found which, of as many as there are bits.
    let (first, rest) = link.split_at(link.len().min(u64::BITS as usize));
    let known = ones(cells_here.facets[owned as usize]).map(|at| &first[at]);
    let looked = rest.iter().filter(|facet| look_at_facet(positions, owned, facet).is_owned());
    known.chain(looked).filter_map(|facet| finite_cell::<P>(owned, facet)).for_each(|cell| f(&cell));
}

fn post_cells<P: Point>(cx: &mut Context<P>, cells: Vec<u64>, leaves: Vec<u64>) {
    let body = Body::Cells { cells: Bulk(cells), leaves: Bulk(leaves) };
    cx.to_coordinator(body);
}

/// Sends the cells that belong to this rank, with their adjacency.
fn send_subdomain<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: Table<P>,
    mut stars: Stars<P>,
) {
    let (rows, open) = match stars.take_subdomain() {
        Some(piece) => piece.into_rows(),
        None => glued(Chart { table: &table, stars: &stars }),
    };
    let body = Body::Piece {
        leaf: subdomain.leaves.first().map_or(NodeId::ROOT, |l| l.id).0,
        ids: Bulk(table.ids),
        rows: Bulk(rows),
        open: Bulk(open),
    };
    cx.to_coordinator(body);
}

/// The same from stars that were written out: facets are matched. What has no partner here is marked as another
/// piece's, although it may be the hull's.
fn glued<P: Point>(chart: Chart<'_, P>) -> (Vec<u32>, Vec<u32>) {
    let Chart { table, stars } = chart;
    let mut cells = Vec::new();
    for owned in 0..table.owned {
        let own = stars.link(owned).iter().filter_map(|facet| finite_cell::<P>(owned, facet));
        own.filter(|cell| smallest_of(&table.positions, cell.as_ref().iter().copied()) == owned)
            .for_each(|c| cells.extend_from_slice(c.as_ref()));
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
    let mut neighbours = vec![SEAM; cells.len()];
    for pair in facets.chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, a), (_, b)] = pair {
            neighbours[a as usize] = b / corners as u32;
            neighbours[b as usize] = a / corners as u32;
        }
    }
    let across = || neighbours.chunks_exact(corners);
    let open = (0..).zip(across()).filter(|(_, across)| across.contains(&SEAM)).map(|(cell, _)| cell);
    let rows = cells.chunks_exact(corners).zip(across());
    (rows.flat_map(|(cell, across)| cell.iter().chain(across)).copied().collect(), open.collect())
}
