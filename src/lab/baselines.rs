//! Rivals: other ways to the same triangulation, counted by the same primitives. They exist for comparison only.
//!
//! **Statement.** A [`Rival`] triangulates the same points as septet:
//! - `incremental`: parallel randomized incremental insertion ([`septet_geometry::dependence`]). Its code is sequential,
//!   but counts the rounds and chains of the parallel algorithm. The worker of septet that holds a point owns it.
//! - `splay`: star splaying (Shewchuk 2005) from the k nearest neighbours of each point. This is `simulate` on the graph of
//!   k nearest neighbours.
//! - `direct`: the path of `triangulate`, charged. Every worker triangulates its subdomain at once.
//!
//! **Work and depth.** Those of `splay` are the totals of its run. `direct` adds its own phases, one after the other. The
//! ghost layer and the interface exchange are charged as a vector step over their tests, and as the delivery of the points
//! that arrive. A subdomain is charged as the insertion of its points and ghosts by `incremental`. The ghosts that arrive
//! late are inserted in sequence.
//!
//! **Departures.** The neighbours of `splay` come from the partition tree, because the ledger has no other search. The
//! splits that all workers of `direct` exchange are not charged ([`septet_workers`], room `direct`).

use std::time::Instant;

use septet_geometry::cost::Price;
use septet_geometry::dependence::{Clock, Dependence, Round, Traffic};
use septet_geometry::point::Point;
use septet_protocol::ids::Group;
use septet_protocol::ledger::{Ledger, PhaseTotal, Totals, steps_on};
use serde::Serialize;

use septet_core::error::Error;
use septet_core::input::sequential::distinct;
use septet_core::result::canonical::{LabelledCells, canonicalise};
use septet_core::run::memory::admit;
use septet_core::spec::{Graph, Neighbours, Spec, Task};
use septet_core::{Accounting, Outcome, TrafficTotal, simulate, triangulate};

/// Name and version of the schema of [`BaselineReport`].
pub const BASELINE_SCHEMA: &str = "septet-rival/2";

/// Another way to the triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rival {
    /// Parallel randomized incremental insertion.
    Incremental,
    /// Star splaying from the `k` nearest neighbours.
    Splay {
        /// Number of neighbours.
        k: u32,
    },
    /// The path of `triangulate`.
    Direct,
}

impl Rival {
    /// Triangulates the points, and compares the cells with those of `reference`, a run of `simulate` on the same points.
    /// Its workers own the points.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn run<P: Point>(
        self,
        points: &[P],
        spec: &Spec,
        reference: &Outcome,
    ) -> Result<(Counted, bool), Error> {
        let of_run = |run: Outcome, k: Option<u32>| {
            let same = run.cells() == reference.cells() && run.hull_facets == reference.hull_facets;
            (RunReport::of(&run, k), same)
        };
        match self {
            Rival::Incremental => {
                let owners = reference.point_owner().unwrap_or_default();
                let made = insertion(points, spec, owners)?;
                let same = made.cells == reference.cells() && made.hull_facets == reference.hull_facets;
                Ok((Counted::Incremental(IncrementalReport::of(&made)), same))
            }
            Rival::Splay { k } => {
                let k_nearest = Graph::Knn { k: Neighbours::Count(k) };
                let run = simulate(points, &spec.clone().with(|c| c.recursion.graph = k_nearest))?;
                let (report, same) = of_run(run, Some(k));
                Ok((Counted::Splay(report), same))
            }
            Rival::Direct => {
                let run = triangulate(points, &spec.clone().with(|c| c.keep.prices = true))?;
                let (report, same) = of_run(run, None);
                Ok((Counted::Direct(report), same))
            }
        }
    }
}

/// The counts of a rival, under its name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Counted {
    /// The counts of incremental insertion.
    Incremental(IncrementalReport),
    /// The counts of star splaying from nearest neighbours.
    Splay(RunReport),
    /// The counts of the path of `triangulate`.
    Direct(RunReport),
}

impl Counted {
    /// Returns the counts that all rivals have.
    pub fn counts(&self) -> &RivalCounts {
        match self {
            Counted::Incremental(report) => &report.counts,
            Counted::Splay(report) | Counted::Direct(report) => &report.counts,
        }
    }

    /// Returns the name of the rival.
    pub fn name(&self) -> &'static str {
        match self {
            Counted::Incremental(_) => "incremental",
            Counted::Splay(_) => "splay",
            Counted::Direct(_) => "direct",
        }
    }
}

/// The counts that all rivals have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RivalCounts {
    /// Number of operations.
    pub work: u64,
    /// Vector steps on the longest chain, with each scan counted as 1.
    pub depth: u64,
    /// Brent's bound on the steps with as many processors as points.
    pub brent: u64,
    /// Number of rounds with messages.
    pub rounds: u64,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
}

