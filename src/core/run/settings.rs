//! The settings of a run. This module alone decides them, from the configuration and the points.
//!
//! [`admit`] checks everything that depends only on the configuration and the number of points. It runs before the
//! points are prepared, so that a refused run does not allocate memory. [`Settings::decide`] decides everything else.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_workers::config::{
    Correction, CostLog, FALLBACK_K, Family, GraphRules, MOST_IN_A_PIECE, Refusal, Repair, SetRule, Shown,
    Stop, Task as RankTask, TreeRules, Wanted, WorkerConfig,
};

use crate::coordinator::Plan;
use crate::error::Error;
use crate::input::Held;
use crate::result::outcome::{Settled, TrafficTotal};
use crate::result::view::MOST_POINTS;
use crate::run::auto_workers::auto_workers;
use crate::run::memory;
use crate::spec::{
    Alpha, Constants, Fault, Graph, MOST_WORKERS, Neighbours, Partition, Purpose, Registers, Spec, SpecError,
    Task, TreeConstants, Until, Words, Workers, alpha_of_spacing,
};

/// Checks the specification, the numbers of the rows and the forecast of memory. `is_team` is set if several processes may
/// share the ranks. The forecast is for one process, which holds its share of the points.
///
/// # Errors
/// Fails if the specification cannot run, or if there are too many points for its memory limit.
pub(crate) fn admit<P: Point>(
    (spec, task): (&Spec, Task),
    input: Held<'_, P>,
    is_team: bool,
) -> Result<(), Error> {
    spec.check()?;
    if spec.machine.registers == Registers::Baseline {
        septet_geometry::simd::use_baseline_registers();
    }
    let correction = spec.recursion.neighbours;
    if correction != Correction::Descent && task == Task::Triangulate {
        return Err(SpecError::Uncorrected { correction: correction.name() }.into());
    }
    if P::IS_WEIGHTED && task.is_independent() {
        return Err(SpecError::Weighted.into());
    }
    if P::DIM > 3 && spec.tree.partition == Partition::Hilbert {
        return Err(
            SpecError::OnlySpace { what: "partitions by the Hilbert curve", dimension: P::DIM }.into()
        );
    }
    if is_team {
        admit_team(spec)?;
    }
    let Held { first, rows, .. } = input;
    if first.checked_add(rows).is_none() {
        return Err(Error::Indices { rows, first, last: u64::MAX });
    }
    memory::admit((spec, task), input.points)
}

/// Refuses what needs all ranks in one process.
///
/// # Errors
/// Fails with the first option that asks for it.
pub fn admit_team(spec: &Spec) -> Result<(), SpecError> {
    let outputs = [
        (spec.machine.workers == Workers::Leaves, "a worker for each leaf", "workers"),
        (spec.keep.costs, "a cost trace", "cost-trace"),
        (spec.keep.view.is_some_and(|points| points > 0), "a picture", "view"),
    ];
    match outputs.iter().find(|(is_wanted, ..)| *is_wanted) {
        Some(&(_, output, option)) => Err(SpecError::NotDistributed { output, option }),
        None => Ok(()),
    }
}

/// The machine of a run, and the reasons for it.
#[derive(Clone, Debug)]
pub(crate) struct Settings<'a> {
    /// What the caller asks for.
    pub(crate) spec: &'a Spec,
    /// What the run computes.
    pub(crate) task: Task,
    /// The parameters that all ranks share.
    pub(crate) machine: WorkerConfig,
    /// The reason for this supergraph; empty if the coordinator chooses it.
    pub(crate) why: String,
    /// Number of leaves below each node if every leaf has its own worker; otherwise empty.
    pub(crate) plan: Plan,
    /// Traffic of the run that made the plan.
    pub(crate) planning: Option<TrafficTotal>,
}

