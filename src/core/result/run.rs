//! The result of a run.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use serde::Serialize;

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;
use septet_protocol::tasks::TaskLog;

use crate::model::MeshView;
use crate::result::canonical::{Cells, Given};
use crate::result::pieces::Pieces;
use crate::result::refutation::Refutation;
use crate::result::view::View;

/// What became of every input point.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Accounting {
    /// Points given.
    pub input: u64,
    /// Vertices of the triangulation.
    pub used: u64,
    /// Coincident points: index, and the index that stands for it.
    pub duplicates: Vec<(u64, u64)>,
    /// Indices of points dropped because they were not finite.
    pub refused: Vec<u64>,
}

/// The parameters that a run settled on.
#[derive(Clone, Debug)]
pub struct Settled {
    /// Number of workers.
    pub workers: u32,
    /// Largest leaf.
    pub leaf: u64,
    /// The supergraph, if there was one to build.
    pub supergraph: Option<Supergraph>,
    /// Why this one.
    pub why: String,
    /// Did the run split to the floor and count work and depth?
    pub counted: bool,
}

/// What a machine sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Traffic {
    /// Rounds in which something was sent.
    pub rounds: u64,
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

impl Traffic {
    /// The totals of a ledger.
    pub fn of(ledger: &Ledger) -> Self {
        ledger.phases.iter().fold(Traffic::default(), |sum, phase| Traffic {
            rounds: sum.rounds + phase.rounds,
            messages: sum.messages + phase.messages,
            bytes: sum.bytes + phase.bytes,
        })
    }
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Run {
    /// 2 or 3: that of the points' type.
    pub space: usize,
    /// Dimension of the points' affine hull, -1 for no points. Below `space` there are no cells.
    pub dimension: isize,
    /// What became of every point.
    pub points: Accounting,
    /// The cells, as the workers made them.
    pub(crate) store: Store,
    /// The cells of pieces as they are exported: made when first asked for.
    pub(crate) canonical: OnceLock<Cells>,
    /// Edges of the supergraph as pairs of input indices, smaller first, sorted, if kept.
    pub graph: Option<Vec<(u64, u64)>>,
    /// Number of facets of the convex hull.
    pub hull_facets: u64,
    /// Unchanged stars whose circumspheres all lie in the ball of radius `alpha r` (`r_k` for nearest
    /// neighbours) around their vertex: a search of that ball alone would prove them.
    pub stars_local: u64,
    /// Stars that the exchange changed.
    pub stars_repaired: u64,
    /// Rounds of exchange.
    pub exchange_rounds: u64,
    /// Why and how many points were gathered, if the exchange was cut short.
    pub fallback: Option<(String, u64)>,
    /// The counts.
    pub ledger: Ledger,
    /// What it took to count the leaves before, for [`crate::config::Workers::Leaves`]; not part of the ledger.
    pub plan: Option<Traffic>,
    /// What is wrong with the stars: nothing, in a run that is no part of an error.
    pub refutation: Option<Refutation>,
    /// Sampled points and the tree, for pictures, if asked for.
    pub picture: Option<View>,
    /// What was run.
    pub settled: Settled,
    /// What leaves had to say to each other, if recorded.
    pub tasks: Option<TaskLog>,
    /// Measured wall-clock seconds of each phase that occurred, in order.
    pub phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds from points in memory to the certified triangulation in memory, canonical order not
    /// included: after [`crate::triangulate`] its pieces with all adjacency, after [`crate::simulate`] the stars on the workers.
    pub triangulate_seconds: f64,
    /// Measured seconds of the whole call.
    pub total_seconds: f64,
}

/// Cells before they are exported.
#[derive(Clone, Debug)]
pub(crate) enum Store {
    /// Rows of input indices.
    Rows(Given),
    /// Pieces, with the owner of each cell to be exported or not.
    Pieces(Pieces, bool),
}

impl Run {
    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        match &self.store {
            Store::Rows(given) => given.len(),
            Store::Pieces(pieces, _) => pieces.len(),
        }
    }

    /// The cells with their adjacency, as [`crate::triangulate`] leaves them in memory. None after [`crate::simulate`].
    pub fn pieces(&self) -> Option<&Pieces> {
        match &self.store {
            Store::Rows(_) => None,
            Store::Pieces(pieces, _) => Some(pieces),
        }
    }

    /// Cells in canonical order: `space + 1` input indices a row. The first call sorts them and keeps them: after
    /// [`crate::triangulate`] 32 bytes a tetrahedron beside the pieces.
    pub fn cells(&self) -> &[u64] {
        &self.exported().rows
    }

    /// Worker of each cell in canonical order, if kept.
    pub fn owner(&self) -> Option<&[u32]> {
        self.exported().owner.as_deref()
    }

    /// Home leaf of each cell in canonical order, if kept.
    pub fn home_leaf(&self) -> Option<&[u64]> {
        self.exported().leaf.as_deref()
    }

    fn exported(&self) -> &Cells {
        match &self.store {
            Store::Rows(given) => given.sorted(),
            Store::Pieces(pieces, with_owner) => self.canonical.get_or_init(|| match self.space {
                2 => pieces.canonical::<DVec2>(*with_owner),
                _ => pieces.canonical::<DVec3>(*with_owner),
            }),
        }
    }

    /// The triangulation over the coordinates it was made from, as files see it.
    pub fn view<'a>(&'a self, coordinates: &'a [f64]) -> MeshView<'a> {
        MeshView {
            dimension: self.space,
            coordinates,
            cells: self.cells(),
            owner: self.owner(),
            home_leaf: self.home_leaf(),
            labels: None,
        }
    }
}
