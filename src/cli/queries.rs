//! `septet locate`, `interpolate` and `alpha`: questions about the triangulation of points.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use septet_core::generate::Request;
use septet_core::model::{HigherPoints, Points};
use septet_core::spec::{Commands, SpecError};
use septet_core::{Outcome, Spec, triangulate};
use septet_geometry::coordinates::Coordinates;
use septet_io::read::ReadOptions;
use septet_queries::{Dimension, Method, NONE, QueryError, Tessellation};

use super::errors::{Code, Failure};
use super::files;
use super::formats::{check_reading, read_options};
use super::given::{Given, Options};
use super::input::{self, Input, Loaded, placed};
use super::progress::Talk;
use super::summary::written;
use super::text::counted;
use super::verify::place_of;
use super::weights::GivenWeights;

pub(super) const OUTPUT_CSV: &str = "Output table (.csv), `-` for standard output";

/// Options of every command that asks a triangulation. `COMMAND` are the bits of [`Commands`].
#[derive(Debug, Args)]
pub(super) struct PointArgs<const COMMAND: u16 = QUERIES> {
    #[arg(
        value_name = "POINTS",
        help = "Point file, pattern in quotes, `@LIST`, `-` for standard input, or `sample:KIND:N[,d=2][,seed=7]`"
    )]
    points: String,
    #[command(flatten)]
    given: Given<COMMAND>,
}

/// The bits of the commands without options of their own.
const QUERIES: u16 = Commands::QUERIES.bits();

impl<const COMMAND: u16> PointArgs<COMMAND> {
    /// Returns what the user asks for, without weights.
    pub(super) fn asking(&self) -> Asking<'_> {
        Asking { points: &self.points, given: self.given.options(), weights: None, has_values: false }
    }
}

/// The arguments of a command that asks a triangulation.
#[derive(Clone, Copy)]
pub(super) struct Asking<'a> {
    pub(super) points: &'a str,
    pub(super) given: &'a Options<Spec>,
    pub(super) weights: Option<GivenWeights<'a>>,
    /// Whether other columns of the points are kept as values.
    pub(super) has_values: bool,
}

/// Options of `septet locate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Simplices are numbered from 0, in the order in which `septet triangulate` writes them. A query on several of them gets the \
smallest number, and one outside of the hull gets an empty field. Location is exact: every point is inside.

Examples:
  septet locate points.csv queries.csv -o simplices.csv
  septet locate points.npy queries.npy")]
pub struct LocateArgs {
    #[command(flatten)]
    points: PointArgs,
    /// File of queries, with the same coordinates as the points
    #[arg(value_name = "QUERIES")]
    queries: String,
    #[arg(short, long, value_name = "FILE", default_value = "-", help = OUTPUT_CSV)]
    output: PathBuf,
}

/// Options of `septet interpolate`.
#[derive(Debug, Args)]
#[command(after_help = "\
A query outside of the hull gets an empty field. Each method reproduces linear functions. Sibson and laplace weigh natural \
neighbours and are smooth between the points.

Examples:
  septet interpolate stations.csv grid.csv --values rain -o rain.csv
  septet interpolate stations.csv grid.csv --values rain --method sibson")]
pub struct InterpolateArgs {
    #[command(flatten)]
    points: PointArgs,
    /// File of queries, with the same coordinates as the points
    #[arg(value_name = "QUERIES")]
    queries: String,
    /// Column of the values in the table of points
    #[arg(long, value_name = "COLUMN")]
    values: String,
    /// Method of interpolation
    #[arg(long, value_name = "METHOD", default_value = "linear", value_parser = methods())]
    method: Method,
    #[arg(short, long, value_name = "FILE", default_value = "-", help = OUTPUT_CSV)]
    output: PathBuf,
}

/// Options of `septet alpha`.
#[derive(Debug, Args)]
#[command(after_help = "\
In space, the output is the boundary of the tetrahedra whose circumradius is at most R, counter-clockwise from outside. In the \
plane, it has the triangles. Some programs take one over the radius, or its square.

Examples:
  septet alpha scan.csv --radius 0.05 -o shape.off
  septet alpha outline.csv --radius 2 -o shape.off")]
pub struct AlphaArgs {
    #[command(flatten)]
    points: PointArgs,
    /// Radius of the largest empty balls, in the units of the points
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    radius: f64,
    /// Output file (.off), `-` for standard output
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
}

/// Returns a parser of the names of methods.
fn methods() -> impl TypedValueParser<Value = Method> {
    let method = |name: String| Method::ALL.into_iter().find(|method| method.name() == name);
    PossibleValuesParser::new(Method::ALL.map(Method::name))
        .try_map(move |name| method(name).ok_or("no method"))
}

