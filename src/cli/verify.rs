//! `septet verify`.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::{DVec2, DVec3};
use septet_core::model::Points;
use septet_core::spec::{Commands, Periodic};
use septet_io::read::{CellFile, CellOptions, ListedFile, PointFile, ReadOptions, read_cells};
use septet_io::{Format, Role, extension};
use septet_lab::report::VerifyReport;
use septet_verify::{Fault, Report, Sites, Triangulation, VerifyOptions, verify};

use super::effects::{excludes, needs};
use super::errors::{Code, Failure};
use super::files;
use super::formats::{check_reading, read_options};
use super::given::Given;
use super::headings::INPUT;
use super::input::{self, Loaded};
use super::progress::Talk;
use super::text::counted;
use super::verify_box::PeriodicPart;
use super::weights::{GivenWeights, WeightArgs};

/// Options of `septet verify`.
#[derive(Debug, Args)]
#[command(after_help = "\
Levels: structure, orientation, manifold, hull, empty spheres, single cover. Together they prove that the cells are a \
Delaunay triangulation of the points. With weights, the level hidden sites follows, and they prove that the cells are the \
regular triangulation. The exit code is 4 if a level fails.

Examples:
  septet verify mesh.vtu
  septet verify mesh.pvtu
  septet verify points.node mesh.1.ele
  septet verify atoms.csv cells.npy --weights w
  septet verify gas.npy cells.npy --periodic 1,1,1 --offsets offsets.npy
  septet verify points.npy cells.npy --perturbed --json -")]
pub struct VerifyArgs {
    #[arg(help = points_help(), value_name = "MESH|POINTS")]
    points: String,
    #[arg(help = format!("Cells of these points: {}", Role::Cells.known()), value_name = "CELLS")]
    cells: Option<PathBuf>,
    #[command(flatten)]
    given: Given<{ Commands::VERIFY.bits() }>,
    #[command(flatten)]
    weights: WeightArgs,
    /// Offsets of the vertices of the cells in a periodic box
    ///
    /// The file is a .npy array of whole numbers, of the shape (cells, d + 1, d), as `septet triangulate` writes it. A vertex
    /// lies at its point plus the offset times the box.
    #[arg(long, value_name = "FILE", help_heading = INPUT, hide_short_help = true)]
    offsets: Option<PathBuf>,
    /// Require that ties are broken by the symbolic perturbation of septet
    #[arg(long)]
    perturbed: bool,
    /// Number of threads [default: cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// Write the report as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
}

/// Returns the help of the first file.
fn points_help() -> String {
    let whole: Vec<String> =
        Format::ALL.iter().filter(|format| format.holds_mesh()).map(|f| format!(".{}", f.name())).collect();
    format!(
        "File of points with their cells ({}), or points: any readable file, or \
         `sample:KIND:N[,d=2][,seed=7][,lipschitz=0.25][,ratio=1.3]`",
        whole.join(" ")
    )
}

impl VerifyArgs {
    /// Returns the file of the cells.
    fn mesh(&self) -> &Path {
        self.cells.as_deref().unwrap_or(Path::new(&self.points))
    }

    /// Returns the kind of the triangulation.
    fn kind(&self) -> &'static str {
        match (self.weights.given().is_some(), self.offsets.is_some()) {
            (false, false) => "Delaunay",
            (true, false) => "regular",
            (false, true) => "periodic Delaunay",
            (true, true) => "periodic regular",
        }
    }

    /// Returns the periodic box and the file of the offsets, if they are given.
    fn periodic(&self) -> Result<Option<(Periodic, &Path)>, Failure> {
        let given = self.given.options();
        let is_periodic = given.has("periodic");
        needs("--offsets", self.offsets.is_some(), "--periodic", is_periodic)?;
        excludes("--terrain", given.has("terrain"), "--periodic", is_periodic)?;
        let Some(periodic) = given.spec()?.input.periodic else { return Ok(None) };
        let Some(offsets) = &self.offsets else {
            let message = "--periodic needs the offsets of the vertices of the cells";
            return Err(Failure::new(Code::Usage, message).help("add --offsets FILE, or omit --periodic"));
        };
        if self.cells.is_none() {
            let message = "--periodic needs the points and the cells in two files";
            return Err(
                Failure::new(Code::Usage, message).help("name the file of the cells after the points")
            );
        }
        Ok(Some((periodic, offsets)))
    }

    /// Returns a clause with the points, if they are in another file.
    fn of_points(&self) -> String {
        self.cells.as_ref().map_or_else(|| "its points".to_owned(), |_| self.points.clone())
    }
}

