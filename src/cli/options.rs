//! Options of `triangulate` and `simulate`, and how they become a configuration.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use septet_core::Config;
use septet_core::config::{
    Alpha, Correction, Fault, Graph, GraphKind, Neighbours, Partition, SeparatorSets, Transport, Workers,
};
use septet_core::generate::{GenerateError, Kind};
use septet_core::result::view::MOST_POINTS;
use septet_io::write::MshVersion;
use septet_lab::trace::Detail;

use super::errors::{Code, Failure};

/// Options of `septet triangulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet triangulate points.node -o mesh.vtu
  septet triangulate scan.ply.gz -o scan.1.ele --json report.json
  septet triangulate sample:uniform:1e5,d=2 --workers 64 --transport sim --delivery-seed 3 --json -
  gunzip -c points.csv.gz | septet triangulate - -o mesh.msh")]
pub struct TriangulateArgs {
    #[command(flatten)]
    pub run: RunArgs,
}

/// Options of `septet simulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet simulate sample:well-spaced:65536 --workers leaves --profile
  septet simulate points.npy --workers 64 --supergraph knn --k 10ln --json counts.json
  septet simulate sample:uniform:1e5 --workers 16 --trace run.json --profile=run.md")]
pub struct SimulateArgs {
    #[command(flatten)]
    pub run: RunArgs,
    #[command(flatten)]
    graph: GraphArgs,
    /// Put the record of what leaves say to each other into the report, for `septet predict` (a second run,
    /// unless there is one worker)
    #[arg(long)]
    tasks: bool,
}

/// Options of both.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// A point file (.node .xyz .txt .csv .npy .off .ply .stl .obj .vtu .msh .mesh, each also .gz), `-` for
    /// standard input, or `sample:KIND:N[,d=2][,seed=7][,lipschitz=0.25]`
    pub input: String,
    /// Write the triangulation (.vtu .msh .msh22 .mesh .off .npy, or one of .node .ele .face .edge .neigh for
    /// the whole set); may be given several times
    #[arg(short, long = "output", value_name = "OUT")]
    pub output: Vec<PathBuf>,
    /// Number of workers, or `leaves` for one per leaf of the partition tree [default: cores]
    #[arg(long, value_name = "P|leaves", value_parser = workers, allow_negative_numbers = true)]
    pub workers: Option<Workers>,
    /// Seed of every random draw
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Write the report as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    pub json: Option<PathBuf>,
    /// Points of the picture in the JSON report, at most 20000, 0 for none [default: 20000 in simulate, 0 in
    /// triangulate]
    #[arg(long, value_name = "N", value_parser = shown)]
    pub view: Option<u32>,
    /// Print tables of phases, rounds and tree levels; with a name ending in .md write them as Markdown, in .csv
    /// as three files (NAME.phases.csv, NAME.rounds.csv, NAME.levels.csv)
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "-")]
    pub profile: Option<PathBuf>,
    #[command(flatten)]
    pub tracing: TraceArgs,
    /// Drop and count points that are not finite or not numbers, instead of refusing the file
    #[arg(long)]
    pub skip_invalid: bool,
    /// Dimension of the input: 2 keeps the first two coordinates
    #[arg(short, long = "dimension", value_name = "2|3", value_parser = dimension)]
    pub dimension: Option<usize>,
    /// Write the owning worker and home leaf of every cell (.vtu)
    #[arg(long)]
    pub with_owner: bool,
    /// Version of files named .msh
    #[arg(long, value_name = "VERSION", value_enum, default_value_t = MshArg::V41)]
    pub msh_version: MshArg,
    /// Plant a fault in the machine (refuse:NODE[-NODE], refuse-draws:EVERY, spoil:RANK, die:RANK:PHASE): for tests
    #[arg(long, hide = true, value_name = "FAULT")]
    pub fault: Option<Fault>,
}

/// Options of a trace.
#[derive(Debug, Args)]
pub struct TraceArgs {
    /// Write what every worker did when, as Chrome's JSON: open it with Perfetto (ui.perfetto.dev)
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// How much the trace tells, each more than the one before [default: subproblem]
    #[arg(long, value_name = "DETAIL", value_enum, requires = "trace")]
    pub trace_level: Option<DetailArg>,
}

/// Options of every command that runs the machine, but for what differs between runs of a sweep.
#[derive(Debug, Args)]
pub struct MachineArgs {
    /// Threads that run the workers [default: cores]
    #[arg(long, value_name = "T")]
    pub threads: Option<usize>,
    /// Vector registers of the inner loops: results are the same
    #[arg(long, value_enum, default_value_t = RegistersArg::Widest)]
    pub registers: RegistersArg,
    /// What cuts subproblems: sphere separators, or k-d planes for comparison
    #[arg(long, value_enum, default_value_t = PartitionArg::Sphere)]
    pub partition: PartitionArg,
    /// Largest leaf of the partition tree, in points
    #[arg(long, value_name = "M|auto", default_value = "auto", value_parser = leaf)]
    pub leaf: Leaf,
    /// How messages travel: over channels between threads, or simulated on one thread
    #[arg(long, value_enum, default_value_t = TransportArg::Channel)]
    pub transport: TransportArg,
    /// Seed of the order of delivery (with --transport sim) [default: 0]
    #[arg(long, value_name = "S")]
    pub delivery_seed: Option<u64>,
    /// Refuse to start if more memory is expected; with K, M, G or T for powers of 1024
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub max_memory: Option<u64>,
}

