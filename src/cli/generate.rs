//! `septet generate`.

use std::path::{Path, PathBuf};

use clap::Args;
use septet_core::generate::{Kind, Request};
use septet_io::write::{PointFormat, WriteOptions, check_points_output, write_points, write_points_to};

use super::errors::Failure;
use super::formats::point_format;
use super::input;
use super::options::{count, dimension, kind};
use super::progress::Talk;

/// Options of `septet generate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Kinds: uniform, poisson, ball, sphere, grid, fcc, jittered, clusters, slab, line, moment-curve;
f-spaced, with boundary: well-spaced, graded, graded-line.

Examples:
  septet generate well-spaced -n 1e5 -o points.node
  septet generate graded -n 20000 -d 2 --lipschitz 0.3 --seed 7 -o points.npy
  septet generate uniform -n 1000 | septet triangulate - -o mesh.vtu")]
pub struct GenerateArgs {
    /// The kind of set
    #[arg(value_parser = kind)]
    kind: Kind,
    /// Number of points; the f-spaced kinds meet it within 5 %
    #[arg(short = 'n', long = "number", value_name = "N", value_parser = count)]
    number: u64,
    /// Dimension
    #[arg(short, long = "dimension", value_name = "2|3", default_value = "3", value_parser = dimension)]
    dimension: usize,
    /// Seed of all draws
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// How fast the spacing of a graded set may grow, between 0 and 1 [default: 0.25]
    #[arg(long, value_name = "L")]
    lipschitz: Option<f64>,
    /// The file (.node .xyz .txt .csv .npy .off .ply .vtu .vtk .obj, each also .gz), `-` for standard output
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// Format of the points, whatever the name of the file [default: by its ending; xyz for standard output]
    #[arg(long, value_name = "NAME", value_parser = point_format)]
    format: Option<PointFormat>,
}

/// Generates and writes.
pub fn run(args: &GenerateArgs, talk: &Talk) -> Result<(), Failure> {
    let options = WriteOptions { point_format: args.format, ..WriteOptions::default() };
    let format = check_points_output(&args.output, &options)?;
    let request = Request {
        kind: args.kind,
        n: args.number,
        dimension: args.dimension,
        seed: args.seed,
        lipschitz: args.lipschitz,
    };
    let made = input::make(&request, talk)?;
    let mut progress = |done: u64, total: u64| talk.stage("writing", done, Some(total));
    if args.output == Path::new("-") {
        let mut out = std::io::stdout().lock();
        write_points_to(&mut out, format, &made.points, &options, &mut progress)?;
    } else {
        write_points(&args.output, &made.points, &options, &mut progress)?;
    }
    talk.clear();
    let number = made.points.len();
    talk.note(format!("septet: {number} points, {} in {} dimensions", args.kind, args.dimension));
    if args.output != Path::new("-") {
        talk.note(format!("  wrote {}", args.output.display()));
    }
    Ok(())
}
