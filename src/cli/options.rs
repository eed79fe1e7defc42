//! Options of `triangulate` and `simulate`, and their conversion into a configuration.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use septet_core::Spec;
use septet_core::generate::{GenerateError, Kind};
use septet_core::result::view::MOST_POINTS;
use septet_core::spec::{
    Alpha, Correction, DEFAULT_SEED, Fault, Graph, GraphKind, Neighbours, Partition, SeparatorSets,
    Transport, Workers,
};
use septet_io::write::OutputFormat;
use septet_lab::trace::Detail;

use super::constants::{Auto, ConstantsArgs, auto};
use super::effects::needs;
use super::errors::{Code, Failure};
use super::faults::fault;
use super::formats::{FormatArgs, ReadArgs};
use super::headings::{GRAPH, INPUT, MACHINE, OUTPUT, REPORTS};
use super::hidden::HiddenArgs;
use super::numbers::{bytes, count};
use super::text::suggestion;

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
    graph: GraphArgs,
    /// Write all calls of primitives with their dependencies, for `septet fold`
    ///
    /// The file has JSON lines without prices, about 1 kB for each point. If its name ends in .gz, it is compressed.
    #[arg(long, value_name = "FILE|-", help_heading = REPORTS, hide_short_help = true)]
    pub cost_trace: Option<PathBuf>,
    /// Nodes of the partition tree that the JSON report lists [default: all]
    ///
    /// Levels, phases and totals always cover all nodes.
    #[arg(long, value_enum, help_heading = REPORTS, hide_short_help = true)]
    pub nodes: Option<NodesArg>,
}

/// Options of both commands.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Point file, `-` for standard input, or `sample:KIND:N` for a generated set
    ///
    /// Files: .node .xyz .txt .csv .npy .off .ply .stl .obj .vtu .vtk .msh .mesh, or binary coordinates with --raw; each also .gz. A pattern in quotes,
    /// such as 'part-*.npy', reads several files in byte order of their names. @LIST reads the files that the text file
    /// LIST names, one per line. Rows are numbered across the files. The full form of a sample is `sample:KIND:N[,d=2][,seed=7][,lipschitz=0.25][,ratio=1.3]`.
    pub input: String,
    /// Write the triangulation; may be given several times
    ///
    /// Formats: .vtu .vtk .msh .msh22 .mesh .off .stl .npy. Any of .node .ele .face .edge .neigh writes all five
    /// files. Each also .gz, and `-` for standard output. NAME.pvtu writes a piece for each worker into the folder
    /// NAME.pieces, which it replaces.
    #[arg(short, long = "output", value_name = "OUT", help_heading = OUTPUT)]
    pub output: Vec<PathBuf>,
    /// Number of workers, or `leaves` for one per leaf of the partition tree [default: auto]
    ///
    /// `auto` is the number of cores. `triangulate` takes fewer for few points, and for points on curved surfaces, where more
    /// workers are not faster. With several processes, `auto` is one worker for each process.
    #[arg(long, value_name = "P|auto|leaves", value_parser = workers, allow_negative_numbers = true, help_heading = MACHINE)]
    pub workers: Option<Workers>,
    /// Seed of the random draws
    #[arg(long, value_name = "S", default_value_t = DEFAULT_SEED, help_heading = MACHINE, hide_short_help = true)]
    pub seed: u64,
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Number of processes, with --transport processes [default: one for each worker, at most the cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256), help_heading = MACHINE, hide_short_help = true)]
    pub processes: Option<u32>,
    /// Write the report as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-", help_heading = REPORTS)]
    pub json: Option<PathBuf>,
    /// Number of points in the picture of the JSON report
    ///
    /// At most 20000, 0 for none. [default: 20000 for simulate in one process, otherwise 0]
    #[arg(long, value_name = "N", value_parser = shown, help_heading = REPORTS, hide_short_help = true)]
    pub view: Option<u32>,
    /// Print tables of phases, rounds and tree levels
    ///
    /// `--profile=NAME.md` writes Markdown instead. `--profile=NAME.csv` writes NAME.phases.csv, NAME.rounds.csv
    /// and NAME.levels.csv.
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "-", help_heading = REPORTS)]
    pub profile: Option<PathBuf>,
    #[command(flatten)]
    pub tracing: TraceArgs,
    /// Drop points with coordinates that are not finite numbers, instead of refusing the file
    #[arg(long, help_heading = INPUT)]
    pub skip_invalid: bool,
    /// Dimension of the input; 2 keeps the first two coordinates
    #[arg(short, long = "dimension", value_name = "2|3", value_parser = dimension, help_heading = INPUT)]
    pub dimension: Option<usize>,
    #[command(flatten)]
    pub reading: ReadArgs,
    /// Keep the other numeric columns of a text table as point data (.vtu .pvtu .vtk)
    #[arg(long, help_heading = INPUT, hide_short_help = true)]
    pub keep_columns: bool,
    #[command(flatten)]
    pub writing: FormatArgs,
    /// Write the owning worker and the owning leaf of every cell (.vtu .pvtu .vtk)
    #[arg(long, help_heading = OUTPUT, hide_short_help = true)]
    pub with_owner: bool,
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
    #[arg(long, value_name = "DETAIL", value_enum, requires = "trace", help_heading = REPORTS, hide_short_help = true)]
    pub trace_level: Option<DetailArg>,
}

