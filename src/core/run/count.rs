//! A run for its counts alone, whole or stopped before the triangulation.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use septet_geometry::point::{Coordinates, Point, PointSlice};
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::ledger::Ledger;
use septet_protocol::transport::TransportError;
use septet_workers::config::WorkerConfig;

use crate::config::Config;
use crate::coordinator::Coordinator;
use crate::error::Error;
use crate::result::run::{Run, Settled};
use crate::run::finish::settled;
use crate::run::start::{Beginning, Started, started_on};
use crate::run::transport::started;
use crate::run::triangulation::simulate;

/// The counts of a run, whole or stopped after [`Config::until`].
#[derive(Clone, Debug)]
pub struct Counts {
    /// 2 or 3.
    pub space: usize,
    /// Distinct points.
    pub points: u64,
    /// What was run. A run that stops builds no supergraph.
    pub settled: Settled,
    /// The counts of all phases up to the last.
    pub ledger: Ledger,
    /// Measured wall-clock seconds of each phase that occurred, in order.
    pub phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds of the whole call.
    pub seconds: f64,
    /// What the rest of the run left; none if it stopped before.
    pub end: Option<Ending>,
}

/// What a whole run leaves besides the counts of its phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ending {
    /// Number of triangles or tetrahedra.
    pub cells: u64,
    /// Stars that the exchange changed.
    pub stars_repaired: u64,
    /// Rounds of exchange.
    pub exchange_rounds: u64,
    /// Points gathered because the exchange was cut short.
    pub gathered: u64,
}

impl Ending {
    /// Of a run.
    pub fn of(run: &Run) -> Ending {
        Ending {
            cells: run.cell_count() as u64,
            stars_repaired: run.stars_repaired,
            exchange_rounds: run.exchange_rounds,
            gathered: run.fallback.as_ref().map_or(0, |f| f.1),
        }
    }
}

impl From<Run> for Counts {
    fn from(run: Run) -> Self {
        let end = Ending::of(&run);
        Counts {
            space: run.space,
            points: run.points.used,
            settled: run.settled,
            ledger: run.ledger,
            phase_seconds: run.phase_seconds,
            seconds: run.total_seconds,
            end: Some(end),
        }
    }
}

/// Counts the paper's recursion: the whole of it as [`simulate`] does, or up to [`Config::until`]. The tree and
/// the neighbours alone take a fraction of the time and memory of a triangulation.
///
/// # Errors
/// See [`Error`].
pub fn count<C: Coordinates>(points: &[C], config: &Config) -> Result<Counts, Error> {
    counted(C::points(points), config)
}

/// In either dimension: compiled here, so that callers do not compile the machine.
#[inline(never)]
fn counted(points: PointSlice<'_>, config: &Config) -> Result<Counts, Error> {
    match points {
        PointSlice::Plane(points) => counts(points, config),
        PointSlice::Space(points) => counts(points, config),
    }
}

fn counts<P: Point>(points: &[P], config: &Config) -> Result<Counts, Error> {
    let Some(until) = config.until else { return simulate(points, config).map(Counts::from) };
    let start = Instant::now();
    let config = &Config { record_tasks: false, view: 0, ..config.clone() };
    let Started { ready, machine, why, plan, .. } =
        match started_on(points, config, true, start, &mut started(config))? {
            Beginning::Machine(started) => *started,
            Beginning::Flat(run) => return Ok(Counts::from(*run)),
        };
    let machine = Arc::new(WorkerConfig { until: Some(until.phase()), ..machine });
    let mut transport = started(config)(&machine)?;
    let collected = Coordinator::new(config, machine.clone()).run(transport.as_mut(), &ready, &plan)?;
    if collected.parts != machine.workers {
        let reason = format!("{} of {} ledgers arrived", collected.parts, machine.workers);
        return Err(TransportError::WorkerFailed { rank: COORDINATOR, reason }.into());
    }
    let points = ready.positions.len() as u64;
    Ok(Counts {
        space: P::DIM,
        points,
        settled: settled(&machine, None, why),
        ledger: Ledger::finish(collected.ledger, points),
        phase_seconds: collected.seconds,
        seconds: start.elapsed().as_secs_f64(),
        end: None,
    })
}
