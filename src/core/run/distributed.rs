//! Triangulations and simulations by several processes, each of which holds a part of the points.
//!
//! **Statement.** Every process runs some ranks of one machine. The union of the parts of all processes is the triangulation
//! of the union of their points. All ranks have the same totals, so all processes come to the same decision on the
//! certificate, and return the same error if there is one.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};
use septet_geometry::point::{Coordinates, Point};
use septet_protocol::ids::{COORDINATOR, NodeId, Phase, Rank};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::Totals;
use septet_protocol::transport::{HostState, Placement, ProcessTransport, TransportError};
use septet_workers::input::{Loaded, Rows, Source};
use septet_workers::share::{Certificate, Share, merged_ledger};
use septet_workers::transport::process::OneProcess;

use crate::coordinator::{Coordinator, Held, Plan, Returned, unbalanced};
use crate::error::{Error, Refutation, incomplete};
use crate::input::Whole;
use crate::result::run::{Accounting, Run, Settled};
use crate::result::subdomain::{Part, Subdomain};
use crate::run::finish::{certify, settled, settled_flat, untimed};
use crate::run::settings::{Settings, admit};
use crate::run::transport::started;
use crate::spec::{Fault, Keep, Spec, SpecError, Task, Workers};

/// Point types of [`triangulate`]: `[f64; 2]`, `[f64; 3]`, [`DVec2`] and [`DVec3`]. The machine is compiled in this crate
/// for each of them.
pub trait ProcessPoint: Coordinates {
    /// The type of the points in messages: [`DVec2`] or [`DVec3`].
    type Point: Point;

    /// Runs [`triangulate`] for this type.
    ///
    /// # Errors
    /// See [`Error`].
    #[doc(hidden)]
    fn triangulate(
        transport: &mut dyn ProcessTransport<Self::Point>,
        points: &[Self],
        first_id: u64,
        spec: &Spec,
    ) -> Result<Part, Error>;
}

macro_rules! process_point {
    ($type:ty, $point:ty) => {
        impl ProcessPoint for $type {
            type Point = $point;

            fn triangulate(
                transport: &mut dyn ProcessTransport<$point>,
                points: &[Self],
                first_id: u64,
                spec: &Spec,
            ) -> Result<Part, Error> {
                let points: &[$point] = bytemuck::cast_slice(points);
                run(transport, Input { points, first_id }, spec)
            }
        }
    };
}
process_point!(DVec2, DVec2);
process_point!(DVec3, DVec3);
process_point!([f64; 2], DVec2);
process_point!([f64; 3], DVec3);

/// Computes the Delaunay triangulation of the points of all processes, and returns the part of this process. The call is
/// collective: every process calls it once, with equal `spec`,
/// except for the threads, the limit of the memory, and the control. By default, each process has one worker.
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
) -> Result<Part, Error> {
    C::triangulate(transport, points, first_id, spec)
}

/// The points of a process.
#[derive(Clone, Copy)]
struct Input<'a, P> {
    points: &'a [P],
    /// Input index of the first point.
    first_id: u64,
}

/// The points of a process, as the source of its workers.
struct OwnRows<'a, P> {
    input: Input<'a, P>,
    /// The workers of the process.
    workers: Range<Rank>,
}

impl<P: Point> Source<P> for OwnRows<'_, P> {
    fn block(&self, block: u32, _: u32) -> Rows<P> {
        let Range { start, end } = self.workers;
        let Input { points, first_id } = self.input;
        Rows::of_whole(first_id, points, &[], block + 1 - start, end - start)
    }
}

fn run<P: Point>(
    transport: &mut dyn ProcessTransport<P>,
    input: Input<'_, P>,
    spec: &Spec,
) -> Result<Part, Error> {
    let placement = match admitted(spec, input, transport.processes()) {
        Ok(placement) => placement,
        Err(error) => return Err(end_all(transport, error)),
    };
    let source = OwnRows { input, workers: placement.workers_of(transport.process()) };
    let held = Held { source: &source, rows: input.points.len() as u64 };
    run_held(transport, held, placement, (spec, Task::Triangulate))?.into_part()
}

/// The result of a process.
pub struct ProcessRun {
    /// The part of the triangulation. It has no cells if the certificate failed.
    pub part: Part,
    /// The counts of the ranks of this process.
    pub ledger: LedgerPart,
    /// The roots of the subtrees of the partition tree that only one rank of this process charges.
    pub(super) roots: Vec<NodeId>,
    /// The parameters of the run. Only the first process has the reason for a supergraph that the coordinator chose.
    pub(super) settled: Settled,
    /// The certificate. Only the first process has the reason of a gathering.
    pub(super) certificate: Certificate,
    /// The reasons why the stars do not form a triangulation. All processes have the same.
    pub(super) refutation: Option<Refutation>,
    /// The planted fault.
    pub(super) fault: Option<Fault>,
    /// Measured wall-clock seconds of each phase that occurred, in order.
    pub(super) phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds of the machine, without the time in which a simulation collects its cells.
    pub(super) seconds: f64,
}

