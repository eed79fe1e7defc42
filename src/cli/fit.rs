//! `septet fit`.

use std::path::PathBuf;

use clap::Args;
use septet_lab::experiment::fit::{Abscissa, FitError, Key, MARGIN, Request, fit, speedup, speedup_table};
use septet_lab::experiment::{Line, read_lines};
use serde_json::json;

use super::errors::{Code, Failure};
use super::files;
use super::progress::Talk;

/// Options of `septet fit`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet fit runs.jsonl -y levels
  septet fit runs.jsonl -y depth --phase partition
  septet fit runs.jsonl -y level-depth --phase neighbours --margin 0.05 --resample 1000
  septet fit runs.jsonl -y bytes --phase separator-sets --json -
  septet fit times.jsonl --speedup

Counts: levels, leaves, attempts, edges, max-degree, replication, exchange-rounds; and with --phase: depth,
depth-log-scan, work, rounds, messages, bytes, seconds, level-depth. Phases are fitted apart, and repair never
with the paper's.")]
pub struct FitArgs {
    /// Files of `septet scale`
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// The count to fit
    #[arg(short = 'y', value_name = "KEY", required_unless_present = "speedup")]
    y: Option<String>,
    /// What it is drawn against
    #[arg(short = 'x', value_name = "n|n/leaf", default_value = "n")]
    x: String,
    /// The phase it is a count of; `paper` or `repair` for all of theirs
    #[arg(long, value_name = "NAME")]
    phase: Option<String>,
    /// The growth that counts as none: with -y level-depth a share of the mean depth per doubling, else a share of
    /// the mean over the whole range of sizes
    #[arg(long, value_name = "SHARE", default_value_t = MARGIN, allow_negative_numbers = true)]
    margin: f64,
    /// Draw the seeds again so many times, and say how often the verdict is the same
    #[arg(long, value_name = "TIMES", default_value_t = 0)]
    resample: u32,
    /// Speed-up of timed runs, against the best serial run of the same points
    #[arg(long, conflicts_with_all = ["y", "phase", "resample"])]
    speedup: bool,
    /// Write the answer as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

/// Runs the subcommand.
pub fn run(args: &FitArgs, talk: &Talk) -> Result<(), Failure> {
    let mut lines: Vec<Line> = Vec::new();
    for file in &args.files {
        let mut read = read_lines(file).map_err(|e| Failure::new(Code::Input, e.to_string()))?;
        if read.incomplete > 0 {
            talk.note(format!("note: {}: an incomplete line at its end is ignored", file.display()));
        }
        lines.append(&mut read.lines);
    }
    let (value, text) = if args.speedup {
        let rows = speedup(&lines)?;
        (json!({ "schema": "septet-speedup/1", "rows": rows }), speedup_table(&rows))
    } else {
        let request = Request {
            y: args.y.as_deref().unwrap_or_default().parse::<Key>()?,
            x: args.x.parse::<Abscissa>()?,
            phase: args.phase.clone(),
            margin: args.margin,
            resamples: args.resample,
        };
        let report = fit(&lines, &request)?;
        (json!(report), report.text())
    };
    let Some(path) = &args.json else {
        print!("{text}");
        return Ok(());
    };
    let mut written = serde_json::to_string_pretty(&value)
        .map_err(|e| Failure::new(Code::Failed, format!("the answer cannot be written: {e}")))?;
    written.push('\n');
    files::write_text(path, &written)?;
    if path.as_os_str() != "-" {
        print!("{text}");
    }
    Ok(())
}

impl From<FitError> for Failure {
    fn from(error: FitError) -> Self {
        let code = match error {
            FitError::TooFewSizes { .. }
            | FitError::TooFewLevels { .. }
            | FitError::TooFewSeeds { .. }
            | FitError::Nothing { .. }
            | FitError::NotTimed
            | FitError::NoSerial { .. } => Code::Input,
            _ => Code::Usage,
        };
        Failure::new(code, error.to_string()).help("see `septet fit --help`")
    }
}