impl<'a> Settings<'a> {
    /// Decides all settings of a run over these points. Of several processes, the place of the ranks decides the number of
    /// `workers`. With [`Workers::Leaves`], there is one worker until the leaves are counted.
    pub(crate) fn decide<P: Point>(
        (spec, task): (&'a Spec, Task),
        input: Held<'_, P>,
        workers: Option<u32>,
    ) -> Self {
        let (wanted, why) = match task {
            Task::Independent { .. } => {
                (Wanted::Fixed(Supergraph::Density { alpha: 1.0 }), "sizes as given".to_string())
            }
            _ => supergraph(spec),
        };
        let mut machine = machine::<P>(spec, task, wanted);
        machine.shown.with_places = workers.is_some();
        let threads = spec.machine.thread_count() as u32;
        machine.workers = match (workers, spec.machine.workers) {
            (Some(workers), _) | (None, Workers::Count(workers)) => workers,
            (None, Workers::Auto) if task == Task::Triangulate => auto_workers(input.points, threads),
            (None, Workers::Auto) => threads,
            (None, Workers::Leaves) => 1,
        };
        Settings { spec, task, machine, why, plan: Plan::new(), planning: None }
    }

    /// Checks the number of workers.
    ///
    /// # Errors
    /// Fails if there are too many.
    pub(crate) fn check_workers(&self) -> Result<(), SpecError> {
        let workers = self.machine.workers;
        if workers > MOST_WORKERS {
            return Err(SpecError::TooManyWorkers { workers, most: MOST_WORKERS });
        }
        Ok(())
    }

    /// Checks the parameters against the number of points.
    ///
    /// # Errors
    /// Fails if the points do not allow k, or if there are too few workers for them.
    pub(crate) fn check<P: Point>(&self, points: u64) -> Result<(), Error> {
        match self.machine.refusal::<P>(points) {
            None => Ok(()),
            Some(Refusal::Neighbours { k }) => Err(SpecError::K { k: u64::from(k), points }.into()),
            Some(Refusal::Piece { points: share }) => {
                let (most, enough) = (MOST_IN_A_PIECE, points.div_ceil(MOST_IN_A_PIECE));
                Err(Error::Piece { points: share, most, workers: enough })
            }
        }
    }

    /// Returns the settings in the form that the result has.
    pub(crate) fn settled(&self, supergraph: Option<Supergraph>, why: String) -> Settled {
        let machine = &self.machine;
        Settled {
            workers: machine.workers,
            leaf: machine.tree.leaf,
            samples: machine.tree.samples,
            tries: machine.tree.tries,
            supergraph,
            why,
            counted: machine.counted,
        }
    }
}

/// Returns the parameters that all ranks share, for one worker.
pub(super) fn machine<P: Point>(spec: &Spec, task: Task, wanted: Wanted) -> WorkerConfig {
    let (counted, whole) = (task.is_counted(), task.until().is_none());
    let independent = task.is_independent();
    let known = if let Wanted::Fixed(supergraph) = wanted { Some(supergraph) } else { None };
    let wished = match task {
        Task::Simulate | Task::Count(_) => spec.tree.constants,
        Task::Triangulate | Task::Independent { .. } => {
            Constants { purpose: Purpose::Timing, ..Constants::default() }
        }
    };
    let constants = TreeConstants::of(wished.purpose, P::DIM, spec.recursion.sets, known);
    let leaf = if independent { LEAF_OF_SITES[P::DIM.min(3) - 2] } else { constants.leaf };
    let shown = Shown {
        with_edges: spec.keep.graph && counted,
        with_sets: spec.keep.sets && counted,
        with_neighbours: spec.keep.neighbours,
        with_prices: spec.keep.prices && !counted,
        with_operations: spec.keep.operations && !counted,
        with_places: false,
        view: if whole { spec.keep.view.unwrap_or(0).min(MOST_POINTS) } else { 0 },
    };
    WorkerConfig {
        run: spec.machine.name(),
        seed: spec.machine.seed,
        task: match task {
            Task::Independent { fixed } => RankTask::Independent { fixed },
            _ => RankTask::Delaunay { skips_invalid: spec.input.skip_invalid },
        },
        workers: 1,
        counted,
        tree: TreeRules {
            leaf: spec.tree.leaf.unwrap_or(leaf),
            samples: wished.samples.unwrap_or(constants.samples),
            tries: wished.tries.unwrap_or(constants.tries),
            balanced: !counted,
            partition: spec.tree.partition,
        },
        graph: if independent {
            GraphRules {
                wanted,
                sets: SetRule::Ghost,
                correction: Correction::Descent,
                repair: Repair::Splay,
                exchange_cap: None,
            }
        } else {
            GraphRules {
                wanted,
                sets: spec.recursion.sets,
                correction: spec.recursion.neighbours,
                // Stars of exact subdomain triangulations hardly ever disagree.
                repair: if counted { spec.recursion.repair } else { Repair::Splay },
                exchange_cap: spec.planted.exchange_cap,
            }
        },
        shown: if independent { Shown::default() } else { shown },
        until: task.until().map(Until::phase),
        // Each point of a conflict graph waits for all its neighbours, so no neighbour may miss it.
        fault: spec.planted.fault.filter(|&fault| !independent || fault != Fault::HalfGhosts),
        stop: Stop::new(spec.control.cancel.clone(), memory::limit_of(spec)),
        cost_log: if spec.keep.costs && counted { CostLog::recording() } else { CostLog::default() },
    }
}

/// Largest leaf of an independent set, in the plane, and in space and above. The search in a leaf takes linear time
/// ([`septet_geometry::grid`]). A leaf may therefore be larger, and the tree lower, than in a search over all pairs.
/// The points of even larger leaves would not fit into the caches.
const LEAF_OF_SITES: [u64; 2] = [2000, 4000];

/// Returns the supergraph to build, and the reason for it.
fn supergraph(spec: &Spec) -> (Wanted, String) {
    let share = if spec.planted.fault == Some(Fault::HalveAlpha) { 0.5 } else { 1.0 };
    let (alpha, k) = match spec.recursion.graph {
        Graph::Knn { k } => return (Wanted::Nearest(k), why_nearest(k)),
        Graph::Density { alpha } => (alpha, None),
        Graph::Overlap { alpha, k } => (alpha, Some(k)),
    };
    let fixed = |alpha: f64| {
        let alpha = share * alpha;
        Wanted::Fixed(match k.map(ball_order) {
            Some(k) => Supergraph::Overlap { alpha, k },
            None => Supergraph::Density { alpha },
        })
    };
    match (alpha, spec.recursion.spacing) {
        (Alpha::Value(alpha), _) if matches!(k, Some(Neighbours::Count(_))) => {
            (fixed(alpha), "alpha and k as given".to_string())
        }
        (Alpha::Value(alpha), _) => (fixed(alpha), "alpha as given".to_string()),
        (Alpha::Auto, Some(lipschitz)) => {
            let why = format!("1.25 * 2 (1 + L) / (1 - L) of an f-spaced set with L = {lipschitz}");
            (fixed(alpha_of_spacing(lipschitz)), why)
        }
        (Alpha::Auto, None) => {
            let family = if k.is_some() { Family::Overlap } else { Family::Density };
            (Wanted::Auto { family, purpose: spec.tree.constants.purpose }, String::new())
        }
    }
}

/// Returns the rank of the neighbour to which the balls of an overlap graph extend. [`Spec::check`] refuses a factor of
/// ln n.
fn ball_order(k: Neighbours) -> u32 {
    if let Neighbours::Count(k) = k { k } else { 1 }
}

/// Returns the reason for k.
fn why_nearest(k: Neighbours) -> String {
    match k {
        Neighbours::Auto => format!("{FALLBACK_K} nearest neighbours, or all there are"),
        Neighbours::Count(_) => "k as given".to_string(),
        Neighbours::Log(factor) => format!("ceil({factor} ln n)"),
    }
}
