//! Options of `septet mesh`, and their conversion into a request.

use std::path::PathBuf;

use clap::{Args, Id};
use septet_core::mesh::view::MOST_CELLS;
use septet_core::mesh::{Boundary, MESH_OPTIONS, MeshSpec};
use septet_core::spec::{Commands, Heading, Row, options_of};
use septet_io::Role;
use septet_io::write::{Order, WriteOptions};

use crate::effects::{excludes, needs};
use crate::errors::{Code, Failure};
use crate::formats::{FormatArgs, listed, mesh_outputs_help};
use crate::given::{Given, GivenMesh, words};
use crate::headings::{INPUT, OUTPUT, REPORTS};
use crate::options::TraceArgs;

/// The help of `--size-field`.
const SIZE_FIELD: &str = "Sizes at points, in rows of `x y [z] size`, or on a mesh";

/// The help of `--order`.
const ORDER: &str = "Order of the cells in outputs [default: 1]";

fn order_help() -> String {
    let known = Role::Mesh.extensions(|row| row.has_order_2);
    format!(
        "{ORDER}\n\nCells of order 2 are quadratic and have straight edges: each edge has a node at its midpoint. Formats: \
         {known}."
    )
}

/// Returns the options that have no meaning with `--check`.
fn not_for_checks() -> Vec<Id> {
    let own =
        ["output", "format", "msh_version", "order", "size_field", "json", "trace", "trace_level", "view"];
    let is_of_domain = |row: &&Row<MeshSpec>| ["weld", "repair", "strict"].contains(&row.name);
    let of_mesh = MESH_OPTIONS.iter().filter(|row| !is_of_domain(row)).map(|row| row.key);
    let of_runs = options_of(Commands::MESH).map(|row| row.key);
    own.into_iter().chain(of_mesh).chain(of_runs).map(Id::from).collect()
}

/// Options of `septet mesh`.
#[derive(Debug, Args)]
#[command(
    after_help = "\
Examples:
  septet mesh part.poly --check
  septet mesh part.poly -o part.vtu
  septet mesh scan.stl --size 0.5 -o scan.msh

`septet mesh --help` lists all options.",
    after_long_help = "\
A piecewise linear complex (.poly, .smesh) may have internal and dangling segments and facets. A surface (.stl .off \
.ply .obj) must be closed. It is remeshed, unless --boundary exact keeps its faces. Several surfaces, or the solids of \
an .stl file, are regions of one domain.

The exit code is 3 if the domain has defects, which are all listed, and 4 if the mesh does not conform to its domain.

Examples:
  septet mesh part.poly --check
  septet mesh part.poly -o part.vtu --radius-edge 1.5
  septet mesh part.poly --json part.json --view 100000
  septet mesh scan.stl --size 0.5 --max-distance 0.01 -o scan.msh
  septet mesh box.off --boundary exact -o box.vtu
  septet mesh scan.stl --repair --weld 1e-6 -o scan.vtu
  septet mesh rock.stl ore.stl -o deposit.vtu
  septet mesh map.poly --size none -o map.vtu
  septet mesh part.poly --size-field sizes.csv --min-size 0.01 -o part.1.ele"
)]
pub struct MeshArgs {
    #[arg(help = format!("Domain: {}", Role::Domain.known()))]
    pub domain: PathBuf,
    /// Further closed surfaces: each file is a region of one domain
    #[arg(value_name = "SURFACE")]
    pub surfaces: Vec<PathBuf>,
    /// Check the domain only
    #[arg(long, conflicts_with_all = not_for_checks(), help_heading = INPUT)]
    pub check: bool,
    #[arg(short, long = "output", value_name = "OUT", help = "Write the mesh or its surface; may be given several times", long_help = mesh_outputs_help(), help_heading = OUTPUT)]
    pub output: Vec<PathBuf>,
    #[command(flatten)]
    pub writing: FormatArgs,
    #[arg(long, value_name = "N", value_parser = words::<Order>(), help = ORDER, long_help = order_help(), help_heading = OUTPUT, hide_short_help = true)]
    pub order: Option<Order>,
    #[arg(long, value_name = "FILE", help = SIZE_FIELD, long_help = format!("{} `-` is standard input.", listed(SIZE_FIELD, Role::Sizes)), help_heading = Heading::Sizes.title(), hide_short_help = true)]
    pub size_field: Option<PathBuf>,
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
    pub mesh: GivenMesh,
    #[command(flatten)]
    pub given: Given<{ Commands::MESH.bits() }>,
    #[command(flatten)]
    pub tracing: TraceArgs,
    /// Write histograms of the mesh quality as SVG files into this directory
    #[arg(long, value_name = "DIR", conflicts_with = "check", help_heading = REPORTS, hide_short_help = true)]
    pub svg: Option<PathBuf>,
}

impl MeshArgs {
    /// Returns the options of the writers.
    pub fn write_options(&self) -> WriteOptions<'static> {
        WriteOptions { order: self.order.unwrap_or_default(), ..self.writing.options() }
    }

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
        needs("--order", self.order.is_some(), "-o OUT", !self.output.is_empty())?;
        let given = self.mesh.options();
        needs("--singularity", given.has("singularity"), "--min-size", given.has("min-size"))?;
        excludes("--improve", given.has("improve"), "--no-improve", given.has("no-improve"))?;
        excludes("--lipschitz", given.has("lipschitz"), "--radius-edge", given.has("radius-edge"))?;
        excludes("--strict", given.has("strict"), "--weld", given.has("weld"))?;
        excludes("--strict", given.has("strict"), "--repair", given.has("repair"))?;
        let mesh = given.spec()?;
        let remeshes = mesh.boundary == Some(Boundary::Remesh);
        if mesh.as_it_is {
            for other in [
                "singularity",
                "lipschitz",
                "radius-edge",
                "min-size",
                "conforming",
                "improve",
                "no-improve",
                "keep-surface",
            ] {
                excludes("--size none", true, &format!("--{other}"), given.has(other))?;
            }
            excludes("--size none", true, "--size-field", self.size_field.is_some())?;
            excludes("--size none", true, "--boundary remesh", remeshes)?;
        }
        excludes("--keep-surface", mesh.keep_surface, "--boundary remesh", remeshes)?;
        excludes("--keep-surface", mesh.keep_surface, "--conforming", mesh.conforming)?;
        if let (Some(size), Some(least)) = (mesh.sizes.most, mesh.sizes.least)
            && least > size
        {
            return usage(
                "--min-size is larger than --size and would override it everywhere",
                "reduce --min-size, or omit it",
            );
        }
        self.check_boundary(mesh.is_constrained() || mesh.boundary == Some(Boundary::Exact))?;
        run.check()?;
        Ok(mesh.with(|mesh| mesh.run = run))
    }

    /// Refuses options of remeshing for an exact boundary.
    pub fn check_boundary(&self, is_exact: bool) -> Result<(), Failure> {
        for (option, (needed, word)) in self.mesh.options().needs() {
            needs(&format!("--{option}"), true, &format!("--{needed} {word}"), !is_exact)?;
        }
        Ok(())
    }
}

/// Parses the largest number of cells in a picture.
fn shown(text: &str) -> Result<u32, String> {
    let number: Option<u32> = text.parse().ok();
    number.filter(|&n| n <= MOST_CELLS).ok_or_else(|| format!("expected a number of at most {MOST_CELLS}"))
}
