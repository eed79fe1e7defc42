//! Four to six dimensions: brute-force triangulations pass, altered ones are refused, and signs are exact.

use std::array::from_fn;
use std::cmp::Ordering;

use super::fixtures::{Mesh, Numbers, PERTURBED, brute, integers, turn};
use super::weights::ANY_ORDER;
use crate::predicates::{in_sphere, orientation};
use crate::{Fault, VerifyOptions};

/// Draws points: in general position, on a small grid, with repetitions, or at many scales.
fn points<const D: usize>(kind: u64, numbers: &mut Numbers) -> Vec<[f64; D]> {
    let count = D + 2 + numbers.below(if D == 4 { 4 } else { 3 }) as usize;
    match kind % 4 {
        0 => numbers.points(count, 1000),
        1 => numbers.points(count, 2),
        2 => {
            let mut points = numbers.points(count - 1, 3);
            points.push(points[0]);
            points
        }
        _ => (0..count)
            .map(|_| from_fn(|_| numbers.below(9) as f64 * 0.1 * 2f64.powi(numbers.below(40) as i32 - 20)))
            .collect(),
    }
}

/// Returns one alteration of a triangulation, and its name.
fn altered<const D: usize>(mesh: &Mesh, points: &[[f64; D]], numbers: &mut Numbers) -> (&'static str, Mesh) {
    let count = (mesh.cells.len() / (D + 1)) as u64;
    let row = |numbers: &mut Numbers| numbers.below(count) as usize * (D + 1);
    let (at, from) = (row(numbers), row(numbers));
    let point = numbers.below(points.len() as u64) as usize;
    let mut other = mesh.clone();
    let what = match numbers.below(5) {
        0 => {
            other.cells.drain(at..=at + D);
            "missing"
        }
        1 => {
            let mut twice = mesh.cells[at..=at + D].to_vec();
            twice.rotate_left(numbers.below(D as u64 + 1) as usize);
            other.cells.extend(twice);
            "twice"
        }
        2 => {
            other.cells[at + numbers.below(D as u64 + 1) as usize] = point as u64;
            "vertex replaced"
        }
        3 => {
            other.cells[at..=at + D].copy_from_slice(&mesh.cells[from..=from + D]);
            "replaced"
        }
        _ => {
            // The cells of a set with another point.
            let mut moved = points.to_vec();
            moved[point] = from_fn(|axis| moved[point][axis] + numbers.below(3) as f64 - 1.0);
            other.cells = brute(&moved).cells;
            "moved"
        }
    };
    (what, other)
}

/// Returns the numbers of triangulations, of alterations without effect, and of refused ones.
fn alterations<const D: usize>(sets: u64, times: usize) -> [u32; 3] {
    let mut counts = [0; 3];
    for i in 0..sets {
        let mut numbers = Numbers(8100 + 100 * D as u64 + i);
        let points = points::<D>(i, &mut numbers);
        let mesh = brute(&points);
        for options in [PERTURBED, VerifyOptions::default()] {
            let report = mesh.verify(options);
            assert!(report.passed(), "{mesh:?} {report:?}");
        }
        counts[0] += 1;
        if mesh.cells.is_empty() {
            assert!(mesh.verify(PERTURBED).dimension_of_points < D as i32);
            continue;
        }
        for _ in 0..times {
            let (what, other) = altered(&mesh, &points, &mut numbers);
            let good = other.as_set() == mesh.as_set();
            let report = other.verify(ANY_ORDER);
            assert_eq!(report.passed(), good, "{what}: {other:?} {report:?}");
            assert!(other.verify(VerifyOptions::default()).passed() >= good, "{what}");
            counts[if good { 1 } else { 2 }] += 1;
        }
    }
    counts
}

#[test]
fn only_the_canonical_triangulation_passes() {
    let scale = std::env::var("SEPTET_SETS").map_or(1, |n| n.parse().unwrap());
    let counts =
        [alterations::<4>(24 * scale, 12), alterations::<5>(12 * scale, 12), alterations::<6>(4 * scale, 12)];
    println!("{counts:?} valid, altered without effect, refused");
    assert!(counts.iter().all(|[_, _, refused]| *refused > 20), "{counts:?}");
}

#[test]
fn flat_and_wrong_arrays_have_their_faults() {
    // All points have equal last coordinates.
    let mut numbers = Numbers(8001);
    let mut flat: Vec<[f64; 5]> = numbers.points(9, 50);
    for point in &mut flat {
        point[4] = 0.1;
    }
    let mesh = brute(&flat);
    assert!(mesh.cells.is_empty() && mesh.verify(PERTURBED).passed());
    assert_eq!(mesh.verify(PERTURBED).dimension_of_points, 4);
    flat[3][4] = 0.2;
    let mesh = Mesh { cells: Vec::new(), ..brute(&flat) };
    assert_eq!(mesh.fault("structure"), Fault::NoCells);
    for dimension in [1, 7] {
        let mesh = Mesh { dimension, coordinates: vec![0.0; 14], cells: Vec::new(), weights: None };
        assert!(matches!(mesh.fault("structure"), Fault::Shape { .. }));
    }
    let mesh =
        Mesh { dimension: 4, coordinates: vec![0.0; 8], cells: Vec::new(), weights: Some(vec![0.0; 2]) };
    assert!(matches!(mesh.fault("structure"), Fault::Shape { .. }));
}

/// Compares signs of nearly degenerate cells with those of integers.
fn signs<const D: usize, const N: usize>(rounds: usize, counts: &mut [u32; 3]) {
    let mut numbers = Numbers(8200 + D as u64);
    for _ in 0..rounds {
        let unit = [1.0, 0.1, 1e-130, 2f64.powi(-100), 5e-324][numbers.below(5) as usize];
        let mut point = || -> [f64; D] {
            from_fn(|_| {
                let x = numbers.below(2) as f64 * unit;
                match numbers.below(30) {
                    0 => x.next_up(),
                    1 => x + unit * 2f64.powi(-40),
                    _ => x,
                }
            })
        };
        let (mut cell, query): ([[f64; D]; N], _) = (from_fn(|_| point()), point());
        let all: Vec<[f64; D]> = cell.iter().copied().chain([query]).collect();
        let lifted = integers(&all, &vec![0.0; N + 1]);
        let rows: Vec<_> = lifted.iter().collect();
        let sign = turn(&rows[..N], D);
        assert_eq!(orientation(&cell), sign, "{all:?}");
        if sign == Ordering::Less {
            cell.swap(0, 1);
        }
        let inside = turn(&rows, D + 1).reverse();
        let inside = if sign == Ordering::Less { inside.reverse() } else { inside };
        assert_eq!(in_sphere(&cell, &query), inside, "{all:?}");
        counts[(inside as i8 + 1) as usize] += 1;
    }
}

#[test]
fn signs_are_exact() {
    let mut counts = [0; 3];
    signs::<4, 5>(2000, &mut counts);
    signs::<5, 6>(400, &mut counts);
    signs::<6, 7>(60, &mut counts);
    assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
}
