//! A maximal independent set of the conflict graph of sites, on the machine.
//!
//! **Statement.** Sites p and q of sizes f(p) and f(q) conflict iff `|p - q| < min(f(p), f(q))` (paper, Section 5, as
//! the guide reads it). The conflict graph is the density graph with alpha 1 of balls with given radii, except that
//! the density graph compares with `<=`. The squared radius of a site is therefore the float below its squared size,
//! which turns `<=` into `<` without rounding.
//!
//! A run has the phases of [`crate::simulate`] with given radii: partition, summaries, separator sets by ghosts, and
//! graph. Rounds of local priorities follow. The proofs are in the module `independent` of `septet_workers`.
//!
//! **Work and depth.** The costs of these phases.

use std::sync::Arc;
use std::time::Instant;

use septet_geometry::point::{Coordinates, Point, PointSlice};
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;
use septet_workers::share::Selected;

use crate::coordinator::{Collected, Coordinator};
use crate::error::Error as RunError;
pub use crate::error::SiteError;
use crate::input::Whole;
use crate::result::cost_trace::CostTrace;
use crate::result::run::{Settled, TrafficTotal};
use crate::run::finish::cost_trace;
use crate::run::settings::{Settings, admit};
use crate::run::transport::started;
use crate::spec::{Spec, Task};

/// A maximal independent set, and the counts of its run.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct IndependentRun {
    /// Positions of the selected sites, ascending, without the fixed ones.
    pub members: Vec<usize>,
    /// Number of undecided sites at the start of each round.
    pub undecided: Vec<u64>,
    /// The counts.
    pub ledger: Ledger,
    /// The parameters of the run.
    pub settled: Settled,
    /// Traffic of the run that counts the leaves for [`crate::spec::Workers::Leaves`]; not part of the ledger.
    pub plan: Option<TrafficTotal>,
    /// The calls of primitives, if requested.
    pub costs: Option<CostTrace>,
    /// Measured wall-clock seconds of each phase that occurred, in order.
    pub phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds of the whole call.
    pub seconds: f64,
}

impl IndependentRun {
    /// Returns the number of rounds of local priorities.
    pub fn rounds(&self) -> usize {
        self.undecided.len()
    }
}

/// Computes a maximal independent set of the conflict graph. The first `fixed` sites are members from the start.
///
/// The greedy algorithm, in the order of [`septet_geometry::priority`], selects the same set. The set is the same for
/// every number of workers and threads and every transport. Permuting the sites does not change which sites are
/// selected.
///
/// The supergraph, the separator sets, the correction and [`Spec::keep`] are not used.
///
/// # Errors
/// Returns an [`crate::Error`], which contains a [`SiteError`] if the sites are invalid.
pub fn independent<C: Coordinates>(
    places: &[C],
    sizes: &[f64],
    fixed: usize,
    spec: &Spec,
) -> Result<IndependentRun, RunError> {
    chosen(C::points(places), sizes, fixed, spec)
}

/// Selects the set in either dimension. It is compiled here, so that callers do not compile the machine.
#[inline(never)]
fn chosen(
    places: PointSlice<'_>,
    sizes: &[f64],
    fixed: usize,
    spec: &Spec,
) -> Result<IndependentRun, RunError> {
    match places {
        PointSlice::Plane(places) => choose(places, sizes, fixed, spec),
        PointSlice::Space(places) => choose(places, sizes, fixed, spec),
    }
}

fn choose<P: Point>(
    places: &[P],
    sizes: &[f64],
    fixed: usize,
    spec: &Spec,
) -> Result<IndependentRun, RunError> {
    let (start, task) = (Instant::now(), Task::Independent { fixed: fixed as u64 });
    admit(spec, task, places.len() as u64, P::DIM)?;
    check_sites(places.len(), sizes, fixed)?;
    let input = Whole { positions: places, sizes };
    let mut start_machine = started(spec);
    let settings = Settings::decide(spec, task, input, &mut start_machine)?;
    let machine = Arc::new(settings.machine.clone());
    let mut hosts = start_machine(&machine);
    let coordinator = Coordinator::new(&spec.control, machine);
    let collected = coordinator.run(hosts.as_mut(), input, &settings.plan)?;
    collected.check_balance()?;
    if let Some(&(second, first)) = collected.input.accounting.duplicates.first() {
        return Err(SiteError::Coincident { first: first as usize, second: second as usize }.into());
    }
    drop(hosts);
    let Collected { shares, ledger, choice, seconds: phase_seconds, .. } = collected;
    let Selected { mut members, undecided } = united(shares.into_iter().map(|share| share.selected));
    members.sort_unstable();
    Ok(IndependentRun {
        members: members.into_iter().map(|id| id as usize).collect(),
        undecided,
        ledger: Ledger::finish(ledger, places.len() as u64, P::DIM),
        settled: settings.settled(choice.supergraph, settings.why.clone()),
        plan: settings.planning,
        costs: cost_trace(&settings.machine)?,
        phase_seconds,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Unites the shares of an independent set, and sums the numbers of undecided points in each round.
fn united(shares: impl Iterator<Item = Selected>) -> Selected {
    let mut all = Selected::default();
    for Selected { mut members, undecided } in shares {
        all.members.append(&mut members);
        let sums = &mut all.undecided;
        sums.resize(sums.len().max(undecided.len()), 0);
        sums.iter_mut().zip(undecided).for_each(|(sum, count)| *sum += count);
    }
    all
}

/// Checks the numbers of places and fixed sites, and the sizes.
fn check_sites(places: usize, sizes: &[f64], fixed: usize) -> Result<(), SiteError> {
    if places != sizes.len() {
        return Err(SiteError::Lengths { places, sizes: sizes.len() });
    }
    if fixed > places {
        return Err(SiteError::Fixed { fixed, sites: places });
    }
    match sizes.iter().position(|&size| !(size > 0.0 && size < f64::INFINITY)) {
        Some(index) => Err(SiteError::Size { index, size: sizes[index] }),
        None => Ok(()),
    }
}
