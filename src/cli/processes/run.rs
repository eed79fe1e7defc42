//! A triangulation or a simulation by several processes, from the arguments to the report.

use std::path::{Path, PathBuf};
use std::time::Instant;

use septet_core::result::subdomain::Part;
use septet_core::run::memory::{peak_rss, rss};
use septet_core::run::processes::{
    HeldRows, ProcessRun, placement, rows_of, simulate_held, triangulate_held,
};
use septet_core::spec::Workers;
use septet_core::{Error, Spec};
use septet_io::read::{ReadOptions, SharedPoints, read_shared};
use septet_io::write::{SharedMesh, check_shared, write_shared};
use septet_lab::report::{RunContext, RunReport};
use septet_protocol::transport::Placement;

use super::report::{Rows, gather, united_ledger};
use super::sample;
use super::team::Team;
use super::trace;
use crate::errors::{Code, Failure};
use crate::files;
use crate::formats::{check_reading, read_options};
use crate::input::Input;
use crate::instruments::Tables;
use crate::progress::Talk;
use crate::triangulate::{Goal, TABLES, of_points, publish, renumbered};

/// The settled arguments of a run.
pub struct Plan<'a> {
    input: Input<'a>,
    tables: Tables,
    reading: ReadOptions,
    placement: Placement,
}

/// Runs a goal on this process of a team. The configuration must state the number of workers.
///
/// # Errors
/// Fails with the first failure of any process.
pub fn run(
    goal: Goal<'_>,
    plan: &Plan<'_>,
    (requested, threads): (&Spec, usize),
    team: &mut Team<'_>,
    talk: &Talk,
) -> Result<(), Failure> {
    let (start, args) = (Instant::now(), goal.args());
    let mut requested = requested.clone();
    let mut spec = requested.clone().with(|c| c.machine.threads = c.machine.threads.or(Some(threads)));
    crate::threads::limit_threads(spec.machine.thread_count());
    let options = args.writing.options();
    check_shared(&mut team.processes, &args.output, &options)?;
    let held = read(plan, team, &mut spec, talk)?;
    requested.recursion.spacing = spec.recursion.spacing;
    go_on(team, talk)?;
    let read_seconds = start.elapsed().as_secs_f64();
    spec.control.cancel = Some(talk.cancel.clone());
    if team.is_first() {
        spec.control.progress = Some(talk.phases());
    }
    let rss_before_bytes = rss();
    let mut run = run_ranks(goal, &spec, &held, team)?;
    let Outcome { part, failure } = take_part(run.as_mut(), plan.placement, team)?;
    let run_seconds = start.elapsed().as_secs_f64();
    let mut files = Vec::new();
    if failure.is_none() {
        let mesh = SharedMesh {
            part: &part,
            rows: &held.points,
            first: args.hidden.first_row.unwrap_or(0) + held.first,
        };
        let is_cancelled = || talk.is_cancelled();
        files = write_shared(&mut team.processes, &args.output, &mesh, &options, &is_cancelled)?;
    }
    let ledger = united_ledger(team, run.as_mut(), Rows::of(goal, &spec))?;
    let context = RunContext {
        command: goal.name(),
        input: &args.input,
        outputs: &args.output,
        threads: spec.machine.thread_count(),
        skipped: held.skipped,
        read_seconds,
        write_seconds: start.elapsed().as_secs_f64() - run_seconds,
        total_seconds: start.elapsed().as_secs_f64(),
        rss_before_bytes,
        peak_rss_bytes: peak_rss(),
    };
    let processes = gather(team, &part, start)?;
    let transport = team.transport;
    team.first_only(|| {
        // The first process has workers in every run.
        let Some(run) = run else { return Ok(()) };
        let report = RunReport::of(&run.into_run(ledger), &requested, &context);
        talk.clear();
        publish((args, &requested), &plan.tables, &report.with_processes(transport, processes), files, talk)
    })?;
    failure.map_or(Ok(()), Err)
}

/// Runs the ranks of this process.
fn run_ranks(
    goal: Goal<'_>,
    spec: &Spec,
    held: &SharedPoints,
    team: &mut Team<'_>,
) -> Result<Option<ProcessRun>, Failure> {
    let base = goal.args().hidden.first_row.unwrap_or(0);
    let rows = HeldRows { points: &held.points, first: held.first, rows: held.rows, base };
    let run = match goal {
        Goal::Triangulate(_) => triangulate_held(&mut team.processes, rows, spec),
        Goal::Simulate(_) => simulate_held(&mut team.processes, rows, spec),
    };
    team.agree(run.map_err(|error| match error {
        Error::Points(error) => {
            let error = renumbered(error, |row| row.saturating_sub(base as usize));
            of_points(&error, &held.files, &goal.args().input)
        }
        error => error.into(),
    }))
}

