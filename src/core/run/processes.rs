//! Runs by several processes, each of which reads its block of the rows of one input.
//!
//! Worker `w` of `p` reads the rows from `n (w - 1) / p` to `n w / p`, rounded down, on every transport. A process holds the
//! rows of its workers. If there are more processes than workers, the last ones run no ranks.

use std::ops::Range;

use septet_geometry::coordinates::{HigherSlice, PointSlice};
use septet_geometry::point::Point;
use septet_protocol::transport::Placement;
use septet_protocol::wire::Processes;
use septet_workers::input::{Rows, Source, block_of};
use septet_workers::transport::over_wire::OverWire;

use crate::error::Error;
use crate::input::Held;
use crate::result::outcome::Outcome;
use crate::run::distributed::workers_of;
use crate::run::{Hosts, run_once};
use crate::spec::{Spec, SpecError, Task};

/// The rows that a process holds.
#[derive(Clone, Copy, Debug)]
pub struct HeldRows<'a> {
    /// The points, with or without weights.
    pub points: PointSlice<'a>,
    /// Position of the first of them among the rows of all processes.
    pub first: u64,
    /// Number of rows of all processes.
    pub rows: u64,
    /// The number of the first row of all processes, usually 0. The others are numbered from it on.
    pub base: u64,
}

/// Returns the places of the ranks of a run by this number of processes.
///
/// # Errors
/// Fails if the specification has no workers.
pub fn placement(spec: &Spec, processes: u32) -> Result<Placement, Error> {
    let workers = workers_of(spec, processes);
    Placement::new(workers, processes.min(workers)).ok_or(SpecError::NoWorkers.into())
}

/// Returns the rows that a process must hold, of `rows` in total.
pub fn rows_of(placement: Placement, process: u32, rows: u64) -> Range<u64> {
    let workers = placement.workers();
    let Range { start, end } = placement.workers_of(process);
    let at = |worker: u32| block_of(rows, worker - 1, workers).start;
    at(start)..at(end)
}

/// Runs a task over the rows of all processes, without regard to a periodic box. Returns `None` on a process without ranks.
///
/// # Errors
/// See [`crate::run::calls::perform_held`].
pub(super) fn run_held(
    processes: &mut Processes<'_>,
    held: HeldRows<'_>,
    order: (&Spec, Task),
) -> Result<Option<Outcome>, Error> {
    let placement = placement(order.0, processes.processes())?;
    if processes.process() >= placement.processes() {
        return Ok(None);
    }
    let outcome = match held.points {
        PointSlice::Plane(points) => run_rows(processes, (points, held), placement, order),
        PointSlice::Space(points) => run_rows(processes, (points, held), placement, order),
        PointSlice::WeightedPlane(points) => run_rows(processes, (points, held), placement, order),
        PointSlice::WeightedSpace(points) => run_rows(processes, (points, held), placement, order),
        PointSlice::Higher(points) => run_higher(processes, (points, held), placement, order),
    };
    outcome.map(Some)
}

/// Runs the ranks of this process.
///
/// # Errors
/// See [`Error`].
pub(super) fn run_rows<P: Point>(
    processes: &mut Processes<'_>,
    (points, held): (&[P], HeldRows<'_>),
    placement: Placement,
    order: (&Spec, Task),
) -> Result<Outcome, Error> {
    let source = &GlobalRows { points, held };
    let own = Held { source, points, first: held.base, rows: held.rows };
    let transport = &mut OverWire::new(processes, placement);
    run_once(order, own, &mut Hosts::Team { transport, placement })
}

#[cfg(feature = "dimensions")]
fn run_higher(
    processes: &mut Processes<'_>,
    (points, held): (HigherSlice<'_>, HeldRows<'_>),
    placement: Placement,
    order: (&Spec, Task),
) -> Result<Outcome, Error> {
    match points {
        HigherSlice::Four(points) => run_rows(processes, (points, held), placement, order),
        HigherSlice::Five(points) => run_rows(processes, (points, held), placement, order),
        HigherSlice::Six(points) => run_rows(processes, (points, held), placement, order),
    }
}

/// Refuses points of dimension 4, 5 or 6. All processes have such points, so none of them waits.
#[cfg(not(feature = "dimensions"))]
fn run_higher(
    _processes: &mut Processes<'_>,
    (points, _held): (HigherSlice<'_>, HeldRows<'_>),
    _placement: Placement,
    _order: (&Spec, Task),
) -> Result<Outcome, Error> {
    Err(SpecError::Dimensions { dimension: points.dimension() }.into())
}

/// The points of a process, as the source of its workers.
struct GlobalRows<'a, P> {
    points: &'a [P],
    held: HeldRows<'a>,
}

impl<P: Point> Source<P> for GlobalRows<'_, P> {
    fn block(&self, block: u32, blocks: u32) -> Rows<P> {
        let HeldRows { first, rows, base, .. } = self.held;
        let Range { start, end } = block_of(rows, block, blocks);
        let at = |row: u64| (row.saturating_sub(first) as usize).min(self.points.len());
        Rows::of_whole(base + start, &self.points[at(start)..at(end)], &[], 0, 1)
    }
}
