//! `septet fold`.

use std::path::{Path, PathBuf};

use clap::Args;
use septet_lab::accounts::{Accounts, ReportError, ReportedRun, fold};

use super::errors::{Code, Failure};
use super::files;
use super::gzip;
use super::input;
use super::progress::Talk;
use super::text::counted;

/// Options of `septet fold`.
#[derive(Debug, Args)]
#[command(after_help = "\
The command prices every row of the trace and takes the longest paths. It shares no code with the ledger of the run. \
The exit code is 4 if a count differs from the report.

Examples:
  septet simulate sample:uniform:1e4 --cost-trace costs.jsonl --json run.json
  septet fold costs.jsonl
  septet fold costs.jsonl --report run.json
  septet simulate sample:uniform:1e4 --cost-trace - | septet fold -")]
pub struct FoldArgs {
    /// Cost trace of `septet simulate --cost-trace`; also .gz, and `-` for standard input
    trace: PathBuf,
    /// Report of the same run (`--json`), to compare the counts; also .gz
    #[arg(long, value_name = "RUN.json")]
    report: Option<PathBuf>,
}

/// Prints the counts by phase, and compares them with the report.
pub fn run(args: &FoldArgs, talk: &Talk) -> Result<(), Failure> {
    let is_stream = |path: &Path| path.as_os_str() == "-";
    if is_stream(&args.trace) && args.report.as_deref().is_some_and(is_stream) {
        let message = "the trace and the report both come from standard input";
        return Err(Failure::new(Code::Usage, message).help("give a file for one of them"));
    }
    let reported = args.report.as_deref().map(|path| reported(path, talk)).transpose()?;
    let owned = args.trace.clone();
    let folded = input::watched(talk, move |_| gzip::open(&owned).map(fold))?;
    let folded = folded.map_err(|error| input::unreadable(&args.trace, &error))?;
    let accounts = folded.map_err(|error| {
        Failure::of(Code::Input, &error, error.remedy()).in_place(&input::name(&args.trace))
    })?;
    let differences = reported.as_ref().map(|run| accounts.compare(run)).transpose();
    let path = args.report.as_deref().unwrap_or(&args.trace);
    let differences = differences.map_err(|error| refused(path, &error))?;
    files::print(&table(&accounts))?;
    let differences = differences.unwrap_or_default();
    for difference in &differences {
        talk.note(difference.to_string());
    }
    if differences.is_empty() {
        return Ok(());
    }
    let number = differences.len() as u64;
    let message = format!(
        "{} {} from the report",
        counted(number, "count"),
        if number == 1 { "differs" } else { "differ" }
    );
    let help = "write both files in one run; if they still differ, please report it with the input";
    Err(Failure::new(Code::Rejected, message).help(help))
}

/// Reads the counts of a report.
fn reported(path: &Path, talk: &Talk) -> Result<ReportedRun, Failure> {
    let text = input::text_of(path, talk)?;
    ReportedRun::parse(text.as_bytes()).map_err(|error| refused(path, &error))
}

/// Returns the failure for a file that is not the report of the run.
fn refused(path: &Path, error: &ReportError) -> Failure {
    Failure::of(Code::Input, error, error.remedy()).in_place(&input::name(path))
}

/// Formats the counts of the phases and the totals.
fn table(accounts: &Accounts) -> String {
    let mut text = format!("{:<16} {:>16} {:>10} {:>10}\n", "phase", "work", "depth", "brent");
    for row in &accounts.phases {
        text = format!("{text}{:<16} {:>16} {:>10}\n", row.phase, row.work, row.depth);
    }
    for (name, total) in
        [("paper", &accounts.paper), ("repair", &accounts.repair), ("selection", &accounts.selection)]
    {
        text = format!("{text}{name:<16} {:>16} {:>10} {:>10}\n", total.work, total.depth, total.brent);
    }
    text
}
