//! Triangulates a generated set and writes it for ParaView.
//!
//! `cargo run --release --example triangulate -- mesh.vtu`

use std::error::Error;
use std::path::PathBuf;

use septet::generate::{generate, parse_sample};
use septet::io::write::{WriteOptions, write};
use septet::{Points, Spec};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("mesh.vtu"), PathBuf::from);
    let sample = generate(&parse_sample("uniform:1000")?, &mut |_, _, _| {})?;
    let Points::Space(points) = &sample.points else { return Err("a sample in space".into()) };

    let run = septet::triangulate(points, &Spec::default())?;
    println!("{} tetrahedra, {} hull facets", run.cell_count(), run.hull_facets);

    let view = run.view(sample.points.coordinates());
    write(&path, &view, &WriteOptions::default(), &mut |_, _| {})?;
    println!("wrote {}", path.display());
    Ok(())
}
