//! Predicted times of a machine, from the counts of a run with the same number of workers.
//!
//! **Statement.** The ledger of a run counts the work, the messages and the bytes of every rank in every round
//! ([`septet_protocol::ledger::RankTally`]). These counts depend on the points, the parameters and the number of
//! workers, but not on the threads and the transport of the run. A computer with two cores can therefore count a
//! machine with thousands of workers, and a cost model turns the counts into seconds.
//!
//! **Models.** All ranks wait for each other at the end of a round, so each round costs the time of its slowest rank.
//! - In BSP (Valiant 1990), a round costs `max work / rate + h / bandwidth + latency`. Here `h` is the largest number
//!   of bytes that one rank sends or receives.
//! - In `LogGP` (Alexandrov et al. 1995), the computation costs the same, and the gap equals the overhead. A rank with
//!   `m` messages, sent and received, and `b` bytes in the direction with more bytes needs
//!   `m overhead + b / bandwidth`. The communication of the round costs the largest of these times, plus the latency.
//! - Brent's bound on the steps with p processors is `work / p + depth`, with the work and depth of all groups of phases.
//!
//! A round without messages has no communication. A phase may charge the work of several rounds in the last of them.
//! The maximum over the ranks of the sum is at most the sum of the maxima, so the prediction may be too low.

use septet_core::{Outcome, TrafficTotal};
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::ledger::{Ledger, PhaseTotal};
use serde::Serialize;
use std::collections::BTreeMap;

mod calibrate;
mod hardware;
mod round;

pub use calibrate::calibrate;
pub use hardware::Hardware;

use round::rounds;

/// The prediction for one number of workers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Prediction {
    /// Number of workers.
    pub workers: u32,
    /// The messages of all phases.
    #[serde(flatten)]
    pub traffic: TrafficTotal,
    /// Bytes divided by the size of `n^(1-1/d) p^(1/d)` point records. This number of points lies on the surfaces of p
    /// subdomains.
    pub surface_ratio: f64,
    /// Charged work of the busiest rank of each round, summed over the rounds.
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PredictedSeconds {
    /// Computation of the slowest rank of each round, summed over all rounds, plus the time that does not depend on the
    /// workers.
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PhasePrediction {
    /// The counts.
    #[serde(flatten)]
    pub total: PhaseTotal,
    /// Work of the rank with the most work in this phase.
    pub busiest_work: u64,
}

/// Predicts the times of the machine that made a run, on other hardware. The run must have counted its work
/// ([`septet_core::simulate`]).
pub fn predict(run: &Outcome, hardware: &Hardware) -> Prediction {
    let ledger = &run.ledger;
    let workers = run.settled.workers.max(1);
    let (mut work, mut compute) = (0, hardware.fixed);
    let (mut bsp, mut loggp) = (0.0, 0.0);
    for round in rounds(ledger, hardware) {
        work += round.work;
        compute += round.compute;
        if round.bytes > 0 {
            bsp += round.bytes as f64 / hardware.bandwidth + hardware.latency;
            loggp += round.transfer + hardware.latency;
        }
    }
    let traffic = TrafficTotal::of(ledger);
    let total = ledger.totals.sum();
    Prediction {
        workers,
        traffic,
        surface_ratio: traffic.bytes as f64 / surface_bytes(run, workers),
        busiest_work: work,
        brent: total.work / u64::from(workers) + total.depth,
        bsp: PredictedSeconds { compute, communicate: bsp },
        loggp: PredictedSeconds { compute, communicate: loggp },
        phases: phases(ledger),
    }
}

/// Returns the size of `n^(1-1/d) p^(1/d)` point records, at least one record.
fn surface_bytes(run: &Outcome, workers: u32) -> f64 {
    let (n, p, d) = (run.points.used as f64, f64::from(workers), run.space as f64);
    let record = 8.0 * d + 20.0;
    (n.powf(1.0 - 1.0 / d) * p.powf(1.0 / d)).max(1.0) * record
}

/// Returns the predictions for each phase.
fn phases(ledger: &Ledger) -> Vec<PhasePrediction> {
    let mut work: BTreeMap<Phase, BTreeMap<Rank, u64>> = BTreeMap::new();
    for (key, tally) in &ledger.part.ranks {
        *work.entry(key.phase).or_default().entry(key.rank).or_default() += tally.work;
    }
    let busiest = |phase| work.get(&phase).and_then(|ranks| ranks.values().max()).copied().unwrap_or(0);
    let row = |total: &PhaseTotal| PhasePrediction { total: *total, busiest_work: busiest(total.phase) };
    ledger.phases.iter().map(row).collect()
}

/// Returns the smallest of these numbers of workers for which BSP predicts more communication than computation.
pub fn takes_over(predictions: &[Prediction]) -> Option<u32> {
    predictions.iter().find(|p| p.bsp.communicate > p.bsp.compute).map(|p| p.workers)
}
