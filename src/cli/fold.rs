//! `septet fold`.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use clap::Args;
use septet_lab::accounts::{Accounts, ReportedCounts, fold};

use super::errors::{Code, Failure};
use super::files;
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
  septet fold costs.jsonl --report run.json")]
pub struct FoldArgs {
    /// Cost trace of `septet simulate --cost-trace`
    trace: PathBuf,
    /// Report of the same run (`--json`), to compare the counts
    #[arg(long, value_name = "RUN.json")]
    report: Option<PathBuf>,
}

/// Prints the counts by phase, and compares them with the report.
pub fn run(args: &FoldArgs, talk: &Talk) -> Result<(), Failure> {
    let reported = args.report.as_deref().map(reported).transpose()?;
    let trace = File::open(&args.trace).map_err(|error| input::unreadable(&args.trace, &error))?;
    let accounts = fold(BufReader::new(trace)).map_err(|error| {
        Failure::new(Code::Input, format!("{}: {error}", args.trace.display()))
            .help("give a file that `septet simulate --cost-trace` wrote")
    })?;
    files::print(&table(&accounts))?;
    let Some(reported) = reported else { return Ok(()) };
    let differences = accounts.differences(&reported);
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
    Err(Failure::new(Code::Rejected, message))
}

/// Reads the counts of a report.
fn reported(path: &Path) -> Result<ReportedCounts, Failure> {
    let text = std::fs::read(path).map_err(|error| input::unreadable(path, &error))?;
    serde_json::from_slice(&text).map_err(|error| {
        Failure::new(Code::Input, format!("{}: not the report of a run: {error}", path.display()))
            .help("give a file that `septet simulate --json` wrote")
    })
}

/// Formats the counts of the phases and the totals.
fn table(accounts: &Accounts) -> String {
    let mut text = format!("{:<16} {:>16} {:>10} {:>10}\n", "phase", "work", "depth", "brent");
    for row in &accounts.phases {
        text += &format!("{:<16} {:>16} {:>10}\n", row.phase, row.work, row.depth);
    }
    for (name, total) in [("paper", &accounts.paper), ("repair", &accounts.repair)] {
        text += &format!("{name:<16} {:>16} {:>10} {:>10}\n", total.work, total.depth, total.brent);
    }
    text
}
