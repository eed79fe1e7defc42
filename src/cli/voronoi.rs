//! `septet voronoi`: areas and volumes of the cells of Voronoi and power diagrams, and the cells themselves.

use std::fmt::{Debug, Write};
use std::path::PathBuf;

use clap::Args;
use septet_core::Spec;
use septet_core::model::Points;
use septet_core::spec::Commands;
use septet_geometry::coordinates::Coordinates;
use septet_geometry::point::Point;
use septet_geometry::site::Weighted;
use septet_queries::{Dimension, Polytope, Region, power_cells, power_volumes};

use super::errors::{Code, Failure};
use super::progress::Talk;
use super::queries::{Asked, Asking, PointArgs, only_space, table, write};
use super::text::counted;
use super::weights::WeightArgs;

/// Options of `septet voronoi`.
#[derive(Debug, Args)]
#[command(after_help = "\
The areas or volumes add up to that of the box. A point that coincides with an earlier one, or that weights hide, gets 0. With \
weights, the cells are those of the power diagram. A .vtu file has each cell as a polygon or polyhedron with its row and its volume.

Examples:
  septet voronoi points.csv --box 0,0,0,1,1,1 -o cells.csv
  septet voronoi galaxies.csv --periodic 100,100,100 -o cells.csv
  septet voronoi atoms.csv --radii r --box 0,0,0,20,20,20 -o cells.vtu
  septet voronoi sample:uniform:1e4,d=2 --box 0,0,1,1")]
pub struct VoronoiArgs {
    #[command(flatten)]
    points: PointArgs<{ Commands::QUERIES.and(Commands::VORONOI).bits() }>,
    #[command(flatten)]
    weights: WeightArgs,
    /// Lower and upper corner of the box, which contains all points
    #[arg(
        long = "box",
        value_name = "X0,Y0[,Z0],X1,Y1[,Z1]",
        allow_hyphen_values = true,
        value_delimiter = ','
    )]
    corners: Option<Vec<f64>>,
    /// Output table (.csv) or cells (.vtu), `-` for a table on standard output
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
}

/// Writes the area or volume of each cell, or the cells.
pub fn voronoi(args: &VoronoiArgs, talk: &Talk) -> Result<(), Failure> {
    let asking = Asking { weights: args.weights.given(), ..args.points.asking() };
    let spec = asking.given.spec()?;
    check_box(&spec, args.corners.as_deref())?;
    let asked = Asked::of(asking, None, (&args.output, &["csv", "vtu"]), talk)?;
    match &asked.loaded.points {
        Points::Plane(points) => answer(args, (&asked, &spec), points, talk),
        Points::Space(points) => answer(args, (&asked, &spec), points, talk),
        Points::Higher(points) => Err(only_space(points)),
    }
}

/// Refuses a box that is missing, or that a periodic box replaces.
fn check_box(spec: &Spec, corners: Option<&[f64]>) -> Result<(), Failure> {
    let lengths = spec.input.periodic.as_ref().map(|periodic| &periodic.lengths);
    let usage = |message: &str, help: &str| Err(Failure::new(Code::Usage, message).help(help));
    match (lengths, corners) {
        (None, None) => usage("the cells need a box", "add --box with its lower and its upper corner"),
        (Some(lengths), Some(_)) if lengths.iter().all(Option::is_some) => {
            usage("--box contradicts --periodic, whose box has no boundary", "omit --box")
        }
        (Some(lengths), None) if lengths.iter().any(Option::is_none) => usage(
            "the cells need a box along the axes that are not periodic",
            "add --box; along a periodic axis, its ends are not used",
        ),
        _ => Ok(()),
    }
}

