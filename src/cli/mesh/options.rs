//! Options of `septet mesh`, and their conversion into a request.

use std::path::PathBuf;

use clap::Args;
use septet_core::mesh::view::MOST_CELLS;
use septet_core::mesh::{Boundary, MeshSpec, SingularityRequest, SingularityShape};
use septet_core::spec::Commands;
use septet_io::Role;

use crate::effects::needs;
use crate::errors::{Code, Failure};
use crate::formats::{FormatArgs, listed, mesh_outputs_help};
use crate::given::{Given, words};
use crate::headings::{INPUT, OUTPUT, REPORTS};
use crate::options::TraceArgs;

/// The help of `--size-field`.
const SIZE_FIELD: &str = "Sizes at points, in rows of `x y [z] size`";
const SIZES: &str = "Sizes and quality";
const BOUNDARY: &str = "Boundary";

/// The options that have no meaning with `--check`.
const NOT_FOR_CHECKS: [&str; 24] = [
    "output",
    "format",
    "msh_version",
    "boundary",
    "feature_angle",
    "max_distance",
    "size",
    "size_field",
    "singularity",
    "lipschitz",
    "radius_edge",
    "min_size",
    "improve",
    "workers",
    "leaf",
    "threads",
    "seed",
    "transport",
    "delivery_seed",
    "max_memory",
    "json",
    "trace",
    "trace_level",
    "view",
];

/// Options of `septet mesh`.
#[derive(Debug, Args)]
#[command(
    after_help = "\
Examples:
  septet mesh part.poly --check
  septet mesh part.poly -o part.vtu
  septet mesh scan.stl --size 0.5 --improve -o scan.msh

`septet mesh --help` lists all options.",
    after_long_help = "\
A piecewise linear complex (.poly, .smesh) may have internal and dangling segments and facets. A surface (.stl .off \
.ply .obj) must be closed. It is remeshed, unless --boundary exact keeps its faces.

The exit code is 3 if the domain has defects, which are all listed, and 4 if the mesh does not conform to its domain.

Examples:
  septet mesh part.poly --check
  septet mesh part.poly -o part.vtu --radius-edge 1.5
  septet mesh part.poly --json part.json --view 100000
  septet mesh scan.stl --size 0.5 --max-distance 0.01 -o scan.msh
  septet mesh box.off --boundary exact -o box.vtu
  septet mesh part.poly --size-field sizes.csv --min-size 0.01 -o part.1.ele"
)]
pub struct MeshArgs {
    #[arg(help = format!("Domain: {}", Role::Domain.known()))]
    pub domain: PathBuf,
    /// Check the domain only
    #[arg(long, conflicts_with_all = NOT_FOR_CHECKS, help_heading = INPUT)]
    pub check: bool,
    #[arg(short, long = "output", value_name = "OUT", help = "Write the mesh or its surface; may be given several times", long_help = mesh_outputs_help(), help_heading = OUTPUT)]
    pub output: Vec<PathBuf>,
    #[command(flatten)]
    pub writing: FormatArgs,
    /// Treatment of the boundary [default: exact for .poly and .smesh, remesh for surfaces]
    #[arg(long, value_name = "MODE", value_parser = words::<Boundary>(), help_heading = BOUNDARY)]
    pub boundary: Option<Boundary>,
    /// Upper limit of the size; edges can be about twice as long
    #[arg(long, value_name = "H", value_parser = length, help_heading = SIZES)]
    pub size: Option<f64>,
    #[arg(long, value_name = "FILE", help = SIZE_FIELD, long_help = format!("{} `-` is standard input.", listed(SIZE_FIELD, Role::Sizes)), help_heading = SIZES, hide_short_help = true)]
    pub size_field: Option<PathBuf>,
    /// Grade sizes down to --min-size at a point or on a line
    ///
    /// Coordinates follow after a colon, as in `point:0,0,1`. By default, the point is the centre of the bounding
    /// box, and the line is the middle third of the box along x.
    #[arg(long, value_name = "point|line[:X,Y,..]", value_parser = singularity, requires = "min_size", help_heading = SIZES, hide_short_help = true)]
    pub singularity: Option<SingularityRequest>,
    /// Growth rate of sizes, between 0 and 1 [default: 0.5]
    ///
    /// Away from the boundary, radius-edge ratios are at most 1/(1-L).
    #[arg(long, value_name = "L", value_parser = lipschitz, conflicts_with = "radius_edge", allow_negative_numbers = true, help_heading = SIZES, hide_short_help = true)]
    pub lipschitz: Option<f64>,
    /// Largest radius-edge ratio away from the boundary, above 1 [default: 2]
    ///
    /// It sets the growth rate of sizes to L = 1 - 1/B.
    #[arg(long, value_name = "B", value_parser = radius_edge, allow_negative_numbers = true, help_heading = SIZES)]
    pub radius_edge: Option<f64>,
    /// Lower limit of the size; overrides every other size
    #[arg(long, value_name = "H", value_parser = length, allow_negative_numbers = true, help_heading = SIZES)]
    pub min_size: Option<f64>,
    /// Angle in degrees above which an edge of a surface is a ridge [default: 60]
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_negative_numbers = true, help_heading = BOUNDARY, hide_short_help = true)]
    pub feature_angle: Option<f64>,
    /// Largest distance between a surface and its remeshed boundary
    ///
    /// By default, refinement aims at a tenth of the local size at face centres, and the limit is half the size.
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true, help_heading = BOUNDARY)]
    pub max_distance: Option<f64>,
    /// Remove slivers: cells with small dihedral angles
    #[arg(long, help_heading = SIZES)]
    pub improve: bool,
    /// Write the report as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-", help_heading = REPORTS)]
    pub json: Option<PathBuf>,
    /// Largest number of cells for which the report contains a picture of the mesh
    ///
    /// `septet report` draws the picture. At most 200000, 0 for none. [default: 20000]
    #[arg(long, value_name = "N", value_parser = shown, help_heading = REPORTS, hide_short_help = true)]
    pub view: Option<u32>,
    /// Print tables of stages, phases and runs of the machine
    ///
    /// `--profile=NAME.md` writes Markdown instead. `--profile=NAME.csv` writes NAME.stages.csv, NAME.phases.csv
    /// and NAME.runs.csv.
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "-", conflicts_with = "check", help_heading = REPORTS, hide_short_help = true)]
    pub profile: Option<PathBuf>,
    #[command(flatten)]
    pub given: Given<{ Commands::MESH.bits() }>,
    #[command(flatten)]
    pub tracing: TraceArgs,
    /// Write histograms of the mesh quality as SVG files into this directory
    #[arg(long, value_name = "DIR", conflicts_with = "check", help_heading = REPORTS, hide_short_help = true)]
    pub svg: Option<PathBuf>,
}

