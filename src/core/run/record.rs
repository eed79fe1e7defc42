//! What the leaves of a run have to say to each other, recorded in a run of its own: recording takes time, and the
//! seconds of the run itself calibrate predictions.

use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::ledger::{Account, Charge, Role};
use septet_protocol::tasks::TaskLog;
use septet_workers::config::{Wanted, WorkerConfig};

use crate::config::Config;
use crate::coordinator::{Collected, Coordinator, Plan};
use crate::error::Error;
use crate::input::prepare::Prepared;
use crate::run::transport::Start;

/// Sets a recording run's name apart from that of the run it is made for.
const RECORDING: u64 = 1 << 62;

/// The record of a run with one worker, if the machine is to record; the machine itself then no longer does.
///
/// # Errors
/// See [`Error`].
pub(crate) fn take_record<P: Point>(
    config: &Config,
    machine: &mut WorkerConfig,
    ready: &Prepared<'_, P>,
    start_machine: &mut Start<'_, P>,
) -> Result<Option<TaskLog>, Error> {
    if !machine.shown.record_tasks {
        return Ok(None);
    }
    let recording = Arc::new(WorkerConfig { run: machine.run ^ RECORDING, workers: 1, ..machine.clone() });
    machine.shown.record_tasks = false;
    let mut transport = start_machine(&recording)?;
    let collected =
        Coordinator::new(config, recording.clone()).run(transport.as_mut(), ready, &Plan::new())?;
    Ok(tasks_of(collected, &recording, P::DIM))
}

/// The record with what the ledger knows: the tree and the charges. None of a run that had to gather.
fn tasks_of(collected: Collected, machine: &WorkerConfig, dimension: usize) -> Option<TaskLog> {
    if collected.fallback.is_some() {
        return None;
    }
    let mut log = *collected.tasks?;
    log.leaf_size = machine.tree.leaf;
    log.dimension = dimension as u32;
    log.chosen = !matches!(machine.graph.wanted, Wanted::Fixed(_));
    let ledger = &collected.ledger;
    log.nodes = ledger.nodes.iter().map(|(n, f)| (n.0, f.population, f.attempts, f.kind.number())).collect();
    let charges = ledger.charges.iter().filter(|(account, _)| !matches!(account.role, Role::Pass(_)));
    let row = |(account, c): (&Account, &Charge)| {
        (account.phase as u8, account.node.0, c.cost.work(), c.cost.depth())
    };
    log.charges = charges.map(row).collect();
    Some(log)
}
