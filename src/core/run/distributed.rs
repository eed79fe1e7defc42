//! Runs by several processes, each of which holds a part of the points.
//!
//! **Statement.** Every process runs some ranks of one machine. The union of the shares of all processes is the triangulation
//! of the union of their points. All ranks have the same totals, so all processes come to the same decision on the
//! certificate, and return the same error if there is one.

use std::ops::Range;

use glam::{DVec2, DVec3};
use septet_geometry::coordinates::Coordinates;
use septet_geometry::point::Point;
use septet_geometry::site::Weighted;
use septet_protocol::ids::Rank;
use septet_protocol::transport::{Placement, ProcessTransport};
use septet_workers::config::cores::within;
use septet_workers::input::{Rows, Source};

use crate::error::Error;
use crate::input::Held;
use crate::result::outcome::Outcome;
use crate::run::hosts::end_all;
use crate::run::{Hosts, certified, run};
use crate::spec::{Spec, SpecError, Task, Workers};

/// Point types of [`triangulate`] and [`simulate`]: `[f64; 2]`, `[f64; 3]`, [`DVec2`], [`DVec3`] and [`Weighted`]. The machine is compiled in this crate for each of them.
pub trait ProcessPoint: Coordinates {
    /// The type of the points in messages: [`DVec2`], [`DVec3`] or [`Weighted`].
    type Point: Point;

    /// Runs a task for this type.
    ///
    /// # Errors
    /// See [`Error`].
    #[doc(hidden)]
    fn run(
        transport: &mut dyn ProcessTransport<Self::Point>,
        points: &[Self],
        first_id: u64,
        order: (&Spec, Task),
    ) -> Result<Outcome, Error>;
}

macro_rules! process_point {
    ($type:ty, $point:ty) => {
        impl ProcessPoint for $type {
            type Point = $point;

            fn run(
                transport: &mut dyn ProcessTransport<$point>,
                points: &[Self],
                first_id: u64,
                order: (&Spec, Task),
            ) -> Result<Outcome, Error> {
                let points: &[$point] = bytemuck::cast_slice(points);
                run_of_process(transport, points, first_id, order)
            }
        }
    };
}
process_point!(DVec2, DVec2);
process_point!(DVec3, DVec3);
process_point!([f64; 2], DVec2);
process_point!([f64; 3], DVec3);
process_point!(Weighted<DVec2>, Weighted<DVec2>);
process_point!(Weighted<DVec3>, Weighted<DVec3>);

/// Computes the Delaunay triangulation of the points of all processes, and returns the shares of the workers of this process.
/// The call is collective: every process calls it once, with equal `spec`, except for the threads, the limit of the memory,
/// and the control. By default, each process has one worker.
///
/// The input indices of `points` are `first_id`, `first_id + 1`, and so on. Points of different processes must have
/// different indices. If there are more points than indices between the smallest and the largest, the run fails. Other
/// repeated indices are not always detected. Among coincident points, the point with the smallest index is a vertex.
/// Processes may have different numbers of points, and a process may have no points.
///
/// # Errors
/// See [`Error`]. If a process fails, all processes return the same error. Two exceptions remain: only the process
/// that was cancelled returns [`Error::Interrupted`], and processes with different specifications may return different errors.
/// After an error, the transport cannot be used again.
pub fn triangulate<C: ProcessPoint>(
    transport: &mut dyn ProcessTransport<C::Point>,
    points: &[C],
    first_id: u64,
    spec: &Spec,
) -> Result<Outcome, Error> {
    C::run(transport, points, first_id, (spec, Task::Triangulate))
}

/// Simulates the paper's recursion over the points of all processes, as [`triangulate`] triangulates them. The counts of the
/// workers of this process are in [`Outcome::own_counts`].
///
/// # Errors
/// See [`triangulate`].
pub fn simulate<C: ProcessPoint>(
    transport: &mut dyn ProcessTransport<C::Point>,
    points: &[C],
    first_id: u64,
    spec: &Spec,
) -> Result<Outcome, Error> {
    C::run(transport, points, first_id, (spec, Task::Simulate))
}

/// The points of a process, as the source of its workers.
struct OwnRows<'a, P> {
    points: &'a [P],
    /// Input index of the first point.
    first_id: u64,
    /// The workers of the process.
    workers: Range<Rank>,
}

impl<P: Point> Source<P> for OwnRows<'_, P> {
    fn block(&self, block: u32, _: u32) -> Rows<P> {
        let Range { start, end } = self.workers;
        Rows::of_whole(self.first_id, self.points, &[], block + 1 - start, end - start)
    }
}

fn run_of_process<P: Point>(
    transport: &mut dyn ProcessTransport<P>,
    points: &[P],
    first_id: u64,
    order: (&Spec, Task),
) -> Result<Outcome, Error> {
    let processes = transport.processes();
    let workers = workers_of(order.0, processes);
    let Some(placement) = Placement::new(workers, processes) else {
        return Err(end_all(transport, SpecError::TooFewWorkers { workers, processes }.into()));
    };
    let workers = placement.workers_of(transport.process());
    let source = &OwnRows { points, first_id, workers };
    let held = Held { source, points, first: first_id, rows: points.len() as u64 };
    let (threads, cancel) = (order.0.machine.threads.unwrap_or(1), order.0.control.cancel.clone());
    within(threads, cancel, || certified(run(order, held, &mut Hosts::Team { transport, placement })?))?
}

/// Returns the number of workers of this number of processes: by default, one for each.
pub(super) fn workers_of(spec: &Spec, processes: u32) -> u32 {
    if let Workers::Count(workers) = spec.machine.workers { workers } else { processes }
}
