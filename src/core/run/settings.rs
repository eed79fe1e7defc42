//! The settings of a run. This module alone decides them, from the configuration and the points.
//!
//! [`admit`] checks everything that depends only on the configuration and the number of points. It runs before the
//! points are prepared, so that a refused run does not allocate memory. [`Settings::decide`] decides everything else.

use std::sync::Arc;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Ledger;
use septet_workers::config::{
    Correction, CostLog, FALLBACK_K, GraphRules, MOST_IN_A_PIECE, Refusal, SetRule, Shown, Stop,
    Task as RankTask, TreeRules, Wanted, WorkerConfig,
};

use crate::coordinator::{Coordinator, Plan};
use crate::error::Error;
use crate::input::Whole;
use crate::result::run::{Settled, TrafficTotal};
use crate::result::view::MOST_POINTS;
use crate::run::auto_workers::auto_workers;
use crate::run::memory;
use crate::run::transport::Start;
use crate::spec::{
    Alpha, Constants, Fault, Graph, MOST_WORKERS, Neighbours, Purpose, Registers, Spec, SpecError, Task,
    TreeConstants, Until, Workers, alpha_of_spacing, cores,
};

/// Checks the configuration and the forecast of memory.
///
/// # Errors
/// Fails if the configuration cannot run, or if there are too many points for its memory limit.
pub(crate) fn admit(spec: &Spec, task: Task, points: u64, dimension: usize) -> Result<(), Error> {
    spec.check()?;
    if spec.machine.registers == Registers::Baseline {
        septet_geometry::simd::use_baseline_registers();
    }
    if spec.recursion.neighbours == Correction::BottomUp && task == Task::Triangulate {
        return Err(SpecError::BottomUpUncounted.into());
    }
    match task {
        Task::Independent { .. } => memory::admit_sites(spec, points, dimension),
        // A run that stops before the graph takes less memory than a triangulation.
        Task::Triangulate | Task::Count(Until::Partition | Until::Neighbours) => {
            memory::admit(spec, points, dimension, false)
        }
        Task::Simulate | Task::Count(Until::Graph) => memory::admit(spec, points, dimension, true),
    }
}

/// The machine of a run, and the reasons for it.
#[derive(Debug)]
pub(crate) struct Settings {
    /// The parameters that all ranks share.
    pub(crate) machine: WorkerConfig,
    /// The reason for this supergraph; empty if the coordinator chooses it.
    pub(crate) why: String,
    /// Number of leaves below each node if every leaf has its own worker; otherwise empty.
    pub(crate) plan: Plan,
    /// Traffic of the run that made the plan.
    pub(crate) planning: Option<TrafficTotal>,
}

impl Settings {
    /// Decides all settings of a run over these points. With [`Workers::Leaves`], this requires a run that grows the
    /// tree.
    ///
    /// # Errors
    /// Fails if there are too many workers, or if the machine that grows the tree fails.
    pub(crate) fn decide<P: Point>(
        spec: &Spec,
        task: Task,
        input: Whole<'_, P>,
        start_machine: &mut Start<'_, P>,
    ) -> Result<Self, Error> {
        let (wanted, why) = match task {
            Task::Independent { .. } => {
                (Wanted::Fixed(Supergraph::Density { alpha: 1.0 }), "sizes as given".to_string())
            }
            _ => supergraph(spec),
        };
        let machine = machine::<P>(spec, task, wanted);
        let mut settings = Settings { machine, why, plan: Plan::new(), planning: None };
        match spec.machine.workers {
            Workers::Auto if task == Task::Triangulate => {
                settings.machine.workers = auto_workers(input.positions, cores() as u32);
            }
            Workers::Auto => settings.machine.workers = cores() as u32,
            Workers::Count(workers) => settings.machine.workers = workers,
            Workers::Leaves => settings.plan_leaves(spec, input, start_machine)?,
        }
        let workers = settings.machine.workers;
        if workers > MOST_WORKERS {
            return Err(SpecError::TooManyWorkers { workers, most: MOST_WORKERS }.into());
        }
        Ok(settings)
    }

    /// Grows the tree once, on one worker, to count the leaves below each node.
    fn plan_leaves<P: Point>(
        &mut self,
        spec: &Spec,
        input: Whole<'_, P>,
        start_machine: &mut Start<'_, P>,
    ) -> Result<(), Error> {
        let run = self.machine.run ^ PLANNING;
        let until = Some(Phase::Partition);
        let machine = Arc::new(WorkerConfig {
            run,
            counted: true,
            until,
            cost_log: CostLog::default(),
            ..self.machine.clone()
        });
        let mut hosts = start_machine(&machine);
        let grown = Coordinator::new(&spec.control, machine).run(hosts.as_mut(), input, &Plan::new())?;
        grown.check_balance()?;
        let part = grown.ledger;
        for (node, _) in part.nodes.iter().filter(|(_, facts)| facts.is_leaf()) {
            let mut at = Some(*node);
            while let Some(n) = at {
                *self.plan.entry(n).or_default() += 1;
                at = n.parent();
            }
        }
        if !grown.input.is_flat(P::DIM) {
            let ledger = Ledger::finish(part, grown.input.population.count, P::DIM);
            self.planning = Some(TrafficTotal::of(&ledger));
        }
        self.machine.workers = self.plan.get(&NodeId::ROOT).copied().unwrap_or(1);
        Ok(())
    }

