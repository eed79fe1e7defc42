//! Triangulates points that four processes hold, and compares the cells with those of one process. Threads replace the
//! processes here.
//!
//! `cargo run --release --example distributed`

use std::collections::BTreeSet;
use std::error::Error;
use std::thread;

use septet::distributed::{channels, triangulate};
use septet::generate::{generate, parse_sample};
use septet::result::Neighbour;
use septet::{Outcome, Points, Spec};

const PROCESSES: usize = 4;

/// The cells of a part, as sorted input indices.
fn cells(part: &Outcome) -> Vec<Vec<u64>> {
    let mut rows = Vec::new();
    for share in &part.shares {
        for cell in 0..share.cell_count() {
            let mut row: Vec<u64> = share.cell(cell).iter().map(|&v| share.ids[v as usize]).collect();
            row.sort_unstable();
            rows.push(row);
        }
    }
    rows
}

/// The number of facets of a part whose other cell belongs to another process.
fn facets_between(part: &Outcome, process: u32) -> usize {
    let of_others = |across| matches!(across, Some(Neighbour::Remote { rank, .. }) if part.placement.process_of(rank) != process);
    let facets = part.shares.iter().flat_map(|share| {
        let cells = 0..share.cell_count();
        cells.flat_map(move |cell| (0..=part.space).map(move |slot| share.neighbour(cell, slot)))
    });
    facets.filter(|&across| of_others(across)).count()
}

fn main() -> Result<(), Box<dyn Error>> {
    let sample = generate(&parse_sample("uniform:20000")?, &mut |_, _, _| {})?;
    let Points::Space(points) = &sample.points else { return Err("a sample in space".into()) };
    let at = |process: usize| points.len() * process / PROCESSES;

    let parts = thread::scope(|scope| {
        let start = |(process, mut transport)| {
            let own = &points[at(process)..at(process + 1)];
            let first_id = at(process) as u64;
            let run = move || triangulate(&mut transport, own, first_id, &Spec::default());
            scope.spawn(run)
        };
        let threads: Vec<_> =
            channels::<glam::DVec3>(PROCESSES as u32).into_iter().enumerate().map(start).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect::<Result<Vec<_>, _>>()
    })?;

    let mut all = BTreeSet::new();
    for (process, part) in (0..).zip(&parts) {
        let cells = cells(part);
        let points: usize = part.shares.iter().map(|share| share.owned).sum();
        let between = facets_between(part, process);
        println!("process {process}: {points} points, {} cells, {between} facets to others", cells.len());
        all.extend(cells);
    }
    println!(
        "all: {} points, {} cells, {} hull facets",
        parts[0].points.used,
        all.len(),
        parts[0].hull_facets
    );

    let whole = septet::triangulate(points, &Spec::default())?;
    let mut expected = BTreeSet::new();
    for cell in whole.cells().chunks_exact(4) {
        let mut row = cell.to_vec();
        row.sort_unstable();
        expected.insert(row);
    }
    if all != expected {
        return Err("the parts have other cells than the whole".into());
    }
    println!("one process computes the same cells");
    Ok(())
}
