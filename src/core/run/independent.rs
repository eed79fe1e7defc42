//! A maximal independent set of the conflict graph of sites, on the machine.
//!
//! **Statement.** Sites p and q of sizes f(p) and f(q) conflict iff `|p - q| < min(f(p), f(q))` (paper, Section 5, as
//! ARCHITECTURE reads it). This is the density graph with alpha 1 of balls of given radii, but for `<` in the place of
//! `<=`: a site's squared radius is the float below its squared size, which turns one into the other without
//! rounding. So a run is that of [`crate::simulate`] with the radii given: partition, summaries, separator sets by
//! ghosts, graph; then rounds of local priorities (`septet_workers`' `independent`, where the proofs are).
//!
//! **Work and depth.** Those of the phases.

use std::sync::Arc;
use std::time::Instant;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::{Coordinates, Point, PointSlice};
use septet_geometry::range::{scale, scale_exponent};
use septet_protocol::ids::{COORDINATOR, NodeId, Phase};
use septet_protocol::ledger::Ledger;
use septet_protocol::transport::TransportError;
use septet_workers::config::{Correction, GraphRules, Shown, Stop, Task, TreeRules, Wanted, WorkerConfig};

use crate::config::{Config, ConfigError, SeparatorSets, Workers};
use crate::coordinator::{Collected, Coordinator, Plan};
use crate::error::Error as RunError;
pub use crate::error::SiteError;
use crate::input::coincide::coincidences;
use crate::input::prepare::{Prepared, without_negative_zero};
use crate::result::run::{Settled, Traffic};
use crate::run::finish::settled;
use crate::run::memory::forecast_sites;
use crate::run::sizing::{check_machine, plan_leaves};
use crate::run::transport::started;

/// A maximal independent set, and what it took.
#[derive(Clone, Debug)]
pub struct IndependentRun {
    /// Positions of the sites that joined, ascending. Those that were fixed are not among them.
    pub members: Vec<usize>,
    /// How many sites were undecided at the start of each round.
    pub undecided: Vec<u64>,
    /// The counts.
    pub ledger: Ledger,
    /// What was run.
    pub settled: Settled,
    /// What it took to count the leaves before, for [`Workers::Leaves`]; not part of the ledger.
    pub plan: Option<Traffic>,
    /// Measured wall-clock seconds of each phase that occurred, in order.
    pub phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds of the whole call.
    pub seconds: f64,
}

impl IndependentRun {
    /// Number of rounds of local priorities.
    pub fn rounds(&self) -> usize {
        self.undecided.len()
    }
}

/// A maximal independent set of the conflict graph, with the first `fixed` sites in it from the start: that of the
/// greedy algorithm in the order of [`septet_geometry::priority`], the same for every number of workers, threads and
/// every transport. It is a set of positions: in another order of the sites it is the same set of sites.
///
/// What the configuration says of supergraphs, separator sets, neighbours, pictures and records is not used.
///
/// # Errors
/// See [`SiteError`] and [`crate::Error`].
pub fn independent<C: Coordinates>(
    places: &[C],
    sizes: &[f64],
    fixed: usize,
    config: &Config,
) -> Result<IndependentRun, RunError> {
    chosen(C::points(places), sizes, fixed, config)
}

/// In either dimension: compiled here, so that callers do not compile the machine.
#[inline(never)]
fn chosen(
    places: PointSlice<'_>,
    sizes: &[f64],
    fixed: usize,
    config: &Config,
) -> Result<IndependentRun, RunError> {
    match places {
        PointSlice::Plane(places) => choose(places, sizes, fixed, config),
        PointSlice::Space(places) => choose(places, sizes, fixed, config),
    }
}

