//! `septet triangulate` and `septet simulate`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use septet_core::model::Points;
use septet_core::result::view::MOST_POINTS;
use septet_core::run::CostTrace;
use septet_core::run::memory::{admit, peak_rss, rss};
use septet_core::{Error, Run, Spec};
use septet_geometry::range::RangeError;
use septet_io::read::ListedFile;
use septet_io::write::{OutputFormat, WriteOptions};
use septet_lab::report::{CostHeader, RunContext, RunReport, write_cost_trace};

use super::effects::needs;
use super::errors::{Code, Failure};
use super::files;
use super::formats::{check_reading, read_options, write_mesh};
use super::given::Options;
use super::input::{Input, Loaded, place_of};
use super::instruments::{Tables, check_trace, traced};
use super::options::{RunArgs, SimulateArgs, TriangulateArgs};
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

    /// Returns the options of the run, as given.
    pub(super) fn given(self) -> &'a Options {
        match self {
            Goal::Triangulate(args) => args.given.options(),
            Goal::Simulate(args) => args.given.options(),
        }
    }

    /// Returns the checked specification, as requested.
    pub(super) fn requested(self) -> Result<Spec, Failure> {
        let (given, args) = (self.given(), self.args());
        needs("--nodes", given.has("nodes"), "--json", args.json.is_some())?;
        let spec = given.spec()?.with(|c| {
            c.keep.costs = self.cost_trace().is_some();
            c.planted.fault = args.fault;
        });
        spec.check()?;
        Ok(spec)
    }
}

/// Runs either subcommand in one process.
pub fn run(goal: Goal<'_>, mut requested: Spec, talk: &Talk) -> Result<(), Failure> {
    let args = goal.args();
    args.hidden.refuse()?;
    let has_pieces = args.writing.any(&args.output, &[OutputFormat::Pvtu]);
    let mut spec = requested.clone().with(|c| c.keep.point_owner = has_pieces);
    let counted = matches!(goal, Goal::Simulate(_));
    let start = Instant::now();
    super::threads::limit_threads(spec.machine.thread_count());
    let input = Input::of(&args.input, spec.input.dimension)?;
    check_trace(&args.tracing)?;
    let tables = Tables::of(args.profile.as_deref(), &TABLES)?;
    let texts = args.json.iter().chain(&args.tracing.trace).map(PathBuf::as_path).chain(tables.paths());
    let texts = texts.chain(goal.cost_trace());
    let texts: Vec<&Path> = texts.collect();
    check_reading(goal.given(), input.is_sample())?;
    let options = args.writing.options();
    files::check_as(&input.files(), &args.output, &options, &texts)?;
    check_effects(args, goal.given())?;
    if let Input::Sample(request) = &input {
        // A sample that is too large is refused before it is generated.
        admit(&spec, request.n, request.dimension, counted)?;
    }
    let loaded = input.load(&read_options(&spec.input)?, talk)?;
    (spec.recursion.spacing, requested.recursion.spacing) = (loaded.spacing, loaded.spacing);
    if args.json.is_some() && counted {
        spec.keep.view = spec.keep.view.or(Some(MOST_POINTS));
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
        files.extend(write_all((args, spec.keep.owner), &run, &loaded, talk)?);
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
        threads: spec.machine.thread_count(),
        skipped: loaded.skipped,
        read_seconds: loaded.seconds,
        write_seconds,
        total_seconds: start.elapsed().as_secs_f64(),
        rss_before_bytes,
        peak_rss_bytes: peak_rss(),
    };
    let report = RunReport::of(&run, &requested, &setting);
    publish((args, &requested), &tables, &report, files, talk)?;
    failure.map_or(Ok(()), Err)
}

/// Writes the tables and the report, and prints the summary. `files` are the files written before.
pub(super) fn publish(
    (args, requested): (&RunArgs, &Spec),
    tables: &Tables,
    report: &RunReport,
    mut files: Vec<PathBuf>,
    talk: &Talk,
) -> Result<(), Failure> {
    let rendered = |format, which| report.tables(format, which);
    files.extend(tables.write(&rendered)?);
    print_report((args, requested), report, &files, talk)?;
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
fn check_effects(args: &RunArgs, given: &Options) -> Result<(), Failure> {
    args.writing.check(&args.output)?;
    let has_data =
        args.writing.any(&args.output, &[OutputFormat::Vtu, OutputFormat::Pvtu, OutputFormat::Vtk]);
    let outputs = "-o OUT.vtu, -o OUT.pvtu or -o OUT.vtk";
    needs("--keep-columns", given.has("keep-columns"), outputs, has_data)?;
    needs("--with-owner", given.has("with-owner"), outputs, has_data)?;
    needs("--view", given.has("view"), "--json", args.json.is_some())
}

/// Writes the report as JSON and prints its summary.
fn print_report(
    (args, requested): (&RunArgs, &Spec),
    report: &RunReport,
    files: &[PathBuf],
    talk: &Talk,
) -> Result<(), Failure> {
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
        let raw = requested.input.raw.as_ref();
        let reading = raw.map_or_else(String::new, |rows| format!(" --raw {rows}"));
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

fn write_all(
    (args, with_owner): (&RunArgs, bool),
    run: &Run,
    loaded: &Loaded,
    talk: &Talk,
) -> Result<Vec<PathBuf>, Failure> {
    let options = WriteOptions {
        with_owner,
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
