//! The result of a run: facts that all processes have, and the shares of the workers of this process.

use std::ops::Deref;
use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use septet_geometry::higher::VecN;
use serde::{Deserialize, Serialize};

use septet_geometry::graph::Supergraph;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::{CondensedLedger, Ledger, PhaseTotal};
use septet_protocol::transport::Placement;
use septet_workers::share::distort;

use crate::result::canonical::{LabelledCells, canonicalise, rows_of_shares};
use crate::result::cost_trace::CostTrace;
use crate::result::own_counts::OwnCounts;
use crate::result::periodic::PeriodicCells;
use crate::result::refutation::Refutation;
use crate::result::share::WorkerShare;
use crate::result::view::View;
use crate::spec::Task;

/// The input points by their use: vertices, duplicates, dropped points and hidden sites.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Accounting {
    /// Number of input points.
    pub input: u64,
    /// Number of points that are vertices of a triangulation: the distinct ones, without the hidden ones.
    pub used: u64,
    /// Number of points that coincide with a point of a smaller index; with weights, with one of the same weight.
    pub duplicate: u64,
    /// Number of points that were dropped because they were not finite.
    pub refused: u64,
    /// Number of hidden sites. `None` without weights. A flat set hides only sites under a heavier one at the same position.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hidden: Option<u64>,
}

/// The input points of this process that are not vertices. The first point at the same coordinates may belong to another
/// process.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LeftOut {
    /// Coincident points: the index of each, and the smallest index with the same coordinates. Ascending.
    pub duplicates: Vec<(u64, u64)>,
    /// Indices of points that were dropped because they were not finite. Ascending.
    pub refused: Vec<u64>,
    /// Indices of hidden sites: strictly above the lower hull of the lifted sites, or under a heavier site at the same
    /// position ([`septet_geometry::site`]). Ascending.
    pub hidden: Vec<u64>,
}

impl LeftOut {
    /// Returns the largest difference of the heights of a coincident point and of the point with which it coincides, or
    /// `None` if no points coincide. `heights` has a height for each point from number `first` on.
    pub fn height_difference(&self, heights: &[f64], first: u64) -> Option<f64> {
        let at = |point: u64| heights.get(usize::try_from(point.checked_sub(first)?).ok()?);
        let difference = |(point, of): &(u64, u64)| Some((at(*point)? - at(*of)?).abs());
        self.duplicates.iter().filter_map(difference).reduce(f64::max)
    }
}

/// The parameters that a run used.
#[derive(Clone, Debug, Serialize, Deserialize)]
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
    /// The supergraph, if the run built one. A process without workers does not have it.
    #[serde(skip)]
    pub supergraph: Option<Supergraph>,
    /// The reason for choosing this supergraph. Of several processes, only the first one has a reason of the coordinator.
    pub why: String,
    /// Whether the run split down to the leaf size and counted work and depth.
    pub counted: bool,
}

/// The facts of a run. All processes have the same.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Facts {
    /// What the run computed.
    pub task: Task,
    /// Number of coordinates: 2 to 6.
    pub space: usize,
    /// Dimension of the affine hull of the points; -1 for no points. If it is less than `space`, there are no cells.
    pub dimension: isize,
    /// The input points by their use.
    pub points: Accounting,
    /// Number of points that have stars on the machine: vertices, points that are hidden by others than the one at their
    /// place, and images of both in a periodic box.
    pub stars: u64,
    /// Number of cells.
    pub cells: u64,
    /// Number of facets of the convex hull.
    pub hull_facets: u64,
    /// Number of unchanged stars whose circumspheres all lie in the ball of radius `alpha r` (`r_k` for nearest
    /// neighbours) around the vertex. A search of this ball would prove such a star.
    pub stars_local: u64,
    /// Number of stars that splaying changed.
    pub stars_repaired: u64,
    /// Number of rounds of splaying.
    pub exchange_rounds: u64,
    /// The reason why splaying was cut short, and the number of points that were then gathered. Of several processes, only
    /// the first one has it.
    pub fallback: Option<(String, u64)>,
    /// The reasons why the stars do not form a triangulation, if the certificate failed.
    pub refutation: Option<Refutation>,
    /// The parameters that the run used.
    pub settled: Settled,
}

