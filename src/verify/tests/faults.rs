//! The verifier rejects every planted fault at the level that defines it.

use super::fixtures::{Mesh, Numbers, brute, failed, kuhn};
use crate::{Fault, VerifyOptions};

fn plane() -> Mesh {
    brute(&Numbers(10).points::<2>(12, 1000))
}

fn space() -> Mesh {
    brute(&Numbers(11).points::<3>(11, 1000))
}

/// A mesh of the plane and one of space, with their numbers of vertices per cell.
fn both() -> [(Mesh, usize); 2] {
    [(plane(), 3), (space(), 4)]
}

/// Returns the mesh without a cell.
fn without(mesh: &Mesh, cell: usize) -> Mesh {
    let n = mesh.dimension + 1;
    let mut less = mesh.clone();
    less.cells.drain(cell * n..(cell + 1) * n);
    less
}

#[test]
fn structure() {
    for (mesh, n) in both() {
        assert_eq!(mesh.failed(), [""; 0]);
        let mut range = mesh.clone();
        range.cells[n + 1] = 12;
        assert_eq!(range.failed(), ["structure"]);
        assert_eq!(range.fault("structure"), Fault::OutOfRange { cell: 1, index: 12 });
        range.cells[n + 1] = u64::MAX;
        assert_eq!(range.failed(), ["structure"]);
        let mut repeated = mesh.clone();
        repeated.cells[n] = repeated.cells[n + 2];
        assert!(matches!(repeated.fault("structure"), Fault::RepeatedVertex { cell: 1, .. }));
        let mut twice = mesh.clone();
        let row: Vec<u64> = twice.cells[n..2 * n].iter().rev().copied().collect();
        twice.cells.extend(row);
        let last = (twice.cells.len() / n - 1) as u64;
        assert_eq!(twice.fault("structure"), Fault::CellTwice { cells: [1, last] });
        let mut unused = mesh.clone();
        unused.coordinates.extend([500.5, 500.25, 499.75][..n - 1].iter());
        let point = (mesh.coordinates.len() / (n - 1)) as u64;
        assert_eq!(unused.fault("structure"), Fault::Unused { point });
        let mut nan = mesh.clone();
        nan.coordinates[n - 1] = f64::NAN;
        assert_eq!(nan.fault("structure"), Fault::NotFinite { point: 1 });
        let mut none = mesh.clone();
        none.cells.clear();
        assert_eq!(none.fault("structure"), Fault::NoCells);
        let report = none.verify(VerifyOptions::default());
        assert!(report.levels[1..].iter().all(|l| l.stopped_by == Some("structure") && !l.passed));
    }
    // A seam has two coincident points, each a vertex of one half of a square.
    let points = [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 2.0], [2.0, 3.0]];
    let seam = Mesh::new(&points, &[[0, 1, 2], [0, 4, 3]]);
    assert_eq!(seam.fault("structure"), Fault::CoincidentVertices { points: [2, 4] });
}

#[test]
fn shape() {
    for (dimension, coordinates, cells) in [(0, 4, 0), (7, 14, 0), (2, 3, 0), (3, 12, 3), (2, 6, 4)] {
        let (coordinates, cells) = (vec![1.0; coordinates], vec![0; cells]);
        let mesh = Mesh { dimension, coordinates, cells, weights: None };
        assert!(matches!(mesh.fault("structure"), Fault::Shape { .. }));
    }
}

#[test]
fn orientation() {
    for (mesh, n) in both() {
        let mut swapped = mesh.clone();
        swapped.cells.swap(n, n + 1);
        assert_eq!(swapped.failed(), [""; 0]);
        let strict = VerifyOptions { any_order: false, ..VerifyOptions::default() };
        let report = swapped.verify(strict);
        assert_eq!(failed(&report), ["orientation"]);
        assert_eq!(report.levels[1].faults, [Fault::Negative { cell: 1 }]);
    }
    // A flat cell between the two halves of a square.
    let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 2.0]];
    let mut mesh = brute(&points);
    assert_eq!(mesh.failed(), [""; 0]);
    mesh.cells.extend([0, 1, 2, 3]);
    assert_eq!(mesh.fault("orientation"), Fault::Flat { cell: 2 });
}

