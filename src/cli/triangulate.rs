//! `septet triangulate` and `septet simulate`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use septet_core::model::Points;
use septet_core::result::view::MOST_POINTS;
use septet_core::run::CostTrace;
use septet_core::run::memory::{admit, peak_rss, rss};
use septet_core::{Error, Run, Spec};
use septet_geometry::range::RangeError;
use septet_io::read::{ListedFile, ReadOptions};
use septet_io::write::{OutputFormat, WriteOptions};
use septet_lab::report::{CostHeader, RunContext, RunReport, write_cost_trace};

use super::effects::needs;
use super::errors::{Code, Failure};
use super::files;
use super::formats::write_mesh;
use super::input::{Input, Loaded, place_of};
use super::instruments::{Tables, check_trace, traced};
use super::options::{NodesArg, RunArgs, SimulateArgs, TriangulateArgs};
use super::progress::Talk;
use super::rows::InputRows;
use super::summary;

/// The tables of a run, as they appear in file names.
pub(super) const TABLES: [&str; 3] = ["phases", "rounds", "levels"];

/// The subcommand with its options.
#[derive(Clone, Copy, Debug)]
pub enum Goal<'a> {
    /// `septet triangulate`.
    Triangulate(&'a TriangulateArgs),
    /// `septet simulate`.
    Simulate(&'a SimulateArgs),
}

impl<'a> Goal<'a> {
    /// Returns the name of the subcommand.
    pub(super) fn name(self) -> &'static str {
        match self {
            Goal::Triangulate(_) => "triangulate",
            Goal::Simulate(_) => "simulate",
        }
    }

    /// Returns the options of both subcommands.
    pub(super) fn args(self) -> &'a RunArgs {
        match self {
            Goal::Triangulate(args) => &args.run,
            Goal::Simulate(args) => &args.run,
        }
    }

    /// Returns the file of the cost trace.
    pub(super) fn cost_trace(self) -> Option<&'a Path> {
        match self {
            Goal::Triangulate(_) => None,
            Goal::Simulate(args) => args.cost_trace.as_deref(),
        }
    }

    /// Returns `true` if the report leaves out the nodes of the tree.
    pub(super) fn hides_nodes(self) -> bool {
        matches!(self, Goal::Simulate(args) if args.nodes == Some(NodesArg::None))
    }

    /// Returns the checked configuration in one process.
    fn spec(self) -> Result<Spec, Failure> {
        self.extend(self.args().spec()?)
    }

    /// Returns the checked configuration of one of several processes ([`RunArgs::config_of_processes`]).
    pub(super) fn config_of_processes(self, workers: u32, threads: usize) -> Result<Spec, Failure> {
        self.extend(self.args().config_of_processes(workers, threads)?)
    }

    /// Applies the options of one subcommand only, and checks the configuration.
    fn extend(self, spec: Spec) -> Result<Spec, Failure> {
        let spec = match self {
            Goal::Triangulate(_) => spec,
            Goal::Simulate(args) => args.extend(spec)?,
        };
        spec.check()?;
        Ok(spec)
    }
}

