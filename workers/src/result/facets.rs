//! Pairs the facets between the cells of ranks.
//!
//! **Statement.** A facet of a triangulation belongs to two cells, or to one cell if it is on the hull. Two ranks have a
//! cell each of a facet between their subdomains, and both know its vertices. They send the facet to the rank that owns its
//! lexicographically smallest vertex. This rank receives both cells and tells each rank the cell on the other side. A
//! facet that arrives once is on the hull. A facet that arrives three times contradicts the certificate.
//!
//! **Rounds.** Two. **Work.** A sort of the facets that arrive.

use std::collections::BTreeMap;

use septet_geometry::point::{Array, Point};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Rank;
use septet_protocol::message::{Body, Message};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::share::{PieceRows, Seam};
use crate::state::cells::{first_coordinate, opposite, smallest_vertex};
use crate::state::rows::{AdjacencyRows, HULL, INTERFACE};
use crate::state::table::Table;

/// Facets for the rank that owns their smallest vertices.
#[derive(Default)]
struct Facets {
    /// `d` ids per facet, ascending.
    vertices: Vec<u64>,
    /// The entry of each facet in the rows of the sender.
    entries: Vec<u32>,
}

/// Replies to a rank: for each entry of its rows, the rank and the cell on the other side.
#[derive(Default)]
struct Across {
    entries: Vec<u32>,
    ranks: Vec<Rank>,
    cells: Vec<u32>,
}

/// A facet that arrived. Facets are ordered by their vertices.
struct Arrived<P: Point> {
    /// Ids of the vertices, ascending; the last one is 0 in the plane.
    vertices: P::Axes<u64>,
    from: Rank,
    /// The entry of the facet in the rows of the sender.
    entry: u32,
}

impl<P: Point> Arrived<P> {
    fn key(&self) -> (&[u64], Rank, u32) {
        (self.vertices.as_ref(), self.from, self.entry)
    }
}

/// Sends the facets whose other cell may be on another rank to the ranks that own their smallest vertices.
pub(super) fn send_facets<P: Point>(cx: &mut Context<P>, table: &Table<P>, rows: &AdjacencyRows) {
    let (corners, width) = (P::DIM + 1, 2 * (P::DIM + 1));
    let first = |v: u32| first_coordinate(table.positions(), v);
    let mut batches: BTreeMap<Rank, Facets> = BTreeMap::new();
    for &cell in rows.open() {
        let start = cell as usize * width;
        let (vertices, across) = rows.rows()[start..start + width].split_at(corners);
        for slot in (0..corners).filter(|&slot| (INTERFACE..HULL).contains(&across[slot])) {
            let facet = opposite::<P>(vertices, slot);
            let smallest = smallest_vertex(table.positions(), facet.as_ref(), first);
            let batch = batches.entry(table.owners()[smallest as usize]).or_default();
            let from = batch.vertices.len();
            batch.vertices.extend(facet.as_ref().iter().map(|&v| table.ids()[v as usize]));
            batch.vertices[from..].sort_unstable();
            batch.entries.push((start + corners + slot) as u32);
        }
    }
    let body =
        |Facets { vertices, entries }| Body::Facets { vertices: Bulk(vertices), entries: Bulk(entries) };
    cx.send_each(0, batches.into_iter().map(|(rank, facets)| (rank, body(facets))));
}

/// Pairs the facets of a round, and replies to their senders.
///
/// # Errors
/// Fails if three cells share a facet.
pub(super) fn pair_facets<P: Point>(cx: &mut Context<P>) -> Result<(), TransportError> {
    let batches = cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Facets { vertices, entries } => {
            Some((m.from, std::mem::take(&mut vertices.0), std::mem::take(&mut entries.0)))
        }
        _ => None,
    });
    let mut arrived: Vec<Arrived<P>> = Vec::new();
    for (from, ids, entries) in batches {
        arrived.extend(ids.chunks_exact(P::DIM).zip(entries).map(|(facet, entry)| {
            let vertices = P::Axes::from_fn(|i| facet.get(i).copied().unwrap_or(0));
            Arrived { vertices, from, entry }
        }));
    }
    arrived.sort_unstable_by(|a, b| a.key().cmp(&b.key()));
    let mut replies: BTreeMap<Rank, Across> = BTreeMap::new();
    let mut reply = |to: Rank, entry: u32, rank: Rank, cell: u32| {
        let across = replies.entry(to).or_default();
        across.entries.push(entry);
        across.ranks.push(rank);
        across.cells.push(cell);
    };
    let cell = |entry: u32| entry / (2 * (P::DIM as u32 + 1));
    for pair in arrived.chunk_by(|a, b| a.vertices.as_ref() == b.vertices.as_ref()) {
        match pair {
            &[Arrived { from, entry, .. }] => reply(from, entry, from, HULL),
            [a, b] => {
                reply(a.from, a.entry, b.from, cell(b.entry));
                reply(b.from, b.entry, a.from, cell(a.entry));
            }
            _ => {
                let reason = format!(
                    "{} cells share the facet {:?}",
                    pair.len(),
                    &pair[0].vertices.as_ref()[..P::DIM]
                );
                return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
            }
        }
    }
    let body = |Across { entries, ranks, cells }| Body::Across {
        entries: Bulk(entries),
        ranks: Bulk(ranks),
        cells: Bulk(cells),
    };
    cx.send_each(0, replies.into_iter().map(|(rank, across)| (rank, body(across))));
    Ok(())
}

/// Stores the neighbours that arrived in a round.
///
/// # Errors
/// Fails if a reply is for an entry that waits for none.
pub(super) fn store_neighbours<P: Point>(
    cx: &mut Context<P>,
    piece: &mut PieceRows,
) -> Result<(), TransportError> {
    let replies = cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Across { entries, ranks, cells } => {
            let [ranks, cells] = [ranks, cells].map(|column| std::mem::take(&mut column.0));
            Some((m.from, std::mem::take(&mut entries.0), ranks.into_iter().zip(cells)))
        }
        _ => None,
    });
    for (from, entries, across) in replies {
        for (entry, (rank, cell)) in entries.into_iter().zip(across) {
            let neighbour = piece.rows.get_mut(entry as usize).filter(|code| **code == INTERFACE);
            let neighbour = neighbour.ok_or_else(|| unasked(from))?;
            if cell == HULL {
                *neighbour = HULL;
                continue;
            }
            piece.seam.push(Seam { rank, cell });
            // The first position is 1: an entry of `INTERFACE` has no reply yet.
            *neighbour = INTERFACE + piece.seam.len() as u32;
        }
    }
    Ok(())
}

fn unasked(from: Rank) -> TransportError {
    let reason = "it replies for a facet that was not sent".to_string();
    TransportError::BadMessage { from, reason }
}

/// Counts the facets of a piece on the hull.
///
/// # Errors
/// Fails if a facet has no neighbour and is not on the hull.
pub(super) fn count_hull<P: Point>(cx: &Context<P>, piece: &mut PieceRows) -> Result<(), TransportError> {
    let (corners, width) = (P::DIM + 1, 2 * (P::DIM + 1));
    let across = |&cell: &u32| &piece.rows[cell as usize * width + corners..(cell as usize + 1) * width];
    let codes = || piece.open.iter().flat_map(across);
    if codes().any(|&code| code == INTERFACE) {
        let reason = "a facet has no neighbour and is not on the hull".to_string();
        return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
    }
    piece.hull_facets = codes().filter(|&&code| code == HULL).count() as u64;
    Ok(())
}