impl ProcessRun {
    /// Returns the message of a failed certificate.
    pub fn refusal(&self) -> Option<String> {
        self.refutation.as_ref().map(Refutation::message)
    }

    /// Returns the part, if the certificate passed.
    fn into_part(self) -> Result<Part, Error> {
        let ProcessRun { part, settled, refutation, .. } = self;
        let Some(refutation) = refutation else { return Ok(part) };
        let run = Run::empty(part.space, part.dimension, part.points, settled);
        let run = Box::new(Run { refutation: Some(refutation), ..run });
        Err(Error::NotCertified { refutation, run })
    }
}

/// Runs the ranks of this process over the rows that it holds.
pub(super) fn run_held<P: Point>(
    transport: &mut dyn ProcessTransport<P>,
    held: Held<'_, P>,
    placement: Placement,
    (spec, task): (&Spec, Task),
) -> Result<ProcessRun, Error> {
    let start = Instant::now();
    let mut settings = Settings::decide(spec, task, Whole::<P>::points(&[]), &mut started(spec))?;
    // The caller placed the workers. By default, each process has one.
    settings.machine.workers = placement.workers();
    settings.machine.shown.with_places = true;
    let coordinator = Coordinator::new(&spec.control, Arc::new(settings.machine.clone()));
    let mut process = OneProcess { transport, placement, threads: spec.machine.threads.unwrap_or(1) };
    let Returned { shares, seconds: phase_seconds } = coordinator.shares(&mut process, held, &Plan::new())?;
    let run = finish(shares, &settings, placement)?;
    let seconds = start.elapsed().as_secs_f64() - untimed(&settings.machine, &phase_seconds);
    Ok(ProcessRun { phase_seconds, seconds, ..run })
}

/// Checks the configuration and the points of this process. Returns the places of the ranks.
fn admitted<P: Point>(spec: &Spec, input: Input<'_, P>, processes: u32) -> Result<Placement, Error> {
    let workers = admitted_workers(spec, processes)?;
    let rows = input.points.len() as u64;
    admit(spec, Task::Triangulate, rows, P::DIM)?;
    if input.first_id.checked_add(rows).is_none() {
        return Err(Error::Indices { rows, first: input.first_id, last: u64::MAX });
    }
    Placement::new(workers, processes).ok_or(SpecError::TooFewWorkers { workers, processes }.into())
}

/// Refuses results that several processes cannot have. Returns the number of workers: by default, one for each process.
pub(super) fn admitted_workers(spec: &Spec, processes: u32) -> Result<u32, Error> {
    let Keep { graph, sets, owner, point_owner, costs, view, nodes: _ } = spec.keep;
    let outputs = [
        (spec.machine.workers == Workers::Leaves, "a worker for each leaf"),
        (graph, "the list of the edges of the supergraph"),
        (sets, "the list of the members of separator sets"),
        (costs, "a cost trace"),
        (owner || point_owner, "an array of owners"),
        (view.is_some_and(|points| points > 0), "a picture"),
    ];
    if let Some(&(_, output)) = outputs.iter().find(|(is_wanted, _)| *is_wanted) {
        return Err(SpecError::NotDistributed { output }.into());
    }
    Ok(if let Workers::Count(workers) = spec.machine.workers { workers } else { processes })
}

/// Ends the run on all processes, because this process cannot start. Returns the error of the run. An error of the
/// configuration keeps its type, because all processes have it.
pub(super) fn end_all<P: Point>(transport: &mut dyn ProcessTransport<P>, error: Error) -> Error {
    let process = transport.process();
    let reason = format!("process {process} does not start: {error}");
    let failed = TransportError::WorkerFailed { rank: process + 1, reason };
    let ended = transport.exchange(Vec::new(), HostState::Failed(failed.clone()));
    match (error, ended) {
        (error @ Error::Spec(_), _) => error,
        (_, Err(first)) => first.into(),
        (_, Ok(_)) => failed.into(),
    }
}

/// The facts of a run that all ranks have.
#[derive(Clone, Copy)]
struct Facts<'a> {
    loaded: &'a Loaded,
    totals: &'a Totals,
}

