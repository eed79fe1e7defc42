//! Options of `triangulate` and `simulate` that are no options of the run itself.

use std::path::PathBuf;

use clap::Args;
use septet_core::generate::{GenerateError, Kind};
use septet_core::spec::{Commands, Fault};
use septet_lab::trace::Detail;

use super::faults::fault;
use super::formats::{FormatArgs, input_help, outputs_help};
use super::given::{Given, words};
use super::headings::{INPUT, OUTPUT, REPORTS};
use super::hidden::HiddenArgs;
use super::text::suggestion;
use super::weights::WeightArgs;

/// Options of `septet triangulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "\
Examples:
  septet triangulate points.node -o mesh.vtu
  septet triangulate sample:uniform:1e5,d=2 -o mesh.vtu

`septet triangulate --help` lists all options.",
    after_long_help = "\
Examples:
  septet triangulate points.node -o mesh.vtu
  septet triangulate scan.ply.gz -o scan.1.ele --json report.json
  septet triangulate sample:uniform:1e5,d=2 --workers 64 --json run.json
  gunzip -c points.csv.gz | septet triangulate - -o mesh.msh"
)]
pub struct TriangulateArgs {
    #[command(flatten)]
    pub run: RunArgs,
    /// Print counts, hull, extent, degrees and the quality of cells; the report then has them too
    ///
    /// The numbers are edges, facets, hull, area or volume, degrees of vertices, radius-edge ratios, angles with
    /// percentiles, and slivers. They do not depend on workers, threads and processes.
    #[arg(long, help_heading = REPORTS)]
    pub stats: bool,
    /// Keep these lines of a terrain as edges: .geojson, .wkt or .poly
    ///
    /// Heights of their points are those of points of the terrain at the same place, otherwise their z, otherwise
    /// interpolated in the terrain. Lines may share points and overlap, but not cross between points.
    #[arg(long, value_name = "FILE", help_heading = INPUT)]
    pub breaklines: Option<PathBuf>,
    #[command(flatten)]
    pub given: Given<{ Commands::TRIANGULATE.bits() }>,
}

/// Options of `septet simulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "\
Examples:
  septet simulate sample:well-spaced:65536 --workers leaves --profile
  septet simulate sample:uniform:1e5 --workers 64 --json run.json

`septet simulate --help` lists all options.",
    after_long_help = "\
Examples:
  septet simulate sample:well-spaced:65536 --workers leaves --profile
  septet simulate points.npy --workers 64 --supergraph knn --k 10ln
  septet simulate sample:uniform:1e5 --workers 64 --json run.json
  septet simulate sample:uniform:1e5 --trace trace.json --profile=run.md"
)]
pub struct SimulateArgs {
    #[command(flatten)]
    pub run: RunArgs,
    #[command(flatten)]
    pub given: Given<{ Commands::SIMULATE.bits() }>,
    /// Write all calls of primitives with their dependencies, for `septet fold`
    ///
    /// The file has JSON lines without prices, about 1 kB for each point. If its name ends in .gz, it is compressed.
    #[arg(long, value_name = "FILE|-", help_heading = REPORTS, hide_short_help = true)]
    pub cost_trace: Option<PathBuf>,
}

/// Options of both commands.
#[derive(Debug, Args)]
pub struct RunArgs {
    #[arg(help = "Point file, `-` for standard input, or `sample:KIND:N` for a generated set", long_help = input_help())]
    pub input: String,
    #[arg(short, long = "output", value_name = "OUT", help = "Write the triangulation; may be given several times", long_help = outputs_help(), help_heading = OUTPUT)]
    pub output: Vec<PathBuf>,
    /// Write the report as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-", help_heading = REPORTS)]
    pub json: Option<PathBuf>,
    /// Write the rows of duplicates, each with the first row of the same point
    ///
    /// The file is a table with the columns `row` and `first`. Rows of points are counted from 0.
    #[arg(long, value_name = "FILE|-", help_heading = REPORTS, hide_short_help = true)]
    pub duplicates: Option<PathBuf>,
    /// Print tables of phases, rounds and tree levels
    ///
    /// `--profile=NAME.md` writes Markdown instead. `--profile=NAME.csv` writes NAME.phases.csv, NAME.rounds.csv
    /// and NAME.levels.csv.
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "-", help_heading = REPORTS)]
    pub profile: Option<PathBuf>,
    #[command(flatten)]
    pub tracing: TraceArgs,
    #[command(flatten)]
    pub writing: FormatArgs,
    #[command(flatten)]
    pub weights: WeightArgs,
    /// Write the rows of hidden points, which their weights exclude from the triangulation
    ///
    /// The file is text with a row on each line, or a .npy array. Rows of points are counted from 0.
    #[arg(long = "hidden", value_name = "FILE|-", help_heading = REPORTS, hide_short_help = true)]
    pub hidden_rows: Option<PathBuf>,
    /// Write the offsets of the vertices of a periodic triangulation
    ///
    /// The file is a .npy array of whole numbers, of the shape (cells, d + 1, d). A vertex lies at its point plus the offset
    /// times the box.
    #[arg(long, value_name = "FILE", help_heading = REPORTS, hide_short_help = true)]
    pub offsets: Option<PathBuf>,
    #[command(flatten)]
    pub hidden: HiddenArgs,
    /// Plant a fault in the machine, for tests; `septet reproduce --fault list` lists the faults
    #[arg(long, hide = true, value_name = "FAULT", value_parser = fault)]
    pub fault: Option<Fault>,
}

/// Options of a trace.
#[derive(Debug, Args)]
pub struct TraceArgs {
    /// Write a timeline of all workers as a Chrome trace, for Perfetto (ui.perfetto.dev)
    #[arg(long, value_name = "FILE", help_heading = REPORTS, hide_short_help = true)]
    pub trace: Option<PathBuf>,
    /// Detail of the trace; each level includes the previous ones [default: subproblem]
    #[arg(long, value_name = "DETAIL", value_parser = words::<Detail>(), requires = "trace", help_heading = REPORTS, hide_short_help = true)]
    pub trace_level: Option<Detail>,
}

/// Parses a kind of point set.
pub fn kind(text: &str) -> Result<Kind, String> {
    let name = text.trim();
    name.parse().map_err(|_: GenerateError| {
        let kinds: Vec<&str> = Kind::all().map(Kind::name).collect();
        format!("{}expected one of {}", suggestion(name, kinds.iter().copied()), kinds.join(" "))
    })
}

/// Parses a dimension of points.
pub fn dimension(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(dimension @ 2..=6) => Ok(dimension),
        _ => Err("expected 2 to 6".into()),
    }
}

/// Parses a dimension of experiments.
pub fn plane_or_space(text: &str) -> Result<usize, String> {
    match text {
        "2" => Ok(2),
        "3" => Ok(3),
        _ => Err("expected 2 or 3".into()),
    }
}