/// Options of every command that counts the paper's recursion.
#[derive(Debug, Args)]
pub struct GraphArgs {
    /// Supergraph of the Delaunay triangulation
    #[arg(long, value_enum, default_value_t = GraphArg::Density)]
    pub supergraph: GraphArg,
    /// alpha of a density or overlap graph, at least 1
    #[arg(long, value_name = "A|auto", default_value = "auto", value_parser = alpha, allow_negative_numbers = true)]
    pub alpha: Alpha,
    /// k of a nearest-neighbour graph; `10ln` stands for ceil(10 ln n)
    #[arg(long, value_name = "K|auto|Cln", default_value = "auto", value_parser = neighbours, allow_hyphen_values = true)]
    pub k: Neighbours,
    /// How separator points are shared: with both sides (the paper), the smaller one, or as ghosts
    #[arg(long, value_enum, default_value_t = SetsArg::Ghost)]
    pub separator_sets: SetsArg,
    /// How nearest-neighbour balls are corrected beyond separators: by one descent from the root, or naively,
    /// node by node from the leaves up, for comparison
    #[arg(long, value_enum, default_value_t = NeighboursArg::Descent)]
    pub neighbours: NeighboursArg,
}

/// `--supergraph`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GraphArg {
    Density,
    Overlap,
    Knn,
}

/// `--separator-sets`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SetsArg {
    Both,
    Smaller,
    Ghost,
}

/// `--partition`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PartitionArg {
    Sphere,
    Kd,
}

/// `--neighbours`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NeighboursArg {
    Descent,
    Naive,
}

impl NeighboursArg {
    /// The correction of this name.
    pub fn correction(self) -> Correction {
        match self {
            NeighboursArg::Descent => Correction::Descent,
            NeighboursArg::Naive => Correction::Naive,
        }
    }
}

/// `--transport`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TransportArg {
    Channel,
    Sim,
}

/// `--registers`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RegistersArg {
    /// The widest that the processor has
    Widest,
    /// Those that every processor of its kind has
    Baseline,
}

/// `--msh-version`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MshArg {
    #[value(name = "2.2")]
    V22,
    #[value(name = "4.1")]
    V41,
}

impl From<MshArg> for MshVersion {
    fn from(version: MshArg) -> Self {
        match version {
            MshArg::V22 => MshVersion::V22,
            MshArg::V41 => MshVersion::V41,
        }
    }
}

/// `--trace-level`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DetailArg {
    /// The coordinator's phases
    Phase,
    /// What each worker does in each round
    Round,
    /// Messages and bytes in flight
    Message,
    /// Steps at nodes of the partition tree
    Subproblem,
}

impl From<DetailArg> for Detail {
    fn from(detail: DetailArg) -> Self {
        match detail {
            DetailArg::Phase => Detail::Phase,
            DetailArg::Round => Detail::Round,
            DetailArg::Message => Detail::Message,
            DetailArg::Subproblem => Detail::Subproblem,
        }
    }
}

/// `--leaf`.
#[derive(Clone, Copy, Debug)]
pub struct Leaf(Option<u64>);

impl MachineArgs {
    /// The configuration these options ask for, with what they leave open by default.
    pub fn config(&self) -> Result<Config, Failure> {
        let base = Config::default();
        let threads = self.threads.unwrap_or(base.machine.threads);
        if self.delivery_seed.is_some() && self.transport == TransportArg::Channel {
            let message = "--delivery-seed goes with --transport sim: channels deliver when they deliver";
            return Err(Failure::new(Code::Usage, message).help("add --transport sim, or leave the seed out"));
        }
        if self.registers == RegistersArg::Baseline {
            septet_geometry::simd::use_baseline_registers();
        }
        Ok(base.with(|c| {
            c.machine.threads = threads;
            c.partition = match self.partition {
                PartitionArg::Sphere => Partition::Sphere,
                PartitionArg::Kd => Partition::Kd,
            };
            c.machine.leaf = self.leaf.0;
            c.machine.transport = match self.transport {
                TransportArg::Channel => Transport::Channel,
                TransportArg::Sim => Transport::Sim { delivery_seed: self.delivery_seed.unwrap_or(0) },
            };
            c.machine.max_memory = self.max_memory;
        }))
    }
}

