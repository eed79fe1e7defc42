//! `septet fit`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use schemars::JsonSchema;
use septet_lab::experiment::fit::{
    Abscissa, FitError, FitRequest, Key, SpeedupRow, fit, speedup, speedup_table,
};
use septet_lab::experiment::{JournalError, Line, read_lines};
use septet_lab::report::SCHEMA;
use septet_lab::report::mesh::MESH_SCHEMA;
use septet_protocol::ids::Phase;
use serde::Serialize;
use serde_json::{Value, json};

use super::effects::{excludes, needs};
use super::errors::{Code, Failure};
use super::files;
use super::input;
use super::progress::Talk;
use super::text::counted;

/// Options of `septet fit`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet fit runs.jsonl
  septet fit runs.jsonl -y levels
  septet fit runs.jsonl -y depth --phase partition
  septet fit runs.jsonl -y level-depth --phase neighbours --resample 1000
  septet fit runs.jsonl -y bytes --phase separator-sets --json -
  septet fit times.jsonl --speedup

Counts of a run: levels, leaves, attempts, edges, max-degree, replication, exchange-rounds. Counts of a phase, with \
--phase: depth, depth-log-scan, work, exact-tests, rounds, messages, bytes, seconds, level-depth, and the counts of rounds, such as \
largest-load. The repair phases are fitted \
separately from the phases of the paper.")]
pub struct FitArgs {
    /// Files of `septet scale`
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Count to fit; if omitted, the counts in the files are listed
    #[arg(short = 'y', value_name = "KEY")]
    y: Option<String>,
    /// Abscissa of the fit [default: n]
    #[arg(short = 'x', value_name = "n|n/leaf")]
    x: Option<String>,
    /// Phase of the count; `paper` and `repair` stand for the sum over their phases
    #[arg(long, value_name = "NAME", requires = "y")]
    phase: Option<String>,
    /// Largest change that does not count as growth
    ///
    /// With -y level-depth, it is a fraction of the mean depth per doubling of the size. Otherwise, it is a fraction
    /// of the mean over the whole range of sizes. [default: 0.05]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    margin: Option<f64>,
    /// Number of bootstrap samples of the seeds; the report states how many of them give the same conclusion
    #[arg(long, value_name = "TIMES")]
    resample: Option<u32>,
    /// Print the speed-up of timed runs over the best serial run on the same points
    #[arg(long, conflicts_with_all = ["y", "x", "phase", "margin", "resample"])]
    speedup: bool,
    /// Write the result as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

/// Name and version of the schema of [`SpeedupReport`].
const SPEEDUP_SCHEMA: &str = "septet-speedup/1";

/// The speed-ups of all sets and machines.
#[derive(Serialize, JsonSchema)]
pub(super) struct SpeedupReport {
    /// Name and version of this schema.
    #[schemars(extend("const" = SPEEDUP_SCHEMA))]
    schema: &'static str,
    /// One row for each set, number of points, number of workers and number of threads.
    rows: Vec<SpeedupRow>,
}

/// Runs the subcommand.
pub fn run(args: &FitArgs, talk: &Talk) -> Result<(), Failure> {
    let request = request(args)?;
    let mut lines: Vec<Line> = Vec::new();
    for file in &args.files {
        let mut read = read_lines(file).map_err(|error| unreadable(file, &error))?;
        if read.incomplete > 0 {
            talk.note(format!("note: {}: the incomplete last line is ignored", file.display()));
        }
        lines.append(&mut read.lines);
    }
    if lines.is_empty() {
        return Err(in_files(&args.files, FitError::NoRuns));
    }
    let (value, text) = if args.speedup {
        let rows = speedup(&lines).map_err(|error| in_files(&args.files, error))?;
        let table = speedup_table(&rows);
        (json!(SpeedupReport { schema: SPEEDUP_SCHEMA, rows }), table)
    } else {
        let Some(request) = request else { return Ok(files::print(&counts(&lines))?) };
        let report = fit(&lines, &request).map_err(|error| in_files(&args.files, error))?;
        (json!(report), report.text())
    };
    let Some(path) = &args.json else { return Ok(files::print(&text)?) };
    let mut written = serde_json::to_string_pretty(&value)
        .map_err(|e| Failure::new(Code::Failed, format!("the result cannot be written: {e}")))?;
    written.push('\n');
    files::write_text(path, &written)?;
    if path.as_os_str() != "-" {
        files::print(&text)?;
    }
    Ok(())
}

/// Returns the request for a fit, or `None` without a count to fit. Options of a fit are then refused.
fn request(args: &FitArgs) -> Result<Option<FitRequest>, Failure> {
    let Some(y) = &args.y else {
        needs("-x", args.x.is_some(), "-y", false)?;
        needs("--margin", args.margin.is_some(), "-y", false)?;
        needs("--resample", args.resample.is_some(), "-y", false)?;
        needs("--json", args.json.is_some(), "-y or --speedup", args.speedup)?;
        return Ok(None);
    };
    let mut request = FitRequest::new(y.parse::<Key>()?, args.phase.as_deref());
    excludes("-x", args.x.is_some(), "-y level-depth", request.y == Key::LevelDepth)?;
    if let Some(x) = &args.x {
        request.x = x.parse::<Abscissa>()?;
    }
    request.margin = args.margin.unwrap_or(request.margin);
    request.resamples = args.resample.unwrap_or(request.resamples);
    Ok(Some(request))
}

/// Lists the counts that can be fitted, with the command for one of them.
fn counts(lines: &[Line]) -> String {
    let rows = lines.iter().flat_map(|line| &line.phases);
    let phases: BTreeSet<Phase> = rows.map(|row| row.total.phase).collect();
    let phases: Vec<&str> = phases.into_iter().map(Phase::name).collect();
    let of_phases: Vec<&str> = Key::names_of_phases().collect();
    let runs = counted(lines.len() as u64, "run");
    format!(
        "{runs}. Choose a count with -y:\n  of a run:    levels, leaves, attempts, edges, max-degree, replication, \
         exchange-rounds\n  of a phase:  {}; add --phase NAME\n  phases:      paper, repair, selection, {}\n",
        of_phases.join(", "),
        phases.join(", ")
    )
}

/// Converts the error of a fit, and adds the names of the files.
fn in_files(files: &[PathBuf], error: FitError) -> Failure {
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    Failure::from(error).in_place(&names.join(", "))
}

/// Converts the error for a file that is not a sweep.
fn unreadable(file: &Path, error: &JournalError) -> Failure {
    match error {
        JournalError::Io { source, .. } => input::unreadable(file, source),
        _ if is_report(file) => {
            let message = format!("{}: this is the report of one run, not a sweep", file.display());
            Failure::new(Code::Input, message)
                .help("`septet scale` writes sweeps; `septet report` shows one run")
        }
        _ => Failure::new(Code::Input, error.to_string()).help("give a file that `septet scale` wrote"),
    }
}

/// Returns `true` if the file is one JSON object with the schema of a run or a mesh.
fn is_report(file: &Path) -> bool {
    let value = std::fs::read(file).ok().and_then(|text| serde_json::from_slice::<Value>(&text).ok());
    value.is_some_and(|value| value["schema"] == SCHEMA || value["schema"] == MESH_SCHEMA)
}

impl From<FitError> for Failure {
    fn from(error: FitError) -> Self {
        let code = match error {
            FitError::NoRuns
            | FitError::TooFewSizes { .. }
            | FitError::TooFewLevels { .. }
            | FitError::TooFewSeeds { .. }
            | FitError::Nothing { .. }
            | FitError::NotTimed
            | FitError::NoSerial { .. } => Code::Input,
            _ => Code::Usage,
        };
        Failure::of(code, &error, error.remedy()).or_help("see `septet fit --help`")
    }
}
