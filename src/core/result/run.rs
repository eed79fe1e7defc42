//! The result of a run.

use serde::Serialize;

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;

use crate::model::{MeshView, Shares};
use crate::result::canonical::{Export, OwnedRows, Store};
use crate::result::cost_trace::CostTrace;
use crate::result::pieces::Pieces;
use crate::result::refutation::Refutation;
use crate::result::view::View;

/// The input points by their use: vertices, duplicates and dropped points.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Accounting {
    /// Number of input points.
    pub input: u64,
    /// Number of vertices of the triangulation.
    pub used: u64,
    /// Coincident points: the index of each, and the smallest index with the same coordinates.
    pub duplicates: Vec<(u64, u64)>,
    /// Indices of points that were dropped because they were not finite.
    pub refused: Vec<u64>,
}

/// The parameters that a run used.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Settled {
    /// Number of workers.
    pub workers: u32,
    /// Largest leaf of the partition tree, in points.
    pub leaf: u64,
    /// Largest expected number of samples of a draw. Balanced separators have other numbers of samples and circles.
    pub samples: u64,
    /// Number of great circles of a draw.
    pub tries: u32,
    /// The supergraph, if the run built one.
    pub supergraph: Option<Supergraph>,
    /// The reason for choosing this supergraph.
    pub why: String,
    /// Whether the run split down to the leaf size and counted work and depth.
    pub counted: bool,
}

/// The traffic of a whole machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TrafficTotal {
    /// Number of rounds in which messages were sent.
    pub rounds: u64,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
}

impl TrafficTotal {
    /// Sums the traffic of all phases of a ledger.
    pub fn of(ledger: &Ledger) -> Self {
        ledger.phases.iter().fold(TrafficTotal::default(), |sum, phase| TrafficTotal {
            rounds: sum.rounds + phase.rounds,
            messages: sum.messages + phase.messages,
            bytes: sum.bytes + phase.bytes,
        })
    }
}

/// A member of a set in which all pairs were compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SetMember {
    /// Path number of the node of the set: a leaf, or a node whose set was not divided further.
    pub node: u64,
    /// Index of the point in the input.
    pub point: u64,
}

/// The result of a run.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Run {
    /// Number of coordinates: 2 or 3.
    pub space: usize,
    /// Dimension of the affine hull of the points; -1 for no points. If it is less than `space`, there are no cells.
    pub dimension: isize,
    /// The input points by their use.
    pub points: Accounting,
    /// The cells.
    pub(crate) export: Export,
    /// The worker that holds each input point, if kept; 0 for a point that is not a vertex.
    pub(crate) point_owner: Option<Vec<u32>>,
    /// Edges of the supergraph, if kept: pairs of input indices, smaller first, sorted.
    pub graph: Option<Vec<(u64, u64)>>,
    /// The members of the sets in which all pairs were compared, if kept, in order.
    pub sets: Option<Vec<SetMember>>,
    /// Number of facets of the convex hull.
    pub hull_facets: u64,
    /// Number of unchanged stars whose circumspheres all lie in the ball of radius `alpha r` (`r_k` for nearest
    /// neighbours) around the vertex. A search of this ball would prove such a star.
    pub stars_local: u64,
    /// Number of stars that splaying changed.
    pub stars_repaired: u64,
    /// Number of rounds of splaying.
    pub exchange_rounds: u64,
    /// The reason why splaying was cut short, and the number of points that were then gathered.
    pub fallback: Option<(String, u64)>,
    /// The counts.
    pub ledger: Ledger,
    /// Traffic of the run that counts the leaves for [`crate::spec::Workers::Leaves`]; not part of the ledger.
    pub plan: Option<TrafficTotal>,
    /// The reasons why the stars do not form a triangulation, for the run of [`crate::Error::NotCertified`] only.
    pub refutation: Option<Refutation>,
    /// Sampled points and the tree, for pictures, if requested.
    pub picture: Option<View>,
    /// The parameters that the run used.
    pub settled: Settled,
    /// The calls of primitives, if requested.
    pub costs: Option<CostTrace>,
    /// Measured wall-clock seconds of each phase that occurred, in order.
    pub phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds from points in memory to the certified triangulation in memory, without the canonical order.
    /// The triangulation is pieces with adjacency after [`crate::triangulate`], and stars on the workers after
    /// [`crate::simulate`].
    pub triangulate_seconds: f64,
    /// Measured seconds of the whole call.
    pub total_seconds: f64,
}

impl Run {
    /// Returns a run without cells and counts.
    pub(crate) fn empty(space: usize, dimension: isize, points: Accounting, settled: Settled) -> Self {
        Run {
            space,
            dimension,
            points,
            export: Export::new(space, Store::Rows(OwnedRows::default()), false),
            point_owner: None,
            graph: None,
            sets: None,
            hull_facets: 0,
            stars_local: 0,
            stars_repaired: 0,
            exchange_rounds: 0,
            fallback: None,
            ledger: Ledger::default(),
            plan: None,
            refutation: None,
            picture: None,
            settled,
            costs: None,
            phase_seconds: Vec::new(),
            triangulate_seconds: 0.0,
            total_seconds: 0.0,
        }
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        self.export.len()
    }

    /// Returns the cells with their adjacency, as [`crate::triangulate`] leaves them in memory. Returns `None`
    /// after [`crate::simulate`].
    pub fn pieces(&self) -> Option<&Pieces> {
        self.export.pieces()
    }

    /// Returns the cells in canonical order: `space + 1` input indices per row.
    ///
    /// The first call sorts the cells and keeps the rows, which take 32 bytes per tetrahedron in addition to the cells
    /// that the run made.
    pub fn cells(&self) -> &[u64] {
        &self.export.canonical().rows
    }

    /// Returns the worker of each cell in canonical order, if kept.
    pub fn owner(&self) -> Option<&[u32]> {
        self.export.canonical().owner.as_deref()
    }

    /// Returns the leaf of each cell in canonical order, if kept.
    pub fn owning_leaf(&self) -> Option<&[u64]> {
        self.export.canonical().leaf.as_deref()
    }

    /// Returns the rank of the worker that holds each input point, if kept. It is 0 for duplicates and dropped points,
    /// which are not vertices. If the points do not span the space, they are not divided, and all vertices count for
    /// worker 1.
    pub fn point_owner(&self) -> Option<&[u32]> {
        self.point_owner.as_deref()
    }

    /// Returns the triangulation in the form that writers take, with the coordinates of the input.
    pub fn view<'a>(&'a self, coordinates: &'a [f64]) -> MeshView<'a> {
        MeshView {
            dimension: self.space,
            coordinates,
            cells: self.cells(),
            owner: self.owner(),
            owning_leaf: self.owning_leaf(),
            shares: self
                .point_owner()
                .map(|point_owner| Shares { workers: self.settled.workers, point_owner }),
            labels: None,
        }
    }
}
