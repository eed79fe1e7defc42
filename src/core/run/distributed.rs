//! Triangulations by several processes, each of which holds a part of the points.
//!
//! **Statement.** Every process runs some ranks of one machine. The union of the parts of all processes is the triangulation
//! of the union of their points. All ranks have the same totals, so all processes come to the same decision on the
//! certificate, and return the same error if there is one.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};
use septet_geometry::point::{Coordinates, Point};
use septet_protocol::ids::{COORDINATOR, Phase, Rank};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::Totals;
use septet_protocol::transport::{HostState, Placement, ProcessTransport, TransportError};
use septet_workers::input::{Loaded, Rows, Source};
use septet_workers::share::{Share, merged_ledger};
use septet_workers::transport::process::OneProcess;

use crate::config::{Config, ConfigError, Keep, Workers};
use crate::coordinator::{Coordinator, Held, Plan, Returned, unbalanced};
use crate::error::{Error, incomplete};
use crate::input::Whole;
use crate::result::run::{Accounting, Run, Settled};
use crate::result::subdomain::{Part, Subdomain};
use crate::run::finish::{NO_SUPERGRAPH, certify};
use crate::run::settings::{Goal, Settings, admit};
use crate::run::transport::started;

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
        config: &Config,
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
                config: &Config,
            ) -> Result<Part, Error> {
                let points: &[$point] = bytemuck::cast_slice(points);
                run(transport, Input { points, first_id }, config)
            }
        }
    };
}
process_point!(DVec2, DVec2);
process_point!(DVec3, DVec3);
process_point!([f64; 2], DVec2);
process_point!([f64; 3], DVec3);

/// Computes the Delaunay triangulation of the points of all processes. Every process calls this function with its own
/// points, whose input indices are `first_id`, `first_id + 1`, and so on. Returns the part of this process.
///
/// # Errors
/// See [`Error`]. All processes return an error. It is the same unless the configurations differ.
pub fn triangulate<C: ProcessPoint>(
    transport: &mut dyn ProcessTransport<C::Point>,
    points: &[C],
    first_id: u64,
    config: &Config,
) -> Result<Part, Error> {
    C::triangulate(transport, points, first_id, config)
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
    config: &Config,
) -> Result<Part, Error> {
    let placement = match admitted(config, input, transport.processes()) {
        Ok(placement) => placement,
        Err(error) => return Err(end_all(transport, error)),
    };
    let source = OwnRows { input, workers: placement.workers_of(transport.process()) };
    let held = Held { source: &source, rows: input.points.len() as u64 };
    Ok(run_held(transport, held, placement, config)?.part)
}

/// The result of a process.
pub struct ProcessRun {
    /// The part of the triangulation.
    pub part: Part,
    /// The counts of the ranks of this process.
    pub ledger: LedgerPart,
    /// The parameters of the run.
    pub settled: Settled,
    /// Measured wall-clock seconds of each phase that occurred, in order.
    pub phase_seconds: Vec<(Phase, f64)>,
    /// Measured seconds of the machine.
    pub seconds: f64,
}

/// Runs the ranks of this process over the rows that it holds.
pub(super) fn run_held<P: Point>(
    transport: &mut dyn ProcessTransport<P>,
    held: Held<'_, P>,
    placement: Placement,
    config: &Config,
) -> Result<ProcessRun, Error> {
    let start = Instant::now();
    let mut settings =
        Settings::decide(config, Goal::Triangulation, Whole::<P>::points(&[]), &mut started(config))?;
    settings.machine.shown.with_places = true;
    let coordinator = Coordinator::new(&config.control, Arc::new(settings.machine.clone()));
    let mut process = OneProcess { transport, placement, threads: config.machine.threads };
    let Returned { shares, seconds: phase_seconds } = coordinator.shares(&mut process, held, &Plan::new())?;
    let ledger = merged_ledger(&shares, settings.machine.fault);
    let part = finish(shares, &settings, placement)?;
    let settled = settings.settled(None, NO_SUPERGRAPH.to_string());
    Ok(ProcessRun { part, ledger, settled, phase_seconds, seconds: start.elapsed().as_secs_f64() })
}

