//! A triangulation by several processes, from the arguments to the report.

use std::path::{Path, PathBuf};
use std::time::Instant;

use septet_core::result::subdomain::Part;
use septet_core::run::memory::{peak_rss, rss};
use septet_core::run::processes::{HeldRows, ProcessRun, placement, rows_of, triangulate_held};
use septet_core::{Config, Error};

use septet_io::read::{ReadOptions, SharedPoints, read_shared, share_points};
use septet_io::write::{SharedMesh, check_shared, write_shared};
use septet_lab::report::{RunContext, RunReport};
use septet_protocol::transport::Placement;

use super::report::{gather, ledgers, lost};
use super::team::Team;
use crate::errors::{Code, Failure};
use crate::files;
use crate::input::{Input, make};
use crate::instruments::Tables;
use crate::options::RunArgs;
use crate::progress::Talk;
use crate::triangulate::{TABLES, print_report};

/// The settled arguments of a run.
struct Plan<'a> {
    input: Input<'a>,
    tables: Tables,
    reading: ReadOptions,
    placement: Placement,
}

/// Runs `septet triangulate` on this process of a team. The configuration must state the number of workers.
///
/// # Errors
/// Fails with the first failure of any process.
pub fn triangulate(
    args: &RunArgs,
    mut config: Config,
    team: &mut Team<'_>,
    talk: &Talk,
) -> Result<(), Failure> {
    let start = Instant::now();
    crate::threads::limit_threads(config.machine.threads);
    config.keep.point_owner = false;
    let plan = plan(args, &config, team);
    let plan = team.agree(plan)?;
    let options = args.writing.options();
    check_shared(&mut team.processes, &args.output, &options)?;
    let held = read(&plan, team, &mut config, talk)?;
    go_on(team, talk)?;
    let read_seconds = start.elapsed().as_secs_f64();
    config.control.cancel = Some(talk.cancel.clone());
    if team.is_first() {
        config.control.progress = Some(talk.phases());
    }
    let rss_before_bytes = rss();
    let rows = HeldRows { points: &held.points, first: held.first, rows: held.rows };
    let run = triangulate_held(&mut team.processes, rows, &config);
    let run = run.map_err(|error| failure(error, &args.input));
    let mut run = team.agree(run)?;
    let part = take_part(run.as_mut(), plan.placement, team)?;
    let run_seconds = start.elapsed().as_secs_f64();
    let mesh = SharedMesh { part: &part, rows: &held.points, first: held.first };
    let files = write_shared(&mut team.processes, &args.output, &mesh, &options, &|| talk.is_cancelled())?;
    let context = RunContext {
        command: "triangulate",
        input: &args.input,
        outputs: &args.output,
        skipped: held.skipped,
        read_seconds,
        write_seconds: start.elapsed().as_secs_f64() - run_seconds,
        total_seconds: start.elapsed().as_secs_f64(),
        rss_before_bytes,
        peak_rss_bytes: peak_rss(),
    };
    let processes = gather(team, &part, start)?;
    let ledgers = ledgers(team, run.as_ref())?;
    let transport = team.transport;
    team.first_only(|| {
        let run = run.ok_or_else(|| Failure::new(Code::Machine, "the first process has no workers"))?;
        let report = RunReport::of(&run.into_run(&ledgers), &config, &context);
        finish(args, &plan.tables, &report.with_processes(transport, processes), (files, talk))
    })?;
    Ok(())
}

/// Ends the command on all processes if one was interrupted.
fn go_on(team: &mut Team<'_>, talk: &Talk) -> Result<(), Failure> {
    team.agree(if talk.is_cancelled() { Err(Failure::interrupted()) } else { Ok(()) })
}