/// Options of every command that runs the machine. The runs of a sweep share them.
#[derive(Debug, Args)]
pub struct MachineArgs {
    /// Number of threads that read, run the workers and write [default: cores]
    #[arg(long, value_name = "T", help_heading = MACHINE)]
    pub threads: Option<usize>,
    /// SIMD width of the inner loops; it does not change results
    #[arg(long, value_enum, default_value_t = RegistersArg::Widest, help_heading = MACHINE, hide_short_help = true)]
    pub registers: RegistersArg,
    /// Separators of the partition
    #[arg(long, value_enum, default_value_t = PartitionArg::Sphere, help_heading = MACHINE, hide_short_help = true)]
    pub partition: PartitionArg,
    /// Largest number of points in a leaf of the partition tree
    #[arg(long, value_name = "M|auto", default_value = "auto", value_parser = auto, help_heading = MACHINE, hide_short_help = true)]
    pub leaf: Auto<u64>,
    /// Transport of the messages
    #[arg(long, value_enum, default_value_t = TransportArg::Channel, help_heading = MACHINE, hide_short_help = true)]
    pub transport: TransportArg,
    /// Seed of the delivery order, with --transport sim [default: 0]
    #[arg(long, value_name = "S", help_heading = MACHINE, hide_short_help = true)]
    pub delivery_seed: Option<u64>,
    /// Refuse to start if the run is expected to need more memory
    ///
    /// K, M, G and T stand for powers of 1024, as in 2G.
    #[arg(long, value_name = "BYTES", value_parser = bytes, help_heading = MACHINE, hide_short_help = true)]
    pub max_memory: Option<u64>,
}

/// Options of every command that counts the paper's recursion.
#[derive(Debug, Args)]
pub struct GraphArgs {
    /// Graph that is expected to contain all edges of the Delaunay triangulation
    #[arg(long, value_enum, default_value_t = GraphArg::Density, help_heading = GRAPH)]
    pub supergraph: GraphArg,
    /// Parameter alpha of a density or overlap graph, at least 1
    #[arg(long, value_name = "A|auto", default_value = "auto", value_parser = alpha, allow_negative_numbers = true, help_heading = GRAPH)]
    pub alpha: Alpha,
    /// Parameter k of a nearest-neighbour graph; `10ln` stands for ceil(10 ln n)
    #[arg(long, value_name = "K|auto|Cln", default_value = "auto", value_parser = neighbours, allow_hyphen_values = true, help_heading = GRAPH)]
    pub k: Neighbours,
    /// Sharing of separator points
    #[arg(long, value_enum, default_value_t = SetsArg::Ghost, help_heading = GRAPH, hide_short_help = true)]
    pub separator_sets: SetsArg,
    /// Correction of nearest-neighbour balls across separators
    #[arg(long, value_enum, default_value_t = NeighboursArg::Descent, help_heading = GRAPH, hide_short_help = true)]
    pub neighbours: NeighboursArg,
    #[command(flatten)]
    pub constants: ConstantsArgs,
}