/// Writes the cell of each query.
pub fn locate(args: &LocateArgs, talk: &Talk) -> Result<(), Failure> {
    let queries = Some(args.queries.as_str());
    let asked = Asked::of(args.points.asking(), queries, (&args.output, &["csv"]), talk)?;
    let cells = match (&asked.loaded.points, &asked.queries) {
        (Points::Plane(points), Points::Plane(queries)) => asked.made(points, talk)?.locate(queries),
        (Points::Space(points), Points::Space(queries)) => asked.made(points, talk)?.locate(queries),
        (Points::Higher(points), _) => return Err(only_space(points)),
        _ => return Err(asked.mixed(&args.queries)),
    };
    let inside = cells.iter().filter(|cell| **cell != NONE).count();
    let fields = cells.iter().map(|&cell| if cell == NONE { String::new() } else { cell.to_string() });
    let summary = format!("{}, {} inside of the hull", counted(cells.len() as u64, "query"), inside);
    write(&args.output, &table("simplex", fields), &summary, talk)
}

/// Writes the interpolated value of each query.
pub fn interpolate(args: &InterpolateArgs, talk: &Talk) -> Result<(), Failure> {
    let queries = Some(args.queries.as_str());
    let asked = Asked::of(
        Asking { has_values: true, ..args.points.asking() },
        queries,
        (&args.output, &["csv"]),
        talk,
    )?;
    let values = asked.values(&args.values)?;
    let method = args.method;
    let weights = match (&asked.loaded.points, &asked.queries) {
        (Points::Plane(points), Points::Plane(queries)) => asked.made(points, talk)?.weights(queries, method),
        (Points::Space(points), Points::Space(queries)) => asked.made(points, talk)?.weights(queries, method),
        (Points::Higher(points), _) => return Err(only_space(points)),
        _ => return Err(asked.mixed(&args.queries)),
    };
    let found = weights.interpolate(values).map_err(|error| asked.failure(&error))?;
    let inside = weights.offsets.windows(2).filter(|ends| ends[0] < ends[1]).count();
    let fields = found.iter().map(|x| if x.is_nan() { String::new() } else { format!("{x}") });
    let summary = format!("{}, {} inside of the hull", counted(found.len() as u64, "query"), inside);
    write(&args.output, &table("value", fields), &summary, talk)
}

/// Writes the boundary of the alpha shape, or its triangles in the plane.
pub fn alpha(args: &AlphaArgs, talk: &Talk) -> Result<(), Failure> {
    if args.radius.is_nan() || args.radius < 0.0 {
        let message = format!("--radius {}: a radius is 0 or more", args.radius);
        return Err(Failure::new(Code::Usage, message).help("give a length in the units of the points"));
    }
    let asked = Asked::of(args.points.asking(), None, (&args.output, &["off"]), talk)?;
    let failure = |error: QueryError| asked.failure(&error);
    let (triangles, volume) = match &asked.loaded.points {
        Points::Plane(points) => {
            let made = asked.made(points, talk)?;
            let shape = made.alpha_shape(args.radius).map_err(failure)?;
            let cells = made.cells().iter().zip(&shape.cells);
            (cells.filter(|(_, is_in)| **is_in).map(|(cell, _)| *cell).collect(), shape.volume)
        }
        Points::Space(points) => {
            let shape = asked.made(points, talk)?.alpha_shape(args.radius).map_err(failure)?;
            (shape.boundary, shape.volume)
        }
        Points::Higher(points) => return Err(only_space(points)),
    };
    let name = if asked.loaded.points.dimension() == 2 { "area" } else { "volume" };
    let summary = format!("{}, {name} {volume}", counted(triangles.len() as u64, "triangle"));
    write(&args.output, &surface(&asked.loaded.points, &triangles), &summary, talk)
}

/// The input of a command.
pub(super) struct Asked<'a> {
    asking: Asking<'a>,
    pub(super) loaded: Loaded,
    /// The queries; no points without a file of them.
    queries: Points,
}

impl<'a> Asked<'a> {
    /// Checks the files, and reads them. `output` is the output with the extensions that it can have.
    pub(super) fn of(
        asking: Asking<'a>,
        queries: Option<&str>,
        (output, extensions): (&Path, &[&str]),
        talk: &Talk,
    ) -> Result<Self, Failure> {
        check_extension(output, extensions)?;
        let spec = asking.given.spec()?;
        septet_core::cores::limit(spec.machine.thread_count());
        let input = Input::of(asking.points, spec.input.dimension, talk)?;
        check_reading(asking.given, input.is_sample())?;
        asking.weights.map_or(Ok(()), |weights| weights.check(asking.given, input.is_sample()))?;
        let of_queries: Option<Option<Request>> =
            queries.map(|queries| input::sample(queries, spec.input.dimension)).transpose()?;
        let mut inputs = input.files();
        inputs.extend(asking.weights.and_then(GivenWeights::file));
        if let (Some(queries), Some(None)) = (queries, &of_queries) {
            input::refuse_list(Path::new(queries), "queries are one file")?;
            if queries == "-" && asking.points == "-" {
                let message = "points and queries cannot both come from standard input";
                return Err(Failure::new(Code::Usage, message).help("give one of them as a file"));
            }
            inputs.push(Path::new(queries));
        }
        files::check(&inputs, &[], &[output])?;
        let weights = asking.weights.map(GivenWeights::reading);
        let options = ReadOptions { keep_columns: asking.has_values, weights, ..read_options(&spec.input)? };
        let loaded = input.load(&options, talk)?;
        let dimension = Some(loaded.points.dimension());
        let queries = match (queries, of_queries) {
            (_, Some(Some(request))) => input::make(&request, talk)?.points,
            (Some(name), _) => {
                let options = ReadOptions { dimension, keep_columns: false, ..options };
                input::open(name, &options, talk)?.points
            }
            (None, _) => Points::Plane(Vec::new()),
        };
        Ok(Asked { asking, loaded, queries })
    }

