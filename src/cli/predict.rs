//! `septet predict`.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use schemars::JsonSchema;
use septet_core::model::Points;
use septet_core::spec::{Commands, SpecError, Transport, Workers};
use septet_core::{Outcome, Spec, simulate};
use septet_lab::predict::{Hardware, Prediction, calibrate, predict, takes_over};
use serde::Serialize;

use super::errors::{Code, Failure};
use super::files;
use super::given::Given;
use super::input::{Loaded, load, placed};
use super::progress::Talk;
use super::text::counted;

/// Options of `septet predict`.
#[derive(Debug, Args)]
#[command(after_help = "\
The rounds, messages, bytes and work are counts of a run with that number of workers, on this computer.

Examples:
  septet predict sample:well-spaced:1e5 --workers 1..4096
  septet predict points.npy --workers 2,48,96 --latency 5e-6 --bandwidth 1e9
  septet predict sample:uniform:1e5 --workers 2 --calibrate")]
pub struct PredictArgs {
    /// Point file, pattern in quotes, `@LIST`, `-` for standard input, or `sample:KIND:N[,d=2][,seed=7][,lipschitz=0.25]`
    input: String,
    /// Numbers of workers: a list, or a range `A..B` for A, 2A, 4A, ... up to B
    #[arg(long, value_name = "P,..|A..B", default_value = "1..64", value_parser = worker_counts)]
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
    /// Measure the channels of this computer, and derive rates from a run with one worker on one thread
    ///
    /// Explicit options take precedence.
    #[arg(long)]
    calibrate: bool,
    /// Write the predictions as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    #[command(flatten)]
    given: Given<{ Commands::PREDICT.bits() }>,
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
    let expected = || "expected numbers such as 2,8,64 or a range such as 1..4096".to_owned();
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

/// Name and version of the schema of [`PredictReport`].
const SCHEMA: &str = "septet-predict/2";

/// The predictions for all numbers of workers.
#[derive(Serialize, JsonSchema)]
pub(super) struct PredictReport<'a> {
    /// Name and version of this schema.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// Version of septet.
    version: &'static str,
    /// The input as given on the command line.
    input: &'a str,
    /// Number of points.
    points: u64,
    /// Number of coordinates: 2 or 3.
    dimension: usize,
    /// Number of leaves of the partition tree.
    leaves: usize,
    /// The hardware of the predicted machines.
    hardware: &'a Hardware,
    /// The predictions, by number of workers.
    predictions: &'a [Prediction],
    /// The smallest of these numbers of workers for which BSP predicts more communication than computation.
    communication_takes_over: Option<u32>,
}

/// The runs of the command, on the same points.
struct Runs<'a> {
    args: &'a PredictArgs,
    loaded: &'a Loaded,
    spec: Spec,
}

impl Runs<'_> {
    /// Simulates the points on a machine with `workers` workers.
    fn simulate(&self, workers: u32, spec: &Spec) -> Result<Outcome, Failure> {
        let spec = spec.clone().with(|c| c.machine.workers = Workers::Count(workers));
        let run = match &self.loaded.points {
            Points::Plane(points) => simulate(points, &spec),
            Points::Space(points) => simulate(points, &spec),
            Points::Higher(points) => {
                let dimension = points.slice().dimension();
                Err(SpecError::OnlySpace { what: "predictions", dimension }.into())
            }
        };
        run.map_err(|error| {
            placed(error, &self.loaded.files, &self.args.input, |point| self.loaded.row(point))
        })
    }

    /// Measures this computer by one worker on one thread.
    fn calibrated(&self) -> Result<Hardware, Failure> {
        let spec = self.spec.clone().with(|c| {
            c.machine.threads = Some(1);
            c.machine.transport = Transport::Channel;
        });
        Ok(calibrate(&self.simulate(1, &spec)?))
    }

    fn hardware(&self) -> Result<Hardware, Failure> {
        let args = self.args;
        let mut hardware = if args.calibrate { self.calibrated()? } else { Hardware::default() };
        hardware.latency = args.latency.unwrap_or(hardware.latency);
        hardware.overhead = args.overhead.unwrap_or(hardware.overhead);
        hardware.bandwidth = args.bandwidth.unwrap_or(hardware.bandwidth);
        if let Some(rate) = args.rate {
            hardware.rate = rate;
            hardware.phase_rates.clear();
        }
        Ok(hardware)
    }
}

impl PredictArgs {
    fn spec(&self, talk: &Talk) -> Result<Spec, Failure> {
        let spec = self.given.options().spec()?.with(|c| {
            c.control.cancel = Some(talk.cancel.clone());
            c.control.progress = Some(talk.phases());
        });
        spec.check()?;
        Ok(spec)
    }
}

/// Runs each machine, and prices and prints its counts.
pub fn run(args: &PredictArgs, talk: &Talk) -> Result<(), Failure> {
    let spec = args.spec(talk)?;
    septet_core::cores::limit(spec.machine.thread_count());
    let loaded = load(&args.input, (args.given.options(), &spec), args.json.as_deref(), talk)?;
    let spec = spec.with(|c| c.recursion.spacing = loaded.spacing);
    let runs = Runs { args, loaded: &loaded, spec };
    let hardware = runs.hardware()?;
    let mut predictions = Vec::new();
    let mut leaves = 0;
    for &workers in &args.workers.0 {
        let run = runs.simulate(workers, &runs.spec)?;
        leaves = run.ledger.part.nodes.values().filter(|facts| facts.is_leaf()).count();
        predictions.push(predict(&run, &hardware));
    }
    talk.clear();
    let points = loaded.points.len() as u64;
    let report = PredictReport {
        schema: SCHEMA,
        version: env!("CARGO_PKG_VERSION"),
        input: &args.input,
        points,
        dimension: loaded.points.dimension(),
        leaves,
        hardware: &hardware,
        predictions: &predictions,
        communication_takes_over: takes_over(&predictions),
    };
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(&report)
            .map_err(|e| Failure::new(Code::Failed, format!("the report cannot be written: {e}")))?;
        files::write_text(path, &(text + "\n"))?;
    }
    if args.json.as_ref().is_none_or(|path| path.as_os_str() != "-") {
        files::write_text("-".as_ref(), &table(&predictions, report.communication_takes_over))?;
    }
    let points = counted(points, "point");
    talk.note(format!("septet: {points}, leaves of the tree: {leaves}"));
    Ok(())
}

fn table(predictions: &[Prediction], over: Option<u32>) -> String {
    let mut out = String::new();
    let head = "workers  rounds   messages           bytes  surface  busiest work  BSP compute +  communicate   LogGP total     Brent steps";
    let _ = writeln!(out, "{head}");
    for p in predictions {
        let _ = writeln!(
            out,
            "{:>7}  {:>6}  {:>9}  {:>14}  {:>7.2}  {:>12}  {:>9.4} s + {:>10.4} s  {:>11.4} s  {:>14}",
            p.workers,
            p.traffic.rounds,
            p.traffic.messages,
            p.traffic.bytes,
            p.surface_ratio,
            p.busiest_work,
            p.bsp.compute,
            p.bsp.communicate,
            p.loggp.total(),
            p.brent,
        );
    }
    let _ = match over {
        Some(p) => writeln!(out, "communication takes longer than computation from {p} workers on (BSP)"),
        None => writeln!(out, "computation takes longer than communication for all of these (BSP)"),
    };
    out
}
