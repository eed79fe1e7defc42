//! Timings, to be run by hand in release: `cargo test --release -p septet --lib verify:: -- --ignored`.

use std::time::Instant;

use super::fixtures::{Mesh, Numbers, canonical_lattice, kuhn};
use crate::verify::{Report, VerifyOptions, verify};

fn timed(name: &str, mesh: &Mesh, perturbed: bool) -> Report {
    let options = VerifyOptions { perturbed, any_order: true, threads: 2 };
    let start = Instant::now();
    let mut stage = (String::new(), start);
    let mut stages = Vec::new();
    let report = verify(&mesh.view(), &options, &mut |name, _, _| {
        if name != stage.0 {
            stage = (name.to_owned(), Instant::now());
            stages.push((stage.0.clone(), start.elapsed()));
        }
    });
    let counts: Vec<u64> = report.levels.iter().map(|level| level.fault_count).collect();
    eprintln!(
        "{name}: {} points, {} cells, {} ties, {:.2?}; faults {counts:?}; stages {stages:.2?}",
        report.points,
        report.cells,
        report.ties,
        start.elapsed()
    );
    report
}

fn side() -> usize {
    std::env::var("SEPTET_SIDE").ok().and_then(|side| side.parse().ok()).unwrap_or(60)
}

#[test]
#[ignore = "a timing"]
fn lattice() {
    let side = side();
    assert!(timed("lattice", &kuhn(side, |p| p), false).passed());
    assert!(timed("canonical lattice", &canonical_lattice(side), true).passed());
}

#[test]
#[ignore = "a timing"]
fn decimal_lattice() {
    timed("lattice of tenths", &kuhn(side(), |p| p.map(|x| 0.1 * x)), false);
    timed("lattice at 1e-120", &kuhn(side(), |p| p.map(|x| x * 2f64.powi(-398))), false);
}

#[test]
#[ignore = "a timing"]
fn jittered_lattice() {
    let mut numbers = Numbers(1);
    let mesh = kuhn(side(), |p| p.map(|x| x + (numbers.next() >> 12) as f64 * 2f64.powi(-56)));
    timed("jittered lattice", &mesh, true);
}

/// Points renumbered and cells reordered at random: no locality left.
#[test]
#[ignore = "a timing"]
fn shuffled_lattice() {
    let mut numbers = Numbers(2);
    let mut permutation = |n: usize| {
        let mut order: Vec<u64> = (0..n as u64).collect();
        for i in (1..n).rev() {
            order.swap(i, numbers.below(i as u64 + 1) as usize);
        }
        order
    };
    let mesh = canonical_lattice(side());
    let (points, cells) = (permutation(mesh.coordinates.len() / 3), permutation(mesh.cells.len() / 4));
    let mut shuffled = mesh.clone();
    for (i, p) in mesh.coordinates.chunks_exact(3).enumerate() {
        let at = 3 * points[i] as usize;
        shuffled.coordinates[at..at + 3].copy_from_slice(p);
    }
    for (i, row) in mesh.cells.chunks_exact(4).enumerate() {
        let at = 4 * cells[i] as usize;
        let row: Vec<u64> = row.iter().map(|&v| points[v as usize]).collect();
        shuffled.cells[at..at + 4].copy_from_slice(&row);
    }
    assert!(timed("shuffled lattice", &shuffled, true).passed());
}
