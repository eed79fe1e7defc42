//! The calls of the library in one process.

use septet_geometry::coordinates::{Coordinates, HigherSlice, PointSlice};
use septet_geometry::point::Point;
use septet_protocol::wire::Processes;
use septet_workers::config::cores::within;

use crate::error::{Error, SiteError};
use crate::input::Whole;
use crate::result::outcome::Outcome;
use crate::run::hosts::started;
use crate::run::periodic::{run_periodic, run_shared};
use crate::run::processes::{HeldRows, run_held};
use crate::run::{Hosts, Start, certified, run};
#[cfg(not(feature = "dimensions"))]
use crate::spec::SpecError;
use crate::spec::{Spec, Task, Until};

/// Computes the Delaunay triangulation of `points`. The result is exact and certified. It is the same for every
/// number of workers and threads and every transport.
///
/// Points with weights ([`septet_geometry::site::Weighted`]) have a regular triangulation. Sites above its lower hull are
/// hidden ([`crate::result::outcome::LeftOut::hidden`]).
///
/// Points in a periodic box ([`crate::spec::InputRules::periodic`]) have a periodic triangulation (the module `periodic` of `run` has the proofs).
///
/// Coincident points count once ([`crate::result::outcome::Facts::points`]). If the points do not span the space, there are
/// no cells. This function does not count work and depth; [`simulate`] does.
///
/// # Errors
/// See [`Error`].
pub fn triangulate<C: Coordinates>(points: &[C], spec: &Spec) -> Result<Outcome, Error> {
    certified(perform(C::points(points), (spec, Task::Triangulate))?)
}

/// Computes the Delaunay triangulation of `points` by the paper's recursion down to the leaf size, and counts work and
/// depth. Points with weights have a regular triangulation, as in [`triangulate`].
///
/// # Errors
/// See [`Error`].
pub fn simulate<C: Coordinates>(points: &[C], spec: &Spec) -> Result<Outcome, Error> {
    certified(perform(C::points(points), (spec, Task::Simulate))?)
}

/// Counts the paper's recursion, either completely, as [`simulate`] does, or up to a phase. The tree and the neighbours take a
/// fraction of the time and memory of a triangulation.
///
/// # Errors
/// See [`Error`].
pub fn count<C: Coordinates>(points: &[C], until: Option<Until>, spec: &Spec) -> Result<Outcome, Error> {
    certified(perform(C::points(points), (spec, until.map_or(Task::Simulate, Task::Count)))?)
}

/// Computes a maximal independent set of the conflict graph of sites. The first `fixed` sites are members from the start. The
/// set is in [`crate::result::outcome::Kept::selected`].
///
/// Sites p and q of sizes f(p) and f(q) conflict iff `|p - q| < min(f(p), f(q))` (paper, Section 5, as the guide reads it). The
/// conflict graph is the density graph with alpha 1 of balls with given radii, except that the density graph compares with
/// `<=`. The squared radius of a site is therefore the float below its squared size, which turns `<=` into `<` without
/// rounding. The run has the phases of [`simulate`] with given radii up to the graph. Rounds of local priorities follow, whose
/// proofs are in the module `independent` of `septet_workers`.
///
/// The greedy algorithm, in the order of
/// [`septet_geometry::priority`], selects the same set. The set is the same for every number of workers and threads and every
/// transport. Permuting the sites does not change which sites are selected.
///
/// [`Spec::recursion`] and [`Spec::keep`] are not used, except for the calls of primitives.
///
/// # Errors
/// Returns an [`Error`], which contains a [`SiteError`] if the sites are invalid.
pub fn independent<C: Coordinates>(
    places: &[C],
    sizes: &[f64],
    fixed: usize,
    spec: &Spec,
) -> Result<Outcome, Error> {
    SiteError::check(places.len(), sizes, fixed)?;
    let task = Task::Independent { fixed: fixed as u64 };
    let outcome = sized(C::points(places), sizes, (spec, task))?;
    match outcome.left_out.duplicates.first() {
        Some(&(second, first)) => {
            Err(SiteError::Coincident { first: first as usize, second: second as usize }.into())
        }
        None => Ok(outcome),
    }
}

