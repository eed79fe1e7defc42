//! Runs that triangulate.

use std::sync::Arc;
use std::time::Instant;

use septet_geometry::point::{Coordinates, Point, PointSlice};

use crate::coordinator::Coordinator;
use crate::error::Error;
use crate::input::Whole;
use crate::result::run::Run;
use crate::run::finish::{Times, certify, cost_trace, finish, flat_result};
use crate::run::settings::{Settings, admit};
use crate::run::transport::{Start, started};
use crate::spec::{Spec, Task};

/// Computes the Delaunay triangulation of `points`. The result is exact and certified. It is the same for every
/// number of workers and threads and every transport.
///
/// Coincident points count once (see [`Run::points`]). If the points do not span the space, there are no cells. This
/// function does not count work and depth; [`simulate`] does.
///
/// # Errors
/// See [`Error`].
pub fn triangulate<C: Coordinates>(points: &[C], spec: &Spec) -> Result<Run, Error> {
    run(C::points(points), spec, false)
}

/// Computes the Delaunay triangulation of `points` by the paper's recursion down to the leaf size, and counts work and
/// depth.
///
/// # Errors
/// See [`Error`].
pub fn simulate<C: Coordinates>(points: &[C], spec: &Spec) -> Result<Run, Error> {
    run(C::points(points), spec, true)
}

/// Runs [`simulate`] (`counted`) or [`triangulate`] in either dimension. It is compiled here, so that callers do not
/// compile the machine.
#[inline(never)]
fn run(points: PointSlice<'_>, spec: &Spec, counted: bool) -> Result<Run, Error> {
    match points {
        PointSlice::Plane(points) => run_on(points, spec, counted, &mut started(spec)),
        PointSlice::Space(points) => run_on(points, spec, counted, &mut started(spec)),
    }
}

/// Runs [`simulate`] (`counted`) or [`triangulate`] on a machine that `start_machine` starts. The transport of the
/// configuration is not used.
///
/// # Errors
/// See [`Error`].
pub fn run_on<P: Point>(
    points: &[P],
    spec: &Spec,
    counted: bool,
    start_machine: &mut Start<'_, P>,
) -> Result<Run, Error> {
    let call = Instant::now();
    let task = if counted { Task::Simulate } else { Task::Triangulate };
    admit(spec, task, points.len() as u64, P::DIM)?;
    let input = Whole::points(points);
    let settings = Settings::decide(spec, task, input, start_machine)?;
    let preparing = call.elapsed();
    let times = Times { call, preparing, machine: Instant::now() };
    let machine = Arc::new(settings.machine.clone());
    let mut hosts = start_machine(&machine);
    let coordinator = Coordinator::new(&spec.control, machine);
    let collected = coordinator.run(hosts.as_mut(), input, &settings.plan)?;
    drop(hosts);
    let refusal = settings.check(collected.input.population.count);
    if collected.input.is_flat(P::DIM) || refusal.is_err() {
        collected.check_balance()?;
        return refusal.map(|()| flat_result(P::DIM, &collected.input, &settings, call));
    }
    let refutation = certify(&collected.certified.totals, collected.input.population, counted)?;
    if refutation.is_none() {
        // The totals and their messages.
        collected.check_balance()?;
    }
    let plan = settings.planning;
    let run = finish(collected, &settings, &times)?;
    let costs = cost_trace(&settings.machine)?;
    let run = Run { plan, refutation, costs, ..run };
    match refutation {
        None => Ok(run),
        Some(refutation) => Err(Error::NotCertified { refutation, run: Box::new(run) }),
    }
}