/// Reads the triangulation, verifies it and prints a line per level.
pub fn run(args: &VerifyArgs, talk: &Talk) -> Result<(), Failure> {
    let inputs: Vec<&Path> = [Path::new(&args.points)].into_iter().chain(args.cells.as_deref()).collect();
    for input in &inputs {
        input::refuse_list(input, "a triangulation has one file of points and one file of cells")?;
    }
    let json: Vec<&Path> = args.json.as_deref().into_iter().collect();
    let weights = args.weights.given();
    let others = weights.and_then(GivenWeights::file).into_iter().chain(args.offsets.as_deref());
    let read: Vec<&Path> = inputs.into_iter().chain(others).collect();
    files::check(&read, &[], &json)?;
    let is_sample = input::sample(&args.points, None)?.is_some();
    check_reading(args.given.options(), is_sample)?;
    weights.map_or(Ok(()), |weights| weights.check(args.given.options(), is_sample))?;
    let periodic = args.periodic()?;
    if is_sample && args.cells.is_none() {
        let message = format!("{} has points and no cells", args.points);
        return Err(Failure::new(Code::Usage, message).help("name the file of the cells after it"));
    }
    let subject = subject(args, talk)?;
    let (points, cells) = (&subject.points, &subject.cells);
    let of_box = |given| PeriodicPart::of(given, (&subject.points, cells), (&args.points, talk));
    let periodic = periodic.map(of_box).transpose()?;
    let mesh = Triangulation {
        dimension: points.dimension(),
        coordinates: points.coordinates(),
        cells: &cells.cells,
    };
    let options = VerifyOptions {
        perturbed: args.perturbed,
        threads: args.threads.unwrap_or(0) as usize,
        any_order: true,
    };
    let weights_of_points = subject.weights.as_deref();
    let sites =
        Sites { mesh, weights: weights_of_points, periodic: periodic.as_ref().map(PeriodicPart::view) };
    let report = verify(sites, &options, &mut |stage, done, total| talk.stage(stage, done, Some(total)));
    talk.clear();
    if let Some(path) = &args.json {
        let json = VerifyReport {
            weights: weights.and_then(GivenWeights::weights),
            radii: weights.and_then(GivenWeights::radii),
            periodic: periodic.as_ref().map(PeriodicPart::report),
            ..VerifyReport::of(&report, &args.points, args.mesh())
        };
        let mut text = serde_json::to_string_pretty(&json)
            .map_err(|e| Failure::new(Code::Failed, format!("the report cannot be written: {e}")))?;
        text.push('\n');
        files::write_text(path, &text)?;
    }
    print(&report, args, &subject, talk);
    if report.passed() {
        return Ok(());
    }
    let message = format!(
        "{} is not a {} triangulation of {}{}",
        args.mesh().display(),
        args.kind(),
        args.of_points(),
        if args.perturbed { " with the symbolic perturbation of septet" } else { "" }
    );
    Err(Failure::new(Code::Rejected, message))
}