/// `--supergraph`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GraphArg {
    /// The density graph of the paper
    Density,
    /// Overlapping neighbour balls
    Overlap,
    /// The k nearest neighbours
    Knn,
}

/// `--nodes`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NodesArg {
    /// Every node
    All,
    /// No node; with several processes, no process then receives the nodes of the others
    None,
}

/// `--separator-sets`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SetsArg {
    /// Both sides receive them, as in the paper
    Both,
    /// Only the side with fewer of them sends them to the other
    Smaller,
    /// Both sides receive them as ghosts
    Ghost,
}

/// `--partition`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PartitionArg {
    /// Sphere separators, as in the paper
    Sphere,
    /// K-d planes, as a baseline
    Kd,
}

/// `--neighbours`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NeighboursArg {
    /// One descent from the root
    Descent,
    /// Bottom-up, node by node, as a baseline
    Naive,
}

impl NeighboursArg {
    /// Returns the correction of this name.
    pub fn correction(self) -> Correction {
        match self {
            NeighboursArg::Descent => Correction::Descent,
            NeighboursArg::Naive => Correction::BottomUp,
        }
    }
}

/// `--transport`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TransportArg {
    /// Channels between threads
    Channel,
    /// A simulator on one thread
    Sim,
    /// Sockets between processes, each of which reads and writes its share; `septet triangulate` and `septet simulate`
    /// only
    Processes,
}

impl TransportArg {
    /// Returns the transport of this name with the seed of the order of delivery.
    pub fn with_seed(self, delivery_seed: Option<u64>) -> Result<Transport, Failure> {
        let is_sim = self == TransportArg::Sim;
        needs("--delivery-seed", delivery_seed.is_some(), "--transport sim", is_sim)?;
        let delivery_seed = delivery_seed.unwrap_or(0);
        match self {
            TransportArg::Channel => Ok(Transport::Channel),
            TransportArg::Sim => Ok(Transport::Sim { delivery_seed }),
            TransportArg::Processes => {
                let message =
                    "--transport processes works with `septet triangulate` and `septet simulate` only";
                Err(Failure::new(Code::Usage, message).help("use --transport channel"))
            }
        }
    }
}

/// `--registers`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RegistersArg {
    /// The widest registers of the processor
    Widest,
    /// The registers that every processor of the architecture has
    Baseline,
}

/// `--trace-level`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DetailArg {
    /// Phases of the coordinator
    Phase,
    /// Rounds of each worker
    Round,
    /// Messages and bytes in flight
    Message,
    /// Steps at the nodes of the partition tree
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

impl MachineArgs {
    /// Returns the configuration for these options, with defaults for the others.
    pub fn spec(&self) -> Result<Spec, Failure> {
        Ok(self.config_on(self.transport.with_seed(self.delivery_seed)?))
    }

    /// Returns the configuration for these options and this transport.
    fn config_on(&self, transport: Transport) -> Spec {
        let base = Spec::default();
        if self.registers == RegistersArg::Baseline {
            septet_geometry::simd::use_baseline_registers();
        }
        base.with(|c| {
            c.machine.threads = self.threads;
            c.tree.partition = match self.partition {
                PartitionArg::Sphere => Partition::Sphere,
                PartitionArg::Kd => Partition::Kd,
            };
            c.tree.leaf = self.leaf.0;
            c.machine.transport = transport;
            c.machine.max_memory = self.max_memory;
        })
    }
}