/// The counts of a rival that runs on the machine of septet.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RunReport {
    /// The word that marks counts of another algorithm.
    pub label: &'static str,
    /// The counts.
    #[serde(flatten)]
    pub counts: RivalCounts,
    /// Number of nearest neighbours from which stars are splayed. `None` for `direct`.
    pub k: Option<u32>,
    /// The phases.
    pub phases: Vec<PhaseTotal>,
}

impl RunReport {
    fn of(run: &Outcome, k: Option<u32>) -> Self {
        let TrafficTotal { rounds, messages, bytes } = TrafficTotal::of(&run.ledger);
        let counts = RivalCounts { rounds, messages, bytes, ..priced(&run.ledger, run.points.used) };
        RunReport { label: "not the paper's", counts, k, phases: run.ledger.phases.clone() }
    }
}

/// Returns work, depth and Brent's bound of all phases. The phases of the direct path run one after the other, and all
/// subdomains of a phase at once.
fn priced(ledger: &Ledger, points: u64) -> RivalCounts {
    let sum = ledger.totals.sum();
    let start = RivalCounts { work: sum.work, depth: sum.depth, brent: sum.brent, ..RivalCounts::default() };
    let direct = ledger.phases.iter().filter(|total| total.phase.group() == Group::Direct);
    direct.fold(start, |sum, &PhaseTotal { work, depth, .. }| RivalCounts {
        work: sum.work + work,
        depth: sum.depth + depth,
        brent: sum.brent + steps_on(Price::from_parts([work, depth, 0, 0, 0]), points),
        ..sum
    })
}

/// The result of the baseline, and its counts.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Baseline {
    /// Number of coordinates: 2 or 3.
    pub space: usize,
    /// Dimension of the affine hull of the points. If it is below `space`, there are no cells and no counts.
    pub dimension: isize,
    /// The input points, counted by use.
    pub points: Accounting,
    /// Cells in canonical order: `space + 1` input indices per row.
    pub cells: Vec<u64>,
    /// Number of facets of the convex hull.
    pub hull_facets: u64,
    /// Maxima over all chains of dependent cells.
    pub clock: Clock,
    /// The counts of each round.
    pub rounds: Vec<Round>,
    /// Brent's bound on the steps with as many processors as points.
    pub brent: u64,
    /// The messages between the owners of points.
    pub traffic: Traffic,
    /// Measured seconds of the whole call.
    pub seconds: f64,
}

/// Triangulates by rounds of incremental insertions, in an order drawn from the seed. It uses only the seed,
/// `skip_invalid` and the memory limit of the configuration.
///
/// # Errors
/// See [`Error`].
pub fn incremental<P: Point>(points: &[P], spec: &Spec) -> Result<Baseline, Error> {
    insertion(points, spec, &[])
}

/// Triangulates as [`incremental`] does, and counts the messages between the owners of the input points.
fn insertion<P: Point>(points: &[P], spec: &Spec, owners: &[u32]) -> Result<Baseline, Error> {
    let start = Instant::now();
    admit((spec, Task::Simulate), points)?;
    let ready = distinct(points, spec.input.skip_invalid)?;
    let mut baseline = Baseline {
        space: P::DIM,
        dimension: ready.dimension,
        points: ready.points,
        cells: Vec::new(),
        hull_facets: 0,
        clock: Clock::default(),
        rounds: Vec::new(),
        brent: 0,
        traffic: Traffic::default(),
        seconds: 0.0,
    };
    if ready.dimension == P::DIM as isize {
        let of_row = |&row: &u64| owners.get(row as usize).copied();
        let owners: Vec<u32> = ready.rows.iter().filter_map(of_row).collect();
        let made =
            Dependence::owned(&ready.positions, spec.machine.seed, &owners).map_err(Error::Baseline)?;
        let vertices = made.cells.iter().flat_map(AsRef::as_ref);
        let rows = vertices.map(|&v| ready.rows[v as usize]).collect();
        baseline.cells = canonicalise::<P>(LabelledCells { rows, owner: None, leaf: None }).rows;
        baseline.hull_facets = made.hull_facets;
        baseline.clock = made.clock;
        baseline.brent = made.brent(baseline.points.used);
        baseline.traffic = made.traffic;
        baseline.rounds = made.rounds;
    }
    baseline.seconds = start.elapsed().as_secs_f64();
    Ok(baseline)
}

