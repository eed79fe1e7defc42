//! Subcommands, exit codes, and what they share: options, progress, errors.

mod completions;
mod errors;
mod excerpt;
mod files;
mod fit;
mod formats;
mod generate;
mod input;
mod instruments;
mod mesh;
mod options;
mod page;
mod predict;
mod progress;
mod report;
mod reproduce;
mod rival;
mod scale;
mod threads;
mod triangulate;
mod verify;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use clap::{ColorChoice, CommandFactory, FromArgMatches, Parser, Subcommand};
use tracing_subscriber::layer::Identity;

use errors::{Code, Failure};
use progress::{Cancelled, Talk, TalkArgs};

/// Delaunay triangulation by sphere separators, density graphs and local convex hulls, on a counted
/// message-passing machine.
#[derive(Debug, Parser)]
#[command(name = "septet", version, propagate_version = true, after_help = AFTER_HELP)]
struct Cli {
    #[command(flatten)]
    talk: TalkArgs,
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  septet triangulate points.node -o mesh.vtu
  septet triangulate sample:well-spaced:100000 -o mesh.vtu --json -
  septet simulate sample:uniform:1e5 --workers leaves --profile

Exit codes:
  0    done
  1    the run failed, or an output cannot be written (found before work starts)
  2    usage: an option or a combination of options that cannot be run
  3    bad input data
  4    a verification or a claim failed
  5    a limit was reached (memory, number of points)
  6    a worker or the transport failed
  130  interrupted

Data goes to standard output, talk to standard error.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Triangulate points: exact, certified, and the same bytes for any number of workers.
    Triangulate(options::TriangulateArgs),
    /// The same triangulation by the paper's recursion to its floor, with every count on.
    Simulate(options::SimulateArgs),
    /// Generate a point set.
    Generate(generate::GenerateArgs),
    /// Make a mesh of a domain, or check the domain for it.
    Mesh(mesh::MeshArgs),
    /// Check any triangulation of any points in exact arithmetic.
    Verify(verify::VerifyArgs),
    /// What the machine would do with any number of workers, from the record of one run.
    Predict(predict::PredictArgs),
    /// Make one offline page of runs and meshes: pictures, tables, the partition or the mesh to turn and slice.
    Report(report::ReportArgs),
    /// Run a sweep over sizes, kinds, workers and seeds, and keep the counts.
    Scale(scale::ScaleArgs),
    /// Judge how a count of a sweep grows: laws with intervals, curvature, flatness, a verdict.
    Fit(fit::FitArgs),
    /// Count another algorithm on the same points, on the same ledger.
    Rival(rival::RivalArgs),
    /// Run the paper's claims as experiments: PASS or FAIL with figure, bound and seed.
    Reproduce(reproduce::ReproduceArgs),
    /// Write a completion script for a shell.
    Completions(completions::CompletionsArgs),
    /// Write the manual page.
    #[command(after_help = "Examples:\n  septet man > septet.1\n  septet man | man -l -")]
    Man,
}

/// Parses, runs, and turns what went wrong into a report and an exit code.
pub fn main() -> ExitCode {
    let command = Cli::command().color(color_choice());
    let cli = match command.try_get_matches().and_then(|m| Cli::from_arg_matches(&m)) {
        Ok(cli) => cli,
        Err(error) => error.exit(),
    };
    let talk = Talk::new(&cli.talk);
    let outcome = catch_unwind(AssertUnwindSafe(|| run(cli.command, &talk)));
    talk.clear();
    let failure = match outcome {
        Ok(Ok(())) => return ExitCode::SUCCESS,
        Ok(Err(failure)) => failure,
        Err(payload) if payload.is::<Cancelled>() => Failure::interrupted(),
        Err(_) => Failure::new(Code::Failed, "septet stopped at a fault of its own")
            .help("please report the message above with the input"),
    };
    failure.print(&talk);
    ExitCode::from(failure.code as u8)
}

fn run(command: Command, talk: &Talk) -> Result<(), Failure> {
    match command {
        Command::Triangulate(args) => triangulate::run(&args.run, args.config()?, false, talk),
        Command::Simulate(args) => triangulate::run(&args.run, args.config()?, true, talk),
        Command::Generate(args) => logged(talk, || generate::run(&args, talk)),
        Command::Mesh(args) => mesh::run(&args, talk),
        Command::Verify(args) => logged(talk, || verify::run(&args, talk)),
        Command::Predict(args) => logged(talk, || predict::run(&args, talk)),
        Command::Report(args) => logged(talk, || report::run(&args, talk)),
        Command::Scale(args) => logged(talk, || scale::run(&args, talk)),
        Command::Fit(args) => logged(talk, || fit::run(&args, talk)),
        Command::Rival(args) => logged(talk, || rival::run(&args, talk)),
        Command::Reproduce(args) => logged(talk, || reproduce::run(&args, talk)),
        Command::Completions(args) => completions::run(&args, Cli::command()),
        Command::Man => completions::man(Cli::command()),
    }
}

/// What has no trace.
fn logged(talk: &Talk, run: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    talk.log(None::<Identity>);
    run()
}

/// `--color` for the messages of the parser itself, which come before the options are known.
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