/// Runs either subcommand in one process.
pub fn run(goal: Goal<'_>, talk: &Talk) -> Result<(), Failure> {
    let (args, mut spec) = (goal.args(), goal.spec()?);
    let counted = matches!(goal, Goal::Simulate(_));
    let start = Instant::now();
    super::threads::limit_threads(spec.machine.thread_count());
    let input = Input::of(&args.input, args.dimension)?;
    check_trace(&args.tracing)?;
    let tables = Tables::of(args.profile.as_deref(), &TABLES)?;
    let texts = args.json.iter().chain(&args.tracing.trace).map(PathBuf::as_path).chain(tables.paths());
    let texts = texts.chain(goal.cost_trace());
    let texts: Vec<&Path> = texts.collect();
    let of_files = [("--keep-columns", args.keep_columns), ("--skip-invalid", args.skip_invalid)];
    args.reading.check(input.is_sample(), &of_files)?;
    let options = args.writing.options();
    files::check_as(&input.files(), &args.output, &options, &texts)?;
    check_effects(args)?;
    if let Input::Sample(request) = &input {
        // A sample that is too large is refused before it is generated.
        admit(&spec, request.n, request.dimension, counted)?;
    }
    let reading = args.reading.options(args.dimension, args.skip_invalid);
    let loaded = input.load(&ReadOptions { keep_columns: args.keep_columns, ..reading }, talk)?;
    spec.recursion.spacing = loaded.spacing;
    if args.json.is_some() {
        spec.keep.view = args.view.unwrap_or(if counted { MOST_POINTS } else { 0 });
    }
    spec.control.cancel = Some(talk.cancel.clone());
    spec.control.progress = Some(talk.phases());
    let rss_before_bytes = rss();
    let go = || match go(&loaded.points, &spec, counted) {
        Ok(run) => Ok((run, None)),
        Err(error) => uncertified(error).map_err(|e| place(e, &loaded, &args.input)),
    };
    let mut files = Vec::new();
    let (run, failure) = traced(&args.tracing, talk, &mut files, go)?;
    let run_seconds = start.elapsed().as_secs_f64();
    if failure.is_none() {
        files.extend(write_all(args, &run, &loaded, talk)?);
    }
    if let (Some(path), Some(trace)) = (goal.cost_trace(), &run.costs) {
        write_costs(path, trace, CostHeader::of(&spec, &run.settled, run.points.used, run.space))?;
        files.extend((path.as_os_str() != "-").then(|| path.to_owned()));
    }
    let write_seconds = start.elapsed().as_secs_f64() - run_seconds;
    talk.clear();
    let setting = RunContext {
        command: goal.name(),
        input: &args.input,
        outputs: &args.output,
        hides_nodes: goal.hides_nodes(),
        skipped: loaded.skipped,
        read_seconds: loaded.seconds,
        write_seconds,
        total_seconds: start.elapsed().as_secs_f64(),
        rss_before_bytes,
        peak_rss_bytes: peak_rss(),
    };
    let report = RunReport::of(&run, &spec, &setting);
    publish(args, &tables, &report, files, talk)?;
    failure.map_or(Ok(()), Err)
}

/// Writes the tables and the report, and prints the summary. `files` are the files written before.
pub(super) fn publish(
    args: &RunArgs,
    tables: &Tables,
    report: &RunReport,
    mut files: Vec<PathBuf>,
    talk: &Talk,
) -> Result<(), Failure> {
    let rendered = |format, which| report.tables(format, which);
    files.extend(tables.write(&rendered)?);
    print_report(args, report, &files, talk)?;
    tables.print(&rendered);
    Ok(())
}

/// Writes the cost trace.
fn write_costs(path: &Path, trace: &CostTrace, header: CostHeader) -> Result<(), Failure> {
    let mut text = Vec::new();
    let written = write_cost_trace(&mut text, header, trace).map_err(|e| e.to_string());
    let text = written.and_then(|()| String::from_utf8(text).map_err(|e| e.to_string()));
    let text =
        text.map_err(|e| Failure::new(Code::Failed, format!("the cost trace cannot be written: {e}")))?;
    Ok(files::write_text(path, &text)?)
}

/// Returns a failure if an option is set that no output or report uses.
fn check_effects(args: &RunArgs) -> Result<(), Failure> {
    args.writing.check(&args.output)?;
    let has_data =
        args.writing.any(&args.output, &[OutputFormat::Vtu, OutputFormat::Pvtu, OutputFormat::Vtk]);
    let outputs = "-o OUT.vtu, -o OUT.pvtu or -o OUT.vtk";
    needs("--keep-columns", args.keep_columns, outputs, has_data)?;
    needs("--with-owner", args.with_owner, outputs, has_data)?;
    needs("--view", args.view.is_some(), "--json", args.json.is_some())
}

