//! The size of a machine and what it is asked for: before its run.

use std::sync::Arc;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;
use septet_workers::config::{Wanted, WorkerConfig};
use septet_workers::selection::FALLBACK_K;

use crate::config::{
    Alpha, Config, ConfigError, Fault, GraphKind, MOST_WORKERS, Neighbours, alpha_of_spacing,
};
use crate::coordinator::{Coordinator, Plan};
use crate::error::Error;
use crate::input::prepare::Prepared;
use crate::result::run::Traffic;
use crate::run::transport::Start;

/// Points that one worker can triangulate at once, with room for uneven pieces.
const MOST_IN_A_PIECE: u64 = 1 << 25;

/// Refuses machines that the planned or given number of workers makes impossible.
pub(crate) fn check_machine(machine: &WorkerConfig, points: u64) -> Result<(), Error> {
    let workers = u64::from(machine.workers);
    if machine.workers > MOST_WORKERS {
        let error = ConfigError::TooManyWorkers { workers: machine.workers, most: MOST_WORKERS };
        return Err(error.into());
    }
    if !machine.counted && points / workers > MOST_IN_A_PIECE {
        let (most, enough) = (MOST_IN_A_PIECE, points.div_ceil(MOST_IN_A_PIECE));
        return Err(Error::Piece { points: points / workers, most, workers: enough });
    }
    Ok(())
}

/// The supergraph asked for, and why.
pub(crate) fn settle(config: &Config, points: u64) -> Result<(Wanted, String), Error> {
    let spaced = config.spacing.map(alpha_of_spacing);
    let share = if config.fault == Some(Fault::HalveAlpha) { 0.5 } else { 1.0 };
    let by_alpha = |alpha: f64| match config.graph {
        GraphKind::Overlap => Supergraph::Overlap { alpha: share * alpha },
        _ => Supergraph::Density { alpha: share * alpha },
    };
    let most = points.saturating_sub(1).max(1);
    Ok(match (config.graph, config.alpha) {
        (GraphKind::Knn, _) => {
            let (k, why) = match config.k {
                Neighbours::Auto => (
                    u64::from(FALLBACK_K).min(most),
                    format!("{FALLBACK_K} nearest neighbours, or all there are"),
                ),
                Neighbours::Count(k) if k == 0 || u64::from(k) >= points => {
                    return Err(ConfigError::K { k: u64::from(k), points }.into());
                }
                Neighbours::Count(k) => (u64::from(k), "k as given".to_string()),
                Neighbours::Log(c) => {
                    let k = (c * (points.max(2) as f64).ln()).ceil() as u64;
                    (k.clamp(1, most), format!("ceil({c} ln n)"))
                }
            };
            (Wanted::Fixed(Supergraph::Knn { k: k as u32 }), why)
        }
        (_, Alpha::Value(alpha)) => (Wanted::Fixed(by_alpha(alpha)), "alpha as given".to_string()),
        (_, Alpha::Auto) => match (spaced, config.spacing) {
            (Some(alpha), Some(lipschitz)) => {
                let why = format!("1.25 * 2 (1 + L) / (1 - L) of an f-spaced set with L = {lipschitz}");
                (Wanted::Fixed(by_alpha(alpha)), why)
            }
            _ if config.graph == GraphKind::Overlap => (Wanted::AutoOverlap, String::new()),
            _ => (Wanted::AutoDensity, String::new()),
        },
    })
}

/// Sets a planning run's name apart from that of the run it plans for.
const PLANNING: u64 = 1 << 63;

/// Grows the tree once, on one worker, to learn how many leaves lie below each node.
pub(crate) fn plan_leaves<P: Point>(
    config: &Config,
    machine: &WorkerConfig,
    ready: &Prepared<'_, P>,
    start_machine: &mut Start<'_, P>,
) -> Result<(Plan, Traffic), Error> {
    let (run, until) = (machine.run ^ PLANNING, Some(Phase::Partition));
    let machine = WorkerConfig { run, counted: true, until, ..machine.clone() };
    let machine = Arc::new(machine);
    let mut transport = start_machine(&machine)?;
    let grown = Coordinator::new(config, machine).run(transport.as_mut(), ready, &Plan::new())?;
    let traffic = Traffic::of(&Ledger::finish(grown.ledger.clone(), ready.positions.len() as u64));
    let mut plan = Plan::new();
    for (node, _) in grown.ledger.nodes.iter().filter(|(_, facts)| facts.is_leaf()) {
        let mut at = Some(*node);
        while let Some(n) = at {
            *plan.entry(n).or_default() += 1;
            at = n.parent();
        }
    }
    Ok((plan, traffic))
}
