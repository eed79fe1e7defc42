//! `septet predict`.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use septet_lab::predict::{Hardware, Prediction, Timed, calibrate, predict, takes_over};
use septet_protocol::tasks::TaskLog;
use serde::{Deserialize, Serialize};

use super::errors::{Code, Failure};
use super::files;
use super::input;
use super::progress::Talk;
use super::text::counted;

/// Options of `septet predict`.
#[derive(Debug, Args)]
#[command(after_help = "\
The predicted rounds, messages and bytes are exact if the number of workers divides 4096.

Examples:
  septet simulate sample:well-spaced:1e5 --workers 1 --tasks --json run.json
  septet predict run.json --workers 1..65536
  septet predict run.json --workers 2,48,96 --latency 5e-6 --bandwidth 1e9
  septet predict run.json --workers 2 --calibrate")]
pub struct PredictArgs {
    /// Report of `septet simulate --tasks --json`
    run: PathBuf,
    /// Numbers of workers: a list, or a range `A..B` for A, 2A, 4A, ... up to B
    #[arg(long, value_name = "P,..|A..B", default_value = "1..65536", value_parser = worker_counts)]
    workers: WorkerCounts,
    /// Latency of a message in seconds [default: 2e-6]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    latency: Option<f64>,
    /// Overhead of a message at its sender and receiver, in seconds [default: 1e-6]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    overhead: Option<f64>,
    /// Bandwidth between two ranks, in bytes per second [default: 1e10]
    #[arg(long, value_name = "BYTES", value_parser = positive)]
    bandwidth: Option<f64>,
    /// Charged operations per second of one worker [default: 1e9]
    #[arg(long, value_name = "OPERATIONS", value_parser = positive)]
    rate: Option<f64>,
    /// Measure the channels of this computer, and derive rates from the times in the report
    ///
    /// The run must have one worker. Explicit options take precedence.
    #[arg(long)]
    calibrate: bool,
    /// Write the predictions as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

/// A list of numbers of workers.
#[derive(Clone, Debug)]
struct WorkerCounts(Vec<u32>);

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite());
    value.ok_or_else(|| "expected a positive number".into())
}

fn worker_counts(text: &str) -> Result<WorkerCounts, String> {
    let number = |t: &str| t.trim().parse().ok().filter(|&p: &u32| p > 0);
    let expected = || "expected numbers such as 2,8,64 or a range such as 1..65536".to_owned();
    let mut counts = match text.split_once("..") {
        None => text.split(',').map(number).collect::<Option<Vec<u32>>>().ok_or_else(expected)?,
        Some((low, high)) => {
            let (low, high) = number(low).zip(number(high)).ok_or_else(expected)?;
            std::iter::successors(Some(low), |p| p.checked_mul(2)).take_while(|&p| p <= high).collect()
        }
    };
    counts.sort_unstable();
    counts.dedup();
    if counts.is_empty() { Err(expected()) } else { Ok(WorkerCounts(counts)) }
}

/// The fields of a run report that a prediction needs.
#[derive(Deserialize)]
struct RunFile {
    schema: String,
    machine: Option<MachineFields>,
    #[serde(default)]
    phases: Vec<PhaseFields>,
    tasks: Option<TaskLog>,
}

#[derive(Deserialize)]
struct MachineFields {
    workers: u32,
}

#[derive(Deserialize)]
struct PhaseFields {
    name: String,
    work: Option<u64>,
    seconds: Option<f64>,
}

/// `septet-predict/1`.
#[derive(Serialize)]
struct PredictReport<'a> {
    schema: &'static str,
    version: &'static str,
    run: String,
    points: u64,
    dimension: u32,
    leaves: usize,
    hardware: &'a Hardware,
    predictions: &'a [Prediction],
    communication_takes_over: Option<u32>,
}

