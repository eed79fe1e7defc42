//! `septet verify`.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec2;
use septet_core::model::Points;
use septet_core::spec::Commands;
use septet_io::read::{CellFile, CellOptions, read_cells};
use septet_io::{Role, extension};
use septet_lab::report::VerifyReport;
use septet_verify::{Report, Triangulation, VerifyOptions, verify};

use super::errors::{Code, Failure};
use super::files;
use super::formats::{check_reading, read_options};
use super::given::Given;
use super::input::{self, Loaded};
use super::progress::Talk;
use super::text::counted;

/// Options of `septet verify`.
#[derive(Debug, Args)]
#[command(after_help = "\
Levels: structure, orientation, manifold, hull, empty spheres, single cover. Together they prove that the cells are a \
Delaunay triangulation of the points. The exit code is 4 if a level fails.

Examples:
  septet verify points.node mesh.1.ele
  septet verify mesh.vtu mesh.vtu
  septet verify points.npy cells.npy --perturbed --json -")]
pub struct VerifyArgs {
    /// Points: any readable file, or `sample:KIND:N[,d=2][,seed=7][,lipschitz=0.25][,ratio=1.3]`
    points: String,
    #[arg(help = format!("Cells: {}", Role::Cells.known()))]
    cells: PathBuf,
    #[command(flatten)]
    given: Given<{ Commands::VERIFY.bits() }>,
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

/// Reads the triangulation, verifies it and prints a line per level.
pub fn run(args: &VerifyArgs, talk: &Talk) -> Result<(), Failure> {
    let inputs = [Path::new(&args.points), &args.cells];
    for input in inputs {
        input::refuse_list(input, "a triangulation has one file of points and one file of cells")?;
    }
    let json: Vec<&Path> = args.json.as_deref().into_iter().collect();
    files::check(&inputs, &[], &json)?;
    let sample = input::sample(&args.points, None)?;
    check_reading(args.given.options(), sample.is_some())?;
    let loaded = match sample {
        Some(request) => input::make(&request, talk)?,
        None => input::open(&args.points, &read_options(&args.given.options().spec()?.input)?, talk)?,
    };
    let (points, cells) = matched(args, loaded, talk)?;
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
    let report = verify(&mesh, &options, &mut |stage, done, total| talk.stage(stage, done, Some(total)));
    talk.clear();
    if let Some(path) = &args.json {
        let json = VerifyReport::of(&report, &args.points, &args.cells);
        let mut text = serde_json::to_string_pretty(&json)
            .map_err(|e| Failure::new(Code::Failed, format!("the report cannot be written: {e}")))?;
        text.push('\n');
        files::write_text(path, &text)?;
    }
    print(&report, args, talk);
    if report.passed() {
        return Ok(());
    }
    let message = format!(
        "{} is not a Delaunay triangulation of {}{}",
        args.cells.display(),
        args.points,
        if args.perturbed { " with the symbolic perturbation of septet" } else { "" }
    );
    Err(Failure::new(Code::Rejected, message))
}

/// Reads the cells, and returns them with the points in the dimension of the cells.
fn matched(args: &VerifyArgs, loaded: Loaded, talk: &Talk) -> Result<(Points, CellFile), Failure> {
    let is_node = extension(Path::new(&args.points)) == "node";
    let flat = flattened(&loaded.points);
    let dimension = match (&loaded.points, &flat) {
        (Points::Plane(_), _) => Some(2),
        _ => None,
    };
    let options = CellOptions {
        base: is_node.then_some(loaded.first_id),
        point_count: Some(loaded.points.len() as u64),
        dimension,
        ..CellOptions::default()
    };
    let mut progress = |read, total| talk.stage("reading cells", read, total);
    let cells = read_cells(&args.cells, &options, &mut progress)?;
    talk.check();
    for note in &cells.notes {
        talk.note(format!("note: {note}"));
    }
    let points = match (cells.dimension, flat) {
        (2, Some(flat)) => {
            talk.note("note: the cells are triangles and every z is 0, so they are verified in the plane");
            flat
        }
        (2, None) if loaded.points.dimension() == 3 => {
            let message = format!(
                "{} contains triangles, but the points of {} have three coordinates",
                args.cells.display(),
                args.points
            );
            return Err(Failure::new(Code::Input, message).help(
                "give a file of tetrahedra, add --terrain to use x and y alone, or give points with two coordinates; \
                 an .off file in space contains the hull only",
            ));
        }
        _ => loaded.points,
    };
    Ok((points, cells))
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

fn print(report: &Report, args: &VerifyArgs, talk: &Talk) {
    for level in &report.levels {
        let state = match (level.passed, level.stopped_by) {
            (true, _) => talk.paint("ok", "32"),
            (false, Some(earlier)) => format!("not checked, {earlier} failed"),
            (false, None) => talk.paint(&format!("FAILED, {}", counted(level.fault_count, "fault")), "1;31"),
        };
        talk.painted(format!("{:<14} {:>12} checked  {state}", level.name, level.checked));
        for fault in &level.faults {
            talk.note(format!("    {fault}"));
        }
        let more = level.fault_count.saturating_sub(level.faults.len() as u64);
        if more > 0 {
            talk.note(format!("    and {more} more"));
        }
    }
    if report.passed() {
        talk.note(format!(
            "septet: {} is a Delaunay triangulation of {}: {}, {}, {}, {}, {}",
            args.cells.display(),
            args.points,
            counted(report.cells, "cell"),
            counted(report.points, "point"),
            counted(report.duplicates, "duplicate"),
            counted(report.hull_facets, "hull facet"),
            counted(report.ties, "tie")
        ));
    }
}