#[test]
fn manifold() {
    // The cases are a third cell on an interior edge, two triangles that share only a vertex, and two cells on the same
    // side.
    let points = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [5.0, 5.0], [9.0, 9.0]];
    let third = Mesh::new(&points, &[[0, 1, 2], [1, 3, 2], [1, 4, 2]]);
    assert!(matches!(third.fault("manifold"), Fault::FacetOvershared { count: 3, .. }));
    let same = Mesh::new(&points, &[[1, 3, 2], [1, 4, 2], [0, 1, 2]]);
    assert!(!same.failed().is_empty());
    let same = Mesh::new(&points[1..], &[[0, 2, 1], [0, 3, 1]]);
    assert!(matches!(same.fault("manifold"), Fault::SameSide { cells: [0, 1], .. }));
    let points = [[0.0, 0.0], [-3.0, 1.0], [-3.0, -1.0], [3.0, -1.0], [3.0, 1.0]];
    let bow = Mesh::new(&points, &[[0, 1, 2], [0, 3, 4]]);
    assert_eq!(bow.fault("manifold"), Fault::PinchedVertex { vertex: 0, cells: [0, 1] });
    // The cases are two tetrahedra that share only an edge, and a belt of six around a point, whose link is an annulus.
    let points = [
        [0.0, 0.0, -1.0],
        [0.0, 0.0, 1.0],
        [3.0, 1.0, 0.0],
        [3.0, -1.0, 0.0],
        [-3.0, 1.0, 0.0],
        [-3.0, -1.0, 0.0],
    ];
    let edge = Mesh::new(&points, &[[0, 1, 2, 3], [0, 1, 4, 5]]);
    assert!(matches!(edge.fault("manifold"), Fault::PinchedVertex { vertex: 0, .. }));
    let ring = [[4.0, 0.0], [-2.0, 3.0], [-2.0, -3.0]];
    let mut points = vec![[0.0, 0.0, 0.0]];
    points.extend(ring.map(|[x, y]| [x, y, 1.0]));
    points.extend(ring.map(|[x, y]| [x, y, -1.0]));
    let belt = [[0, 1, 2, 4], [0, 2, 4, 5], [0, 2, 3, 5], [0, 3, 5, 6], [0, 3, 1, 6], [0, 1, 6, 4]];
    let belt = Mesh::new(&points, &belt);
    let link = Fault::LinkNotADisc { vertex: 0, euler: 0, boundary: 6 };
    assert!(belt.verify(VerifyOptions::default()).levels[2].faults.contains(&link));
}

#[test]
fn holes_and_outlines() {
    for (mesh, n) in both() {
        for cell in 0..mesh.cells.len() / n {
            // The missing cell leaves a dent or a hole, or it was the only cell of a point.
            let failed = without(&mesh, cell).failed();
            assert!(failed.contains(&"hull") || failed == ["structure"], "{failed:?}");
        }
    }
    // A hole in the middle has an inner boundary, reflex at each ridge.
    let lattice = kuhn(3, |p| p);
    let middle = without(&lattice, (1 + 3 * (1 + 3)) * 6);
    assert!(matches!(middle.fault("hull"), Fault::Reflex { .. }));
    // A lattice without the cells of one outer cube: all points stay in use.
    let mut notch = lattice.clone();
    notch.cells.drain(4 * 6 * 4..5 * 6 * 4);
    assert!(notch.failed().contains(&"hull"));
    // A slit: the cells at the origin go all the way round, and the last edge lies on the first.
    let points = [[0.0, 0.0], [-4.0, 0.0], [0.0, 4.0], [4.0, 0.0], [0.0, -4.0], [-2.0, 0.0]];
    let slit = Mesh::new(&points, &[[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]]);
    let report = slit.verify(VerifyOptions::default());
    let folded = Fault::Folded { ridge: vec![0], cells: [0, 3] };
    assert!(report.levels[3].faults.contains(&folded), "{report:?}");
}

