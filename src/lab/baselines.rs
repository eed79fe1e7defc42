//! A baseline: parallel randomized incremental insertion ([`septet_geometry::dependence`]). It runs on the same points
//! as septet, and the same primitives count its work and depth. It exists for comparison only. Its code is sequential,
//! but counts the rounds and chains of the parallel algorithm.

use std::time::Instant;

use septet_geometry::dependence::{Clock, Dependence, Round};
use septet_geometry::point::Point;
use septet_protocol::ledger::Totals;
use serde::Serialize;

use septet_core::error::Error;
use septet_core::input::sequential::distinct;
use septet_core::result::canonical::{LabelledCells, canonicalise};
use septet_core::run::memory::admit;
use septet_core::spec::Spec;
use septet_core::{Accounting, Outcome};

/// Name and version of the schema of [`BaselineReport`].
pub const BASELINE_SCHEMA: &str = "septet-rival/1";

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
    /// Measured seconds of the whole call.
    pub seconds: f64,
}

/// Triangulates by rounds of incremental insertions, in an order drawn from the seed. It uses only the seed,
/// `skip_invalid` and the memory limit of the configuration.
///
/// # Errors
/// See [`Error`].
pub fn incremental<P: Point>(points: &[P], spec: &Spec) -> Result<Baseline, Error> {
    let start = Instant::now();
    admit(spec, points.len() as u64, P::DIM, true)?;
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
        seconds: 0.0,
    };
    if ready.dimension == P::DIM as isize {
        let made = Dependence::new(&ready.positions, spec.machine.seed).map_err(Error::Baseline)?;
        let vertices = made.cells.iter().flat_map(AsRef::as_ref);
        let rows = vertices.map(|&v| ready.rows[v as usize]).collect();
        baseline.cells = canonicalise::<P>(LabelledCells { rows, owner: None, leaf: None }).rows;
        baseline.hull_facets = made.hull_facets;
        baseline.clock = made.clock;
        baseline.brent = made.brent(baseline.points.used);
        baseline.rounds = made.rounds;
    }
    baseline.seconds = start.elapsed().as_secs_f64();
    Ok(baseline)
}

/// The report of `septet rival incremental --json`.
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
    /// Whether septet's triangulation has the same cells.
    pub same_cells: bool,
    /// The counts of the baseline.
    pub incremental: IncrementalReport,
    /// The counts of septet, if requested.
    pub septet: Option<SeptetReport>,
}

/// Counts of the incremental insertions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct IncrementalReport {
    /// Number of operations.
    pub work: u64,
    /// Vector steps on the longest chain of cells, with each scan counted as 1.
    pub depth: u64,
    /// `depth` with a scan of m items counted as `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// `depth` with a union of conflict lists counted as 1, as with a concurrent hash table.
    pub depth_hashed: u64,
    /// Brent's bound on the steps with as many processors as points.
    pub brent: u64,
    /// Number of cells on the longest chain: the dependence depth.
    pub chain: u64,
    /// Number of in-sphere tests.
    pub tests: u64,
    /// Number of cells created, including cells at infinity.
    pub cells: u64,
    /// The counts of each round.
    pub rounds: Vec<BaselineRound>,
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

impl BaselineReport {
    /// Returns the report of a baseline and of septet's run on the same points. The report includes the counts of the
    /// run if the run was counted.
    pub fn of(baseline: &Baseline, run: &Outcome, input: &str, seed: u64) -> Self {
        let row = |r: &Round| BaselineRound {
            facets: r.facets,
            cells: r.cells,
            tests: r.tests,
            work: r.work,
            steps: r.steps,
        };
        let sum = |of: fn(&Round) -> u64| baseline.rounds.iter().map(of).sum();
        BaselineReport {
            schema: BASELINE_SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            input: input.to_owned(),
            seed,
            points: baseline.points.used,
            space: baseline.space,
            dimension: baseline.dimension,
            simplices: (baseline.cells.len() / (baseline.space + 1)) as u64,
            hull_facets: baseline.hull_facets,
            same_cells: baseline.cells == run.cells() && baseline.hull_facets == run.hull_facets,
            incremental: IncrementalReport {
                work: sum(|r| r.work),
                depth: baseline.clock.steps,
                depth_log_scan: baseline.clock.log_scan,
                depth_hashed: baseline.clock.hashed,
                brent: baseline.brent,
                chain: baseline.clock.chain,
                tests: sum(|r| r.tests),
                cells: sum(|r| r.cells),
                rounds: baseline.rounds.iter().map(row).collect(),
            },
            septet: run.settled.counted.then(|| SeptetReport::of(run)),
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