/// Settles the arguments, and refuses those that several processes cannot obey.
fn plan<'a>(args: &'a RunArgs, config: &Config, team: &Team<'_>) -> Result<Plan<'a>, Failure> {
    if args.input == "@-" || args.input.trim_start_matches('@').starts_with("/dev/") {
        let message = format!("{}: several processes cannot read it", args.input);
        return Err(
            Failure::new(Code::Usage, message).help("give the name of a file, or - for standard input")
        );
    }
    let input = Input::of(&args.input, args.dimension)?;
    let tables = Tables::of(args.profile.as_deref(), &TABLES)?;
    refuse(args)?;
    args.reading.check(input.is_sample(), &[("--skip-invalid", args.skip_invalid)])?;
    args.writing.check(&args.output)?;
    let placement = placement(config, team.processes.processes())?;
    if team.is_first() {
        let texts: Vec<&Path> = args.json.iter().map(PathBuf::as_path).chain(tables.paths()).collect();
        files::check_as(&input.files(), &args.output, &args.writing.options(), &texts)?;
    }
    let reading = args.reading.options(args.dimension, args.skip_invalid);
    Ok(Plan { input, tables, reading, placement })
}

/// Refuses options that need all cells or all ranks in one process.
fn refuse(args: &RunArgs) -> Result<(), Failure> {
    let options = [
        ("--trace", args.tracing.trace.is_some()),
        ("--keep-columns", args.keep_columns),
        ("--with-owner", args.with_owner),
        ("--view", args.view.is_some()),
        ("--skip-invalid", args.skip_invalid),
        ("--max-memory", args.machine.max_memory.is_some()),
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
fn read(
    plan: &Plan<'_>,
    team: &mut Team<'_>,
    config: &mut Config,
    talk: &Talk,
) -> Result<SharedPoints, Failure> {
    let (process, placement) = (team.processes.process(), plan.placement);
    let block = |rows: u64| rows_of(placement, process, rows);
    let held = match &plan.input {
        Input::Sample(request) => {
            let made = team.first_only(|| make(request, talk))?;
            let spacing = made.as_ref().and_then(|made| made.spacing);
            config.spacing = team.processes.all_gather(&spacing).map_err(lost)?.swap_remove(0);
            share_points(&mut team.processes, made.map(|made| made.points), &block)?
        }
        Input::File(name) => read_shared(&mut team.processes, &[PathBuf::from(name)], &plan.reading, &block)?,
        Input::List(list) => read_shared(&mut team.processes, list.files(), &plan.reading, &block)?,
    };
    if team.is_first() {
        for note in &held.notes {
            talk.note(format!("note: {note}"));
        }
        if held.skipped > 0 {
            talk.note(format!("note: {} skipped", crate::text::counted(held.skipped, "invalid point")));
        }
    }
    Ok(held)
}

/// Takes the part of this process, and leaves the totals. A process without ranks has the totals only.
fn take_part(
    run: Option<&mut ProcessRun>,
    placement: Placement,
    team: &mut Team<'_>,
) -> Result<Part, Failure> {
    let totals = run.as_ref().map_or([0; 6], |run| run.part.totals());
    let totals = team.processes.all_gather(&totals).map_err(lost)?;
    let without = Part::of_totals(totals[0], placement);
    Ok(match run {
        Some(run) => std::mem::replace(&mut run.part, without),
        None => without,
    })
}

/// Converts an error of the run. An error about points then names the input.
fn failure(error: Error, input: &str) -> Failure {
    let is_of_points = matches!(error, Error::Points(_));
    let failure = Failure::from(error);
    if !is_of_points {
        return failure;
    }
    let name = if input == "-" { "standard input" } else { input };
    failure.in_place(name).help("round the coordinates to a common grid, or drop these points")
}

/// Writes the report and the tables, and prints the summary.
fn finish(
    args: &RunArgs,
    tables: &Tables,
    report: &RunReport,
    (mut files, talk): (Vec<PathBuf>, &Talk),
) -> Result<(), Failure> {
    talk.clear();
    let rendered = |format, which| report.tables(format, which);
    files.extend(tables.write(&rendered)?);
    print_report(args, report, &files, talk)?;
    tables.print(&rendered);
    Ok(())
}
