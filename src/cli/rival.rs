//! `septet rival`.

use std::fmt::Write;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use septet_core::generate::Kind;
use septet_core::model::Points;
use septet_core::spec::{Commands, DEFAULT_SEED, SpecError, Workers};
use septet_core::{Spec, simulate};
use septet_geometry::point::Point;
use septet_lab::baselines::{BaselineReport, Counted, Rival};
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
    Incremental(PointArgs),
    /// Star splaying from the k nearest neighbours of each point (not the paper's)
    Splay(SplayArgs),
    /// The path of `triangulate`, charged: ghost layers, subdomain triangulations, interface (not the paper's)
    Direct(PointArgs),
}

impl Which {
    /// Returns the rival and its options.
    fn parts(&self) -> (Rival, &PointArgs) {
        match self {
            Which::Incremental(args) => (Rival::Incremental, args),
            Which::Splay(SplayArgs { k, args }) => (Rival::Splay { k: *k }, args),
            Which::Direct(args) => (Rival::Direct, args),
        }
    }
}

/// Options of `septet rival splay`.
#[derive(Debug, Args)]
struct SplayArgs {
    /// Number of nearest neighbours
    #[arg(long, value_name = "K", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..))]
    k: u32,
    #[command(flatten)]
    args: PointArgs,
}

/// Options of every rival.
#[derive(Debug, Args)]
#[command(after_help = "\
The cells are compared with the cells of `simulate`. The exit code is 4 if they differ.

Examples:
  septet rival incremental -n 1e5 --kind uniform
  septet rival splay -n 1e5 --kind uniform --k 12
  septet rival direct -n 1e5 --kind uniform --workers 64
  septet rival incremental points.npy --against --json rival.json")]
struct PointArgs {
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
    /// Number of workers of septet, which own the points; one subdomain each for `direct`
    #[arg(long, value_name = "P", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    workers: u32,
    /// Also print the counts of `simulate` on the same points
    #[arg(long)]
    against: bool,
    /// Write the counts as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    #[command(flatten)]
    given: Given<{ Commands::RIVAL.bits() }>,
}

impl PointArgs {
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
    let (rival, args) = args.rival.parts();
    let spec = args.given.options().spec()?;
    let name = args.name(&spec);
    let loaded = load(&name, (args.given.options(), &spec), args.json.as_deref(), talk)?;
    let spec = spec.with(|c| {
        c.machine.seed = args.seed;
        c.machine.workers = Workers::Count(args.workers);
        c.recursion.spacing = loaded.spacing;
        c.control.cancel = Some(talk.cancel.clone());
        c.control.progress = Some(talk.phases());
    });
    let report = match &loaded.points {
        Points::Plane(points) => compare(points, (rival, &name, args.against), &spec, talk),
        Points::Space(points) => compare(points, (rival, &name, args.against), &spec, talk),
        Points::Higher(points) => {
            let dimension = points.slice().dimension();
            Err(septet_core::Error::from(SpecError::OnlySpace { what: "comparisons", dimension }))
        }
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
    talk.note(format!("septet: {points}, {cells} by {}", report.rival.name()));
    if report.same_cells {
        return Ok(());
    }
    let message = format!("rival {} and septet give different cells", report.rival.name());
    Err(Failure::new(Code::Rejected, message)
        .help("this is a defect of septet: please report it with the input"))
}

fn compare<P: Point>(
    points: &[P],
    (rival, name, against): (Rival, &str, bool),
    spec: &Spec,
    talk: &Talk,
) -> Result<BaselineReport, septet_core::Error> {
    let run = simulate(points, spec)?;
    talk.check();
    talk.stage("running the rival", 0, None);
    let counted = rival.run(points, spec, &run)?;
    Ok(BaselineReport::of(counted, &run, (name, spec.machine.seed), against))
}

/// Formats the counts of the baseline next to the counts of septet.
fn table(report: &BaselineReport) -> String {
    let mut out = String::new();
    let rival = report.rival.counts();
    let totals = report.septet.as_ref().map(|s| [&s.totals.paper, &s.totals.repair]);
    let head = ["", report.rival.name(), "septet", "its repair"];
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
    count("steps with n processors (Brent)", rival.brent, Some(|t| t.brent));
    count("rounds with messages", rival.rounds, None);
    count("messages", rival.messages, None);
    count("bytes", rival.bytes, None);
    match &report.rival {
        Counted::Incremental(own) => {
            count("depth (a scan of m ceil(log2 m))", own.depth_log_scan, Some(|t| t.depth_log_scan));
            count("depth (a union of conflicts 1)", own.depth_hashed, None);
            count("dependence depth (cells)", own.chain, None);
            count("rounds of insertions", own.insertion_rounds.len() as u64, None);
            count("in-sphere tests", own.tests, None);
            count("cells made", own.cells, None);
        }
        Counted::Splay(own) | Counted::Direct(own) => {
            own.phases.iter().for_each(|p| count(&format!("work of {}", p.phase.name()), p.work, None));
        }
    }
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