    /// Checks the parameters against the number of points.
    ///
    /// # Errors
    /// Fails if the points do not allow k, or if there are too few workers for them.
    pub(crate) fn check(&self, points: u64) -> Result<(), Error> {
        match self.machine.refusal(points) {
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

/// The bit that distinguishes the name of a planning run from the name of the run that it plans.
const PLANNING: u64 = 1 << 63;

/// Returns the parameters that all ranks share, for one worker.
fn machine<P: Point>(spec: &Spec, task: Task, wanted: Wanted) -> WorkerConfig {
    let (counted, whole) = (task.is_counted(), task.until().is_none());
    let independent = task.is_independent();
    let alpha = match wanted {
        Wanted::Fixed(Supergraph::Density { alpha } | Supergraph::Overlap { alpha }) => Some(alpha),
        _ => None,
    };
    let wished = match task {
        Task::Simulate | Task::Count(_) => spec.tree.constants,
        Task::Triangulate | Task::Independent { .. } => {
            Constants { purpose: Purpose::Timing, ..Constants::default() }
        }
    };
    let constants = TreeConstants::of(wished.purpose, P::DIM, spec.recursion.sets, alpha);
    let leaf = if independent { LEAF_OF_SITES[P::DIM - 2] } else { constants.leaf };
    let shown = Shown {
        with_edges: spec.keep.graph && counted,
        with_sets: spec.keep.sets && counted,
        with_leaves: spec.keep.owner,
        with_owned: spec.keep.point_owner && whole && !independent,
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
            GraphRules { wanted, sets: SetRule::Ghost, correction: Correction::Descent, exchange_cap: None }
        } else {
            GraphRules {
                wanted,
                sets: spec.recursion.sets,
                correction: spec.recursion.neighbours,
                exchange_cap: spec.planted.exchange_cap,
            }
        },
        shown: if independent { Shown::default() } else { shown },
        until: task.until().map(Until::phase),
        // Each point of a conflict graph waits for all its neighbours, so no neighbour may miss it.
        fault: spec.planted.fault.filter(|&fault| !independent || fault != Fault::HalfGhosts),
        stop: Stop::new(spec.control.cancel.clone()),
        cost_log: if spec.keep.costs && counted { CostLog::recording() } else { CostLog::default() },
    }
}

/// Largest leaf of an independent set, in the plane and in space. The search in a leaf takes linear time
/// ([`septet_geometry::grid`]). A leaf may therefore be larger, and the tree lower, than in a search over all pairs.
/// The points of even larger leaves would not fit into the caches.
const LEAF_OF_SITES: [u64; 2] = [2000, 4000];

/// Returns the supergraph to build, and the reason for it.
fn supergraph(spec: &Spec) -> (Wanted, String) {
    let share = if spec.planted.fault == Some(Fault::HalveAlpha) { 0.5 } else { 1.0 };
    let (alpha, overlap) = match spec.recursion.graph {
        Graph::Knn { k } => return (Wanted::Nearest(k), why_nearest(k)),
        Graph::Density { alpha } => (alpha, false),
        Graph::Overlap { alpha } => (alpha, true),
    };
    let fixed = |alpha: f64| {
        let alpha = share * alpha;
        Wanted::Fixed(if overlap { Supergraph::Overlap { alpha } } else { Supergraph::Density { alpha } })
    };
    match (alpha, spec.recursion.spacing) {
        (Alpha::Value(alpha), _) => (fixed(alpha), "alpha as given".to_string()),
        (Alpha::Auto, Some(lipschitz)) => {
            let why = format!("1.25 * 2 (1 + L) / (1 - L) of an f-spaced set with L = {lipschitz}");
            (fixed(alpha_of_spacing(lipschitz)), why)
        }
        (Alpha::Auto, None) if overlap => (Wanted::AutoOverlap, String::new()),
        (Alpha::Auto, None) => (Wanted::AutoDensity, String::new()),
    }
}

/// Returns the reason for k.
fn why_nearest(k: Neighbours) -> String {
    match k {
        Neighbours::Auto => format!("{FALLBACK_K} nearest neighbours, or all there are"),
        Neighbours::Count(_) => "k as given".to_string(),
        Neighbours::Log(factor) => format!("ceil({factor} ln n)"),
    }
}
