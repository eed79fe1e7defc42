//! Verifies a triangulation by any program, with its points and cells in two files.
//!
//! `cargo run --release --example verify -- points.node cells.ele`

use std::error::Error;
use std::path::PathBuf;

use septet::Spec;
use septet::generate::{generate, parse_sample};
use septet::io::read::{CellOptions, ReadOptions, read, read_cells};
use septet::io::write::{WriteOptions, write};
use septet::verify::{Triangulation, VerifyOptions, verify};

fn main() -> Result<(), Box<dyn Error>> {
    let mut files = std::env::args().skip(1).map(PathBuf::from);
    let (points, cells) = match (files.next(), files.next()) {
        (Some(points), Some(cells)) => (points, cells),
        _ => sample_files()?,
    };
    let points = read(&points, &ReadOptions::default(), &mut |_, _| {})?.points;
    let cells = read_cells(&cells, &CellOptions::default(), &mut |_, _| {})?;
    let mesh = Triangulation {
        dimension: points.dimension(),
        coordinates: points.coordinates(),
        cells: &cells.cells,
    };
    let report = verify(&mesh, &VerifyOptions::default(), &mut |_, _, _| {});
    for level in &report.levels {
        println!("{}: {} checked, {} faults", level.name, level.checked, level.fault_count);
    }
    if report.passed() { Ok(()) } else { Err("this is not a Delaunay triangulation of the points".into()) }
}

/// Writes files to verify, for a call without arguments.
fn sample_files() -> Result<(PathBuf, PathBuf), Box<dyn Error>> {
    let sample = generate(&parse_sample("uniform:300")?, &mut |_, _, _| {})?;
    let septet::Points::Space(points) = &sample.points else { return Err("a sample in space".into()) };
    let run = septet::triangulate(points, &Spec::default())?;
    let folder = std::env::temp_dir();
    let (node, ele) = (folder.join("septet-example.node"), folder.join("septet-example.ele"));
    write(&ele, &run.view(sample.points.coordinates()), &WriteOptions::default(), &mut |_, _| {})?;
    Ok((node, ele))
}