/// Runs a task over points in this process. A failed certificate is not an error
/// ([`crate::result::outcome::Facts::refutation`]).
///
/// # Errors
/// See [`Error`].
pub fn perform(points: PointSlice<'_>, order: (&Spec, Task)) -> Result<Outcome, Error> {
    sized(points, &[], order)
}

/// Runs a task over the rows of all processes. Returns `None` on a process without ranks. A failed certificate is not an error
/// ([`crate::result::outcome::Facts::refutation`]), because the counts of the run are still reported. The cells in a periodic
/// box are in the outcome of the first process.
///
/// # Errors
/// See [`Error`]. All processes with ranks return an error, and the others do not.
pub fn perform_held(
    processes: &mut Processes<'_>,
    held: HeldRows<'_>,
    order: (&Spec, Task),
) -> Result<Option<Outcome>, Error> {
    on_threads(order.0, || match &order.0.input.periodic {
        Some(periodic) => run_shared(processes, held, periodic, order),
        None => run_held(processes, held, order),
    })
}

/// Runs a task over points or sites, on the threads of the specification.
fn sized(points: PointSlice<'_>, sizes: &[f64], order: (&Spec, Task)) -> Result<Outcome, Error> {
    on_threads(order.0, || machine_run(points, sizes, order))
}

/// Calls `f` with the threads and the flag of a specification.
fn on_threads<T>(spec: &Spec, f: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    within(spec.machine.thread_count(), spec.control.cancel.clone(), f)?
}

/// Runs a task over points or sites in any dimension. It is compiled here, so that callers do not compile the machine.
#[inline(never)]
fn machine_run(points: PointSlice<'_>, sizes: &[f64], order: (&Spec, Task)) -> Result<Outcome, Error> {
    if let Some(periodic) = &order.0.input.periodic {
        return run_periodic(points, periodic, order);
    }
    match points {
        PointSlice::Plane(positions) => run(
            order,
            Whole { positions, sizes }.held(),
            &mut Hosts::Own(&mut started(order, positions.len())),
        ),
        PointSlice::Space(positions) => run(
            order,
            Whole { positions, sizes }.held(),
            &mut Hosts::Own(&mut started(order, positions.len())),
        ),
        PointSlice::WeightedPlane(positions) => run(
            order,
            Whole { positions, sizes }.held(),
            &mut Hosts::Own(&mut started(order, positions.len())),
        ),
        PointSlice::WeightedSpace(positions) => run(
            order,
            Whole { positions, sizes }.held(),
            &mut Hosts::Own(&mut started(order, positions.len())),
        ),
        PointSlice::Higher(points) => higher(points, sizes, order),
    }
}

/// Runs a task over points of dimension 4, 5 or 6.
#[cfg(feature = "dimensions")]
fn higher(points: HigherSlice<'_>, sizes: &[f64], order: (&Spec, Task)) -> Result<Outcome, Error> {
    match points {
        HigherSlice::Four(positions) => run(
            order,
            Whole { positions, sizes }.held(),
            &mut Hosts::Own(&mut started(order, positions.len())),
        ),
        HigherSlice::Five(positions) => run(
            order,
            Whole { positions, sizes }.held(),
            &mut Hosts::Own(&mut started(order, positions.len())),
        ),
        HigherSlice::Six(positions) => run(
            order,
            Whole { positions, sizes }.held(),
            &mut Hosts::Own(&mut started(order, positions.len())),
        ),
    }
}

/// Refuses points of dimension 4, 5 or 6.
#[cfg(not(feature = "dimensions"))]
fn higher(points: HigherSlice<'_>, _sizes: &[f64], _order: (&Spec, Task)) -> Result<Outcome, Error> {
    Err(SpecError::Dimensions { dimension: points.dimension() }.into())
}

/// Runs a task over points on a machine that `start` starts. The transport of the specification is not used.
///
/// # Errors
/// See [`Error`].
pub fn run_on<P: Point>(
    points: &[P],
    order: (&Spec, Task),
    start: &mut Start<'_, P>,
) -> Result<Outcome, Error> {
    on_threads(order.0, || certified(run(order, Whole::points(points).held(), &mut Hosts::Own(start))?))
}
