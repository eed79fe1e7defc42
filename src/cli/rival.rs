//! `septet rival`.

use std::fmt::Write;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use septet_core::generate::Kind;
use septet_core::model::Points;
use septet_core::spec::{Commands, DEFAULT_SEED};
use septet_core::{Spec, simulate, triangulate};
use septet_geometry::point::Point;
use septet_lab::baselines::{BaselineReport, incremental};
use septet_protocol::ledger::Total;

use super::errors::{Code, Failure};
use super::files;
use super::given::Given;
use super::input::{load, placed};
use super::options::kind;
use super::progress::Talk;
use super::text::counted;
use septet_core::spec::count;

/// Options of `septet rival`.
#[derive(Debug, Args)]
pub struct RivalArgs {
    #[command(subcommand)]
    rival: Which,
}

#[derive(Debug, Subcommand)]
enum Which {
    /// Parallel randomized incremental insertion (Blelloch, Gu, Shun and Sun 2020): dependence depth and work
    Incremental(IncrementalArgs),
}

/// Options of `septet rival incremental`.
#[derive(Debug, Args)]
#[command(after_help = "\
The cells are compared with the cells of septet. The exit code is 4 if they differ.

Examples:
  septet rival incremental -n 1e5 --kind uniform
  septet rival incremental points.npy --against --json rival.json")]
struct IncrementalArgs {
    /// Point file, pattern in quotes, `@LIST`, `-` for standard input, or `sample:KIND:N[,d=2][,seed=7][,lipschitz=0.25][,ratio=1.3]`
    #[arg(required_unless_present = "kind")]
    input: Option<String>,
    /// Kind of a generated set, instead of an input; requires -n
    #[arg(long, value_name = "KIND", value_parser = kind, conflicts_with = "input", requires = "number")]
    kind: Option<Kind>,
    /// Number of points of the generated set
    #[arg(short = 'n', long = "number", value_name = "N", value_parser = count, conflicts_with = "input", requires = "kind")]
    number: Option<u64>,
    /// Seed of the insertion order, of septet, and of the generated set
    #[arg(long, value_name = "S", default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Also run `simulate` on the same points and print its counts
    #[arg(long)]
    against: bool,
    /// Write the counts as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    #[command(flatten)]
    given: Given<{ Commands::RIVAL.bits() }>,
}

impl IncrementalArgs {
    /// Returns the name of the input file, or the description of the sample.
    fn name(&self, spec: &Spec) -> String {
        let sample = || {
            let (kind, n) = (self.kind?, self.number?);
            Some(format!("sample:{kind}:{n},d={},seed={}", spec.input.dimension.unwrap_or(3), self.seed))
        };
        self.input.clone().or_else(sample).unwrap_or_default()
    }
}

/// Runs the baseline and septet on the same points and compares the cells.
pub fn run(args: &RivalArgs, talk: &Talk) -> Result<(), Failure> {
    let Which::Incremental(args) = &args.rival;
    let spec = args.given.options().spec()?;
    let name = args.name(&spec);
    let loaded = load(&name, (args.given.options(), &spec), args.json.as_deref(), talk)?;
    let spec = spec.with(|c| {
        c.machine.seed = args.seed;
        c.recursion.spacing = loaded.spacing;
        c.control.cancel = Some(talk.cancel.clone());
        c.control.progress = Some(talk.phases());
    });
    let report = match &loaded.points {
        Points::Plane(points) => compare(points, &name, args, &spec, talk),
        Points::Space(points) => compare(points, &name, args, &spec, talk),
    };
    let report = report.map_err(|e| placed(e, &loaded.files, &name, |point| loaded.row(point)))?;
    talk.clear();
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(&report)
            .map_err(|e| Failure::new(Code::Failed, format!("the report cannot be written: {e}")))?;
        files::write_text(path, &(text + "\n"))?;
    }
    if args.json.as_ref().is_none_or(|path| path.as_os_str() != "-") {
        files::write_text("-".as_ref(), &table(&report))?;
    }
    let cell = if report.space == 2 { "triangle" } else { "tetrahedron" };
    let [points, cells] = [counted(report.points, "point"), counted(report.simplices, cell)];
    talk.note(format!("septet: {points}, {cells} by insertion"));
    if report.same_cells {
        return Ok(());
    }
    let message = "insertion and septet give different cells";
    Err(Failure::new(Code::Rejected, message)
        .help("this is a defect of septet: please report it with the input"))
}

fn compare<P: Point>(
    points: &[P],
    name: &str,
    args: &IncrementalArgs,
    spec: &Spec,
    talk: &Talk,
) -> Result<BaselineReport, septet_core::Error> {
    let run = if args.against { simulate(points, spec)? } else { triangulate(points, spec)? };
    talk.check();
    talk.stage("inserting", 0, None);
    let rival = incremental(points, spec)?;
    Ok(BaselineReport::of(&rival, &run, name, args.seed))
}

/// Formats the counts of the baseline next to the counts of septet.
fn table(report: &BaselineReport) -> String {
    let mut out = String::new();
    let rival = &report.incremental;
    let totals = report.septet.as_ref().map(|s| [&s.totals.paper, &s.totals.repair]);
    let head = ["", "incremental", "septet", "its repair"];
    let columns = if totals.is_some() { 4 } else { 2 };
    let mut row = |cells: &[String]| {
        let mut line = format!("{:<34}", cells[0]);
        for cell in &cells[1..columns.min(cells.len())] {
            let _ = write!(line, "  {cell:>15}");
        }
        let _ = writeln!(out, "{}", line.trim_end());
    };
    row(&head.map(str::to_owned));
    let mut count = |name: &str, own: u64, of: Option<fn(&Total) -> u64>| {
        let mut cells = vec![name.to_owned(), own.to_string()];
        if let (Some(totals), Some(of)) = (totals, of) {
            cells.extend(totals.map(|t| of(t).to_string()));
        }
        row(&cells);
    };
    count("work (operations)", rival.work, Some(|t| t.work));
    count("depth (steps, a scan 1)", rival.depth, Some(|t| t.depth));
    count("depth (a scan of m ceil(log2 m))", rival.depth_log_scan, Some(|t| t.depth_log_scan));
    count("depth (a union of conflicts 1)", rival.depth_hashed, None);
    count("steps with n processors (Brent)", rival.brent, Some(|t| t.brent));
    count("dependence depth (cells)", rival.chain, None);
    count("rounds", rival.rounds.len() as u64, None);
    count("in-sphere tests", rival.tests, None);
    count("cells made", rival.cells, None);
    if let Some(septet) = &report.septet {
        let _ = writeln!(
            out,
            "septet: {}, {} of repair, {} gathered",
            counted(septet.levels, "level"),
            counted(septet.exchange_rounds, "round"),
            counted(septet.gathered, "point")
        );
    }
    out
}