impl MeshArgs {
    /// Returns the request for these options, without the size field, which the caller reads.
    pub fn request(&self) -> Result<MeshSpec, Failure> {
        let usage = |message: &str, help: &str| Err(Failure::new(Code::Usage, message).help(help));
        let run = self.given.options().spec()?;
        needs("--view", self.view.is_some(), "--json", self.json.is_some())?;
        let is_reported = self.json.is_some() || self.svg.is_some() || self.profile.is_some();
        if !self.check && !is_reported && self.output.is_empty() && self.tracing.trace.is_none() {
            let message = "no output is given";
            return usage(message, "use -o FILE or --json FILE, or --check to check the domain only");
        }
        if let (Some(size), Some(least)) = (self.size, self.min_size)
            && least > size
        {
            return usage(
                "--min-size is larger than --size and would override it everywhere",
                "reduce --min-size, or omit it",
            );
        }
        self.check_boundary(self.boundary == Some(Boundary::Exact))?;
        run.check()?;
        let by_ratio = self.radius_edge.map(|b| 1.0 - 1.0 / b);
        Ok(MeshSpec::default().with(|mesh| {
            mesh.run = run;
            mesh.boundary = self.boundary;
            let sizes = &mut mesh.sizes;
            (sizes.most, sizes.least) = (self.size, self.min_size);
            sizes.singularity.clone_from(&self.singularity);
            sizes.lipschitz = self.lipschitz.or(by_ratio).unwrap_or(sizes.lipschitz);
            mesh.feature_angle = self.feature_angle.unwrap_or(mesh.feature_angle);
            mesh.max_distance = self.max_distance;
            mesh.improve = self.improve;
        }))
    }
}

impl MeshArgs {
    /// Refuses options of remeshing for an exact boundary.
    pub fn check_boundary(&self, is_exact: bool) -> Result<(), Failure> {
        for (option, is_given) in [
            ("--feature-angle", self.feature_angle.is_some()),
            ("--max-distance", self.max_distance.is_some()),
        ] {
            needs(option, is_given, "--boundary remesh", !is_exact)?;
        }
        Ok(())
    }
}

/// Parses the largest number of cells in a picture.
fn shown(text: &str) -> Result<u32, String> {
    let number: Option<u32> = text.parse().ok();
    number.filter(|&n| n <= MOST_CELLS).ok_or_else(|| format!("expected a number of at most {MOST_CELLS}"))
}

/// Parses a number and checks a condition.
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
    // L = 1 - 1/B must lie strictly between 0 and 1 after rounding.
    number(text, "a number above 1", |b| b > 1.0 && 1.0 - 1.0 / b > 0.0 && 1.0 - 1.0 / b < 1.0)
}

fn degrees(text: &str) -> Result<f64, String> {
    number(text, "an angle from 0 to 180 degrees", |x| (0.0..=180.0).contains(&x))
}

fn singularity(text: &str) -> Result<SingularityRequest, String> {
    let expected = || "expected `point`, `line`, `point:X,Y[,Z]` or `line:X,Y[,Z],X,Y[,Z]`".to_owned();
    let (name, place) = text.split_once(':').map_or((text, None), |(name, place)| (name, Some(place)));
    let (shape, points) = match name {
        "point" => (SingularityShape::Point, 1),
        "line" => (SingularityShape::Line, 2),
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
