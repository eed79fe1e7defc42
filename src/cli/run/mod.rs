//! `septet triangulate` and `septet simulate`, from the options to the report, in one process or in several.
//!
//! A process that runs a command alone is a team of one. Several processes run the same command. They agree on every error
//! before they continue, so that all end with the same exit code. Only the first one prints.

mod breaklines;
mod goal;
mod output;
mod plan;
mod report;
mod rows;
mod team;
mod trace;

use std::path::PathBuf;
use std::time::Instant;

use septet_core::cores::{limit, within};
use septet_core::run::calls::perform_held;
use septet_core::run::memory::{check_peak, peak_rss, rss};
use septet_core::run::processes::HeldRows;
use septet_core::run::stats::shared_stats;
use septet_core::{Outcome, Remedy, Spec, Stats, perform};
use septet_lab::report::{RunContext, RunReport};
use septet_protocol::wire::Alone;

use crate::errors::{Code, Failure};
use crate::files::remove;
use crate::progress::Talk;
use crate::weights::GivenWeights;
pub use goal::Goal;
use output::{write_costs, write_lists, write_mesh_files};
use plan::Plan;
use report::{gather, publish, unite_counts};
use rows::Rows;
pub use team::Team;

/// Runs either subcommand in this process alone.
///
/// # Errors
/// Fails if an option, the input or an output is not valid, or if the run fails.
pub fn run_alone(goal: Goal<'_>, requested: Spec, talk: &Talk) -> Result<(), Failure> {
    goal.args().hidden.refuse()?;
    run(goal, (requested, None), &mut Team::alone(&mut Alone), talk)
}

/// Runs either subcommand on the processes of a team, as requested. `threads` is the default number of threads of a process.
///
/// # Errors
/// Fails with the first failure of any process.
pub fn run(
    goal: Goal<'_>,
    (requested, threads): (Spec, Option<usize>),
    team: &mut Team<'_>,
    talk: &Talk,
) -> Result<(), Failure> {
    let spec = requested.clone().with(|c| {
        c.machine.threads = c.machine.threads.or(threads);
    });
    let threads = spec.machine.thread_count();
    limit(threads);
    within(threads, None, || run_within(goal, (requested, spec), team, talk))
        .unwrap_or_else(|_| Err(Failure::interrupted()))
}

/// Runs either subcommand on the threads of the call.
fn run_within(
    goal: Goal<'_>,
    (mut requested, mut spec): (Spec, Spec),
    team: &mut Team<'_>,
    talk: &Talk,
) -> Result<(), Failure> {
    let (start, args) = (Instant::now(), goal.args());
    let plan = Plan::of(goal, &spec, (team, talk));
    let plan = team.agree(plan)?;
    plan.check_outputs(team)?;
    let rows = Rows::read(&plan, team, talk)?;
    plan.check_dimension(rows.held.points.dimension(), team)?;
    let read_seconds = rows.seconds.unwrap_or_else(|| start.elapsed().as_secs_f64());
    rows.complete(&mut spec, &plan, team, talk)?;
    requested.recursion.spacing = spec.recursion.spacing;
    let rss_before_bytes = rss();
    let mut files = Vec::new();
    let mut run =
        trace::traced(&args.tracing, team, talk, &mut files, |team| run_ranks(&plan, &spec, &rows, team))?;
    let run_seconds = start.elapsed().as_secs_f64();
    let failure = rejection(&run);
    if failure.is_none() {
        files.extend(write_mesh_files((&plan, &spec), &run, &rows, team, talk)?);
    }
    write_lists(&plan, &run, (&rows, team), &mut files)?;
    let stats = numbers((goal, &run), &rows, team)?;
    unite_counts(team, &mut run, (goal, spec.keep.nodes))?;
    files.extend(write_costs(goal, &spec, &run)?);
    talk.clear();
    let height_difference = rows.height_difference(&run, &plan, team)?;
    let context = RunContext {
        command: goal.name(),
        input: &args.input,
        outputs: &args.output,
        weights: goal.weights().and_then(GivenWeights::weights),
        radii: goal.weights().and_then(GivenWeights::radii),
        threads: spec.machine.thread_count(),
        skipped: rows.held.skipped,
        reading: rows.held.reading.as_ref(),
        extent: rows.held.extent.as_ref(),
        is_terrain: rows.held.heights.is_some(),
        height_difference,
        stats: stats.as_ref(),
        read_seconds,
        write_seconds: start.elapsed().as_secs_f64() - run_seconds,
        total_seconds: start.elapsed().as_secs_f64(),
        rss_before_bytes,
        peak_rss_bytes: peak_rss(),
    };
    let processes = gather(team, &run, start)?;
    team.agree(check_memory(&spec, &files)).inspect_err(|_| remove(&files))?;
    let transport = team.transport;
    let published = team.first_only(|| {
        let report = RunReport::of(&run, &requested, &context);
        let report = match transport {
            Some(name) => report.with_processes(name, processes),
            None => report,
        };
        check_memory(&spec, &files)?;
        let is_delaunay = plan.goal.breaklines().is_none();
        publish((args, &requested, is_delaunay), &plan.tables, &report, files.clone(), talk)
    })?;
    let files = published.unwrap_or(files);
    team.agree(check_memory(&spec, &files)).inspect_err(|_| remove(&files))?;
    failure.map_or(Ok(()), Err)
}

/// Returns the failure of a run whose certificate failed.
fn rejection(run: &Outcome) -> Option<Failure> {
    run.refutation.as_ref().map(|found| {
        let message = format!("the certificate failed: {found}");
        Failure::of(Code::Rejected, &message, Some(Remedy::REPORT))
    })
}

/// Checks the peak of a run that has written its files. Removes them if it is above the limit.
fn check_memory(spec: &Spec, files: &[PathBuf]) -> Result<(), Failure> {
    check_peak(spec).map_err(Failure::from).inspect_err(|_| remove(files))
}

/// Returns the numbers of the triangulation, if they are requested and its certificate passed.
fn numbers(
    (goal, run): (Goal<'_>, &Outcome),
    rows: &Rows,
    team: &mut Team<'_>,
) -> Result<Option<Stats>, Failure> {
    if !goal.has_stats() || run.refutation.is_some() {
        return Ok(None);
    }
    Ok(Some(shared_stats(&mut team.processes, run, rows.held.points.coordinates())?))
}

/// Runs the ranks of this process. A process without ranks gets the facts from the first one.
fn run_ranks(plan: &Plan<'_>, spec: &Spec, rows: &Rows, team: &mut Team<'_>) -> Result<Outcome, Failure> {
    let order = (spec, plan.goal.task());
    let Some(placement) = plan.placement else {
        return perform(rows.sites(), order).map_err(|error| rows.failure(error, plan));
    };
    let held = &rows.held;
    let own = HeldRows { points: rows.sites(), first: held.first, rows: held.rows, base: plan.first_row() };
    let run = perform_held(&mut team.processes, own, order);
    // The process that holds a row of the input speaks first.
    let (knowing, run) = match run.map_err(|error| rows.told(error, plan)) {
        Err((true, failure)) => (Err(failure), Ok(None)),
        Err((false, failure)) => (Ok(()), Err(failure)),
        Ok(run) => (Ok(()), Ok(run)),
    };
    team.agree(knowing)?;
    let run = team.agree(run)?;
    let facts = team.all_gather(&run.as_ref().map(|run| run.facts.clone()))?.swap_remove(0);
    let facts = facts.ok_or_else(|| Failure::new(Code::Machine, "the first process has no workers"))?;
    Ok(run.unwrap_or_else(|| Outcome::of_facts(facts, placement)))
}
