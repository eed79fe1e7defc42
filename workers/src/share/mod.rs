//! The results of a run, which stay with the ranks.

use septet_geometry::evaluation::Evaluated;
use septet_geometry::graph::Supergraph;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::{Merged, SiteTotals, Totals, ViewPart};

use crate::config::Fault;
use crate::input::Loaded;

/// The cells of a rank. A cell belongs to the rank that owns its lexicographically smallest vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PieceRows {
    /// Input indices of the points of the rank, then of other points, the other vertices of its cells among them.
    pub ids: Vec<u64>,
    /// Number of points of the rank.
    pub owned: usize,
    /// The leaves of the tree that the rank holds, with the number of cells of each. The cells of a leaf are consecutive.
    pub leaves: Vec<(NodeId, u64)>,
    /// Whether the cells have neighbours.
    pub has_neighbours: bool,
    /// For each cell its vertices, as positions in `ids`, positively oriented, then its neighbours, if it has any. The
    /// neighbour opposite a vertex is a cell of this piece, or [`HULL`](crate::state::rows::HULL), or
    /// [`INTERFACE`](crate::state::rows::INTERFACE) plus one plus a position in `seam`.
    pub rows: Vec<u32>,
    /// The cells with a facet on the hull or to another piece, ascending.
    pub open: Vec<u32>,
    /// The neighbours in other pieces.
    pub seam: Vec<Seam>,
    /// Number of facets on the hull, if the cells have neighbours.
    pub hull_facets: u64,
    /// The places of the points, if the run keeps them.
    pub places: Places,
    /// Input indices of the points of the rank that are hidden: strictly above the lower hull, under no site at the same
    /// position.
    pub hidden: Vec<u64>,
}

impl PieceRows {
    /// Returns the number of entries of a row, for cells of `corners` vertices.
    pub fn width(&self, corners: usize) -> usize {
        if self.has_neighbours { 2 * corners } else { corners }
    }
}

/// The places of the points of a piece.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places {
    /// Coordinates on the machine, `d` per point.
    pub coordinates: Vec<f64>,
    /// The rank that owns each point.
    pub owners: Vec<Rank>,
}

/// A cell of another rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seam {
    /// The rank.
    pub rank: Rank,
    /// The cell of its piece.
    pub cell: u32,
}

/// A share of a maximal independent set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selected {
    /// Input indices of the members that joined.
    pub members: Vec<u64>,
    /// Number of undecided owned points at the start of each round, up to the last round with an undecided point.
    pub undecided: Vec<u64>,
}

/// The last certificate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Certificate {
    /// The totals of all ranks. Rounds of exchange in the merged result are the sum over all passes. Before the end of a
    /// run, only the coordinator has the merged result, and the other totals are zero.
    pub totals: Box<Totals>,
    /// Hidden sites of all ranks that are under no site at the same position, at the end of a run. The default without
    /// weights.
    pub sites: SiteTotals,
    /// The reason why stars were gathered, and the largest number of gathered points, if there was a gathering.
    pub fallback: Option<(String, u64)>,
}

impl Certificate {
    pub(crate) fn add(&mut self, merged: Merged) {
        let exchange_rounds = self.totals.merged.exchange_rounds + merged.exchange_rounds;
        self.totals.merged = Merged { exchange_rounds, ..merged };
    }

    pub(crate) fn note_gathered(&mut self, reason: &str, points: u64) {
        let before = self.fallback.as_ref().map_or(0, |(_, most)| *most);
        self.fallback = Some((reason.to_string(), points.max(before)));
    }
}

/// The supergraph of the run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// The supergraph, if there is one.
    pub supergraph: Option<Supergraph>,
    /// The reason for the choice, if the coordinator chose the supergraph.
    pub why: Option<String>,
}

/// The ledger of a rank.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RankLedger {
    /// The counts.
    pub part: LedgerPart,
    /// The root of the subtree of the partition tree that only this rank charges, if there is one.
    pub root: Option<NodeId>,
}

/// The results that a rank has at the end of a run. They stay with the rank. Only the coordinator has the reasons in the
/// certificate and in the choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Share<P> {
    /// The rank.
    pub rank: Rank,
    /// The input.
    pub loaded: Loaded,
    /// The points and the cells of the rank, if the certificate passed.
    pub piece: PieceRows,
    /// The edges of the supergraph that count at an owned point, as pairs of input indices, if the run keeps them.
    pub edges: Vec<u64>,
    /// Input index and squared radius of the ball of each owned point, if the run ends with the balls and keeps them.
    pub radii2: Vec<(u64, f64)>,
    /// Node and input index of each member of the sets in which the rank compared all pairs, if the run keeps them.
    pub sets: Vec<[u64; 2]>,
    /// The share of the independent set, if the task asks for one.
    pub selected: Selected,
    /// The results of the items that the rank evaluated, if the task is an evaluation.
    pub evaluated: Evaluated,
    /// The part of the picture, if the run has one.
    pub view: Option<ViewPart<P>>,
    /// The ledger of the rank.
    pub ledger: Box<RankLedger>,
    /// The certificate.
    pub certified: Certificate,
    /// The supergraph.
    pub choice: Choice,
}

impl<P> Share<P> {
    /// Creates the share of a rank without results.
    pub fn new(rank: Rank) -> Self {
        Share {
            rank,
            loaded: Loaded::default(),
            piece: PieceRows::default(),
            edges: Vec::new(),
            radii2: Vec::new(),
            sets: Vec::new(),
            selected: Selected::default(),
            evaluated: Evaluated::default(),
            view: None,
            ledger: Box::default(),
            certified: Certificate::default(),
            choice: Choice::default(),
        }
    }
}

/// Merges the ledgers of all ranks. A fault of charges changes the merged ledger.
pub fn merged_ledger<'a>(
    ledgers: impl IntoIterator<Item = &'a LedgerPart>,
    fault: Option<Fault>,
) -> LedgerPart {
    let mut all = LedgerPart::default();
    for ledger in ledgers {
        all.merge(ledger);
    }
    distort(&mut all, fault);
    all
}

/// Changes the merged ledger, if the fault is a fault of charges.
pub fn distort(all: &mut LedgerPart, fault: Option<Fault>) {
    if let Some(fault) = fault {
        fault.distort(all);
    }
}
