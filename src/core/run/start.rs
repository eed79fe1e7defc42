//! The start of a run: parameters checked, points prepared, the machine sized.

use std::time::Instant;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::NodeId;
use septet_workers::config::{Correction, GraphRules, Shown, Stop, Task, TreeRules, Wanted, WorkerConfig};

use crate::config::{Config, ConfigError, Workers};
use crate::coordinator::Plan;
use crate::error::Error;
use crate::input::prepare::{Prepared, prepare};
use crate::result::run::{Run, Traffic};
use crate::result::view::MOST_POINTS;
use crate::run::finish::flat_result;
use crate::run::memory::admit;
use crate::run::sizing::{check_machine, plan_leaves, settle};
use crate::run::transport::Start;

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
        counted,
        tree: TreeRules {
            leaf: config.leaf_size(P::DIM, alpha),
            balanced: !counted,
            partition: config.partition,
        },
        graph: GraphRules { wanted, sets: config.sets, correction: config.correction },
        shown: Shown {
            collect_graph: config.keep_graph && counted,
            with_leaves: config.with_owner,
            view: config.view.min(MOST_POINTS),
            record_tasks: config.record_tasks && counted,
        },
        until: None,
        exchange_cap: config.exchange_cap,
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