/// Writes the report as JSON and prints its summary.
fn print_report(args: &RunArgs, report: &RunReport, files: &[PathBuf], talk: &Talk) -> Result<(), Failure> {
    if let Some(path) = &args.json {
        let mut text = report
            .to_json()
            .map_err(|e| Failure::new(Code::Failed, format!("the report cannot be written: {e}")))?;
        text.push('\n');
        files::write_text(path, &text)?;
    }
    let is_sample = args.input.starts_with("sample:");
    for line in summary::of_run(report, is_sample).into_iter().chain(summary::written(files)) {
        talk.note(line);
    }
    if report.dimension < report.space as isize {
        talk.note(format!("note: {}", report.flat_note()));
    } else if report.certificate == "passed" {
        let reading = args.reading.for_verify();
        talk.note(summary::next_step(&args.input, &reading, &args.output, args.json.as_deref()));
    }
    Ok(())
}

/// Turns the error of a failed certificate into its run and the failure, because the counts of the run are still
/// reported. Other errors are returned unchanged.
fn uncertified(error: Error) -> Result<(Run, Option<Failure>), Error> {
    let message = error.to_string();
    match error {
        Error::NotCertified { run, .. } => Ok((*run, Some(Failure::new(Code::Rejected, message)))),
        error => Err(error),
    }
}

fn go(points: &Points, spec: &Spec, counted: bool) -> Result<Run, Error> {
    match (points, counted) {
        (Points::Plane(points), false) => septet_core::triangulate(points, spec),
        (Points::Space(points), false) => septet_core::triangulate(points, spec),
        (Points::Plane(points), true) => septet_core::simulate(points, spec),
        (Points::Space(points), true) => septet_core::simulate(points, spec),
    }
}

/// Converts an error. An error about points then gives the file and the positions of the points in it.
pub fn place(error: Error, loaded: &Loaded, input: &str) -> Failure {
    let Error::Points(error) = error else { return error.into() };
    let at = |i: usize| loaded.source_index.as_ref().map_or(i, |s| s[i] as usize);
    of_points(&renumbered(error, at), &loaded.files, input)
}

/// Returns the error with other numbers of its points.
pub(super) fn renumbered(mut error: RangeError, at: impl Fn(usize) -> usize) -> RangeError {
    match &mut error {
        RangeError::NotFinite { index, .. } => *index = at(*index),
        RangeError::Spread { low, high, .. } => (*low, *high) = (at(*low), at(*high)),
    }
    error
}

/// Returns the failure for points that cannot be triangulated. `files` are the files of a list.
pub(super) fn of_points(error: &RangeError, files: &[ListedFile], input: &str) -> Failure {
    let rows = match *error {
        RangeError::NotFinite { index, .. } => vec![index],
        RangeError::Spread { low, high, .. } => vec![low, high],
    };
    let name = if input == "-" { "standard input" } else { input };
    let is_list = files.len() > 1;
    let places = rows.into_iter().filter_map(|row| place_of(files, row as u64)).filter(|_| is_list);
    let places: String = places.collect();
    Failure::new(Code::Input, format!("{name}: {error} (points counted from 0{places})"))
        .help("round the coordinates to a common grid, or drop these points")
}

fn write_all(args: &RunArgs, run: &Run, loaded: &Loaded, talk: &Talk) -> Result<Vec<PathBuf>, Failure> {
    let options = WriteOptions {
        with_owner: args.with_owner,
        first_id: loaded.first_id,
        point_data: &loaded.columns,
        ..args.writing.options()
    };
    let mut files = Vec::new();
    for output in &args.output {
        talk.check();
        let stage = format!("writing {}", output.display());
        let mut progress = |done: u64, total: u64| talk.stage(&stage, done, Some(total));
        let view = run.view(loaded.points.coordinates());
        let written = match (&loaded.source_index, options.format_of(output)?) {
            // In a file that has only cells, or only some of the points, indices count all rows of the input, including
            // dropped ones.
            (Some(source), OutputFormat::Npy | OutputFormat::Pvtu) => {
                let rows = InputRows::of(&view, &loaded.columns, source, loaded.skipped);
                let options = WriteOptions { point_data: &rows.columns, ..options };
                write_mesh(output, &rows.view(&view), &options, &mut progress)
            }
            _ => write_mesh(output, &view, &options, &mut progress),
        };
        files.extend(written?);
    }
    Ok(files)
}