/// Ends the command on all processes if one was interrupted.
fn go_on(team: &mut Team<'_>, talk: &Talk) -> Result<(), Failure> {
    team.agree(if talk.is_cancelled() { Err(Failure::interrupted()) } else { Ok(()) })
}

/// Settles the arguments, and refuses those that several processes cannot obey. The first process checks the names of all
/// files that the processes write.
///
/// # Errors
/// Fails if the arguments do not fit together, or if a file cannot be written.
pub fn plan<'a>(goal: Goal<'a>, spec: &Spec, team: &Team<'_>) -> Result<Plan<'a>, Failure> {
    let args = goal.args();
    if args.input == "@-" || args.input.trim_start_matches('@').starts_with("/dev/") {
        let message = format!("{}: several processes cannot read it", args.input);
        return Err(
            Failure::new(Code::Usage, message).help("give the name of a file, or - for standard input")
        );
    }
    let input = Input::of(&args.input, spec.input.dimension)?;
    let tables = Tables::of(args.profile.as_deref(), &TABLES)?;
    refuse(goal, spec)?;
    check_reading(goal.given(), input.is_sample())?;
    args.writing.check(&args.output)?;
    let placement = placement(spec, team.processes.processes())?;
    if team.is_first() {
        let traces = trace::paths(&args.tracing, team.processes.processes());
        let texts = args.json.iter().chain(&traces).map(PathBuf::as_path).chain(tables.paths());
        let texts: Vec<&Path> = texts.collect();
        files::check_as(&input.files(), &args.output, &args.writing.options(), &texts)?;
    }
    let reading = read_options(&spec.input)?;
    Ok(Plan { input, tables, reading, placement })
}

/// Refuses options that need all cells or all ranks in one process.
fn refuse(goal: Goal<'_>, spec: &Spec) -> Result<(), Failure> {
    let options = [
        ("--workers leaves", spec.machine.workers == Workers::Leaves),
        ("--cost-trace", goal.cost_trace().is_some()),
        ("--keep-columns", spec.input.keep_columns),
        ("--with-owner", spec.keep.owner),
        ("--view", spec.keep.view.is_some_and(|shown| shown > 0)),
        ("--skip-invalid", spec.input.skip_invalid),
        ("--max-memory", spec.machine.max_memory.is_some()),
    ];
    match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => {
            Err(Failure::new(Code::Usage, format!("{option} does not work with several processes"))
                .help(format!("omit {option}, or run the command in one process")))
        }
        None => Ok(()),
    }
}

/// Reads or generates the rows of this process.
fn read(plan: &Plan<'_>, team: &mut Team<'_>, spec: &mut Spec, talk: &Talk) -> Result<SharedPoints, Failure> {
    let (process, placement) = (team.processes.process(), plan.placement);
    let block = |rows: u64| rows_of(placement, process, rows);
    let held = match &plan.input {
        Input::Sample(request) => {
            let (held, spacing) = sample::rows(request, team, &block, talk)?;
            spec.recursion.spacing = spacing;
            held
        }
        Input::File(name) => read_shared(&mut team.processes, &[PathBuf::from(name)], &plan.reading, &block)?,
        Input::List(list) => read_shared(&mut team.processes, list.files(), &plan.reading, &block)?,
    };
    if team.is_first() {
        for note in &held.notes {
            talk.note(format!("note: {note}"));
        }
    }
    Ok(held)
}

/// The result of the ranks, which every process has.
struct Outcome {
    /// The part of this process.
    part: Part,
    /// The failure of the certificate.
    failure: Option<Failure>,
}

/// Takes the part of this process, and leaves the totals. A process without ranks has the totals only.
fn take_part(
    run: Option<&mut ProcessRun>,
    placement: Placement,
    team: &mut Team<'_>,
) -> Result<Outcome, Failure> {
    let own = run.as_ref().map(|run| (run.part.totals(), run.refusal()));
    let first = team.all_gather(&own)?.swap_remove(0);
    let (totals, refusal) =
        first.ok_or_else(|| Failure::new(Code::Machine, "the first process has no workers"))?;
    let without = Part::of_totals(totals, placement);
    let part = match run {
        Some(run) => std::mem::replace(&mut run.part, without),
        None => without,
    };
    Ok(Outcome { part, failure: refusal.map(|message| Failure::new(Code::Rejected, message)) })
}
