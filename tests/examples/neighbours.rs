//! Walks from cell to cell, and collects the neighbours of every point.

use std::collections::BTreeSet;
use std::error::Error;

use septet::generate::{generate, parse_sample};
use septet::result::Neighbour;
use septet::{Points, Spec};

fn main() -> Result<(), Box<dyn Error>> {
    let sample = generate(&parse_sample("uniform:500")?, &mut |_, _, _| {})?;
    let Points::Space(points) = &sample.points else { return Err("a sample in space".into()) };
    let run = septet::triangulate(points, &Spec::default())?;

    // Rows of four input indices: two vertices of a cell are neighbours.
    let mut neighbours = vec![BTreeSet::<u64>::new(); points.len()];
    for cell in run.cells().chunks_exact(4) {
        for &a in cell {
            neighbours[a as usize].extend(cell.iter().filter(|&&b| b != a));
        }
    }
    let degrees: usize = neighbours.iter().map(BTreeSet::len).sum();
    println!("mean degree {:.2}", degrees as f64 / points.len() as f64);

    // The adjacency of cells: each worker's share has its own cells.
    let mut facets = 0;
    for share in &run.shares {
        for cell in 0..share.cell_count() {
            facets += (0..4).filter(|&slot| share.neighbour(cell, slot) == Some(Neighbour::Hull)).count();
        }
    }
    assert_eq!(facets as u64, run.hull_facets);
    println!("{facets} facets without a cell on the other side: the hull");
    Ok(())
}