/// Reads the points and the cells, and returns them in the dimension of the cells.
fn subject(args: &VerifyArgs, talk: &Talk) -> Result<Subject, Failure> {
    let weights = args.weights.given().map(GivenWeights::reading);
    let reading = ReadOptions { weights, ..read_options(&args.given.options().spec()?.input)? };
    let Some(cells) = &args.cells else {
        return Subject::of_mesh(Path::new(&args.points), &reading, talk);
    };
    let loaded = match input::sample(&args.points, None)? {
        Some(request) => input::make(&request, talk)?,
        None => input::open(&args.points, &reading, talk)?,
    };
    if Format::of_path(cells) == Some(Format::Pvtu) {
        return Subject::of_pieces(args, cells, loaded, talk);
    }
    let is_node = extension(Path::new(&args.points)) == "node";
    let dimension = match &loaded.points {
        Points::Plane(_) => Some(2),
        Points::Space(_) => None,
        Points::Higher(points) => Some(points.slice().dimension()),
    };
    let options = CellOptions {
        base: is_node.then_some(loaded.first_id),
        point_count: Some(loaded.points.len() as u64),
        dimension,
        ..CellOptions::default()
    };
    let path = cells.clone();
    let file = input::watched(talk, move |progress| read_cells(&path, &options, progress))??;
    talk.check();
    let Loaded { points, weights, .. } = loaded;
    Subject { points, weights, cells: file, ids: None }.in_dimension(args, talk)
}

/// Points and cells to be verified.
struct Subject {
    points: Points,
    /// The weights of the points, if they have some.
    weights: Option<Vec<f64>>,
    cells: CellFile,
    /// The ids of the points, if they are not 0, 1, 2 and so on.
    ids: Option<Vec<u64>>,
}

impl Subject {
    /// Reads points and cells of one file.
    fn of_mesh(path: &Path, options: &ReadOptions, talk: &Talk) -> Result<Self, Failure> {
        let (mut points, cells) = input::open_mesh(path, options, talk)?;
        // Without cells, the file does not show its dimension. In space, flat points are right to have none.
        if cells.cells.is_empty()
            && let Some(plane) = flattened(&points.points)
        {
            talk.note("note: there are no cells and every z is 0, so the points are verified in the plane");
            points.points = plane;
        }
        let PointFile { points, weights, source_index: ids, .. } = points;
        let whole = Subject { points, weights, cells, ids };
        whole.in_dimension_of(&path.display().to_string(), path, talk)
    }

    /// Reads the cells of pieces, and compares the points of the pieces with the loaded points.
    fn of_pieces(args: &VerifyArgs, path: &Path, loaded: Loaded, talk: &Talk) -> Result<Self, Failure> {
        let (held, cells) = input::open_mesh(path, &ReadOptions::default(), talk)?;
        let own = Subject { points: held.points, weights: None, cells, ids: held.source_index };
        let mut positions = Vec::with_capacity(own.points.len());
        for point in 0..own.points.len() {
            let id = own.id(point as u64);
            let position = match &loaded.source_index {
                Some(rows) => rows.binary_search(&id).ok(),
                None => usize::try_from(id).ok().filter(|id| *id < loaded.points.len()),
            };
            let same = position.filter(|&position| {
                place_of(&own.points, None, point)
                    == place_of(&loaded.points, loaded.heights.as_deref(), position)
            });
            let Some(position) = same else {
                let piece = own.piece_of_point(point as u64).unwrap_or_else(|| path.display().to_string());
                let found = if position.is_some() { "has other coordinates" } else { "does not exist" };
                let message = format!("{piece}: its point with the id {id} {found} in {}", args.points);
                return Err(Failure::new(Code::Input, message).help("give the points of these pieces"));
            };
            positions.push(position as u64);
        }
        let mut cells = own.cells;
        for vertex in &mut cells.cells {
            *vertex = positions[*vertex as usize];
        }
        let Loaded { points, weights, .. } = loaded;
        Subject { points, weights, cells, ids: None }.in_dimension(args, talk)
    }

    /// Returns the points in the dimension of the cells, after printing the notes on the cells.
    fn in_dimension(self, args: &VerifyArgs, talk: &Talk) -> Result<Self, Failure> {
        self.in_dimension_of(&args.points, args.mesh(), talk)
    }

    fn in_dimension_of(self, points_file: &str, cells_file: &Path, talk: &Talk) -> Result<Self, Failure> {
        for note in &self.cells.notes {
            talk.note(format!("note: {note}"));
        }
        if self.cells.dimension != 2 || self.points.dimension() == 2 {
            return Ok(self);
        }
        let Some(points) = flattened(&self.points) else {
            let message = format!(
                "{} contains triangles, but the points of {points_file} have three coordinates",
                cells_file.display(),
            );
            return Err(Failure::new(Code::Input, message).help(
                "give a file of tetrahedra, add --terrain to use x and y alone, or give points with two coordinates; \
                 an .off file in space contains the hull only",
            ));
        };
        talk.note("note: the cells are triangles and every z is 0, so they are verified in the plane");
        Ok(Subject { points, ..self })
    }

