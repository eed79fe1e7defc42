//! septet-cli: the subcommands, options, progress messages, errors and exit codes of the program `septet`.

mod completions;
mod door;
mod effects;
mod errors;
mod excerpt;
mod far;
mod faults;
mod files;
mod fit;
mod fold;
mod formats;
mod generate;
mod given;
#[cfg(test)]
mod guide_tests;
mod gzip;
mod headings;
mod hidden;
mod input;
mod instruments;
mod mesh;
mod names;
mod options;
mod page;
mod predict;
mod processes;
mod progress;
mod queries;
#[cfg(test)]
mod remedy_tests;
mod report;
mod reproduce;
mod rival;
mod run;
mod scale;
mod schema;
mod stats;
mod summary;
mod text;
mod verify;
mod verify_box;
mod voronoi;
mod weights;

use std::any::Any;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ColorChoice, CommandFactory, FromArgMatches, Parser, Subcommand};
use septet_core::spec::Transport;
use septet_protocol::wire::Wire;
use tracing_subscriber::layer::Identity;

use errors::{Code, Failure};
use progress::{Talk, TalkArgs};
use run::Goal;
use text::{near, nearest, printable};

/// Turn your points into triangles or tetrahedra, and your surface into a mesh of its inside.
///
/// septet reads scans, tables, catalogues, arrays and meshes. Every triangulation is the exact Delaunay triangulation of
/// the points, and septet checks each result before it writes a file.
#[derive(Debug, Parser)]
#[command(
    name = "septet",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = EXAMPLES,
    after_long_help = AFTER_HELP
)]
struct Cli {
    #[command(flatten)]
    talk: TalkArgs,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  septet triangulate points.csv -o mesh.vtu
  septet mesh part.stl --size 0.5 -o part.vtu
  septet verify mesh.vtu

`septet COMMAND --help` explains a command. `septet --help` lists the exit codes.";

const AFTER_HELP: &str = "\
Examples:
  septet triangulate points.csv -o mesh.vtu
  septet triangulate sample:well-spaced:100000 -o mesh.vtu
  septet simulate sample:uniform:1e5 --workers leaves --profile
  septet mesh part.stl --size 0.5 -o part.vtu
  septet verify mesh.vtu

`septet triangulate` is the fast path. `septet simulate` runs the parallel algorithm of the paper (sphere separators, \
density graphs, local convex hulls) on a message-passing machine, and counts work, depth, rounds, messages and bytes. \
Both give the same bytes for any number of workers.

Exit codes:
  0    success
  1    the run failed, or an output cannot be written
  2    an option or a combination of options is not valid
  3    the input data are not valid
  4    a verification or a claim failed
  5    a limit was reached: memory or number of points
  6    a worker or the transport failed
  130  interrupted

Data are written to standard output, messages to standard error.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Triangulate points: exact, certified, and with the same bytes for any number of workers.
    Triangulate(options::TriangulateArgs),
    /// Mesh a domain, or check the domain.
    Mesh(mesh::MeshArgs),
    /// Verify any Delaunay triangulation in exact arithmetic.
    Verify(verify::VerifyArgs),
    /// Find the simplex that contains each query.
    Locate(queries::LocateArgs),
    /// Interpolate values of points at queries.
    Interpolate(queries::InterpolateArgs),
    /// Measure the Voronoi cells of points in a box.
    Voronoi(voronoi::VoronoiArgs),
    /// Write the alpha shape of points.
    Alpha(queries::AlphaArgs),
    /// Generate a point set.
    Generate(generate::GenerateArgs),
    /// Create a self-contained HTML page from the reports of runs and meshes.
    Report(report::ReportArgs),
    /// Triangulate points by the algorithm of the paper and count its operations and messages.
    Simulate(options::SimulateArgs),
    /// Predict the time of a machine with any number of workers from its counts.
    Predict(predict::PredictArgs),
    /// Run a sweep over sizes, kinds, workers and seeds, and record the counts.
    Scale(scale::ScaleArgs),
    /// Fit growth laws to the counts of a sweep.
    Fit(fit::FitArgs),
    /// Price a cost trace, and compare its counts with a report.
    Fold(fold::FoldArgs),
    /// Count another algorithm on the same points, as a baseline.
    Rival(rival::RivalArgs),
    /// Test the claims of the paper by experiments.
    Reproduce(reproduce::ReproduceArgs),
    /// Print the JSON schema of a report.
    Schema(schema::SchemaArgs),
    /// Print a completion script for a shell.
    Completions(completions::CompletionsArgs),
    /// Print the manual, or write a manual page for each command.
    Man(completions::ManArgs),
}

