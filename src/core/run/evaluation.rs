//! Runs that evaluate a rule of the caller at items (`septet_workers::evaluation`).
//!
//! All ranks are in this process, because no message carries a rule.

use std::time::Instant;

use septet_geometry::evaluation::{Evaluated, Evaluation};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;
use septet_workers::config::{Task as RankTask, Wanted, WorkerConfig};
use septet_workers::input::{Rows, Source};
use septet_workers::share::merged_ledger;

use crate::coordinator::Plan;
use crate::error::Error;
use crate::input::Held;
use crate::run::Hosts;
use crate::run::finish::unbalanced;
use crate::run::hosts::{Order, started};
use crate::run::settings::machine;
use crate::spec::{MOST_WORKERS, Spec, SpecError, Task, Workers};

/// The result of a run.
pub(crate) struct EvaluationRun {
    /// The results of the rule.
    pub(crate) evaluated: Evaluated,
    /// The counts of the run.
    pub(crate) ledger: Ledger,
    /// Measured seconds of each phase, in order.
    pub(crate) phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds of the run.
    pub(crate) seconds: f64,
}

/// A rule, as the source of the ranks. It has no points.
struct Ruled<'a>(&'a dyn Evaluation);

impl<P: Point> Source<P> for Ruled<'_> {
    fn block(&self, _block: u32, _blocks: u32) -> Rows<P> {
        Rows::default()
    }

    fn evaluation(&self) -> Option<&dyn Evaluation> {
        Some(self.0)
    }
}

/// Evaluates a rule on the machine of the specification, and charges a phase.
///
/// # Errors
/// See [`Error`].
pub(crate) fn evaluate<P: Point>(
    spec: &Spec,
    phase: Phase,
    rule: &dyn Evaluation,
) -> Result<EvaluationRun, Error> {
    let start = Instant::now();
    let config = parameters::<P>(spec, phase)?;
    let order = Order {
        machine: &config,
        plan: &Plan::new(),
        control: &spec.control,
        threads: spec.machine.threads.unwrap_or(1),
    };
    let input = Held { source: &Ruled(rule), points: &[], first: 0, rows: 0 };
    let returned =
        Hosts::<P>::Own(&mut started((spec, Task::Independent { fixed: 0 }), 0)).run(&order, input)?.returned;
    let part = merged_ledger(returned.shares.iter().map(|share| &share.ledger.part), config.fault);
    if part.balance != 0 {
        return Err(unbalanced());
    }
    let mut evaluated = Evaluated::default();
    for share in returned.shares {
        evaluated.append(share.evaluated);
    }
    Ok(EvaluationRun {
        evaluated,
        ledger: Ledger::finish(part, rule.count(), P::DIM),
        phase_seconds: returned.seconds,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Returns the parameters of the ranks.
fn parameters<P: Point>(spec: &Spec, phase: Phase) -> Result<WorkerConfig, Error> {
    spec.check()?;
    let workers = match spec.machine.workers {
        Workers::Count(workers) => workers,
        Workers::Auto => spec.machine.thread_count() as u32,
        Workers::Leaves => 1,
    };
    if workers > MOST_WORKERS {
        return Err(SpecError::TooManyWorkers { workers, most: MOST_WORKERS }.into());
    }
    // An evaluation has no graph.
    let wanted = Wanted::Fixed(Supergraph::Density { alpha: 1.0 });
    let machine = machine::<P>(spec, Task::Independent { fixed: 0 }, wanted);
    Ok(WorkerConfig { task: RankTask::Evaluation { phase }, workers, ..machine })
}
