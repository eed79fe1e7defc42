//! A run: points and parameters in, a certified triangulation and its counts out.

pub mod count;
pub mod independent;
pub mod memory;
mod record;
mod sizing;

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use glam::{DVec2, DVec3};
use serde::Serialize;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::{Coordinates, Point, PointSlice};
use septet_protocol::ids::{COORDINATOR, NodeId, Phase};
use septet_protocol::ledger::Ledger;
use septet_protocol::tasks::TaskLog;
use septet_protocol::transport::Transport;
use septet_protocol::transport::TransportError;
use septet_workers::config::{Correction, Stop, Task, Wanted, WorkerConfig};
use septet_workers::transport::{TransportKind, launch};

use crate::config::{Config, ConfigError, Workers};
use crate::coordinator::{Collected, Coordinator, Plan};
use crate::error::{Error, Refutation};
use crate::input::prepare::{Prepared, prepare};
use crate::model::MeshView;
use crate::result::canonical::{Cells, Given};
use crate::result::pieces::Pieces;
use crate::result::view::{MOST_POINTS, View};
use crate::run::memory::admit;
use crate::run::record::take_record;
use crate::run::sizing::{check_machine, plan_leaves, settle};

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

impl Accounting {
    /// What became of the points that were prepared so.
    pub fn of<P: Point>(input: usize, ready: &Prepared<'_, P>) -> Self {
        Accounting {
            input: input as u64,
            used: ready.positions.len() as u64,
            duplicates: ready.duplicates.clone(),
            refused: ready.refused.clone(),
        }
    }
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
    store: Store,
    /// The cells of pieces as they are exported: made when first asked for.
    canonical: OnceLock<Cells>,
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
    /// What it took to count the leaves before, for [`Workers::Leaves`]; not part of the ledger.
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
    /// included: after [`triangulate`] its pieces with all adjacency, after [`simulate`] the stars on the workers.
    pub triangulate_seconds: f64,
    /// Measured seconds of the whole call.
    pub total_seconds: f64,
}

/// Cells before they are exported.
#[derive(Clone, Debug)]
enum Store {
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

    /// The cells with their adjacency, as [`triangulate`] leaves them in memory. None after [`simulate`].
    pub fn pieces(&self) -> Option<&Pieces> {
        match &self.store {
            Store::Rows(_) => None,
            Store::Pieces(pieces, _) => Some(pieces),
        }
    }

    /// Cells in canonical order: `space + 1` input indices a row. The first call sorts them and keeps them: after
    /// [`triangulate`] 32 bytes a tetrahedron beside the pieces.
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

/// The Delaunay triangulation of `points`, exact, certified, and the same for every number of workers,
/// threads and every transport.
///
/// Coincident points count once (see [`Run::points`]); points that span less than the space give no cells.
/// Work and depth are not counted: see [`simulate`].
///
/// # Errors
/// See [`Error`].
pub fn triangulate<C: Coordinates>(points: &[C], config: &Config) -> Result<Run, Error> {
    run(C::points(points), config, false)
}

/// The same triangulation by the paper's recursion to its floor, with every count on.
///
/// # Errors
/// See [`Error`].
pub fn simulate<C: Coordinates>(points: &[C], config: &Config) -> Result<Run, Error> {
    run(C::points(points), config, true)
}

/// Both, in either dimension: compiled here, so that callers do not compile the machine.
#[inline(never)]
fn run(points: PointSlice<'_>, config: &Config, counted: bool) -> Result<Run, Error> {
    match points {
        PointSlice::Plane(points) => run_on(points, config, counted, &mut started(config)),
        PointSlice::Space(points) => run_on(points, config, counted, &mut started(config)),
    }
}

/// Starts the workers of a machine: what [`run_on`] is given. It may be called twice, for [`Workers::Leaves`]
/// grows the tree first to count its leaves.
pub type Start<'a, P> = dyn FnMut(&Arc<WorkerConfig>) -> std::io::Result<Box<dyn Transport<P>>> + 'a;

/// The transport of the configuration.
pub(crate) fn started<P: Point>(
    config: &Config,
) -> impl FnMut(&Arc<WorkerConfig>) -> std::io::Result<Box<dyn Transport<P>>> {
    let kind = match config.transport {
        TransportKind::Channel { .. } => TransportKind::Channel { threads: config.threads },
        TransportKind::Sim { delivery_seed } => TransportKind::Sim { delivery_seed },
    };
    move |machine| launch::<P>(kind, machine)
}

/// [`simulate`] (`counted`) or [`triangulate`], on a machine whose workers `start` reaches; the
/// configuration's own transport is not used.
///
/// # Errors
/// See [`Error`].
pub fn run_on<P: Point>(
    points: &[P],
    config: &Config,
    counted: bool,
    start_machine: &mut Start<'_, P>,
) -> Result<Run, Error> {
    let start = Instant::now();
    if let Some(until) = config.until {
        return Err(ConfigError::Stops { until: until.name() }.into());
    }
    let Started { ready, mut machine, why, plan, planning } =
        match started_on(points, config, counted, start, start_machine)? {
            Beginning::Machine(started) => *started,
            Beginning::Flat(run) => return Ok(*run),
        };
    let before = Instant::now();
    let tasks = take_record(config, &mut machine, &ready, start_machine)?;
    let recording = before.elapsed();
    let machine = Arc::new(machine);
    let mut transport = start_machine(&machine)?;
    let collected = Coordinator::new(config, machine.clone()).run(transport.as_mut(), &ready, &plan)?;
    drop(transport);
    let refutation = certify(&collected, ready.positions.len() as u64, P::DIM, machine.workers)?;
    let mut run = finish::<P>(points.len(), &ready, collected, &machine, why, start)?;
    (run.plan, run.refutation, run.tasks) = (planning, refutation, tasks);
    run.triangulate_seconds -= recording.as_secs_f64();
    match refutation {
        None => Ok(run),
        Some(refutation) => Err(Error::NotCertified { refutation, run: Box::new(run) }),
    }
}

/// What stands before a run: points, a machine for them, why this supergraph, and the plan of the leaves.
pub(crate) struct Started<'a, P: Point> {
    pub(crate) ready: Prepared<'a, P>,
    pub(crate) machine: WorkerConfig,
    pub(crate) why: String,
    pub(crate) plan: Plan,
    pub(crate) planning: Option<Traffic>,
}