    /// Returns the id of a point in the files of pieces.
    fn id(&self, point: u64) -> u64 {
        self.ids.as_ref().map_or(point, |ids| ids[point as usize])
    }

    /// Returns the piece of a cell, and the position of the cell in it.
    fn piece_of_cell(&self, cell: u64) -> Option<String> {
        let piece = ListedFile::of_row(&self.cells.pieces, cell)?;
        Some(format!("cell {cell} is cell {} of {}", cell - piece.first_row, input::name(&piece.path)))
    }

    /// Returns the first piece with a cell at this point.
    fn piece_of_point(&self, point: u64) -> Option<String> {
        let at = self.cells.cells.iter().position(|vertex| *vertex == point)?;
        let cell = (at / (self.cells.dimension + 1)) as u64;
        Some(input::name(&ListedFile::of_row(&self.cells.pieces, cell)?.path))
    }

    /// Returns the pieces of a fault and the ids of its points. Empty for other files than those of pieces.
    fn origin(&self, fault: &Fault) -> String {
        let (cells, points) = (fault.cells(), fault.points());
        let mut texts: Vec<String> = cells.iter().filter_map(|cell| self.piece_of_cell(*cell)).collect();
        if texts.is_empty() {
            let of = |point: &u64| Some(format!("point {point} is in {}", self.piece_of_point(*point)?));
            texts.extend(points.iter().filter_map(of));
        }
        if self.ids.is_some() {
            texts.extend(points.iter().map(|&point| format!("point {point} has the id {}", self.id(point))));
        }
        if texts.is_empty() { String::new() } else { format!(" ({})", texts.join(", ")) }
    }
}

/// Returns the place of a point in space. In the plane, z is its height, or 0 without heights.
pub fn place_of(points: &Points, heights: Option<&[f64]>, at: usize) -> DVec3 {
    match points {
        Points::Plane(points) => points[at].extend(heights.map_or(0.0, |heights| heights[at])),
        Points::Space(points) => points[at],
        Points::Higher(points) => {
            let dimension = points.slice().dimension();
            DVec3::from_slice(&points.coordinates()[at * dimension..])
        }
    }
}

/// Converts points in space to points in the plane if all have z = 0.
fn flattened(points: &Points) -> Option<Points> {
    match points {
        Points::Space(p) if p.iter().all(|p| p.z == 0.0) => {
            Some(Points::Plane(p.iter().map(|p| DVec2::new(p.x, p.y)).collect()))
        }
        _ => None,
    }
}

fn print(report: &Report, args: &VerifyArgs, subject: &Subject, talk: &Talk) {
    for level in &report.levels {
        let state = match (level.passed, level.stopped_by) {
            (true, _) => talk.paint("ok", "32"),
            (false, Some(earlier)) => format!("not checked, {earlier} failed"),
            (false, None) => talk.paint(&format!("FAILED, {}", counted(level.fault_count, "fault")), "1;31"),
        };
        talk.painted(format!("{:<14} {:>12} checked  {state}", level.name, level.checked));
        for fault in &level.faults {
            talk.note(format!("    {fault}{}", subject.origin(fault)));
        }
        let more = level.fault_count.saturating_sub(level.faults.len() as u64);
        if more > 0 {
            talk.note(format!("    and {more} more"));
        }
    }
    if report.passed() {
        let hidden = report.hidden.map(|hidden| format!(", {} hidden", counted(hidden, "point")));
        talk.note(format!(
            "septet: {} is a {} triangulation of {}: {}, {}, {}, {}, {}{}",
            args.mesh().display(),
            args.kind(),
            args.of_points(),
            counted(report.cells, "cell"),
            counted(report.points, "point"),
            counted(report.duplicates, "duplicate"),
            counted(report.hull_facets, "hull facet"),
            counted(report.ties, "tie"),
            hidden.unwrap_or_default()
        ));
    }
}