impl GraphArgs {
    /// Returns the configuration with these options.
    pub fn extend(&self, config: Config) -> Result<Config, Failure> {
        let kind = match self.supergraph {
            GraphArg::Density => GraphKind::Density,
            GraphArg::Overlap => GraphKind::Overlap,
            GraphArg::Knn => GraphKind::Knn,
        };
        let graph = Graph::new(kind, self.alpha, self.k)?;
        Ok(config.with(|c| {
            c.graph = graph;
            c.separator_sets = match self.separator_sets {
                SetsArg::Both => SeparatorSets::Both,
                SetsArg::Smaller => SeparatorSets::Smaller,
                SetsArg::Ghost => SeparatorSets::Ghost,
            };
            c.correction = self.neighbours.correction();
        }))
    }
}

impl TriangulateArgs {
    /// The configuration these options ask for.
    pub fn config(&self) -> Result<Config, Failure> {
        let config = self.run.config()?;
        config.check()?;
        Ok(config)
    }
}

impl SimulateArgs {
    /// The configuration these options ask for.
    pub fn config(&self) -> Result<Config, Failure> {
        let config = self.graph.extend(self.run.config()?)?.with(|c| c.keep.tasks = self.tasks);
        config.check()?;
        Ok(config)
    }
}

impl RunArgs {
    fn config(&self) -> Result<Config, Failure> {
        let config = self.machine.config()?;
        Ok(config.with(|c| {
            c.machine.workers = self.workers.unwrap_or(c.machine.workers);
            c.machine.seed = self.seed;
            c.skip_invalid = self.skip_invalid;
            c.keep.owner = self.with_owner;
            c.planted.fault = self.fault;
        }))
    }
}

/// A whole number, with an exponent if need be.
pub fn count(text: &str) -> Result<u64, String> {
    let parsed = match text.split_once(['e', 'E']) {
        None => text.parse().ok(),
        Some((mantissa, exponent)) => exponent
            .parse()
            .ok()
            .and_then(|e| 10u64.checked_pow(e))
            .and_then(|power| mantissa.parse::<u64>().ok()?.checked_mul(power)),
    };
    parsed.ok_or_else(|| "expected a whole number, such as 1000 or 1e6".to_owned())
}

fn shown(text: &str) -> Result<u32, String> {
    let number = count(text)?;
    u32::try_from(number)
        .ok()
        .filter(|&n| n <= MOST_POINTS)
        .ok_or_else(|| format!("expected at most {MOST_POINTS} points"))
}

/// A kind of sets.
pub fn kind(text: &str) -> Result<Kind, String> {
    text.trim().parse().map_err(|e: GenerateError| e.to_string())
}

/// A number of workers, or `leaves`.
pub fn workers(text: &str) -> Result<Workers, String> {
    match text {
        "leaves" => Ok(Workers::Leaves),
        _ => text.parse().map(Workers::Count).map_err(|_| "expected a number of workers, or `leaves`".into()),
    }
}

fn alpha(text: &str) -> Result<Alpha, String> {
    match text {
        "auto" => Ok(Alpha::Auto),
        _ => text.parse().map(Alpha::Value).map_err(|_| "expected a number of at least 1, or `auto`".into()),
    }
}

fn neighbours(text: &str) -> Result<Neighbours, String> {
    let expected = || "expected a number, `auto`, or a factor of ln n such as `10ln`".to_owned();
    match (text, text.strip_suffix("ln")) {
        ("auto", _) => Ok(Neighbours::Auto),
        (_, Some(factor)) => factor.parse().map(Neighbours::Log).map_err(|_| expected()),
        _ => text.parse().map(Neighbours::Count).map_err(|_| expected()),
    }
}

fn leaf(text: &str) -> Result<Leaf, String> {
    if text == "auto" { Ok(Leaf(None)) } else { count(text).map(|m| Leaf(Some(m))) }
}

/// 2 or 3.
pub fn dimension(text: &str) -> Result<usize, String> {
    match text {
        "2" => Ok(2),
        "3" => Ok(3),
        _ => Err("expected 2 or 3".into()),
    }
}

/// A number of bytes, with K, M, G or T for powers of 1024.
pub fn bytes(text: &str) -> Result<u64, String> {
    let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
    let text = text.strip_suffix('i').unwrap_or(text);
    let (digits, shift) = match text.char_indices().next_back() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'm' | 'M')) => (&text[..at], 20),
        Some((at, 'g' | 'G')) => (&text[..at], 30),
        Some((at, 't' | 'T')) => (&text[..at], 40),
        _ => (text, 0),
    };
    let value = digits.parse::<f64>().ok().filter(|v| *v >= 0.0 && v.is_finite());
    let value = value.ok_or_else(|| "expected a number of bytes, such as 500M or 2G".to_owned())?;
    Ok((value * (1u64 << shift) as f64) as u64)
}