impl GraphArgs {
    /// Returns `spec` with these options applied.
    pub fn extend(&self, spec: Spec) -> Result<Spec, Failure> {
        let kind = match self.supergraph {
            GraphArg::Density => GraphKind::Density,
            GraphArg::Overlap => GraphKind::Overlap,
            GraphArg::Knn => GraphKind::Knn,
        };
        let graph = Graph::new(kind, self.alpha, self.k)?;
        Ok(self.constants.extend(spec).with(|c| {
            c.recursion.graph = graph;
            c.recursion.sets = match self.separator_sets {
                SetsArg::Both => SeparatorSets::Both,
                SetsArg::Smaller => SeparatorSets::Smaller,
                SetsArg::Ghost => SeparatorSets::Ghost,
            };
            c.recursion.neighbours = self.neighbours.correction();
        }))
    }
}

impl SimulateArgs {
    /// Returns `spec` with the options of its own applied.
    pub fn extend(&self, spec: Spec) -> Result<Spec, Failure> {
        needs("--nodes", self.nodes.is_some(), "--json", self.run.json.is_some())?;
        Ok(self.graph.extend(spec)?.with(|c| c.keep.costs = self.cost_trace.is_some()))
    }
}

impl RunArgs {
    /// Returns the configuration of these options in one process.
    pub fn spec(&self) -> Result<Spec, Failure> {
        needs("--processes", self.processes.is_some(), "--transport processes", false)?;
        self.hidden.refuse()?;
        let has_pieces = self.writing.any(&self.output, &[OutputFormat::Pvtu]);
        Ok(self.settled(self.machine.spec()?).with(|c| c.keep.point_owner = has_pieces))
    }

    /// Returns the configuration of one of several processes: the number of workers is `workers` by default, and the number
    /// of threads of each process is `threads`.
    pub fn config_of_processes(&self, workers: u32, threads: usize) -> Result<Spec, Failure> {
        let seeded = self.machine.delivery_seed.is_some();
        needs("--delivery-seed", seeded, "--transport sim", false)?;
        Ok(self.settled(self.machine.config_on(Transport::Channel)).with(|c| {
            c.machine.workers = match self.workers {
                None | Some(Workers::Auto) => Workers::Count(workers),
                Some(given) => given,
            };
            c.machine.threads = self.machine.threads.or(Some(threads));
        }))
    }

    /// Returns `spec` with the options of the run applied.
    fn settled(&self, spec: Spec) -> Spec {
        spec.with(|c| {
            c.machine.workers = self.workers.unwrap_or(c.machine.workers);
            c.machine.seed = self.seed;
            c.input.skip_invalid = self.skip_invalid;
            c.keep.owner = self.with_owner;
            c.planted.fault = self.fault;
        })
    }
}

fn shown(text: &str) -> Result<u32, String> {
    let number = count(text)?;
    u32::try_from(number)
        .ok()
        .filter(|&n| n <= MOST_POINTS)
        .ok_or_else(|| format!("expected at most {MOST_POINTS} points"))
}

/// Parses a kind of point set.
pub fn kind(text: &str) -> Result<Kind, String> {
    let name = text.trim();
    name.parse().map_err(|_: GenerateError| {
        let kinds: Vec<&str> = Kind::all().map(Kind::name).collect();
        format!("{}expected one of {}", suggestion(name, kinds.iter().copied()), kinds.join(" "))
    })
}

/// Parses a number of workers, `auto` or `leaves`.
pub fn workers(text: &str) -> Result<Workers, String> {
    match text {
        "auto" => Ok(Workers::Auto),
        "leaves" => Ok(Workers::Leaves),
        _ => text
            .parse()
            .map(Workers::Count)
            .map_err(|_| "expected a number of workers, `auto` or `leaves`".into()),
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

/// Parses a dimension.
pub fn dimension(text: &str) -> Result<usize, String> {
    match text {
        "2" => Ok(2),
        "3" => Ok(3),
        _ => Err("expected 2 or 3".into()),
    }
}