    /// Triangulates points, or points with weights.
    pub(super) fn run<C: Coordinates>(&self, points: &[C], talk: &Talk) -> Result<Outcome, Failure> {
        let spec = self.asking.given.spec()?.with(|spec| {
            spec.recursion.spacing = self.loaded.spacing;
            spec.control.cancel = Some(talk.cancel.clone());
            spec.control.progress = Some(talk.phases());
        });
        let run = triangulate(points, &spec).map_err(|error| {
            placed(error, &self.loaded.files, self.asking.points, |point| self.loaded.row(point))
        })?;
        talk.check();
        talk.stage("answering", 0, None);
        Ok(run)
    }

    /// Triangulates the points for queries.
    pub(super) fn made<P: Dimension + Coordinates>(
        &self,
        points: &[P],
        talk: &Talk,
    ) -> Result<Tessellation<P>, Failure> {
        let run = self.run(points, talk)?;
        Tessellation::new(points, &run).map_err(|error| self.failure(&error))
    }

    /// Returns the values of a column.
    fn values(&self, name: &str) -> Result<&[f64], Failure> {
        let columns = &self.loaded.columns;
        if let Some(column) = columns.iter().find(|column| column.name == name) {
            return Ok(&column.values);
        }
        let message = format!("{}: there is no column of values named {name}", self.asking.points);
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        Err(Failure::new(Code::Input, message).help(if names.is_empty() {
            "give a text table with other columns than the coordinates".to_owned()
        } else {
            format!("the other columns are {}", names.join(", "))
        }))
    }

    /// Returns the failure for an error of a query.
    pub(super) fn failure(&self, error: &QueryError) -> Failure {
        let name = self.asking.points;
        match error {
            QueryError::EmptyBox { .. } | QueryError::Radius => Failure::new(Code::Usage, error.to_string()),
            QueryError::OutsideBox { index } => {
                let message = format!("{name}: point {} lies outside of the box", self.loaded.row(*index));
                Failure::new(Code::Input, message).help("enlarge the box, or drop the point")
            }
            QueryError::TooMany { .. } => Failure::new(Code::Limit, format!("{name}: {error}")),
            _ => Failure::new(Code::Input, format!("{name}: {error}")),
        }
    }

    /// Returns the failure for queries with another number of coordinates.
    fn mixed(&self, queries: &str) -> Failure {
        let [own, other] = [self.loaded.points.dimension(), self.queries.dimension()];
        let message = format!("{queries}: queries have {other} coordinates, but points have {own}");
        Failure::new(Code::Input, message).help("give queries with as many coordinates as the points")
    }
}

/// Refuses an output with another extension.
fn check_extension(output: &Path, extensions: &[&str]) -> Result<(), Failure> {
    let own = output.extension().unwrap_or_default();
    if output.as_os_str() == "-" || extensions.iter().any(|extension| own == *extension) {
        return Ok(());
    }
    let known = extensions.join(" or .");
    let message = format!("{}: the output of this command is a .{known} file", output.display());
    Err(Failure::new(Code::Usage, message).help(format!("give it a name that ends in .{known}")))
}

/// Returns the failure for points of a dimension that has no queries.
pub(super) fn only_space(points: &HigherPoints) -> Failure {
    SpecError::OnlySpace { what: "queries", dimension: points.slice().dimension() }.into()
}

/// Formats a table of one field for each row.
pub(super) fn table(name: &str, fields: impl Iterator<Item = String>) -> String {
    let mut text = format!("row,{name}\n");
    for (row, field) in fields.enumerate() {
        let _ = writeln!(text, "{row},{field}");
    }
    text
}

/// Formats triangles and their vertices in the format OFF.
fn surface(points: &Points, triangles: &[[u32; 3]]) -> String {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut text = format!("OFF\n{} {} 0\n", used.len(), triangles.len());
    for &v in &used {
        let place = place_of(points, None, v as usize);
        let _ = writeln!(text, "{:?} {:?} {:?}", place.x, place.y, place.z);
    }
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| used.partition_point(|&other| other < v));
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

/// Writes the output, and prints what it is.
pub(super) fn write(output: &Path, text: &str, summary: &str, talk: &Talk) -> Result<(), Failure> {
    talk.check();
    files::write_text(output, text)?;
    talk.clear();
    talk.note(format!("septet: {summary}"));
    if output.as_os_str() != "-" {
        for line in written(&[output.to_owned()]) {
            talk.note(line);
        }
    }
    Ok(())
}