impl Facts<'_> {
    fn of<P>(share: &Share<P>) -> Facts<'_> {
        Facts { loaded: &share.loaded, totals: &share.certified.totals }
    }

    fn are_those(self, other: Facts<'_>) -> bool {
        let global = |facts: Facts<'_>| {
            let Loaded { survey, population, dimension, .. } = *facts.loaded;
            (survey, population, dimension, *facts.totals)
        };
        global(self) == global(other)
    }

    /// Checks the facts. Returns the exponent of the power of two by which coordinates were multiplied, and the reasons
    /// against the certificate, if there are any. Points that do not span a space of dimension `space` have no certificate.
    ///
    /// # Errors
    /// Fails if messages are missing, if the rows cannot be triangulated, or if cells are missing.
    fn check(self, settings: &Settings, space: usize) -> Result<(i32, Option<Refutation>), Error> {
        let Facts { loaded: Loaded { population, dimension, .. }, totals } = self;
        let rows = self.check_rows(settings);
        let has_stars = rows.is_ok() && *dimension >= space as isize;
        // A message that changed on its way could make the ranks refuse a valid input.
        if !has_stars && totals.balance != 0 {
            return Err(unbalanced());
        }
        let exponent = rows?;
        let refutation =
            if has_stars { certify(totals, *population, settings.machine.counted)? } else { None };
        Ok((exponent, refutation))
    }

    /// Checks the rows of all processes. Returns the exponent.
    fn check_rows(self, settings: &Settings) -> Result<i32, Error> {
        let Facts { loaded: Loaded { survey, population, .. }, totals } = self;
        if survey.repeats_numbers() {
            return Err(Error::Indices { rows: survey.rows, first: survey.first, last: survey.last });
        }
        let exponent = survey.exponent(settings.machine.task.skips_invalid()).map_err(Error::Points)?;
        let counted = population.count + totals.left_out;
        if counted != survey.rows {
            return Err(incomplete(format!("the ranks account for {counted} of {} rows", survey.rows)));
        }
        settings.check(population.count)?;
        Ok(exponent)
    }
}

/// Decides on the run, and returns the result of this process without its times.
fn finish<P: Point>(
    mut shares: Vec<Share<P>>,
    settings: &Settings,
    placement: Placement,
) -> Result<ProcessRun, Error> {
    let ledger = merged_ledger(shares.iter().map(|share| &share.ledger.part), None);
    let Some(first) = shares.first() else {
        return Err(incomplete("the process returned no share".to_string()));
    };
    let facts = Facts::of(first);
    if !shares.iter().all(|share| Facts::of(share).are_those(facts)) {
        return Err(incomplete("the ranks have different totals of the run".to_string()));
    }
    let (exponent, refutation) = facts.check(settings, P::DIM)?;
    let Loaded { survey, population, dimension, .. } = *facts.loaded;
    let mut points = Accounting { input: survey.rows, used: population.count, ..Accounting::default() };
    for share in &mut shares {
        let repeated = std::mem::take(&mut share.loaded.repeated).into_iter();
        points.duplicates.extend(repeated.map(|[row, first]| (row, first)));
        points.refused.append(&mut share.loaded.refused);
    }
    // The coordinator has the first share of its process.
    let first = &mut shares[0];
    let (certificate, choice) = (std::mem::take(&mut first.certified), std::mem::take(&mut first.choice));
    let is_flat = dimension < P::DIM as isize;
    let settled = if is_flat { settled_flat(settings) } else { settled(settings, choice) };
    let Totals { cells, merged, .. } = *certificate.totals;
    let subdomain = |Share { rank, piece, cells, .. }: Share<P>| {
        if settings.machine.counted {
            Subdomain::of_stars::<P>(rank, cells, exponent)
        } else {
            Subdomain::of_piece::<P>(rank, piece.unwrap_or_default(), (exponent, placement))
        }
    };
    let roots = shares.iter().filter_map(|share| share.ledger.root).collect();
    let workers = shares.into_iter().filter(|share| share.rank != COORDINATOR);
    let Some(subdomains) = workers.map(subdomain).collect() else {
        return Err(incomplete("the arrays of a subdomain do not fit together".to_string()));
    };
    let hull_facets = if refutation.is_none() { merged.hull_facets } else { 0 };
    let part = Part { space: P::DIM, dimension, points, cells, hull_facets, placement, subdomains };
    let (fault, phase_seconds, seconds) = (settings.machine.fault, Vec::new(), 0.0);
    Ok(ProcessRun { part, ledger, roots, settled, certificate, refutation, fault, phase_seconds, seconds })
}
