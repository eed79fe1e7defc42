//! `septet predict`.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use septet_lab::predict::{Hardware, Prediction, Timed, calibrate, predict, takes_over};
use septet_protocol::tasks::TaskLog;
use serde::{Deserialize, Serialize};

use super::errors::{Code, Failure};
use super::files;
use super::progress::Talk;

/// Options of `septet predict`.
#[derive(Debug, Args)]
#[command(after_help = "\
Rounds, messages and bytes are those of a real run wherever the number of workers divides 4096.

Examples:
  septet simulate sample:well-spaced:1e5 --workers 1 --tasks --json run.json
  septet predict run.json --workers 1..65536
  septet predict run.json --workers 2,48,96 --latency 5e-6 --bandwidth 1e9 --json -
  septet predict run.json --workers 2 --calibrate")]
pub struct PredictArgs {
    /// A report of `septet simulate --tasks --json`
    run: PathBuf,
    /// Numbers of workers: a list, or a range `a..b` of the powers of two times a that are at most b
    #[arg(long, value_name = "P,..|A..B", default_value = "1..65536", value_parser = worker_counts)]
    workers: Counts,
    /// Seconds from one rank to another [default: 2e-6]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    latency: Option<f64>,
    /// Seconds a rank spends on a message [default: 1e-6]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    overhead: Option<f64>,
    /// Bytes a second between two ranks [default: 1e10]
    #[arg(long, value_name = "BYTES", value_parser = positive)]
    bandwidth: Option<f64>,
    /// Charged operations a second of one worker [default: 1e9]
    #[arg(long, value_name = "OPERATIONS", value_parser = positive)]
    rate: Option<f64>,
    /// Measure this machine's channels, and take rates from the seconds of the run, which must be of one
    /// worker; what is given explicitly stands
    #[arg(long)]
    calibrate: bool,
    /// Write the predictions as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

/// Numbers of workers.
#[derive(Clone, Debug)]
struct Counts(Vec<u32>);

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite());
    value.ok_or_else(|| "expected a positive number".into())
}

fn worker_counts(text: &str) -> Result<Counts, String> {
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
    if counts.is_empty() { Err(expected()) } else { Ok(Counts(counts)) }
}

/// The part of a run's report that is read.
#[derive(Deserialize)]
struct RunFile {
    schema: String,
    machine: Option<Machine>,
    #[serde(default)]
    phases: Vec<Phase>,
    tasks: Option<TaskLog>,
}

#[derive(Deserialize)]
struct Machine {
    workers: u32,
}

#[derive(Deserialize)]
struct Phase {
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

/// Reads the record, predicts, prints.
pub fn run(args: &PredictArgs, talk: &Talk) -> Result<(), Failure> {
    let file = read(args)?;
    let log = file.tasks.as_ref().ok_or_else(|| {
        let message = format!("{}: the report holds no record of tasks", args.run.display());
        Failure::new(Code::Input, message).help("run `septet simulate ... --tasks --json FILE`")
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
    talk.note(format!("septet: {} points in {} leaves", log.population, log.leaves.len()));
    Ok(())
}

fn read(args: &PredictArgs) -> Result<RunFile, Failure> {
    let name = args.run.display();
    let text = std::fs::read(&args.run)
        .map_err(|e| Failure::new(Code::Input, format!("{name}: cannot be read: {e}")))?;
    let file: RunFile = serde_json::from_slice(&text)
        .map_err(|e| Failure::new(Code::Input, format!("{name}: no report of a run: {e}")))?;
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
            let message = "--calibrate needs a run with one worker: its seconds are those of the work";
            return Err(Failure::new(Code::Usage, message).help("record it with --workers 1 --threads 1"));
        }
        let timed = |p: &Phase| Timed {
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
        Some(p) => writeln!(out, "communication takes longer than computing from {p} workers on (BSP)"),
        None => writeln!(out, "computing takes longer than communication at all of these (BSP)"),
    };
    out
}
