//! Predictions of the machine for any number of workers, from the record of one run.
//!
//! **Statement.** The messages between leaves are a function of points, seed and parameters
//! ([`septet_protocol::tasks`]). The placement follows from the machine's rule, applied to the recorded tree. With
//! `p` workers, rounds, messages and bytes are therefore sums over the pairs of leaves on different workers.
//! [`Prediction`] contains these sums. They equal the counts of a real run if `p` divides the number of blocks in the
//! record, which tests check. Otherwise, a block that two ranks share is assigned to one of them.
//!
//! **Time.** The rank that holds a leaf does its work, and the work of a shared node is divided among its group. In
//! BSP (Valiant 1990), a round costs `max work / rate + h / bandwidth + latency`, where `h` is the largest number of
//! bytes that one rank sends or receives. In `LogGP` (Alexandrov et al. 1995), it costs
//! `max work / rate + latency + 2 overhead + (m - 1) max(overhead, gap) + (bytes - m) / bandwidth`. Here `m` is the
//! number of messages at the busiest rank, and the gap equals the overhead. Brent's bound on the steps with p
//! processors is `work / p + depth`.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::tasks::TaskLog;
use serde::Serialize;

mod calibrate;
mod descent;
mod error;
mod hardware;
mod machine;
mod partition;
mod placement;
mod replay;
mod sizes;
mod traffic;

pub use calibrate::{Timed, calibrate};
pub use error::PredictError;
pub use hardware::Hardware;
pub use traffic::{Load, PhaseTraffic, RoundTraffic};

use placement::Placement;

/// The prediction for one number of workers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Prediction {
    /// Number of workers.
    pub workers: u32,
    /// Whether the counts are exact. Otherwise, the shares of the input's blocks are rounded.
    pub exact: bool,
    /// Number of rounds in which messages are sent.
    pub rounds: u64,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
    /// Bytes divided by the size of `n^(1-1/d) p^(1/d)` point records, which is the surface of p subdomains.
    pub surface_ratio: f64,
    /// Charged work of the busiest worker, summed over the phases.
    pub busiest_work: u64,
    /// `work / p + depth`.
    pub brent: u64,
    /// Seconds by BSP.
    pub bsp: PredictedSeconds,
    /// Seconds by `LogGP`.
    pub loggp: PredictedSeconds,
    /// The predictions for each phase.
    pub phases: Vec<PhasePrediction>,
}

/// Predicted seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PredictedSeconds {
    /// Computation of the busiest worker, summed over all phases.
    pub compute: f64,
    /// Communication, summed over all rounds.
    pub communicate: f64,
}

impl PredictedSeconds {
    /// Returns the sum of both.
    pub fn total(&self) -> f64 {
        self.compute + self.communicate
    }
}

/// One phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PhasePrediction {
    /// The name.
    pub name: &'static str,
    /// Number of rounds with messages.
    pub rounds: u64,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
    /// Work of the busiest worker.
    pub busiest_work: u64,
}

/// Predicts the counts and times of a machine with `workers` workers.
///
/// # Errors
/// See [`PredictError`].
pub fn predict(log: &TaskLog, workers: u32, hardware: &Hardware) -> Result<Prediction, PredictError> {
    let most = septet_core::config::MOST_WORKERS;
    if workers == 0 || workers > most {
        return Err(PredictError::Workers { workers, most });
    }
    check(log)?;
    let (place, traffic) = match log.dimension {
        2 => replay::replay::<DVec2>(log, workers)?,
        _ => replay::replay::<DVec3>(log, workers)?,
    };
    Ok(summary(log, &place, &traffic, hardware))
}

/// Upper limit on the number of edges between two leaves in a record.
const MOST_EDGES: u64 = 1 << 40;

/// Checks that the parts of a record are consistent.
fn check(log: &TaskLog) -> Result<(), PredictError> {
    let leaves = log.leaves.len();
    let known = |leaf: u32| (leaf as usize) < leaves;
    let corrupt = |what| Err(PredictError::Corrupt { what });
    if !matches!(log.dimension, 2 | 3) {
        return corrupt("the dimension is neither 2 nor 3");
    }
    if log.blocks == 0 || log.first_blocks.len() != leaves {
        return corrupt("a leaf has no blocks of the input");
    }
    let blocks = log.first_blocks.iter().chain(log.samples.iter().map(|s| &s.2)).flatten();
    if blocks.into_iter().any(|b| b.0 >= log.blocks) {
        return corrupt("a block that does not exist");
    }
    let mut named = log.frame.iter().copied().chain(log.reach.iter().map(|r| r.1));
    let mut pairs = log
        .reverse
        .iter()
        .map(|r| (r.0, r.1))
        .chain(log.senders.iter().flat_map(|t| [(t.0, t.1), (t.0, t.2)]))
        .chain(log.agreement.iter().map(|r| (r.1, r.2)))
        .chain(log.exchange.iter().map(|s| (s.from, s.to)));
    if !named.all(known) || !pairs.all(|(a, b)| known(a) && known(b)) {
        return corrupt("a leaf that does not exist");
    }
    if !log.reverse.is_empty() && log.senders.is_empty() {
        return corrupt("it lists no senders of edges, because an earlier version of septet wrote it");
    }
    let edges = log.reverse.iter().map(|r| r.2).chain(log.senders.iter().map(|t| t.3));
    if edges.max().is_some_and(|most| most > MOST_EDGES) {
        return corrupt("more edges than points can have");
    }
    if log.leaves.contains(&0) || log.nodes.iter().any(|n| n.0 == 0) {
        return corrupt("a path of zero");
    }
    Ok(())
}