#[test]
fn an_edge_flip() {
    let mesh = plane();
    let mut flips = 0;
    let rows = mesh.cells.chunks_exact(3);
    for (i, a) in rows.clone().enumerate() {
        for (j, b) in rows.clone().enumerate().skip(i + 1) {
            let far: Vec<u64> = b.iter().filter(|v| !a.contains(v)).copied().collect();
            let Some(k) = (0..3).find(|&k| far.len() == 1 && !b.contains(&a[k])) else {
                continue;
            };
            let (apex, p, q) = (a[k], a[(k + 1) % 3], a[(k + 2) % 3]);
            let mut flipped = mesh.clone();
            flipped.cells[3 * i..3 * i + 3].copy_from_slice(&[apex, p, far[0]]);
            flipped.cells[3 * j..3 * j + 3].copy_from_slice(&[apex, far[0], q]);
            let strict = VerifyOptions { any_order: false, ..VerifyOptions::default() };
            let failed = failed(&flipped.verify(strict));
            if failed == ["empty spheres"] {
                flips += 1;
            } else {
                // The two triangles did not form a convex quadrilateral.
                assert!(failed.contains(&"orientation"), "{failed:?}");
            }
        }
    }
    assert!(flips > 4);
}

#[test]
fn a_two_three_flip() {
    let mesh = space();
    let mut flips = 0;
    let rows = mesh.cells.chunks_exact(4);
    for (i, a) in rows.clone().enumerate() {
        for (j, b) in rows.clone().enumerate().skip(i + 1) {
            let far: Vec<u64> = b.iter().filter(|v| !a.contains(v)).copied().collect();
            let Some(k) = (0..4).find(|&k| far.len() == 1 && !b.contains(&a[k])) else {
                continue;
            };
            // Each vertex of the shared facet is replaced by the far vertex in turn.
            let mut flipped = without(&without(&mesh, j), i);
            for slot in (0..4).filter(|&slot| slot != k) {
                let mut row = a.to_vec();
                row[slot] = far[0];
                flipped.cells.extend(row);
            }
            let strict = VerifyOptions { any_order: false, ..VerifyOptions::default() };
            let failed = failed(&flipped.verify(strict));
            if failed == ["empty spheres"] {
                flips += 1;
            } else {
                // If the union is not convex, a new cell is negative or existed before.
                assert!(failed.contains(&"orientation") || failed == ["structure"], "{failed:?}");
            }
        }
    }
    assert!(flips > 4);
}

/// A nearly regular pentagon.
const RING: [[f64; 2]; 5] =
    [[1000.0, 0.0], [309.0, 951.0], [-809.0, 588.0], [-809.0, -588.0], [309.0, -951.0]];

#[test]
fn wound_twice() {
    // Triangles that go twice around a point: every local condition holds.
    let mut points = RING.to_vec();
    points.push([0.0, 0.0]);
    let star: Vec<[u64; 3]> = (0..5).map(|i| [5, i, (i + 2) % 5]).collect();
    let star = Mesh::new(&points, &star);
    assert_eq!(star.failed(), ["single cover"]);
    let report = star.verify(VerifyOptions::default());
    let counts = |fault: &&Fault| matches!(fault, Fault::CoveredTwice { .. });
    assert!(report.levels[5].faults.iter().any(|fault| counts(&fault)));
    // Tetrahedra that go twice around an edge.
    let mut points: Vec<[f64; 3]> = RING.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    points.extend([[0.0, 0.0, -100.0], [0.0, 0.0, 100.0]]);
    let star: Vec<[u64; 4]> = (0..5).map(|i| [5, 6, i, (i + 2) % 5]).collect();
    assert_eq!(Mesh::new(&points, &star).failed(), ["single cover"]);
}

#[test]
fn two_components() {
    for (mesh, _) in both() {
        // The copies are far apart, on top of each other (a double cover), or one lies within a cell of the other.
        for (scale, shift) in [(1.0, 1e6), (1.0, 0.25), (1e-6, 500.0), (1e-6, 0.0)] {
            let mut other = mesh.clone();
            other.coordinates.iter_mut().for_each(|x| *x = *x * scale + shift);
            let mut two = mesh.clone();
            two.append(&other);
            assert_eq!(two.failed(), ["single cover"]);
        }
    }
}

#[test]
fn a_moved_point() {
    for (mesh, n) in both() {
        let mut moved = mesh.clone();
        let far = moved.coordinates.len() - (n - 1);
        moved.coordinates[far] += 1e4;
        assert!(!moved.failed().is_empty());
    }
}
