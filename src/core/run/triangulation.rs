//! Runs that triangulate.

use std::sync::Arc;
use std::time::Instant;

use septet_geometry::point::{Coordinates, Point, PointSlice};

use crate::config::{Config, ConfigError};
use crate::coordinator::Coordinator;
use crate::error::Error;
use crate::result::run::Run;
use crate::run::finish::{certify, finish};
use crate::run::record::take_record;
use crate::run::start::{Beginning, Started, started_on};
use crate::run::transport::{Start, started};

/// The Delaunay triangulation of `points`, exact, certified, and the same for every number of workers,
/// threads and every transport.
///
/// Coincident points count once (see [`Run::points`]); points that span less than the space give no cells.
/// Work and depth are not counted: see [`simulate`].
///
/// # Errors
/// See [`Error`].
pub fn triangulate<C: Coordinates>(points: &[C], config: &Config) -> Result<Run, Error> {
    run(C::points(points), config, false)
}

/// The same triangulation by the paper's recursion to its floor, with every count on.
///
/// # Errors
/// See [`Error`].
pub fn simulate<C: Coordinates>(points: &[C], config: &Config) -> Result<Run, Error> {
    run(C::points(points), config, true)
}

/// Both, in either dimension: compiled here, so that callers do not compile the machine.
#[inline(never)]
fn run(points: PointSlice<'_>, config: &Config, counted: bool) -> Result<Run, Error> {
    match points {
        PointSlice::Plane(points) => run_on(points, config, counted, &mut started(config)),
        PointSlice::Space(points) => run_on(points, config, counted, &mut started(config)),
    }
}

/// [`simulate`] (`counted`) or [`triangulate`], on a machine whose workers `start` reaches; the
/// configuration's own transport is not used.
///
/// # Errors
/// See [`Error`].
pub fn run_on<P: Point>(
    points: &[P],
    config: &Config,
    counted: bool,
    start_machine: &mut Start<'_, P>,
) -> Result<Run, Error> {
    let start = Instant::now();
    if let Some(until) = config.until {
        return Err(ConfigError::Stops { until: until.name() }.into());
    }
    let Started { ready, mut machine, why, plan, planning } =
        match started_on(points, config, counted, start, start_machine)? {
            Beginning::Machine(started) => *started,
            Beginning::Flat(run) => return Ok(*run),
        };
    let before = Instant::now();
    let tasks = take_record(config, &mut machine, &ready, start_machine)?;
    let recording = before.elapsed();
    let machine = Arc::new(machine);
    let mut transport = start_machine(&machine)?;
    let collected = Coordinator::new(config, machine.clone()).run(transport.as_mut(), &ready, &plan)?;
    drop(transport);
    let refutation = certify(&collected, ready.positions.len() as u64, P::DIM, machine.workers)?;
    let mut run = finish::<P>(points.len(), &ready, collected, &machine, why, start)?;
    (run.plan, run.refutation, run.tasks) = (planning, refutation, tasks);
    run.triangulate_seconds -= recording.as_secs_f64();
    match refutation {
        None => Ok(run),
        Some(refutation) => Err(Error::NotCertified { refutation, run: Box::new(run) }),
    }
}
