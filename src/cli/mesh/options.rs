//! Options of `septet mesh`, and how they become a request.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use septet_core::config::{Config, Machine, Transport, Workers};
use septet_core::mesh::view::MOST_CELLS;
use septet_core::mesh::{
    Boundary, DEFAULT_FEATURE_ANGLE, DEFAULT_LIPSCHITZ, MeshRequest, Shape, SingularityRequest,
};

use crate::errors::{Code, Failure};
use crate::options::{MshArg, TraceArgs, TransportArg, bytes, workers};

/// Options of `septet mesh`.
#[derive(Debug, Args)]
#[command(after_help = "\
A piecewise linear complex (.poly, .smesh) may have internal and dangling pieces; a surface (.stl .off .ply .obj)
must be closed, and its faces are made anew unless --boundary exact keeps them. Exit code 3 and the list of all defects
if the domain has any; 4 if the mesh does not conform to it.

Examples:
  septet mesh part.poly --check
  septet mesh part.poly -o part.vtu --radius-edge 1.5
  septet mesh part.poly --json part.json --view 100000 && septet report part.json -o part.html
  septet mesh scan.stl --size 0.5 --max-distance 0.01 -o scan.msh --json -
  septet mesh box.off --boundary exact -o box.vtu
  septet mesh part.poly --size-field sizes.csv --min-size 0.01 -o part.1.ele -o part-surface.stl")]
pub struct MeshArgs {
    /// The domain: .poly .smesh .stl .off .ply .obj, each also .gz
    pub domain: PathBuf,
    /// Check the domain, and do no more
    #[arg(long, conflicts_with_all = ["output", "json", "trace"])]
    pub check: bool,
    /// Write the mesh (.vtu .msh .msh22 .mesh .npy, or one of .node .ele .face .edge .neigh for the whole set) or its
    /// surface (.off .stl); may be given several times
    #[arg(short, long = "output", value_name = "OUT")]
    pub output: Vec<PathBuf>,
    /// Keep every segment and facet of the input, or corners and ridges of a surface alone
    /// [default: exact for .poly and .smesh, remesh for surfaces]
    #[arg(long, value_name = "MODE", value_enum)]
    pub boundary: Option<BoundaryArg>,
    /// Largest distance of neighbouring points
    #[arg(long, value_name = "H", value_parser = length)]
    pub size: Option<f64>,
    /// Sizes at points, rows of `x y [z] size` (.txt .csv .npy, each also .gz, - for standard input)
    #[arg(long, value_name = "FILE")]
    pub size_field: Option<PathBuf>,
    /// Let sizes fall to --min-size at a place: `point`, `line`, or with coordinates, as in `point:0,0,1`
    /// [default places: the middle of the box, its middle third along x]
    #[arg(long, value_name = "point|line[:X,Y,..]", value_parser = singularity, requires = "min_size")]
    pub singularity: Option<SingularityRequest>,
    /// How fast sizes may grow, between 0 and 1; radius-edge ratios are at most 1/(1-L) [default: 0.5]
    #[arg(long, value_name = "L", value_parser = lipschitz, conflicts_with = "radius_edge", allow_negative_numbers = true)]
    pub lipschitz: Option<f64>,
    /// Largest radius-edge ratio away from the boundary, above 1: L = 1 - 1/B [default: 2]
    #[arg(long, value_name = "B", value_parser = radius_edge, allow_negative_numbers = true)]
    pub radius_edge: Option<f64>,
    /// Smallest distance of neighbouring points; it wins over everything else
    #[arg(long, value_name = "H", value_parser = length, allow_negative_numbers = true)]
    pub min_size: Option<f64>,
    /// Edges of a surface that turn by more degrees are ridges [default: 60]
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true)]
    pub feature_angle: Option<f64>,
    /// Largest distance between the boundary and the surface (with --boundary remesh)
    /// [default: half the size, a tenth from the centres of faces]
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true)]
    pub max_distance: Option<f64>,
    /// Remove slivers
    #[arg(long)]
    pub improve: bool,
    /// Number of workers, or `leaves` for one per leaf of the partition tree [default: cores]
    #[arg(long, value_name = "P|leaves", value_parser = workers, allow_negative_numbers = true)]
    pub workers: Option<Workers>,
    /// Largest leaf of the partition trees of independent sets [default: 4000 in space, 2000 in the plane]
    #[arg(long, value_name = "M")]
    pub leaf: Option<u64>,
    /// Threads that run the workers [default: cores]
    #[arg(long, value_name = "T")]
    pub threads: Option<usize>,
    /// Seed of every random draw
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// How messages travel: over channels between threads, or simulated on one thread
    #[arg(long, value_enum, default_value_t = TransportArg::Channel)]
    pub transport: TransportArg,
    /// Seed of the order of delivery (with --transport sim) [default: 0]
    #[arg(long, value_name = "S")]
    pub delivery_seed: Option<u64>,
    /// Refuse to start if more memory is expected; with K, M, G or T for powers of 1024. Without it a mesh
    /// that is sure to need more than there is ends as soon as that is known
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub max_memory: Option<u64>,
    /// Write the report as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    pub json: Option<PathBuf>,
    /// Put a picture of the mesh into the report if it has at most N cells, for `septet report`; at most 200000, 0 for
    /// none [default: 20000]
    #[arg(long, value_name = "N", value_parser = shown, requires = "json")]
    pub view: Option<u32>,
    /// Print tables of stages, of phases and of runs of the machine; with a name ending in .md write them as Markdown,
    /// in .csv as three files (NAME.stages.csv, NAME.phases.csv, NAME.runs.csv)
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "-", conflicts_with = "check")]
    pub profile: Option<PathBuf>,
    #[command(flatten)]
    pub tracing: TraceArgs,
    /// Write histograms of the mesh's quality as SVG into this directory
    #[arg(long, value_name = "DIR", conflicts_with = "check")]
    pub svg: Option<PathBuf>,
    /// Version of files named .msh
    #[arg(long, value_name = "VERSION", value_enum, default_value_t = MshArg::V41)]
    pub msh_version: MshArg,
}