/// How a run begins.
pub(crate) enum Beginning<'a, P: Point> {
    /// With points that span the space.
    Machine(Box<Started<'a, P>>),
    /// With points that do not: their result.
    Flat(Box<Run>),
}

/// Checks the parameters, prepares the points, and sizes the machine.
pub(crate) fn started_on<'a, P: Point>(
    points: &'a [P],
    config: &Config,
    counted: bool,
    start: Instant,
    start_machine: &mut Start<'_, P>,
) -> Result<Beginning<'a, P>, Error> {
    config.check()?;
    if config.correction == Correction::Naive && !counted {
        return Err(ConfigError::NaiveUncounted.into());
    }
    admit(config, points.len() as u64, P::DIM, counted && config.until.is_none())?;
    let ready = prepare(points, config.skip_invalid)?;
    let (wanted, why) = settle(config, ready.positions.len() as u64)?;
    let alpha = match wanted {
        Wanted::Fixed(Supergraph::Density { alpha } | Supergraph::Overlap { alpha }) => Some(alpha),
        _ => None,
    };
    let mut machine = WorkerConfig {
        run: config.run.unwrap_or(config.seed),
        seed: config.seed,
        task: Task::Delaunay,
        workers: 1,
        leaf: config.leaf_size(P::DIM, alpha),
        counted,
        halving: !counted,
        wanted,
        sets: config.sets,
        collect_graph: config.keep_graph && counted,
        until: None,
        with_leaves: config.with_owner,
        view: config.view.min(MOST_POINTS),
        exchange_cap: config.exchange_cap,
        partition: config.partition,
        correction: config.correction,
        record_tasks: config.record_tasks && counted,
        fault: config.fault,
        stop: Stop::new(config.cancel.clone()),
    };
    if ready.dimension < P::DIM as isize {
        machine.workers = match config.workers {
            Workers::Count(p) => p,
            Workers::Leaves => 1,
        };
        let run = flat_result::<P>(points.len(), &ready, &machine, why, start);
        return Ok(Beginning::Flat(Box::new(run)));
    }
    let (plan, planning) = match config.workers {
        Workers::Count(p) => {
            machine.workers = p;
            (Plan::new(), None)
        }
        Workers::Leaves => {
            let (plan, traffic) = plan_leaves(config, &machine, &ready, start_machine)?;
            machine.workers = plan.get(&NodeId::ROOT).copied().unwrap_or(1);
            (plan, Some(traffic))
        }
    };
    check_machine(&machine, ready.positions.len() as u64)?;
    Ok(Beginning::Machine(Box::new(Started { ready, machine, why, plan, planning })))
}

pub(crate) fn settled(machine: &WorkerConfig, supergraph: Option<Supergraph>, why: String) -> Settled {
    Settled { workers: machine.workers, leaf: machine.leaf, supergraph, why, counted: machine.counted }
}

