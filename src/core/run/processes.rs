//! Triangulations and simulations by several processes, each of which reads its block of the rows of one input.
//!
//! Worker `w` of `p` reads the rows from `n (w - 1) / p` to `n w / p`, rounded down, on every transport. A process holds the
//! rows of its workers. If there are more processes than workers, the last ones run no ranks.

use std::ops::Range;

use septet_geometry::point::Point;
use septet_protocol::ledger::{CondensedLedger, Condensing, Ledger, PhaseSet};
use septet_protocol::transport::Placement;
use septet_protocol::wire::Processes;
use septet_workers::input::{Rows, Source, block_of};
use septet_workers::share::{Certificate, distort};
use septet_workers::transport::over_wire::OverWire;

use crate::coordinator::Held;
use crate::error::Error;
use crate::model::Points;
use crate::result::canonical::{Export, Store};
use crate::result::run::Run;
use crate::result::subdomain::Part;
pub use crate::run::distributed::ProcessRun;
use crate::run::distributed::{admitted_workers, end_all, run_held};
use crate::run::settings::admit;
use crate::spec::{Fault, Spec, SpecError, Task};

/// The rows that a process holds.
#[derive(Clone, Copy, Debug)]
pub struct HeldRows<'a> {
    /// The points.
    pub points: &'a Points,
    /// Position of the first of them among the rows of all processes.
    pub first: u64,
    /// Number of rows of all processes.
    pub rows: u64,
    /// The number of the first row of all processes, usually 0. The others are numbered from it on.
    pub base: u64,
}

impl HeldRows<'_> {
    /// Checks that all rows have numbers.
    fn check(&self) -> Result<(), Error> {
        let HeldRows { rows, base, .. } = *self;
        let all = base.checked_add(rows);
        all.map(drop).ok_or(Error::Indices { rows, first: base, last: u64::MAX })
    }
}

/// Returns the places of the ranks of a run by this number of processes.
///
/// # Errors
/// Fails if the configuration asks for a result that several processes cannot have.
pub fn placement(spec: &Spec, processes: u32) -> Result<Placement, Error> {
    let workers = admitted_workers(spec, processes)?;
    Placement::new(workers, processes.min(workers)).ok_or(SpecError::NoWorkers.into())
}

/// Returns the rows that a process must hold, of `rows` in total.
pub fn rows_of(placement: Placement, process: u32, rows: u64) -> Range<u64> {
    let workers = placement.workers();
    let Range { start, end } = placement.workers_of(process);
    let at = |worker: u32| block_of(rows, worker - 1, workers).start;
    at(start)..at(end)
}

/// Triangulates the rows of all processes. Returns `None` on a process without ranks. A failed certificate is not an error
/// ([`ProcessRun::refusal`]), because the counts of the run are still reported.
///
/// # Errors
/// See [`Error`]. All processes with ranks return an error, and the others do not.
pub fn triangulate_held(
    processes: &mut Processes<'_>,
    held: HeldRows<'_>,
    spec: &Spec,
) -> Result<Option<ProcessRun>, Error> {
    run_own(processes, held, (spec, Task::Triangulate))
}

/// Simulates the paper's recursion over the rows of all processes, as [`triangulate_held`] triangulates them.
///
/// # Errors
/// See [`triangulate_held`].
pub fn simulate_held(
    processes: &mut Processes<'_>,
    held: HeldRows<'_>,
    spec: &Spec,
) -> Result<Option<ProcessRun>, Error> {
    run_own(processes, held, (spec, Task::Simulate))
}

/// Runs the ranks of this process, if it has any.
fn run_own(
    processes: &mut Processes<'_>,
    held: HeldRows<'_>,
    order: (&Spec, Task),
) -> Result<Option<ProcessRun>, Error> {
    let placement = placement(order.0, processes.processes())?;
    if processes.process() >= placement.processes() {
        return Ok(None);
    }
    let run = match held.points {
        Points::Plane(points) => run(processes, (points, held), placement, order),
        Points::Space(points) => run(processes, (points, held), placement, order),
    };
    run.map(Some)
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

fn run<P: Point>(
    processes: &mut Processes<'_>,
    (points, held): (&[P], HeldRows<'_>),
    placement: Placement,
    (spec, task): (&Spec, Task),
) -> Result<ProcessRun, Error> {
    let mut transport = OverWire::new(processes, placement);
    let source = GlobalRows { points, held };
    // The forecast is for one process, which holds its share of the points.
    let admitted = held.check().and_then(|()| admit(spec, task, points.len() as u64, P::DIM));
    if let Err(error) = admitted {
        return Err(end_all::<P>(&mut transport, error));
    }
    let held = Held { source: &source, rows: points.len() as u64 };
    run_held(&mut transport, held, placement, (spec, task))
}

impl ProcessRun {
    /// Takes the counts of this process, with sums in place of the rows of subtrees that only one rank charges. `phases` are
    /// those of all processes. If `keeps_nodes` is set, the facts of all nodes remain rows.
    pub fn condense(&mut self, phases: PhaseSet, keeps_nodes: bool) -> CondensedLedger {
        let needs_rows = self.fault.is_some_and(Fault::needs_rows);
        let roots = if needs_rows { &[][..] } else { &self.roots };
        let condensing = Condensing { roots, phases, space: self.part.space, keeps_nodes };
        std::mem::take(&mut self.ledger).condense(&condensing)
    }

    /// Returns the run of all processes for a report, from the united counts of all of them. Its cells are in the parts of the
    /// processes, so it has only their number.
    pub fn into_run(self, mut ledger: CondensedLedger) -> Run {
        let ProcessRun { part, settled, certificate, refutation, fault, phase_seconds, seconds, .. } = self;
        let Part { space, dimension, points, cells, .. } = part;
        let used = points.used;
        let empty = Run { triangulate_seconds: seconds, ..Run::empty(space, dimension, points, settled) };
        if dimension < space as isize {
            // As in one process, such a run has no counts.
            return empty;
        }
        let Certificate { totals, fallback } = certificate;
        let merged = totals.merged;
        distort(&mut ledger.part, fault);
        Run {
            export: Export::new(space, Store::Elsewhere(cells), false),
            hull_facets: merged.hull_facets,
            stars_local: merged.local,
            stars_repaired: merged.repaired,
            exchange_rounds: merged.exchange_rounds,
            fallback,
            ledger: Ledger::of_condensed(ledger, used, space),
            refutation,
            phase_seconds,
            ..empty
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_without_numbers_are_refused() {
        let points = Points::Plane(Vec::new());
        let check = |base| HeldRows { points: &points, first: 0, rows: 10, base }.check();
        assert!([0, 1 << 33, u64::MAX - 10].iter().all(|&base| check(base).is_ok()));
        assert!(matches!(check(u64::MAX - 9), Err(Error::Indices { rows: 10, .. })));
    }
}