impl Facts {
    /// Returns `true` if the points do not span the space, so that there are no cells.
    pub fn is_flat(&self) -> bool {
        self.dimension < self.space as isize
    }
}

/// The traffic of a whole machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
        TrafficTotal::of_phases(&ledger.phases)
    }

    /// Sums the traffic of phases.
    pub fn of_phases<'a>(phases: impl IntoIterator<Item = &'a PhaseTotal>) -> Self {
        phases.into_iter().fold(TrafficTotal::default(), |sum, phase| TrafficTotal {
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

/// A maximal independent set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Positions of the selected sites, ascending, without the fixed ones.
    pub members: Vec<usize>,
    /// Number of undecided sites at the start of each round of local priorities.
    pub undecided: Vec<u64>,
}

impl Selection {
    /// Returns the number of rounds of local priorities.
    pub fn rounds(&self) -> usize {
        self.undecided.len()
    }
}

/// The optional contents of a result. Of several processes, each has those of its workers.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Kept {
    /// Edges of the supergraph, if kept: pairs of input indices, smaller first, sorted.
    pub graph: Option<Vec<(u64, u64)>>,
    /// Input index and squared radius of the ball of each point, if the edges are to be kept and the run ends with the balls,
    /// in the order of the indices. The radii are those on the machine, in its scaled coordinates.
    pub radii2: Option<Vec<(u64, f64)>>,
    /// The members of the sets in which all pairs were compared, if kept, in order.
    pub sets: Option<Vec<SetMember>>,
    /// Sampled points and the tree, for pictures, if requested.
    pub picture: Option<View>,
    /// The calls of primitives, if requested.
    pub costs: Option<CostTrace>,
    /// The independent set, if the run selects one.
    pub selected: Option<Selection>,
    /// The offsets of vertices and other facts, if the points lie in a periodic box.
    pub periodic: Option<PeriodicCells>,
}

/// Measured wall-clock seconds of a run.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Times {
    /// Seconds of each phase that occurred, in order.
    pub phases: Vec<(Phase, f64)>,
    /// Seconds from points in memory to the certified triangulation in memory, without the canonical order. The
    /// triangulation is cells with neighbours after [`crate::triangulate`], and stars on the workers after
    /// [`crate::simulate`].
    pub triangulate: f64,
    /// Seconds of the whole call.
    pub total: f64,
}

/// The result of a run. It contains its [`Facts`], the share of each worker of this process, and the counts. One process has
/// all shares.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Outcome {
    /// The facts that all processes have. They are also fields of the outcome.
    pub facts: Facts,
    /// The input points of this process that are not vertices.
    pub left_out: LeftOut,
    /// The shares of the workers of this process, in the order of the ranks. They are empty if there are no cells.
    pub shares: Vec<WorkerShare>,
    /// The process of each worker.
    pub placement: Placement,
    /// The counts. Of several processes, only the first one has them, and only after [`Outcome::unite`].
    pub ledger: Ledger,
    /// The counts of the workers of this process, if several processes may take part in the run.
    pub own_counts: Option<OwnCounts>,
    /// Traffic of the run that counts the leaves for [`crate::spec::Workers::Leaves`]; not part of the ledger.
    pub plan: Option<TrafficTotal>,
    /// The optional contents.
    pub kept: Kept,
    /// Measured seconds.
    pub times: Times,
    /// Whether cells have an owner and a leaf.
    pub(crate) has_owners: bool,
    /// The cells of this process in canonical order, once requested.
    pub(crate) canonical: OnceLock<LabelledCells>,
    /// The worker of each input point, once requested.
    pub(crate) point_owner: OnceLock<Vec<u32>>,
}

impl Deref for Outcome {
    type Target = Facts;

    fn deref(&self) -> &Facts {
        &self.facts
    }
}

impl Outcome {
    /// Returns the outcome of a process without workers.
    pub fn of_facts(facts: Facts, placement: Placement) -> Self {
        Outcome {
            facts,
            left_out: LeftOut::default(),
            shares: Vec::new(),
            placement,
            ledger: Ledger::default(),
            own_counts: None,
            plan: None,
            kept: Kept::default(),
            times: Times::default(),
            has_owners: false,
            canonical: OnceLock::new(),
            point_owner: OnceLock::new(),
        }
    }