impl Command {
    /// Returns the goal of a command that several processes can run together.
    fn goal(&self) -> Option<Goal<'_>> {
        match self {
            Command::Triangulate(args) => Some(Goal::Triangulate(args)),
            Command::Simulate(args) => Some(Goal::Simulate(args)),
            _ => None,
        }
    }
}

/// Parses the arguments, runs the command, reports any failure and returns the exit code.
pub fn main() -> ExitCode {
    let cli = match parsed(false) {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let is_silent = cli.command.goal().is_some_and(processes::is_started);
    let talk = Talk::new(&cli.talk, is_silent);
    ended(&talk, |talk| run(cli.command, talk)).unwrap_or_else(|_| panicked(&talk))
}

/// Returns the page of a report as HTML, as `septet report` writes it. `name` is the file in messages.
///
/// # Errors
/// Fails with a message if the text contains no report.
pub fn page_of(name: &str, report: &str) -> Result<String, String> {
    let page = page::Page::of(&[(name.to_owned(), report.to_owned())]).map_err(|error| error.to_string())?;
    page.html().map_err(|error| error.to_string())
}

/// Runs the program on one of several processes, which a wire connects. Only the first process prints. `name` is the name of
/// the connection in reports.
///
/// # Panics
/// Panics if the command does, so that the caller can end the other processes.
pub fn main_of_processes(wire: &mut dyn Wire, name: &'static str) -> ExitCode {
    let is_silent = wire.process() != 0;
    let cli = match parsed(is_silent) {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let talk = Talk::new(&cli.talk, is_silent);
    let on_wire = |talk: &Talk| match cli.command.goal() {
        Some(goal) => processes::on_wire(goal, wire, name, talk),
        None => Err(processes::not_on_processes()),
    };
    ended(&talk, on_wire).unwrap_or_else(|payload| resume_unwind(payload))
}

/// Parses the arguments. Prints a message and returns the exit code if there is nothing to run.
fn parsed(is_silent: bool) -> Result<Cli, ExitCode> {
    let command = Cli::command().color(color_choice());
    command.try_get_matches().and_then(|m| Cli::from_arg_matches(&m)).map_err(|error| {
        let code = ExitCode::from(error.exit_code() as u8);
        if !is_silent {
            refuse(error);
        }
        code
    })
}

/// Runs a command, reports any failure and returns the exit code. Returns the payload of a panic.
fn ended(
    talk: &Talk,
    command: impl FnOnce(&Talk) -> Result<(), Failure>,
) -> Result<ExitCode, Box<dyn Any + Send>> {
    let outcome = catch_unwind(AssertUnwindSafe(|| command(talk)));
    talk.clear();
    let failure = match outcome {
        Ok(Ok(())) => return Ok(ExitCode::SUCCESS),
        Ok(Err(failure)) => failure,
        Err(payload) => errors::failure_of(payload)?,
    };
    Ok(report(&failure, talk))
}

/// Prints a failure, and returns its exit code.
fn report(failure: &Failure, talk: &Talk) -> ExitCode {
    if failure.code != Code::ReaderGone && (failure.is_own || !talk.is_silent()) {
        failure.print(talk);
    }
    ExitCode::from(failure.code as u8)
}

/// Reports a panic, whose message has been printed, and returns the exit code.
fn panicked(talk: &Talk) -> ExitCode {
    let failure = Failure::new(Code::Failed, "internal error");
    report(&failure.help("please report the message above together with the input"), talk)
}

/// Prints a message from the argument parser: the help, the version, or an error.
fn refuse(mut error: clap::Error) {
    if std::env::args_os().len() <= 1 {
        let _ = writeln!(std::io::stderr(), "Try: septet triangulate sample:uniform:1e5 -o mesh.vtu\n");
    }
    let typed = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(typed)) => typed.clone(),
        _ => String::new(),
    };
    if let Some(message) = door::message(&typed).filter(|_| is_first_word(&typed)) {
        let _ = std::io::stderr().write_all(message.as_bytes());
        return;
    }
    if let Some(ContextValue::Strings(names)) = error.get(ContextKind::SuggestedSubcommand) {
        let sorted = nearest(&typed, names.iter().map(String::as_str));
        let sorted = sorted.into_iter().map(str::to_owned).collect();
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(sorted));
    }
    if let (Some(ContextValue::String(typed)), Some(ContextValue::Strings(names)), None) = (
        error.get(ContextKind::InvalidValue),
        error.get(ContextKind::ValidValue),
        error.get(ContextKind::SuggestedValue),
    ) && let Some(name) = near(typed, names.iter().map(String::as_str)).map(str::to_owned)
    {
        error.insert(ContextKind::SuggestedValue, ContextValue::String(name));
    }
    if reads_several(&error) {
        let tip = "quote a pattern, such as 'part-*.npy', or name the files in a list, such as @list.txt";
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    // A name could contain escape sequences for the terminal.
    let unsafe_text = |value: &ContextValue| match value {
        ContextValue::String(text) if text.contains(char::is_control) => Some(printable(text)),
        _ => None,
    };
    let escaped: Vec<_> = error.context().filter_map(|(kind, v)| Some((kind, unsafe_text(v)?))).collect();
    if !escaped.is_empty() {
        // The suggestions contain the name again.
        error.remove(ContextKind::Suggested);
    }
    for (kind, text) in escaped {
        error.insert(kind, ContextValue::String(text));
    }
    // Nothing can be reported if the stream is closed.
    let _ = error.print();
}