/// Reads the task record, and computes and prints the predictions.
pub fn run(args: &PredictArgs, talk: &Talk) -> Result<(), Failure> {
    let file = read(args)?;
    let log = file.tasks.as_ref().ok_or_else(|| {
        let message = format!("{}: the report has no record of the tasks", args.run.display());
        Failure::new(Code::Input, message)
            .help("create the report with `septet simulate ... --tasks --json FILE`")
    })?;
    let hardware = hardware(args, &file)?;
    let mut predictions = Vec::new();
    for &workers in &args.workers.0 {
        talk.check();
        let prediction = predict(log, workers, &hardware)
            .map_err(|e| Failure::new(Code::Input, format!("{}: {e}", args.run.display())))?;
        predictions.push(prediction);
    }
    let over = takes_over(&predictions);
    if let Some(path) = &args.json {
        let report = PredictReport {
            schema: "septet-predict/1",
            version: env!("CARGO_PKG_VERSION"),
            run: args.run.display().to_string(),
            points: log.population,
            dimension: log.dimension,
            leaves: log.leaves.len(),
            hardware: &hardware,
            predictions: &predictions,
            communication_takes_over: over,
        };
        let text = serde_json::to_string_pretty(&report)
            .map_err(|e| Failure::new(Code::Failed, format!("the report cannot be written: {e}")))?;
        files::write_text(path, &(text + "\n"))?;
    }
    if args.json.as_ref().is_none_or(|path| path.as_os_str() != "-") {
        files::write_text("-".as_ref(), &table(&predictions, over))?;
    }
    let [points, leaves] = [counted(log.population, "point"), log.leaves.len().to_string()];
    talk.note(format!("septet: {points}, leaves of the tree: {leaves}"));
    Ok(())
}

fn read(args: &PredictArgs) -> Result<RunFile, Failure> {
    let name = args.run.display();
    let text = std::fs::read(&args.run).map_err(|error| input::unreadable(&args.run, &error))?;
    let file: RunFile = serde_json::from_slice(&text)
        .map_err(|e| Failure::new(Code::Input, format!("{name}: not a report of a run: {e}")))?;
    if file.schema != septet_lab::report::SCHEMA {
        let message = format!("{name}: schema `{}`, expected `{}`", file.schema, septet_lab::report::SCHEMA);
        return Err(Failure::new(Code::Input, message));
    }
    Ok(file)
}

fn hardware(args: &PredictArgs, file: &RunFile) -> Result<Hardware, Failure> {
    let mut hardware = Hardware::default();
    if args.calibrate {
        if file.machine.as_ref().is_none_or(|m| m.workers != 1) {
            let message = "--calibrate needs the report of a run with one worker";
            return Err(
                Failure::new(Code::Usage, message).help("create the report with --workers 1 --threads 1")
            );
        }
        let timed = |p: &PhaseFields| Timed {
            name: p.name.clone(),
            work: p.work.unwrap_or(0),
            seconds: p.seconds.unwrap_or(0.0),
        };
        hardware = calibrate(&file.phases.iter().map(timed).collect::<Vec<_>>());
    }
    hardware.latency = args.latency.unwrap_or(hardware.latency);
    hardware.overhead = args.overhead.unwrap_or(hardware.overhead);
    hardware.bandwidth = args.bandwidth.unwrap_or(hardware.bandwidth);
    if let Some(rate) = args.rate {
        hardware.rate = rate;
        hardware.phase_rates.clear();
    }
    Ok(hardware)
}

fn table(predictions: &[Prediction], over: Option<u32>) -> String {
    let mut out = String::new();
    let head = "workers  rounds   messages           bytes  surface  busiest work  BSP compute +  communicate   LogGP total     Brent steps  exact";
    let _ = writeln!(out, "{head}");
    for p in predictions {
        let _ = writeln!(
            out,
            "{:>7}  {:>6}  {:>9}  {:>14}  {:>7.2}  {:>12}  {:>9.4} s + {:>10.4} s  {:>11.4} s  {:>14}  {}",
            p.workers,
            p.rounds,
            p.messages,
            p.bytes,
            p.surface_ratio,
            p.busiest_work,
            p.bsp.compute,
            p.bsp.communicate,
            p.loggp.total(),
            p.brent,
            if p.exact { "yes" } else { "no" },
        );
    }
    let _ = match over {
        Some(p) => writeln!(out, "communication takes longer than computation from {p} workers on (BSP)"),
        None => writeln!(out, "computation takes longer than communication for all of these (BSP)"),
    };
    out
}
