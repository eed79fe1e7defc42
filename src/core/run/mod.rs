//! A run: from points and a [`Spec`] to a certified triangulation and its counts.
//!
//! `run` is the only way. Its callers differ in the task, the source of the rows, and the place of the ranks.

mod auto_workers;
pub mod calls;
pub mod distributed;
pub(crate) mod evaluation;
mod finish;
mod forecast;
mod hosts;
mod leaves;
pub mod memory;
mod perform;
pub mod periodic;
pub mod processes;
mod settings;
pub mod stats;

use std::time::Instant;

use septet_geometry::point::Point;

use crate::error::{Error, PeriodicError};
use crate::input::Held;
pub use crate::result::cost_trace::{CostRow, CostTrace};
use crate::result::outcome::Outcome;
use crate::spec::{Spec, Task, Workers};
pub use hosts::Start;
pub(crate) use hosts::{Hosts, started};
use leaves::plan_leaves;
use perform::perform;

pub use settings::admit_team;
use settings::{Settings, admit};

/// Runs a task over the rows of all processes. A failed certificate is not an error, because the counts of the run are still
/// reported ([`certified`]).
///
/// # Errors
/// See [`Error`]. All processes with ranks return an error.
pub(crate) fn run<P: Point>(
    (spec, task): (&Spec, Task),
    input: Held<'_, P>,
    hosts: &mut Hosts<'_, P>,
) -> Result<Outcome, Error> {
    if spec.input.periodic.is_some() {
        return Err(hosts.end(PeriodicError::Task.into()));
    }
    run_once((spec, task), input, hosts)
}

/// Runs a task, without regard to a periodic box.
///
/// # Errors
/// See [`run`].
pub(crate) fn run_once<P: Point>(
    (spec, task): (&Spec, Task),
    input: Held<'_, P>,
    hosts: &mut Hosts<'_, P>,
) -> Result<Outcome, Error> {
    let start = Instant::now();
    let admitted = admit((spec, task), input, hosts.is_team());
    admitted.map_err(|error| hosts.end(error))?;
    let mut settings = Settings::decide((spec, task), input, hosts.workers());
    if spec.machine.workers == Workers::Leaves {
        plan_leaves(&mut settings, input, hosts)?;
    }
    settings.check_workers()?;
    perform(&settings, input, hosts, start)
}

/// Returns an outcome whose certificate passed.
///
/// # Errors
/// Returns [`Error::NotCertified`] with the outcome otherwise.
pub(crate) fn certified(outcome: Outcome) -> Result<Outcome, Error> {
    match outcome.facts.refutation {
        None => Ok(outcome),
        Some(refutation) => Err(Error::NotCertified { refutation, run: Box::new(outcome) }),
    }
}