/// Answers for points of a dimension.
fn answer<P: Dimension + Coordinates>(
    args: &VoronoiArgs,
    (asked, spec): (&Asked<'_>, &Spec),
    points: &[P],
    talk: &Talk,
) -> Result<(), Failure>
where
    Weighted<P>: Coordinates,
{
    let corners = args.corners.as_deref().map(|corners| between::<P>(corners)).transpose()?;
    let (is_table, weights) = (args.output.extension().is_none_or(|own| own != "vtu"), &asked.loaded.weights);
    let failure = |error| asked.failure(&error);
    let periodic = spec.input.periodic.as_ref();
    if let (true, None, None, Some((low, high))) = (is_table, weights, periodic, corners) {
        let volumes = asked.made(points, talk)?.voronoi_volumes_in(low, high).map_err(failure)?;
        return write_volumes::<P>(args, &volumes, talk);
    }
    let weight = |at: usize| weights.as_ref().map_or(0.0, |weights| weights[at]);
    let sites = points.iter().enumerate().map(|(at, &point)| Weighted::new(point, weight(at)));
    let sites: Vec<Weighted<P>> = sites.collect();
    let run = asked.run(&sites, talk)?;
    let region = match (periodic, corners) {
        (Some(periodic), None) => Region::of_periods(periodic),
        (Some(periodic), Some((low, high))) => Region::of_periods(periodic).between(low, high),
        (None, Some((low, high))) => Region::of_box(low, high),
        (None, None) => Region::of_box(P::default(), P::default()),
    };
    let volumes = power_volumes(&sites, &run, region).map_err(failure)?;
    if is_table {
        return write_volumes::<P>(args, &volumes, talk);
    }
    let cells = power_cells(&sites, &run, region).map_err(failure)?;
    let rows: Vec<usize> = (0..cells.len()).filter(|&row| !cells[row].corners.is_empty()).collect();
    let text = polytopes(&cells, &rows, &volumes);
    write(&args.output, &text, &summary::<P>(rows.len(), &volumes), talk)
}

/// Returns the corners of the box.
fn between<P: Point>(corners: &[f64]) -> Result<(P, P), Failure> {
    if corners.len() != 2 * P::DIM {
        let message = format!("--box has {} numbers, but the points need {}", corners.len(), 2 * P::DIM);
        return Err(Failure::new(Code::Usage, message).help("give the lower corner, then the upper corner"));
    }
    let (low, high) = corners.split_at(P::DIM);
    Ok((P::from_coords(low), P::from_coords(high)))
}

fn summary<P: Point>(cells: usize, volumes: &[f64]) -> String {
    let name = if P::DIM == 2 { "area" } else { "volume" };
    format!("{}, {name} {}", counted(cells as u64, "cell"), volumes.iter().sum::<f64>())
}

fn write_volumes<P: Point>(args: &VoronoiArgs, volumes: &[f64], talk: &Talk) -> Result<(), Failure> {
    let text = table("volume", volumes.iter().map(f64::to_string));
    write(&args.output, &text, &summary::<P>(volumes.len(), volumes), talk)
}

/// Formats the cells of some rows as a VTK unstructured grid of polygons (type 7) or polyhedra (type 42).
fn polytopes<P: Point>(cells: &[Polytope<P>], rows: &[usize], volumes: &[f64]) -> String {
    let is_plane = P::DIM == 2;
    let mut points = String::new();
    let (mut corners, mut ends) = (Vec::new(), Vec::new());
    let (mut faces, mut face_ends) = (Vec::new(), Vec::new());
    let mut first = 0;
    for &row in rows {
        let cell = &cells[row];
        for corner in &cell.corners {
            let z = if is_plane { 0.0 } else { corner.coord(2) };
            let _ = writeln!(points, "{:?} {:?} {z:?}", corner.coord(0), corner.coord(1));
        }
        faces.push(cell.faces.len());
        for face in &cell.faces {
            faces.push(face.len());
            faces.extend(face.iter().map(|&corner| first + corner as usize));
        }
        corners.extend(first..first + cell.corners.len());
        first += cell.corners.len();
        ends.push(first);
        face_ends.push(faces.len());
    }
    let array = |kind: &str, name: &str, text: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">\n{text}\n</DataArray>\n")
    };
    let kind = if is_plane { 7 } else { 42 };
    let mut grid =
        array("Int64", "connectivity", &listed(&corners)) + &array("Int64", "offsets", &listed(&ends));
    grid += &array("UInt8", "types", &listed(&vec![kind; rows.len()]));
    if !is_plane {
        grid += &array("Int64", "faces", &listed(&faces));
        grid += &array("Int64", "faceoffsets", &listed(&face_ends));
    }
    let place = "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\"";
    let measures: Vec<f64> = rows.iter().map(|&row| volumes[row]).collect();
    let data = array("Int64", "row", &listed(rows)) + &array("Float64", "volume", &listed(&measures));
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"{first}\" NumberOfCells=\"{}\">\n\
         <Points>\n<DataArray {place}>\n{points}</DataArray>\n</Points>\n<Cells>\n{grid}</Cells>\n\
         <CellData>\n{data}</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
        rows.len()
    )
}

/// Formats numbers with blanks between them.
fn listed<T: Debug>(numbers: &[T]) -> String {
    numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(" ")
}