/// Checks the configuration and the points of this process. Returns the places of the ranks.
fn admitted<P: Point>(config: &Config, input: Input<'_, P>, processes: u32) -> Result<Placement, Error> {
    let workers = admitted_workers(config, processes)?;
    let rows = input.points.len() as u64;
    admit(config, Goal::Triangulation, rows, P::DIM)?;
    if input.first_id.checked_add(rows).is_none() {
        return Err(Error::Indices { rows, first: input.first_id, last: u64::MAX });
    }
    Placement::new(workers, processes).ok_or(ConfigError::TooFewWorkers { workers, processes }.into())
}

/// Refuses results that several processes cannot have. Returns the number of workers: by default, one for each process.
pub(super) fn admitted_workers(config: &Config, processes: u32) -> Result<u32, Error> {
    let Keep { graph, sets, owner, point_owner, costs, view } = config.keep;
    let outputs = [
        (config.machine.workers == Workers::Leaves, "a worker for each leaf"),
        (graph || sets || costs, "a counted run"),
        (owner || point_owner, "an array of owners"),
        (view > 0, "a picture"),
    ];
    if let Some(&(_, output)) = outputs.iter().find(|(is_wanted, _)| *is_wanted) {
        return Err(ConfigError::NotDistributed { output }.into());
    }
    Ok(if let Workers::Count(workers) = config.machine.workers { workers } else { processes })
}

/// Ends the run on all processes, because this process cannot start. Returns the error of the run. An error of the
/// configuration keeps its type, because all processes have it.
pub(super) fn end_all<P: Point>(transport: &mut dyn ProcessTransport<P>, error: Error) -> Error {
    let process = transport.process();
    let reason = format!("process {process} does not start: {error}");
    let failed = TransportError::WorkerFailed { rank: process + 1, reason };
    let ended = transport.exchange(Vec::new(), HostState::Failed(failed.clone()));
    match (error, ended) {
        (error @ Error::Config(_), _) => error,
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

    /// Checks the facts. Returns the exponent of the power of two by which coordinates were multiplied.
    ///
    /// # Errors
    /// Fails if messages are missing, or if the rows cannot be triangulated.
    fn check(self, settings: &Settings) -> Result<i32, Error> {
        let Facts { loaded: Loaded { survey, population, .. }, totals } = self;
        if totals.balance != 0 {
            return Err(unbalanced());
        }
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

/// Decides on the run, and returns the part of this process.
fn finish<P: Point>(
    mut shares: Vec<Share<P>>,
    settings: &Settings,
    placement: Placement,
) -> Result<Part, Error> {
    let Some(first) = shares.first() else {
        return Err(incomplete("the process returned no share".to_string()));
    };
    let facts = Facts::of(first);
    if !shares.iter().all(|share| Facts::of(share).are_those(facts)) {
        return Err(incomplete("the ranks have different totals of the run".to_string()));
    }
    let exponent = facts.check(settings)?;
    let (dimension, population, totals) = (first.loaded.dimension, first.loaded.population, *facts.totals);
    let input = first.loaded.survey.rows;
    let mut rows = Accounting { input, used: population.count, ..Accounting::default() };
    for share in &mut shares {
        let repeated = std::mem::take(&mut share.loaded.repeated).into_iter();
        rows.duplicates.extend(repeated.map(|[row, first]| (row, first)));
        rows.refused.append(&mut share.loaded.refused);
    }
    let is_flat = dimension < P::DIM as isize;
    let refutation = if is_flat { None } else { certify(&totals, population, settings.machine.counted)? };
    if let Some(refutation) = refutation {
        let settled = settings.settled(None, settings.why.clone());
        let run = Run { refutation: Some(refutation), ..Run::empty(P::DIM, dimension, rows, settled) };
        return Err(Error::NotCertified { refutation, run: Box::new(run) });
    }
    let workers = shares.into_iter().filter(|share| share.rank != COORDINATOR);
    let subdomain = |Share { rank, piece, .. }: Share<P>| {
        Subdomain::of::<P>(rank, piece.unwrap_or_default(), (exponent, placement))
    };
    let Some(subdomains) = workers.map(subdomain).collect() else {
        return Err(incomplete("the arrays of a subdomain do not fit together".to_string()));
    };
    let (cells, hull_facets) = (totals.cells, totals.hull_facets);
    Ok(Part { space: P::DIM, dimension, points: rows, cells, hull_facets, placement, subdomains })
}