/// `--boundary`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BoundaryArg {
    /// Every segment and facet
    Exact,
    /// Corners, and ridges above the feature angle
    Remesh,
}

impl From<BoundaryArg> for Boundary {
    fn from(boundary: BoundaryArg) -> Self {
        match boundary {
            BoundaryArg::Exact => Boundary::Exact,
            BoundaryArg::Remesh => Boundary::Remesh,
        }
    }
}

impl MeshArgs {
    /// What is asked for; the size field has yet to be read.
    pub fn request(&self) -> Result<MeshRequest, Failure> {
        let usage = |message: &str, help: &str| Err(Failure::new(Code::Usage, message).help(help));
        if self.delivery_seed.is_some() && self.transport == TransportArg::Channel {
            let message = "--delivery-seed goes with --transport sim: channels deliver when they deliver";
            return usage(message, "add --transport sim, or leave the seed out");
        }
        let told = self.json.is_some() || self.svg.is_some() || self.profile.is_some();
        if !self.check && !told && self.output.is_empty() && self.tracing.trace.is_none() {
            return usage("where is the mesh to go?", "give -o OUT, or --check to check the domain alone");
        }
        if let (Some(size), Some(least)) = (self.size, self.min_size)
            && least > size
        {
            return usage(
                "--min-size is above --size, and would win everywhere",
                "give a smaller --min-size, or --size alone",
            );
        }
        if self.max_distance.is_some() && self.boundary == Some(BoundaryArg::Exact) {
            return Err(exact_has_no_distance());
        }
        let machine = Machine::default().with(|m| {
            m.workers = self.workers.unwrap_or(m.workers);
            m.threads = self.threads.unwrap_or(m.threads);
            m.leaf = self.leaf;
            m.transport = match self.transport {
                TransportArg::Channel => Transport::Channel,
                TransportArg::Sim => Transport::Sim { delivery_seed: self.delivery_seed.unwrap_or(0) },
            };
            m.seed = self.seed;
            m.max_memory = self.max_memory;
        });
        Config::default().with(|c| c.machine = machine.clone()).check()?;
        let by_ratio = self.radius_edge.map(|b| 1.0 - 1.0 / b);
        Ok(MeshRequest {
            boundary: self.boundary.map(Boundary::from),
            size: self.size,
            field: None,
            singularity: self.singularity.clone(),
            min_size: self.min_size,
            lipschitz: self.lipschitz.or(by_ratio).unwrap_or(DEFAULT_LIPSCHITZ),
            feature_angle: self.feature_angle.unwrap_or(DEFAULT_FEATURE_ANGLE),
            max_distance: self.max_distance,
            improve: self.improve,
            machine,
            cancel: None,
        })
    }
}

/// The most cells of a picture.
fn shown(text: &str) -> Result<u32, String> {
    let number: Option<u32> = text.parse().ok();
    number.filter(|&n| n <= MOST_CELLS).ok_or_else(|| format!("expected a number of at most {MOST_CELLS}"))
}

/// A boundary that is kept as it is has no distance from itself.
pub fn exact_has_no_distance() -> Failure {
    let message = "--max-distance goes with --boundary remesh: --boundary exact keeps the boundary itself";
    Failure::new(Code::Usage, message).help("leave the distance out, or add --boundary remesh for a surface")
}

/// A number with a property.
fn number(text: &str, expected: &str, good: impl Fn(f64) -> bool) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|&x: &f64| x.is_finite() && good(x))
        .ok_or_else(|| format!("expected {expected}"))
}

fn length(text: &str) -> Result<f64, String> {
    number(text, "a positive length", |x| x > 0.0)
}

fn lipschitz(text: &str) -> Result<f64, String> {
    number(text, "a number between 0 and 1, both exclusive", |x| x > 0.0 && x < 1.0)
}

fn radius_edge(text: &str) -> Result<f64, String> {
    // L = 1 - 1/B has to lie strictly between 0 and 1, as rounded.
    number(text, "a number above 1", |b| b > 1.0 && 1.0 - 1.0 / b > 0.0 && 1.0 - 1.0 / b < 1.0)
}

fn degrees(text: &str) -> Result<f64, String> {
    number(text, "an angle from 0 to 180 degrees", |x| (0.0..=180.0).contains(&x))
}

fn singularity(text: &str) -> Result<SingularityRequest, String> {
    let expected = || "expected `point`, `line`, `point:X,Y[,Z]` or `line:X,Y[,Z],X,Y[,Z]`".to_owned();
    let (name, place) = text.split_once(':').map_or((text, None), |(name, place)| (name, Some(place)));
    let (shape, points) = match name {
        "point" => (Shape::Point, 1),
        "line" => (Shape::Line, 2),
        _ => return Err(expected()),
    };
    let at = match place {
        None => Vec::new(),
        Some(place) => place
            .split(',')
            .map(|c| c.trim().parse().ok().filter(|x: &f64| x.is_finite()))
            .collect::<Option<Vec<f64>>>()
            .filter(|at| at.len() == 2 * points || at.len() == 3 * points)
            .ok_or_else(expected)?,
    };
    Ok(SingularityRequest { shape, at })
}