    /// Sets the counts of the run, given those of all processes. Points that do not span the space have none.
    pub fn unite(&mut self, mut counts: CondensedLedger) {
        if !self.is_flat() {
            distort(&mut counts.part, self.own_counts.as_ref().and_then(|own| own.fault));
            self.ledger = Ledger::of_condensed(counts, self.facts.stars, self.space);
        }
    }

    /// Returns `true` if this process has all shares.
    pub fn is_whole(&self) -> bool {
        self.placement.processes() == 1
    }

    /// Returns the number of cells of all processes.
    pub fn cell_count(&self) -> usize {
        self.facts.cells as usize
    }

    /// Returns the cells of this process in canonical order: `space + 1` input indices per row.
    ///
    /// The first call sorts the cells and keeps the rows, which take 32 bytes per tetrahedron in addition to the shares.
    pub fn cells(&self) -> &[u64] {
        &self.canonical().rows
    }

    /// Returns the worker of each cell in canonical order, if kept.
    pub fn owner(&self) -> Option<&[u32]> {
        self.canonical().owner.as_deref()
    }

    /// Returns the leaf of each cell in canonical order, if kept.
    pub fn owning_leaf(&self) -> Option<&[u64]> {
        self.canonical().leaf.as_deref()
    }

    /// Returns `true` if the owner and the leaf of each cell are kept.
    pub fn has_owners(&self) -> bool {
        self.has_owners
    }

    fn canonical(&self) -> &LabelledCells {
        self.canonical.get_or_init(|| {
            if let Some(cells) = &self.kept.periodic {
                return LabelledCells { rows: cells.rows(), ..LabelledCells::default() };
            }
            let cells = rows_of_shares(&self.shares, self.space + 1, self.has_owners);
            match self.space {
                2 => canonicalise::<DVec2>(cells),
                3 => canonicalise::<DVec3>(cells),
                4 => canonicalise::<VecN<4>>(cells),
                5 => canonicalise::<VecN<5>>(cells),
                _ => canonicalise::<VecN<6>>(cells),
            }
        })
    }

    /// Returns the rank of the worker that holds each input point, if one process has all of them. It is 0 for duplicates,
    /// dropped points and hidden ones, which are not vertices. If the points do not span the space, they are not divided, and all vertices
    /// count for worker 1.
    pub fn point_owner(&self) -> Option<&[u32]> {
        self.is_whole().then(|| &self.point_owner.get_or_init(|| self.owners_of_points())[..])
    }

    fn owners_of_points(&self) -> Vec<u32> {
        let mut owners = vec![u32::from(self.is_flat()); self.points.input as usize];
        let mut set = |id: u64, owner: u32| {
            if let Some(of) = usize::try_from(id).ok().and_then(|id| owners.get_mut(id)) {
                *of = owner;
            }
        };
        for share in &self.shares {
            share.ids[..share.owned].iter().for_each(|&id| set(id, share.rank));
        }
        self.left_out.duplicates.iter().for_each(|&(id, _)| set(id, 0));
        self.left_out.refused.iter().for_each(|&id| set(id, 0));
        self.left_out.hidden.iter().for_each(|&id| set(id, 0));
        owners
    }

    /// Returns the counts of a complete run besides those of its phases. Returns `None` for a run that stopped before. A run whose
    /// points do not span the space is complete at once.
    pub fn ending(&self) -> Option<Ending> {
        (self.is_flat() || self.task.until().is_none()).then(|| Ending {
            cells: self.facts.cells,
            stars_repaired: self.stars_repaired,
            exchange_rounds: self.exchange_rounds,
            gathered: self.fallback.as_ref().map_or(0, |(_, points)| *points),
        })
    }
}

/// The result of a complete run besides the counts of its phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Ending {
    /// Number of triangles or tetrahedra.
    pub cells: u64,
    /// Number of stars that splaying changed.
    pub stars_repaired: u64,
    /// Rounds of splaying.
    pub exchange_rounds: u64,
    /// Number of points gathered because splaying was cut short.
    pub gathered: u64,
}
