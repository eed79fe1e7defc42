//! Another algorithm on the same points, counted on the same ledger's primitives: parallel randomized
//! incremental insertion ([`septet_geometry::dependence`]). For comparison only; it is sequential code.

use std::time::Instant;

use septet_geometry::dependence::{Clock, Dependence, Round};
use septet_geometry::point::Point;
use serde::Serialize;

use septet_core::config::Config;
use septet_core::error::Error;
use septet_core::input::prepare::prepare;
use septet_core::result::canonical::{Cells, canonicalise};
use septet_core::run::memory::admit;
use septet_core::run::{Accounting, Run};

/// Name and version of the schema of [`RivalReport`].
pub const RIVAL_SCHEMA: &str = "septet-rival/1";

/// What the rival made, and its counts.
#[derive(Clone, Debug)]
pub struct Rival {
    /// 2 or 3.
    pub space: usize,
    /// Dimension of the points' affine hull. Below `space` there are no cells and no counts.
    pub dimension: isize,
    /// What became of every point.
    pub points: Accounting,
    /// Cells in canonical order: `space + 1` input indices a row.
    pub cells: Vec<u64>,
    /// Number of facets of the hull.
    pub hull_facets: u64,
    /// The longest chains of dependent cells.
    pub clock: Clock,
    /// Round by round.
    pub rounds: Vec<Round>,
    /// Brent's bound on the steps with as many processors as points.
    pub brent: u64,
    /// Measured seconds of the whole call.
    pub seconds: f64,
}

/// Triangulates by rounds of incremental insertions, in an order drawn from the seed. Of the configuration,
/// seed, `skip_invalid` and `max_memory` count.
///
/// # Errors
/// See [`Error`].
pub fn incremental<P: Point>(points: &[P], config: &Config) -> Result<Rival, Error> {
    let start = Instant::now();
    admit(config, points.len() as u64, P::DIM, true)?;
    let ready = prepare(points, config.skip_invalid)?;
    let mut rival = Rival {
        space: P::DIM,
        dimension: ready.dimension,
        points: ready.accounting(points.len()),
        cells: Vec::new(),
        hull_facets: 0,
        clock: Clock::default(),
        rounds: Vec::new(),
        brent: 0,
        seconds: 0.0,
    };
    if ready.dimension == P::DIM as isize {
        let made = Dependence::new(&ready.positions, config.machine.seed).map_err(Error::Baseline)?;
        let vertices = made.cells.iter().flat_map(AsRef::as_ref);
        let rows = vertices.map(|&v| ready.id(v as usize)).collect();
        rival.cells = canonicalise::<P>(Cells { rows, owner: None, leaf: None }).rows;
        rival.hull_facets = made.hull_facets;
        rival.clock = made.clock;
        rival.brent = made.brent(rival.points.used);
        rival.rounds = made.rounds;
    }
    rival.seconds = start.elapsed().as_secs_f64();
    Ok(rival)
}

/// What `septet rival incremental --json` writes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RivalReport {
    /// [`RIVAL_SCHEMA`].
    pub schema: &'static str,
    /// Version of septet.
    pub version: &'static str,
    /// The input as named.
    pub input: String,
    /// Of the order of insertion, and of septet's draws.
    pub seed: u64,
    /// Distinct points.
    pub points: u64,
    /// Number of coordinates: 2 or 3.
    pub space: usize,
    /// Dimension of the points' affine hull.
    pub dimension: isize,
    /// Number of triangles or tetrahedra.
    pub simplices: u64,
    /// Number of facets of the hull.
    pub hull_facets: u64,
    /// Are they the cells of septet's own triangulation?
    pub same_cells: bool,
    /// The rival's counts.
    pub incremental: IncrementalReport,
    /// Septet's, if asked for.
    pub septet: Option<SeptetReport>,
}

/// Counts of the incremental insertions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct IncrementalReport {
    /// Operations.
    pub work: u64,
    /// Vector steps on the longest chain of cells, a scan counting 1.
    pub depth: u64,
    /// The same, a scan of m items counting `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// The same as `depth`, a union of conflicts counting 1: a concurrent hash table's.
    pub depth_hashed: u64,
    /// Brent's bound on the steps with as many processors as points.
    pub brent: u64,
    /// Cells on the longest chain: the dependence depth.
    pub chain: u64,
    /// In-sphere tests.
    pub tests: u64,
    /// Cells made, those at infinity included.
    pub cells: u64,
    /// Round by round.
    pub rounds: Vec<RivalRound>,
}

/// One round of insertions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RivalRound {
    /// Facets settled.
    pub facets: u64,
    /// Cells made.
    pub cells: u64,
    /// In-sphere tests.
    pub tests: u64,
    /// Operations.
    pub work: u64,
    /// Vector steps of its longest cell.
    pub steps: u64,
}

/// Septet's counts of the same points.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SeptetReport {
    /// The paper's phases.
    pub paper: SeptetTotal,
    /// Agreement of the stars and repair.
    pub repair: SeptetTotal,
    /// Levels of the partition tree below the root.
    pub levels: u32,
    /// Rounds of exchange in the repair.
    pub exchange_rounds: u64,
    /// Points gathered because the exchange was cut short.
    pub gathered: u64,
}

/// Totals of a group of phases.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SeptetTotal {
    /// Operations.
    pub work: u64,
    /// Longest chain of vector steps, a scan counting 1.
    pub depth: u64,
    /// The same, a scan of m items counting `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Brent's bound on the steps with as many processors as points.
    pub brent: u64,
}

impl RivalReport {
    /// The report of a rival beside a run of septet on the same points, whose counts are kept if it has any.
    pub fn of(rival: &Rival, run: &Run, input: &str, seed: u64) -> Self {
        let row = |r: &Round| RivalRound {
            facets: r.facets,
            cells: r.cells,
            tests: r.tests,
            work: r.work,
            steps: r.steps,
        };
        let sum = |of: fn(&Round) -> u64| rival.rounds.iter().map(of).sum();
        RivalReport {
            schema: RIVAL_SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            input: input.to_owned(),
            seed,
            points: rival.points.used,
            space: rival.space,
            dimension: rival.dimension,
            simplices: (rival.cells.len() / (rival.space + 1)) as u64,
            hull_facets: rival.hull_facets,
            same_cells: rival.cells == run.cells() && rival.hull_facets == run.hull_facets,
            incremental: IncrementalReport {
                work: sum(|r| r.work),
                depth: rival.clock.steps,
                depth_log_scan: rival.clock.log_scan,
                depth_hashed: rival.clock.hashed,
                brent: rival.brent,
                chain: rival.clock.chain,
                tests: sum(|r| r.tests),
                cells: sum(|r| r.cells),
                rounds: rival.rounds.iter().map(row).collect(),
            },
            septet: run.settled.counted.then(|| SeptetReport::of(run)),
        }
    }
}

impl SeptetReport {
    fn of(run: &Run) -> Self {
        let total = |t: &septet_protocol::ledger::Total| SeptetTotal {
            work: t.work,
            depth: t.depth,
            depth_log_scan: t.depth_log_scan,
            brent: t.brent,
        };
        SeptetReport {
            paper: total(&run.ledger.paper),
            repair: total(&run.ledger.repair),
            levels: run.ledger.part.nodes.keys().map(|node| node.level()).max().unwrap_or(0),
            exchange_rounds: run.exchange_rounds,
            gathered: run.fallback.as_ref().map_or(0, |f| f.1),
        }
    }
}
