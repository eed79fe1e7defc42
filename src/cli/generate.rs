//! `septet generate`.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Args;
use septet_core::generate::{Kind, Request};
use septet_core::spec::DEFAULT_SEED;
use septet_io::write::{OutputError, WriteOptions, check_points_output, write_points, write_points_to};
use septet_io::{Format, Role};

use super::errors::Failure;
use super::formats::listed;
use super::input;
use super::names::of_role;
use super::options::{dimension, kind};
use super::progress::Talk;
use super::summary::written;
use super::text::counted;
use septet_core::spec::count;

/// The help of the output.
const OUTPUT: &str = "Output file, `-` for standard output";

/// Options of `septet generate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Kinds: uniform, poisson, ball, sphere, grid, fcc, jittered, clusters, slab, line, moment-curve, shells; \
f-spaced sets with points on the boundary: well-spaced, graded, graded-line.

Examples:
  septet generate well-spaced -n 1e5 -o points.node
  septet generate graded -n 20000 -d 2 --lipschitz 0.3 -o points.npy
  septet generate uniform -n 1000 | septet triangulate - -o mesh.vtu")]
pub struct GenerateArgs {
    /// Kind of the set
    #[arg(value_parser = kind)]
    kind: Kind,
    /// Number of points; within 5 % for f-spaced kinds
    #[arg(short = 'n', long = "number", value_name = "N", value_parser = count)]
    number: u64,
    /// Dimension
    #[arg(short, long = "dimension", value_name = "2..6", default_value = "3", value_parser = dimension)]
    dimension: usize,
    /// Seed of the random draws
    #[arg(long, value_name = "S", default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Lipschitz constant of the spacing of a graded set, between 0 and 1 [default: 0.25]
    #[arg(long, value_name = "L")]
    lipschitz: Option<f64>,
    /// Ratio of consecutive radii of shells, above 1 [default: 1.3]
    #[arg(long, value_name = "R")]
    ratio: Option<f64>,
    #[arg(short, long, value_name = "FILE", default_value = "-", help = OUTPUT, long_help = listed(OUTPUT, Role::PointSet))]
    output: PathBuf,
    /// Format of the points, regardless of the file name; defaults to xyz for standard output
    #[arg(long, value_name = "NAME", value_parser = of_role(Role::PointSet))]
    format: Option<Format>,
}

/// Generates a point set and writes it.
pub fn run(args: &GenerateArgs, talk: &Talk) -> Result<(), Failure> {
    let options = WriteOptions { format: args.format, ..WriteOptions::default() };
    let format = check_points_output(&args.output, &options)?;
    let request = Request {
        kind: args.kind,
        n: args.number,
        dimension: args.dimension,
        seed: args.seed,
        lipschitz: args.lipschitz,
        ratio: args.ratio,
    };
    let made = input::make(&request, talk)?;
    let mut progress = |done: u64, total: u64| talk.stage("writing", done, Some(total));
    if args.output == Path::new("-") {
        let mut out = std::io::stdout().lock();
        match write_points_to(&mut out, format, &made.points, &options, &mut progress) {
            Err(OutputError::Stream { source }) if source.kind() == ErrorKind::BrokenPipe => {}
            written => written.map(drop)?,
        }
    } else {
        write_points(&args.output, &made.points, &options, &mut progress)?;
    }
    talk.clear();
    let number = counted(made.points.len() as u64, "point");
    talk.note(format!("septet: {number}, {} in {} dimensions", args.kind, args.dimension));
    if args.output != Path::new("-") {
        for line in written(std::slice::from_ref(&args.output)) {
            talk.note(line);
        }
    }
    Ok(())
}
