//! The record of tasks, which a separate run makes. Recording takes time, and predictions are calibrated with the
//! seconds of the main run.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::ledger::{Account, Charge, Role};
use septet_protocol::tasks::TaskLog;
use septet_workers::config::{Wanted, WorkerConfig};
use septet_workers::coordinator::Share;

use crate::config::Control;
use crate::coordinator::{Coordinator, Plan};
use crate::error::Error;
use crate::input::prepare::Prepared;
use crate::run::transport::Start;

/// Records the tasks in a run of its own, on the machine that the settings name, if any.
///
/// # Errors
/// See [`Error`].
pub(crate) fn take_record<P: Point>(
    control: &Control,
    recording: Option<&Arc<WorkerConfig>>,
    ready: &Prepared<'_, P>,
    start_machine: &mut Start<'_, P>,
) -> Result<Option<TaskLog>, Error> {
    let Some(recording) = recording else { return Ok(None) };
    let mut transport = start_machine(recording)?;
    let collected =
        Coordinator::new(control, recording.clone()).run(transport.as_mut(), ready, &Plan::new())?;
    Ok(tasks_of(collected.share, recording, P::DIM))
}

/// Returns the record with the tree and the charges of the ledger, or `None` if the run gathered stars.
fn tasks_of<P: Point>(share: Share<P>, machine: &WorkerConfig, dimension: usize) -> Option<TaskLog> {
    if share.certified.fallback.is_some() {
        return None;
    }
    let mut log = *share.counted.tasks?;
    log.leaf_size = machine.tree.leaf;
    log.dimension = dimension as u32;
    log.chosen = !matches!(machine.graph.wanted, Wanted::Fixed(_));
    let ledger = &share.counted.ledger;
    log.nodes = ledger.nodes.iter().map(|(n, f)| (n.0, f.population, f.attempts, f.kind.number())).collect();
    let charges = ledger.charges.iter().filter(|(account, _)| !matches!(account.role, Role::Pass(_)));
    let row =
        |(account, c): (&Account, &Charge)| (account.phase, account.node.0, c.cost.work(), c.cost.depth());
    log.charges = charges.map(row).collect();
    Some(log)
}
