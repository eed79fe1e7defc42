//! Triangulations by several processes, each of which reads its block of the rows of one input.
//!
//! Worker `w` of `p` reads the rows from `n (w - 1) / p` to `n w / p`, rounded down, on every transport. A process holds the
//! rows of its workers. If there are more processes than workers, the last ones run no ranks.

use std::ops::Range;

use septet_geometry::point::Point;
use septet_protocol::ledger::{Ledger, LedgerPart};
use septet_protocol::transport::Placement;
use septet_protocol::wire::Processes;
use septet_workers::input::{Rows, Source, block_of};
use septet_workers::transport::over_wire::OverWire;

use crate::config::{Config, ConfigError};
use crate::coordinator::Held;
use crate::error::Error;
use crate::model::Points;
use crate::result::canonical::{Export, Store};
use crate::result::run::{Run, Settled};
use crate::run::distributed::{admitted_workers, run_held};

pub use crate::run::distributed::ProcessRun;
use crate::run::finish::NOTHING;
use crate::run::settings::{Goal, admit};

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
pub fn placement(config: &Config, processes: u32) -> Result<Placement, Error> {
    let workers = admitted_workers(config)?;
    Placement::new(workers, processes.min(workers)).ok_or(ConfigError::NoWorkers.into())
}

/// Returns the rows that a process must hold, of `rows` in total.
pub fn rows_of(placement: Placement, process: u32, rows: u64) -> Range<u64> {
    let workers = placement.workers();
    let Range { start, end } = placement.workers_of(process);
    let at = |worker: u32| block_of(rows, worker - 1, workers).start;
    at(start)..at(end)
}

/// Triangulates the rows of all processes. Returns `None` on a process without ranks.
///
/// # Errors
/// See [`Error`]. All processes with ranks return an error, and the others do not.
pub fn triangulate_held(
    processes: &mut Processes<'_>,
    held: HeldRows<'_>,
    config: &Config,
) -> Result<Option<ProcessRun>, Error> {
    let placement = placement(config, processes.processes())?;
    if processes.process() >= placement.processes() {
        return Ok(None);
    }
    let run = match held.points {
        Points::Plane(points) => run(processes, (points, held), placement, config),
        Points::Space(points) => run(processes, (points, held), placement, config),
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
    config: &Config,
) -> Result<ProcessRun, Error> {
    let mut transport = OverWire::new(processes, placement);
    let source = GlobalRows { points, held };
    // The forecast is for one process, which holds its share of the points.
    let admitted =
        held.check().and_then(|()| admit(config, Goal::Triangulation, points.len() as u64, P::DIM));
    if let Err(error) = admitted {
        return Err(super::distributed::end_all::<P>(&mut transport, error));
    }
    run_held(&mut transport, Held { source: &source, rows: points.len() as u64 }, placement, config)
}

impl ProcessRun {
    /// Returns the run of all processes for a report, from the counts of all of them. Its cells are in the parts of the
    /// processes, so it has only their number.
    pub fn into_run(self, ledgers: &[LedgerPart]) -> Run {
        let ProcessRun { part, settled, phase_seconds, seconds, .. } = self;
        if part.dimension < part.space as isize {
            // As in one process, such a run has no counts.
            let settled = Settled { why: NOTHING.to_string(), ..settled };
            let empty = Run::empty(part.space, part.dimension, part.points, settled);
            return Run { triangulate_seconds: seconds, ..empty };
        }
        let mut ledger = LedgerPart::default();
        for part in ledgers {
            ledger.merge(part);
        }
        let used = part.points.used;
        let hull_facets = part.hull_facets;
        Run {
            export: Export::new(part.space, Store::Elsewhere(part.cells), false),
            hull_facets,
            ledger: Ledger::finish(ledger, used),
            phase_seconds,
            triangulate_seconds: seconds,
            ..Run::empty(part.space, part.dimension, part.points, settled)
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