/// The report of `septet rival --json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct BaselineReport {
    /// Name and version of this schema.
    #[cfg_attr(feature = "schema", schemars(extend("const" = BASELINE_SCHEMA)))]
    pub schema: &'static str,
    /// Version of septet.
    pub version: &'static str,
    /// The input as given on the command line.
    pub input: String,
    /// Seed of the insertion order and of septet's random draws.
    pub seed: u64,
    /// Number of distinct points.
    pub points: u64,
    /// Number of coordinates: 2 or 3.
    pub space: usize,
    /// Dimension of the affine hull of the points.
    pub dimension: isize,
    /// Number of triangles or tetrahedra.
    pub simplices: u64,
    /// Number of facets of the convex hull.
    pub hull_facets: u64,
    /// Number of workers of septet, which own the points.
    pub workers: u32,
    /// Whether `simulate` gives the same cells.
    pub same_cells: bool,
    /// The counts of the rival.
    #[serde(flatten)]
    #[cfg_attr(feature = "schema", schemars(with = "CountedByName"))]
    pub rival: Counted,
    /// The counts of septet, if requested.
    pub septet: Option<SeptetReport>,
}

/// The fields of [`Counted`] in reports, for the schema: the counts under the name of the rival.
#[cfg(feature = "schema")]
#[derive(schemars::JsonSchema)]
#[expect(dead_code, reason = "only the schema reads the fields")]
struct CountedByName {
    /// The counts of incremental insertion. Absent for another rival.
    #[serde(skip_serializing_if = "Option::is_none")]
    incremental: Option<IncrementalReport>,
    /// The counts of star splaying from nearest neighbours. Absent for another rival.
    #[serde(skip_serializing_if = "Option::is_none")]
    splay: Option<RunReport>,
    /// The counts of the path of `triangulate`. Absent for another rival.
    #[serde(skip_serializing_if = "Option::is_none")]
    direct: Option<RunReport>,
}

/// Counts of the incremental insertions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct IncrementalReport {
    /// The counts that all rivals have.
    #[serde(flatten)]
    pub counts: RivalCounts,
    /// `depth` with a scan of m items counted as `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// `depth` with a union of conflict lists counted as 1, as with a concurrent hash table.
    pub depth_hashed: u64,
    /// Number of cells on the longest chain: the dependence depth.
    pub chain: u64,
    /// Number of in-sphere tests.
    pub tests: u64,
    /// Number of cells created, including cells at infinity.
    pub cells: u64,
    /// The counts of each round of insertions.
    pub insertion_rounds: Vec<BaselineRound>,
}

/// One round of insertions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BaselineRound {
    /// Number of facets between two cells that the round settled.
    pub facets: u64,
    /// Number of cells created.
    pub cells: u64,
    /// Number of in-sphere tests.
    pub tests: u64,
    /// Number of operations.
    pub work: u64,
    /// Vector steps of the round: those of the slowest cell, and those that all cells share.
    pub steps: u64,
}

/// The counts of septet on the same points.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SeptetReport {
    /// The totals of the groups of phases.
    #[serde(flatten)]
    pub totals: Totals,
    /// Number of levels of the partition tree below the root.
    pub levels: u32,
    /// Number of rounds of splaying.
    pub exchange_rounds: u64,
    /// Number of points gathered because splaying was stopped early.
    pub gathered: u64,
}

impl IncrementalReport {
    fn of(baseline: &Baseline) -> Self {
        let row = |r: &Round| BaselineRound {
            facets: r.facets,
            cells: r.cells,
            tests: r.tests,
            work: r.work,
            steps: r.steps,
        };
        let sum = |of: fn(&Round) -> u64| baseline.rounds.iter().map(of).sum();
        let Traffic { rounds, messages, bytes } = baseline.traffic;
        let (work, depth) = (sum(|r| r.work), baseline.clock.steps);
        IncrementalReport {
            counts: RivalCounts { work, depth, brent: baseline.brent, rounds, messages, bytes },
            depth_log_scan: baseline.clock.log_scan,
            depth_hashed: baseline.clock.hashed,
            chain: baseline.clock.chain,
            tests: sum(|r| r.tests),
            cells: sum(|r| r.cells),
            insertion_rounds: baseline.rounds.iter().map(row).collect(),
        }
    }
}

impl BaselineReport {
    /// Returns the report of a rival ([`Rival::run`]) and of the run of `simulate` on the same points. The report includes
    /// the counts of that run if it is set `against` the rival.
    pub fn of(
        (rival, same_cells): (Counted, bool),
        run: &Outcome,
        (input, seed): (&str, u64),
        against: bool,
    ) -> Self {
        BaselineReport {
            schema: BASELINE_SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            input: input.to_owned(),
            seed,
            points: run.points.used,
            space: run.space,
            dimension: run.dimension,
            simplices: run.cell_count() as u64,
            hull_facets: run.hull_facets,
            workers: run.settled.workers,
            same_cells,
            rival,
            septet: against.then(|| SeptetReport::of(run)),
        }
    }
}

impl SeptetReport {
    fn of(run: &Outcome) -> Self {
        SeptetReport {
            totals: run.ledger.totals,
            levels: run.ledger.part.nodes.keys().map(|node| node.level()).max().unwrap_or(0),
            exchange_rounds: run.exchange_rounds,
            gathered: run.fallback.as_ref().map_or(0, |f| f.1),
        }
    }
}