/// Whether a word is the first argument that is no option.
fn is_first_word(typed: &str) -> bool {
    let first = std::env::args_os().skip(1).find(|word| !word.as_encoded_bytes().starts_with(b"-"));
    first.is_some_and(|word| word == typed)
}

/// Returns `true` if a command that reads points has a second file as its argument, as from a pattern that the shell has
/// expanded.
fn reads_several(error: &clap::Error) -> bool {
    let reads_points =
        |a: String| matches!(a.as_str(), "triangulate" | "simulate" | "predict" | "incremental");
    match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(argument)) => {
            error.kind() == ErrorKind::UnknownArgument
                && Path::new(argument).is_file()
                && std::env::args_os().filter_map(|a| a.into_string().ok()).any(reads_points)
        }
        _ => false,
    }
}

fn run(command: Command, talk: &Talk) -> Result<(), Failure> {
    match command {
        Command::Triangulate(args) => run_goal(Goal::Triangulate(&args), talk),
        Command::Simulate(args) => run_goal(Goal::Simulate(&args), talk),
        Command::Generate(args) => logged(talk, || generate::run(&args, talk)),
        Command::Mesh(args) => mesh::run(&args, talk),
        Command::Verify(args) => logged(talk, || verify::run(&args, talk)),
        Command::Locate(args) => logged(talk, || queries::locate(&args, talk)),
        Command::Interpolate(args) => logged(talk, || queries::interpolate(&args, talk)),
        Command::Voronoi(args) => logged(talk, || voronoi::voronoi(&args, talk)),
        Command::Alpha(args) => logged(talk, || queries::alpha(&args, talk)),
        Command::Predict(args) => logged(talk, || predict::run(&args, talk)),
        Command::Report(args) => logged(talk, || report::run(&args, talk)),
        Command::Scale(args) => logged(talk, || scale::run(&args, talk)),
        Command::Fit(args) => logged(talk, || fit::run(&args, talk)),
        Command::Fold(args) => logged(talk, || fold::run(&args, talk)),
        Command::Rival(args) => logged(talk, || rival::run(&args, talk)),
        Command::Reproduce(args) => logged(talk, || reproduce::run(&args, talk)),
        Command::Completions(args) => completions::run(&args, Cli::command()),
        Command::Schema(args) => schema::run(&args),
        Command::Man(args) => completions::man(&args, Cli::command()),
    }
}

/// Runs `septet triangulate` or `septet simulate` with its transport.
fn run_goal(goal: Goal<'_>, talk: &Talk) -> Result<(), Failure> {
    let requested = goal.requested()?;
    match requested.machine.transport {
        Transport::Processes { .. } => processes::local(goal, &requested, talk),
        _ => run::run_alone(goal, requested, talk),
    }
}

/// Sets up logging and runs a command that writes no trace.
fn logged(talk: &Talk, run: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    talk.log(None::<Identity>);
    run()
}

/// Finds the value of `--color` for messages from the argument parser, which are printed before the options are
/// parsed.
fn color_choice() -> ColorChoice {
    let args: Vec<String> = std::env::args().collect();
    let value = args.iter().enumerate().find_map(|(i, a)| match a.strip_prefix("--color") {
        Some("") => args.get(i + 1).map(String::as_str),
        Some(rest) => rest.strip_prefix('='),
        None => None,
    });
    match value {
        Some("never") => ColorChoice::Never,
        Some("always") => ColorChoice::Always,
        _ => ColorChoice::Auto,
    }
}
