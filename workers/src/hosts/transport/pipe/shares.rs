//! The frames before the first round and after the last: the block of a worker, and its share.

use std::sync::{Mutex, PoisonError};

use septet_geometry::point::Point;
use septet_protocol::codec::{self, Bulk, CodecError, FRAME_LIMIT};
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::{Totals, ViewPart};

use crate::hosts::host::Job;
use crate::input::{Loaded, Rows, Source};
use crate::partition::leader::Plan;
use crate::share::{CellRows, Certificate, PieceRows, Places, RankLedger, Seam, Selected, Share};

/// The input that the coordinator assigns to a worker: its block, and the plan of the placement.
pub(super) struct Assigned<P> {
    /// The rows, until the worker has taken them.
    rows: Mutex<Rows<P>>,
    plan: Plan,
}

impl<P: Point> Assigned<P> {
    /// Returns the input of a worker.
    pub(super) fn of(job: &Job<'_, P>, rank: Rank) -> Self {
        let rows = Mutex::new(job.source.block(rank - 1, job.config.workers));
        Assigned { rows, plan: job.plan.clone() }
    }

    /// Returns the plan of the placement.
    pub(super) fn plan(&self) -> &Plan {
        &self.plan
    }

    pub(super) fn to_bytes(&self) -> Result<Vec<u8>, CodecError> {
        let (nodes, leaves): (Vec<u64>, Vec<u32>) = self.plan.iter().map(|(node, l)| (node.0, *l)).unzip();
        let Rows { first, positions, sizes } = self.take();
        within_limit(codec::encode(&(first, Bulk(positions), Bulk(sizes), Bulk(nodes), Bulk(leaves)))?)
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, CodecError> {
        let (first, positions, sizes, nodes, leaves): AssignedFrame<P> = codec::decode(bytes)?;
        let plan = nodes.0.into_iter().map(NodeId).zip(leaves.0).collect();
        Ok(Assigned { rows: Mutex::new(Rows { first, positions: positions.0, sizes: sizes.0 }), plan })
    }

    fn take(&self) -> Rows<P> {
        std::mem::take(&mut self.rows.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The input of a worker as it travels: the first row, coordinates and sizes, then nodes and leaves of the plan.
type AssignedFrame<P> = (u64, Bulk<P>, Bulk<f64>, Bulk<u64>, Bulk<u32>);

/// The source of a worker's process. It has the block of its rank only, which the rank takes once.
impl<P: Point> Source<P> for Assigned<P> {
    fn block(&self, _: u32, _: u32) -> Rows<P> {
        self.take()
    }
}

/// Returns the bytes of a frame, unless there are too many.
fn within_limit(bytes: Vec<u8>) -> Result<Vec<u8>, CodecError> {
    if bytes.len() > FRAME_LIMIT { Err(CodecError::TooLong { bytes: bytes.len() }) } else { Ok(bytes) }
}

/// Places as they travel: coordinates and owners.
type PlacesFrame = (Bulk<f64>, Bulk<Rank>);

/// A piece as it travels: its leaf and hull facets, ids, rows, open cells, ranks and cells of other pieces, and places.
type PieceFrame = ((u64, u64), Bulk<u64>, Bulk<u32>, Bulk<u32>, (Bulk<Rank>, Bulk<u32>), PlacesFrame);

/// Cells as they travel: rows, leaves, ids and places.
type CellsFrame = (Bulk<u64>, Bulk<u64>, Bulk<u64>, PlacesFrame);

/// A share as it travels: the ledger, the owned points, the piece, the cells, edges, sets, members and undecided points,
/// the view, the refused and repeated rows, the totals, and the root of the rank's subtree.
type ShareFrame<P> = (
    Bulk<u64>,
    Bulk<u64>,
    Option<PieceFrame>,
    CellsFrame,
    Bulk<u64>,
    Bulk<[u64; 2]>,
    (Bulk<u64>, Bulk<u64>),
    Option<ViewPart<P>>,
    (Bulk<u64>, Bulk<[u64; 2]>, Totals, Option<NodeId>),
);

/// Encodes the share of a worker.
pub(super) fn share_to_bytes<P: Point>(share: &Share<P>) -> Result<Vec<u8>, CodecError> {
    let bulk = |words: &Vec<u64>| Bulk(words.clone());
    let piece = share.piece.as_ref().map(|p| {
        let (ranks, cells): (Vec<Rank>, Vec<u32>) = p.seam.iter().map(|seam| (seam.rank, seam.cell)).unzip();
        let counts = (p.leaf, p.hull_facets);
        let seam = (Bulk(ranks), Bulk(cells));
        (counts, bulk(&p.ids), Bulk(p.rows.clone()), Bulk(p.open.clone()), seam, places_frame(&p.places))
    });
    let CellRows { rows, leaves, ids, places } = &share.cells;
    let frame: ShareFrame<P> = (
        Bulk(share.ledger.part.to_words()),
        bulk(&share.owned),
        piece,
        (bulk(rows), bulk(leaves), bulk(ids), places_frame(places)),
        bulk(&share.edges),
        Bulk(share.sets.clone()),
        (bulk(&share.selected.members), bulk(&share.selected.undecided)),
        share.view.clone(),
        (
            bulk(&share.loaded.refused),
            Bulk(share.loaded.repeated.clone()),
            *share.certified.totals,
            share.ledger.root,
        ),
    );
    within_limit(codec::encode(&frame)?)
}

fn places_frame(Places { coordinates, owners }: &Places) -> PlacesFrame {
    (Bulk(coordinates.clone()), Bulk(owners.clone()))
}

fn places_of((coordinates, owners): PlacesFrame) -> Places {
    Places { coordinates: coordinates.0, owners: owners.0 }
}

/// Decodes the share of a worker.
pub(super) fn share_from_bytes<P: Point>(rank: Rank, bytes: &[u8]) -> Result<Share<P>, CodecError> {
    let (words, owned, piece, cells, edges, sets, selected, view, end): ShareFrame<P> = codec::decode(bytes)?;
    let ledger = LedgerPart::from_words(&words).ok_or(CodecError::Corrupt { what: "the ledger" })?;
    let piece = piece.map(|((leaf, hull_facets), ids, rows, open, (ranks, cells), places)| {
        let seam = ranks.0.into_iter().zip(cells.0).map(|(rank, cell)| Seam { rank, cell });
        let (seam, places) = (seam.collect(), places_of(places));
        PieceRows { leaf, ids: ids.0, rows: rows.0, open: open.0, seam, hull_facets, places }
    });
    let (rows, leaves, ids, places) = cells;
    let cells = CellRows { rows: rows.0, leaves: leaves.0, ids: ids.0, places: places_of(places) };
    for (what, fits) in [
        ("the picture", view.as_ref().is_none_or(ViewPart::is_consistent)),
        ("the graph", edges.len() % 2 == 0),
        (
            "the list of leaves",
            cells.leaves.is_empty() || cells.leaves.len() * (P::DIM + 1) == cells.rows.len(),
        ),
    ] {
        if !fits {
            return Err(CodecError::Corrupt { what });
        }
    }
    let (refused, repeated, totals, root) = end;
    if root == Some(NodeId(0)) {
        return Err(CodecError::Corrupt { what: "the root of the subtree" });
    }
    let loaded = Loaded { refused: refused.0, repeated: repeated.0, ..Loaded::default() };
    Ok(Share {
        loaded,
        owned: owned.0,
        piece,
        cells,
        edges: edges.0,
        sets: sets.0,
        selected: Selected { members: selected.0.0, undecided: selected.1.0 },
        view,
        ledger: Box::new(RankLedger { part: ledger, root }),
        certified: Certificate { totals: Box::new(totals), fallback: None },
        ..Share::new(rank)
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn shares_travel_whole() {
        let share = Share::<DVec2> {
            piece: Some(PieceRows {
                leaf: 5,
                ids: vec![1 << 40],
                rows: vec![7, 8],
                open: vec![0],
                seam: vec![Seam { rank: 2, cell: 9 }],
                hull_facets: 3,
                places: Places { coordinates: vec![0.5, 0.25], owners: vec![3] },
            }),
            certified: Certificate {
                totals: Box::new(Totals { cells: 4, cell_hash: 1 << 63, ..Totals::default() }),
                fallback: None,
            },
            cells: CellRows {
                rows: vec![1, 2, 3],
                leaves: vec![9],
                ids: vec![1, 2, 3],
                places: Places { coordinates: vec![0.5; 6], owners: vec![3, 3, 1] },
            },
            loaded: Loaded { refused: vec![4], repeated: vec![[6, 5]], ..Loaded::default() },
            owned: vec![2],
            edges: vec![4, 5],
            sets: vec![[6, 7]],
            selected: Selected { members: vec![8], undecided: vec![2, 1] },
            view: Some(ViewPart::default()),
            ledger: Box::new(RankLedger { root: Some(NodeId(5)), ..RankLedger::default() }),
            ..Share::new(3)
        };
        let bytes = share_to_bytes(&share).unwrap();
        assert_eq!(share_from_bytes::<DVec2>(3, &bytes).unwrap(), share);
        assert!(share_from_bytes::<DVec2>(3, &bytes[1..]).is_err());
        let spoilt: [fn(&mut Share<DVec2>); 4] = [
            |share| share.ledger.root = Some(NodeId(0)),
            |share| share.edges.push(6),
            |share| share.cells.leaves.push(9),
            |share| share.view.as_mut().unwrap().leaves.push(1),
        ];
        for spoil in spoilt {
            let mut other = share.clone();
            spoil(&mut other);
            let bytes = share_to_bytes(&other).unwrap();
            assert!(share_from_bytes::<DVec2>(3, &bytes).is_err(), "{other:?}");
        }
    }
}