/// Returns the work of every rank by phase. A rank does the work of the subtree that it holds, and a group divides
/// the work of a shared node.
fn work_by_rank(log: &TaskLog, place: &Placement) -> BTreeMap<Phase, BTreeMap<Rank, u64>> {
    let shared: BTreeMap<u64, (Rank, u32)> =
        place.groups.iter().filter(|g| !g.whole).map(|g| (g.node.0, (g.first, g.ranks))).collect();
    let pieces: BTreeMap<u64, Rank> =
        place.groups.iter().filter(|g| g.whole).map(|g| (g.node.0, g.first)).collect();
    let mut work: BTreeMap<Phase, BTreeMap<Rank, u64>> = BTreeMap::new();
    for &(phase, node, amount, _) in &log.charges {
        let phase = work.entry(phase).or_default();
        if let Some(&(first, ranks)) = shared.get(&node) {
            for rank in first..first + ranks {
                *phase.entry(rank).or_default() += amount / u64::from(ranks);
            }
            continue;
        }
        let mut at = Some(NodeId(node));
        while let Some(n) = at {
            if let Some(&rank) = pieces.get(&n.0) {
                *phase.entry(rank).or_default() += amount;
                break;
            }
            at = n.parent();
        }
    }
    work
}

fn summary(log: &TaskLog, place: &Placement, traffic: &PhaseTraffic, hardware: &Hardware) -> Prediction {
    let work = work_by_rank(log, place);
    let busiest = |phase: Phase| work.get(&phase).and_then(|w| w.values().copied().max()).unwrap_or(0);
    let loads = traffic.phases();
    let mut phases = Vec::new();
    let mut compute = hardware.fixed;
    for phase in Phase::ALL {
        let (rounds, load) = loads.get(&phase).copied().unwrap_or_default();
        let busiest_work = busiest(phase);
        if rounds == 0 && busiest_work == 0 {
            continue;
        }
        let rate = hardware.phase_rates.get(phase.name()).copied().unwrap_or(hardware.rate);
        compute += busiest_work as f64 / rate;
        let (messages, bytes) = (load.messages, load.bytes);
        phases.push(PhasePrediction { name: phase.name(), rounds, messages, bytes, busiest_work });
    }
    let (mut bsp, mut loggp) = (0.0, 0.0);
    for (_, round) in traffic.rounds() {
        let most = round.most();
        let (messages, bytes) = (most.messages as f64, most.bytes as f64);
        bsp += bytes / hardware.bandwidth + hardware.latency;
        loggp += hardware.latency
            + (messages + 1.0) * hardware.overhead
            + (bytes - messages).max(0.0) / hardware.bandwidth;
    }
    let (rounds, all) = traffic.total();
    let total_work: u64 = log.charges.iter().map(|c| c.2).sum();
    let d = f64::from(log.dimension);
    let (n, p) = (log.population as f64, f64::from(place.workers));
    let record = (8.0 * d) + 20.0;
    let depth = phases.iter().map(|ph| depth_of(log, ph.name)).sum::<u64>();
    Prediction {
        workers: place.workers,
        exact: log.blocks.is_multiple_of(place.workers),
        rounds,
        messages: all.messages,
        bytes: all.bytes,
        surface_ratio: all.bytes as f64 / (n.powf(1.0 - 1.0 / d) * p.powf(1.0 / d) * record),
        busiest_work: phases.iter().map(|ph| ph.busiest_work).sum(),
        brent: total_work / u64::from(place.workers) + depth,
        bsp: PredictedSeconds { compute, communicate: bsp },
        loggp: PredictedSeconds { compute, communicate: loggp },
        phases,
    }
}

/// Returns the longest chain of a phase's charges down the tree.
fn depth_of(log: &TaskLog, name: &str) -> u64 {
    let Some(phase) = Phase::ALL.into_iter().find(|p| p.name() == name) else { return 0 };
    let mut ends: BTreeMap<u64, u64> = BTreeMap::new();
    let mut longest = 0;
    // Paths are sorted, so a parent precedes its children.
    for &(_, node, _, depth) in log.charges.iter().filter(|c| c.0 == phase) {
        let above = NodeId(node).parent().and_then(|p| ends.get(&p.0)).copied().unwrap_or(0);
        let end = above + depth;
        ends.insert(node, end);
        longest = longest.max(end);
    }
    longest
}

/// Returns the smallest of these numbers of workers for which BSP predicts more communication than computation.
pub fn takes_over(predictions: &[Prediction]) -> Option<u32> {
    predictions.iter().find(|p| p.bsp.communicate > p.bsp.compute).map(|p| p.workers)
}
