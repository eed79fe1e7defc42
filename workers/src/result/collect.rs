//! Builds the share of a rank: its cells, its data for pictures and its ledger. The share stays with the rank.
//!
//! **Rounds.** Two if the cells get neighbours, for the facets between pieces (`result::facets`), and those of the totals
//! (`result::totals`).

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::result::certified::Certified;
use crate::result::facets::{count_hull, pair_facets, send_facets, store_neighbours};
use crate::result::merge::{OwnedCells, Results, classify};
use crate::result::totals::totals;
use crate::result::view::view_part;
use crate::share::{PieceRows, Places, Share};
use crate::stars::owned::{Stars, StarsView};
use crate::state::bits::ones;
use crate::state::cells::{finite_cell, opposite};
use crate::state::ghosts::Ghosts;
use crate::state::rows::{AdjacencyRows, INTERFACE};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::Leaf;

/// Adds the ledger to the share.
pub(crate) async fn collect_counts<P: Point>(
    cx: &mut Context<P>,
    share: Share<P>,
) -> Result<Share<P>, TransportError> {
    cx.enter(Phase::Collect)?;
    collect(cx, share).await
}

/// Adds the cells and the data for pictures to the share, if the certificate passed. Then adds the ledger.
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
    let instance = certified.instance();
    if certified.has_passed() {
        if cx.config().shown.view > 0 {
            add_picture_data(&mut table, &mut stars);
            let results = Results::new(subdomain, StarsView::new(&table, &stars), instance);
            share.view = Some(view_part(cx, results, ghosts, instance.population.count));
        }
        if table.owned_len() > 0 {
            share.piece = piece(cx, subdomain, table, stars, certified.owned_cells());
        }
        if cx.config().has_neighbours() {
            pair(cx, &mut share.piece).await?;
        }
    }
    share.certified = certified.into_certificate();
    collect(cx, share).await
}

/// Pairs the facets between pieces.
async fn pair<P: Point>(cx: &mut Context<P>, piece: &mut PieceRows) -> Result<(), TransportError> {
    while cx.exchange().await? {
        pair_facets(cx)?;
        store_neighbours(cx, piece)?;
    }
    // The last exchange delivered no message, so the ranks begin a second pass of the phase.
    cx.enter(Phase::Collect)?;
    count_hull(cx, piece)
}

/// Ends the run of a rank: adds the totals of all ranks and the ledger to the share, and files the record of charges.
async fn collect<P: Point>(cx: &mut Context<P>, mut share: Share<P>) -> Result<Share<P>, TransportError> {
    let (all, sites) = totals(cx, &share).await?;
    (*share.certified.totals, share.certified.sites) = (all, sites);
    if let Some(fault) = cx.config().fault {
        fault.distort_worker(cx.ledger_mut());
    }
    cx.file_charges();
    share.ledger.part = cx.take_ledger();
    cx.enter(Phase::Done)?;
    Ok(share)
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

/// Returns the cells that belong to this rank. If they get neighbours, sends the facets that other ranks may share.
fn piece<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: Table<P>,
    mut stars: Stars<P>,
    owned_cells: &OwnedCells,
) -> PieceRows {
    let has_neighbours = cx.config().has_neighbours();
    let hidden = stars.hidden().into_iter().map(|v| table.ids()[v as usize]).collect();
    let (cells, leaves) = if let Some(triangulation) = stars.take_triangulation() {
        let leaf = subdomain.leaves().first().map_or(NodeId::ROOT, Leaf::id);
        (triangulation.into_rows(), vec![(leaf, owned_cells.count())])
    } else {
        let (cells, leaves) = cells_of_stars(StarsView::new(&table, &stars), subdomain, owned_cells);
        drop(stars);
        let rows = if has_neighbours { matched::<P>(&cells) } else { AdjacencyRows::new(cells, Vec::new()) };
        (rows, leaves)
    };
    if has_neighbours {
        send_facets(cx, &table, &cells);
    }
    let (rows, open) = cells.into_parts();
    let places = if cx.config().shown.with_places { places(&table) } else { Places::default() };
    let owned = table.owned_len() as usize;
    PieceRows {
        ids: table.into_ids(),
        owned,
        leaves,
        has_neighbours,
        rows,
        open,
        places,
        hidden,
        ..PieceRows::default()
    }
}

/// Returns the places of all points of a rank.
fn places<P: Point>(table: &Table<P>) -> Places {
    let coordinates = bytemuck::cast_slice(table.positions()).to_vec();
    Places { coordinates, owners: table.owners().to_vec() }
}

/// Returns the vertices of the cells that belong to owned points, and the leaves with the number of cells of each.
fn cells_of_stars<P: Point>(
    view: StarsView<'_, P>,
    subdomain: &Subdomain<P>,
    owned_cells: &OwnedCells,
) -> (Vec<u32>, Vec<(NodeId, u64)>) {
    let corners = P::DIM + 1;
    let mut cells = Vec::with_capacity(owned_cells.count() as usize * corners);
    let mut leaves = Vec::with_capacity(subdomain.leaves().len());
    for leaf in subdomain.leaves() {
        let before = cells.len();
        for vertex in leaf.owned() {
            each_owned_cell(view, owned_cells, vertex, |cell| cells.extend_from_slice(cell.as_ref()));
        }
        leaves.push((leaf.id(), ((cells.len() - before) / corners) as u64));
    }
    (cells, leaves)
}

/// Adds their neighbours to cells, by matching their facets. A facet without a match gets the entry [`INTERFACE`], although
/// it may be on the hull.
fn matched<P: Point>(cells: &[u32]) -> AdjacencyRows {
    let corners = P::DIM + 1;
    let mut facets: Vec<(P::Facet, u32)> = (0..cells.len())
        .map(|entry| {
            let cell = &cells[entry / corners * corners..][..corners];
            let mut facet = opposite::<P>(cell, entry % corners);
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