fn choose<P: Point>(
    places: &[P],
    sizes: &[f64],
    fixed: usize,
    config: &Config,
) -> Result<IndependentRun, RunError> {
    let start = Instant::now();
    config.check()?;
    if let Some(until) = config.until {
        return Err(ConfigError::Stops { until: until.name() }.into());
    }
    if let Some(limit) = config.max_memory {
        let forecast = forecast_sites(places.len() as u64, P::DIM);
        if forecast > limit {
            return Err(RunError::Memory { forecast, limit, points: places.len() as u64 });
        }
    }
    let ready = prepare_sites(places, sizes, fixed)?;
    let mut machine = machine_of::<P>(fixed as u64, config);
    let (plan, planning) = match config.workers {
        Workers::Count(workers) => {
            machine.workers = workers;
            (Plan::new(), None)
        }
        Workers::Leaves => {
            let (plan, traffic) = plan_leaves(config, &machine, &ready, &mut started(config))?;
            machine.workers = plan.get(&NodeId::ROOT).copied().unwrap_or(1);
            (plan, Some(traffic))
        }
    };
    let sites = ready.positions.len() as u64;
    check_machine(&machine, sites)?;
    let machine = Arc::new(machine);
    let mut transport = started(config)(&machine)?;
    let mut collected = Coordinator::new(config, machine.clone()).run(transport.as_mut(), &ready, &plan)?;
    drop(transport);
    check_parts(&collected, &machine)?;
    collected.members.sort_unstable();
    Ok(IndependentRun {
        members: collected.members.into_iter().map(|id| id as usize).collect(),
        undecided: collected.undecided,
        ledger: Ledger::finish(collected.ledger, sites),
        settled: settled(&machine, collected.supergraph, "sizes as given".to_string()),
        plan: planning,
        phase_seconds: collected.seconds,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Checks sites and brings them into the exact range, sizes with them.
fn prepare_sites<P: Point>(
    places: &[P],
    sizes: &[f64],
    fixed: usize,
) -> Result<Prepared<'static, P>, RunError> {
    if places.len() != sizes.len() {
        return Err(SiteError::Lengths { places: places.len(), sizes: sizes.len() }.into());
    }
    if fixed > places.len() {
        return Err(SiteError::Fixed { fixed, sites: places.len() }.into());
    }
    if let Some(index) = sizes.iter().position(|&size| !(size > 0.0 && size < f64::INFINITY)) {
        return Err(SiteError::Size { index, size: sizes[index] }.into());
    }
    let exponent = scale_exponent(places)?;
    let positions: Vec<P> = places.iter().map(|&p| scaled(without_negative_zero(p), exponent)).collect();
    if let Some(&(second, first)) = coincidences(&positions).first() {
        return Err(SiteError::Coincident { first: first as usize, second: second as usize }.into());
    }
    let radius2 = |&size: &f64| squared_radius(scaled(P::splat(size), exponent).coord(0));
    Ok(Prepared::of_sites(positions, sizes.iter().map(radius2).collect(), exponent))
}

fn scaled<P: Point>(p: P, exponent: i32) -> P {
    if exponent == 0 { p } else { scale(p, exponent) }
}

/// The largest float below the square, so that `d2 <= radius2` iff `d2 < size * size`: for a square beyond all floats
/// the largest one, which no squared distance in the range exceeds; for one that vanishes 0, which none reaches.
fn squared_radius(size: f64) -> f64 {
    (size * size).next_down().max(0.0)
}

/// The machine, but for the number of workers.
fn machine_of<P: Point>(fixed: u64, config: &Config) -> WorkerConfig {
    WorkerConfig {
        run: config.run.unwrap_or(config.seed),
        seed: config.seed,
        task: Task::Independent { fixed },
        workers: 1,
        counted: true,
        tree: TreeRules {
            leaf: config.leaf.unwrap_or(if P::DIM == 3 { LEAF[1] } else { LEAF[0] }),
            balanced: false,
            partition: config.partition,
        },
        graph: GraphRules {
            wanted: Wanted::Fixed(Supergraph::Density { alpha: 1.0 }),
            sets: SeparatorSets::Ghost,
            correction: Correction::Descent,
        },
        shown: Shown::default(),
        until: None,
        exchange_cap: None,
        fault: config.fault,
        stop: Stop::new(config.cancel.clone()),
    }
}

/// Largest leaf in the plane and in space. A leaf's search is linear ([`septet_geometry::grid`]), so it may be larger
/// than where all pairs are taken, and the tree lower; beyond this its members leave the fast memory.
const LEAF: [u64; 2] = [2000, 4000];

/// Have all workers reported?
fn check_parts(collected: &Collected, machine: &WorkerConfig) -> Result<(), RunError> {
    if collected.parts == machine.workers {
        return Ok(());
    }
    let reason = format!("{} of {} ledgers arrived", collected.parts, machine.workers);
    Err(TransportError::WorkerFailed { rank: COORDINATOR, reason }.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squared_radii_make_the_comparison_strict() {
        for size in [1e-300, 1e-20, 0.1, 1.0, 3.0, 1e20, 1e200] {
            let (square, r2) = (size * size, squared_radius(size));
            for d2 in [square, square.next_down(), square.next_up(), 1e-130, 1.0, 1e120] {
                if d2.is_finite() && d2 > 0.0 {
                    assert_eq!(d2 <= r2, d2 < square, "{size} {d2}");
                }
            }
        }
    }
}