/// The result for points that span less than the space: no cells, nothing run.
fn flat_result<P: Point>(
    input: usize,
    ready: &Prepared<'_, P>,
    machine: &WorkerConfig,
    why: String,
    start: Instant,
) -> Run {
    let seconds = start.elapsed().as_secs_f64();
    let why = if why.is_empty() { "nothing to triangulate".to_string() } else { why };
    Run {
        space: P::DIM,
        dimension: ready.dimension,
        points: Accounting::of(input, ready),
        store: Store::Rows(Given::new(P::DIM, Vec::new(), Cells::default())),
        canonical: OnceLock::new(),
        graph: None,
        hull_facets: 0,
        stars_local: 0,
        stars_repaired: 0,
        exchange_rounds: 0,
        fallback: None,
        ledger: Ledger::default(),
        plan: None,
        refutation: None,
        picture: None,
        settled: settled(machine, None, why),
        tasks: None,
        phase_seconds: Vec::new(),
        triangulate_seconds: seconds,
        total_seconds: seconds,
    }
}

/// What the stars lack of a certificate, if anything.
///
/// # Errors
/// If not everything that was announced has arrived.
fn certify(
    collected: &Collected,
    population: u64,
    dimension: usize,
    workers: u32,
) -> Result<Option<Refutation>, Error> {
    let merged = &collected.merged;
    let passed = merged.stars == population && merged.disagreements == 0 && merged.minima == 1;
    let pieces: usize = collected.pieces.iter().map(|p| p.piece.rows.len() / 2).sum();
    let cells: usize = collected.cells.iter().map(Vec::len).sum();
    let rows = ((cells + pieces) / (dimension + 1)) as u64;
    // Stars that do not agree send no cells.
    let expected = if passed { merged.cells } else { 0 };
    if rows != expected || collected.parts != workers {
        let parts = collected.parts;
        let reason = format!("{rows} of {expected} cells and {parts} of {workers} ledgers arrived");
        return Err(TransportError::WorkerFailed { rank: COORDINATOR, reason }.into());
    }
    let refutation = Refutation {
        disagreements: merged.disagreements,
        minima: merged.minima,
        stars: merged.stars,
        points: population,
    };
    Ok((!passed).then_some(refutation))
}

fn finish<P: Point>(
    input: usize,
    ready: &Prepared<'_, P>,
    collected: Collected,
    machine: &WorkerConfig,
    why: String,
    start: Instant,
) -> Result<Run, Error> {
    let population = ready.positions.len() as u64;
    let merged = collected.merged;
    let (with_owner, exponent) = (machine.with_leaves, ready.exponent);
    let (store, triangulate_seconds) = if machine.counted {
        // Cells of a counted run come as rows; what is measured ends before they do.
        let collecting: f64 = collected.seconds.iter().filter(|s| s.0 == Phase::Collect).map(|s| s.1).sum();
        let seconds = start.elapsed().as_secs_f64() - collecting;
        let beside = Cells {
            rows: Vec::new(),
            owner: with_owner.then_some(collected.owner),
            leaf: with_owner.then_some(collected.leaves),
        };
        (Store::Rows(Given::new(P::DIM, collected.cells, beside)), seconds)
    } else {
        // Stars that do not agree send no cells.
        let hull_facets = if collected.pieces.is_empty() { 0 } else { merged.hull_facets };
        let joined = Pieces::join(P::DIM + 1, collected.pieces, hull_facets);
        let pieces = joined.ok_or_else(|| TransportError::WorkerFailed {
            rank: COORDINATOR,
            reason: "the pieces do not fit together".to_string(),
        })?;
        (Store::Pieces(pieces, with_owner), start.elapsed().as_secs_f64())
    };
    let why = if machine.counted { collected.why.unwrap_or(why) } else { NO_SUPERGRAPH.to_string() };
    Ok(Run {
        space: P::DIM,
        dimension: P::DIM as isize,
        points: Accounting::of(input, ready),
        store,
        canonical: OnceLock::new(),
        graph: machine.collect_graph.then(|| sorted_edges(&collected.edges)),
        hull_facets: merged.hull_facets,
        stars_local: merged.local,
        stars_repaired: merged.repaired,
        exchange_rounds: merged.exchange_rounds,
        fallback: collected.fallback,
        ledger: Ledger::finish(collected.ledger, population),
        plan: None,
        refutation: None,
        picture: (machine.view > 0).then(|| collected.album.view::<P>(population, machine.view, exponent)),
        settled: settled(machine, collected.supergraph.filter(|_| machine.counted), why),
        tasks: None,
        phase_seconds: collected.seconds,
        triangulate_seconds,
        total_seconds: start.elapsed().as_secs_f64(),
    })
}

/// Why a triangulation has no supergraph to report.
const NO_SUPERGRAPH: &str = "pieces look across their seams by their own circumspheres";

fn sorted_edges(flat: &[u64]) -> Vec<(u64, u64)> {
    let mut edges: Vec<(u64, u64)> = flat.chunks_exact(2).map(|e| (e[0].min(e[1]), e[0].max(e[1]))).collect();
    edges.sort_unstable();
    edges
}
