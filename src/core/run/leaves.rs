//! The plan of a run in which every leaf has its own worker.

use std::time::Instant;

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_workers::config::{CostLog, WorkerConfig};

use crate::error::Error;
use crate::input::Held;
use crate::result::outcome::TrafficTotal;
use crate::run::hosts::Hosts;
use crate::run::perform::perform;
use crate::run::settings::Settings;

/// The bit that distinguishes the name of a planning run from the name of the run that it plans.
const PLANNING: u64 = 1 << 63;

/// Grows the tree once, on one worker, to count the leaves below each node.
pub(super) fn plan_leaves<P: Point>(
    settings: &mut Settings<'_>,
    input: Held<'_, P>,
    hosts: &mut Hosts<'_, P>,
) -> Result<(), Error> {
    let machine = WorkerConfig {
        run: settings.machine.run ^ PLANNING,
        counted: true,
        until: Some(Phase::Partition),
        cost_log: CostLog::default(),
        ..settings.machine.clone()
    };
    let growing = Settings { machine, ..settings.clone() };
    let grown = perform(&growing, input, hosts, Instant::now())?;
    for (node, _) in grown.ledger.part.nodes.iter().filter(|(_, facts)| facts.is_leaf()) {
        let mut at = Some(*node);
        while let Some(n) = at {
            *settings.plan.entry(n).or_default() += 1;
            at = n.parent();
        }
    }
    settings.planning = (!grown.is_flat()).then(|| TrafficTotal::of(&grown.ledger));
    settings.machine.workers = settings.plan.get(&NodeId::ROOT).copied().unwrap_or(1);
    Ok(())
}
