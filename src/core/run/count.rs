//! A run for its counts only, complete or stopped before the triangulation.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use septet_geometry::point::{Coordinates, Point, PointSlice};
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;

use crate::coordinator::Coordinator;
use crate::error::Error;
use crate::input::Whole;
use crate::result::cost_trace::CostTrace;
use crate::result::run::{Run, Settled};
use crate::run::finish::{cost_trace, flat_result};
use crate::run::settings::{Settings, admit};
use crate::run::transport::started;
use crate::run::triangulation::simulate;
use crate::spec::{Spec, Task, Until};

/// The counts of a run, complete or stopped after a phase.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RunCounts {
    /// 2 or 3.
    pub space: usize,
    /// Number of distinct points.
    pub points: u64,
    /// The parameters of the run. A run that stops builds no supergraph.
    pub settled: Settled,
    /// The counts of all phases up to the last.
    pub ledger: Ledger,
    /// Measured wall-clock seconds of each phase that occurred, in order.
    pub phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds of the whole call.
    pub seconds: f64,
    /// The calls of primitives, if requested.
    pub costs: Option<CostTrace>,
    /// The result of the remaining phases. `None` if the run stopped before them.
    pub end: Option<Ending>,
}

/// The result of a complete run besides the counts of its phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Ending {
    /// Number of triangles or tetrahedra.
    pub cells: u64,
    /// Number of stars that splaying changed.
    pub stars_repaired: u64,
    /// Rounds of splaying.
    pub exchange_rounds: u64,
    /// Number of points gathered because splaying was cut short.
    pub gathered: u64,
}

impl Ending {
    /// Returns the ending of a run.
    pub fn of(run: &Run) -> Ending {
        Ending {
            cells: run.cell_count() as u64,
            stars_repaired: run.stars_repaired,
            exchange_rounds: run.exchange_rounds,
            gathered: run.fallback.as_ref().map_or(0, |f| f.1),
        }
    }
}

impl From<Run> for RunCounts {
    fn from(run: Run) -> Self {
        let end = Ending::of(&run);
        RunCounts {
            space: run.space,
            points: run.points.used,
            settled: run.settled,
            ledger: run.ledger,
            phase_seconds: run.phase_seconds,
            seconds: run.total_seconds,
            costs: run.costs,
            end: Some(end),
        }
    }
}

/// Counts the paper's recursion, either completely, as [`simulate`] does, or up to a phase. The tree and the
/// neighbours take a fraction of the time and memory of a triangulation.
///
/// # Errors
/// See [`Error`].
pub fn count<C: Coordinates>(points: &[C], until: Option<Until>, spec: &Spec) -> Result<RunCounts, Error> {
    counted(C::points(points), until, spec)
}

/// Counts a run in either dimension. It is compiled here, so that callers do not compile the machine.
#[inline(never)]
fn counted(points: PointSlice<'_>, until: Option<Until>, spec: &Spec) -> Result<RunCounts, Error> {
    match points {
        PointSlice::Plane(points) => counts(points, until, spec),
        PointSlice::Space(points) => counts(points, until, spec),
    }
}

fn counts<P: Point>(points: &[P], until: Option<Until>, spec: &Spec) -> Result<RunCounts, Error> {
    let Some(until) = until else { return simulate(points, spec).map(RunCounts::from) };
    let (start, task) = (Instant::now(), Task::Count(until));
    admit(spec, task, points.len() as u64, P::DIM)?;
    let mut start_machine = started(spec);
    let input = Whole::points(points);
    let settings = Settings::decide(spec, task, input, &mut start_machine)?;
    let machine = Arc::new(settings.machine.clone());
    let mut hosts = start_machine(&machine);
    let coordinator = Coordinator::new(&spec.control, machine);
    let collected = coordinator.run(hosts.as_mut(), input, &settings.plan)?;
    collected.check_balance()?;
    if collected.input.is_flat(P::DIM) {
        return Ok(flat_result(P::DIM, &collected.input, &settings, start).into());
    }
    let points = collected.input.population.count;
    settings.check(points)?;
    Ok(RunCounts {
        space: P::DIM,
        points,
        settled: settings.settled(None, settings.why.clone()),
        ledger: Ledger::finish(collected.ledger, points, P::DIM),
        phase_seconds: collected.seconds,
        seconds: start.elapsed().as_secs_f64(),
        costs: cost_trace(&settings.machine)?,
        end: None,
    })
}
