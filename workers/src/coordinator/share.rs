//! The result of a run, as the coordinator collects it.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Rank;
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::{Body, Merged, Message, ViewPart};
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;

/// The part of a triangulation that one worker sends.
#[derive(Clone, Debug)]
pub struct PieceRows {
    /// The worker.
    pub owner: Rank,
    /// The node of the tree that the worker holds.
    pub leaf: u64,
    /// Input indices of the vertices.
    pub ids: Vec<u64>,
    /// For each cell its vertices, as positions in `ids`, then its neighbours.
    pub rows: Vec<u32>,
    /// The cells that have a facet without a neighbour in this part.
    pub open: Vec<u32>,
}

/// The points that one worker owns.
#[derive(Clone, Debug)]
pub struct OwnedPoints {
    /// The worker.
    pub owner: Rank,
    /// Their input indices.
    pub ids: Vec<u64>,
}

/// Cells as rows of input indices.
#[derive(Clone, Debug, Default)]
pub struct CellRows {
    /// The rows, in the parts in which they arrived.
    pub parts: Vec<Vec<u64>>,
    /// The worker of each cell, if the workers send leaves.
    pub owners: Vec<Rank>,
    /// The node of each cell's leaf, if the workers send leaves.
    pub leaves: Vec<u64>,
}

/// A maximal independent set.
#[derive(Clone, Debug, Default)]
pub struct Selected {
    /// The members, in the order of arrival.
    pub members: Vec<u64>,
    /// Points undecided at the start of each round of local priorities.
    pub undecided: Vec<u64>,
}

/// The counts of the machine.
#[derive(Clone, Debug, Default)]
pub struct MachineCounts {
    /// The ledgers of all ranks.
    pub ledger: LedgerPart,
    /// Number of ranks whose ledgers have arrived.
    pub parts: u32,
}

/// The last certificate.
#[derive(Clone, Debug, Default)]
pub struct Certificate {
    /// The merged result of all workers. Its rounds of exchange are the sum over all passes.
    pub merged: Merged,
    /// The reason why stars were gathered, and the largest number of gathered points, if there was a gathering.
    pub fallback: Option<(String, u64)>,
}

impl Certificate {
    pub(crate) fn add(&mut self, merged: Merged) {
        let exchange_rounds = self.merged.exchange_rounds + merged.exchange_rounds;
        self.merged = Merged { exchange_rounds, ..merged };
    }

    pub(crate) fn note_gathered(&mut self, reason: &str, points: u64) {
        let before = self.fallback.as_ref().map_or(0, |(_, most)| *most);
        self.fallback = Some((reason.to_string(), points.max(before)));
    }
}

/// The supergraph of the run.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// The supergraph, if there is one.
    pub supergraph: Option<Supergraph>,
    /// The reason for the choice, if the coordinator chose the supergraph.
    pub why: Option<String>,
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Share<P> {
    /// Parts of a triangulation, in the order of arrival.
    pub pieces: Vec<PieceRows>,
    /// Cells of stars.
    pub cells: CellRows,
    /// The points of each worker, if the workers send them, in the order of arrival.
    pub owned: Vec<OwnedPoints>,
    /// Edges of the supergraph as pairs of input indices, if the workers send them.
    pub edges: Vec<u64>,
    /// Node and id of each member of the sets in which all pairs were compared, if the workers send them.
    pub sets: Vec<[u64; 2]>,
    /// The independent set, if the task asks for one.
    pub selected: Selected,
    /// The counts.
    pub counted: MachineCounts,
    /// The workers' parts of the picture, in the order of arrival.
    pub views: Vec<ViewPart<P>>,
    /// The certificate.
    pub certified: Certificate,
    /// The supergraph.
    pub choice: Choice,
}

impl<P> Default for Share<P> {
    fn default() -> Self {
        Share {
            pieces: Vec::new(),
            cells: CellRows::default(),
            owned: Vec::new(),
            edges: Vec::new(),
            sets: Vec::new(),
            selected: Selected::default(),
            counted: MachineCounts::default(),
            views: Vec::new(),
            certified: Certificate::default(),
            choice: Choice::default(),
        }
    }
}

/// Returns `true` if the message is part of a result and, for a view, if its arrays fit together.
fn is_result<P: Point>(message: &Message<P>) -> bool {
    match &message.body {
        Body::View(part) => part.is_consistent(),
        Body::Cells { .. }
        | Body::Piece { .. }
        | Body::Owned(_)
        | Body::Selected { .. }
        | Body::Ledger(_) => true,
        _ => false,
    }
}

impl<P: Point> Share<P> {
    /// Takes the results of a round.
    ///
    /// # Errors
    /// Fails if a ledger does not decode.
    pub(crate) fn receive(&mut self, cx: &mut Context<P>) -> Result<(), TransportError> {
        let with_leaves = cx.config().shown.with_leaves;
        let results = cx.take(|m| {
            is_result(m).then(|| (m.from, std::mem::replace(&mut m.body, Body::Outcome(Outcome::default()))))
        });
        for (from, body) in results {
            self.add(from, body, with_leaves)?;
        }
        Ok(())
    }

    fn add(&mut self, from: Rank, body: Body<P>, with_leaves: bool) -> Result<(), TransportError> {
        match body {
            Body::Cells { cells: Bulk(rows), mut leaves } => {
                if with_leaves {
                    self.cells.owners.extend(std::iter::repeat_n(from, rows.len() / (P::DIM + 1)));
                    self.cells.leaves.append(&mut leaves);
                }
                self.cells.parts.push(rows);
            }
            Body::Piece { leaf, ids: Bulk(ids), rows: Bulk(rows), open: Bulk(open) } => {
                self.pieces.push(PieceRows { owner: from, leaf, ids, rows, open });
            }
            Body::Owned(Bulk(ids)) => self.owned.push(OwnedPoints { owner: from, ids }),
            Body::Selected { mut members, undecided } => {
                self.selected.members.append(&mut members);
                let sums = &mut self.selected.undecided;
                sums.resize(sums.len().max(undecided.len()), 0);
                sums.iter_mut().zip(&undecided.0).for_each(|(sum, count)| *sum += count);
            }
            Body::View(part) => self.views.push(*part),
            Body::Ledger(words) => {
                let corrupt = || TransportError::BadMessage { from, reason: "corrupt ledger".to_string() };
                self.counted.ledger.merge(&LedgerPart::from_words(&words).ok_or_else(corrupt)?);
                self.counted.parts += 1;
            }
            _ => {}
        }
        Ok(())
    }
}
