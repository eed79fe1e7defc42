//! The verifier accepts Delaunay triangulations.

use super::fixtures::{Mesh, Numbers, PERTURBED, brute, canonical_lattice, failed, kuhn};
use crate::VerifyOptions;

fn accepted(mesh: &Mesh) {
    for options in [PERTURBED, VerifyOptions::default()] {
        let report = mesh.verify(options);
        assert!(report.passed(), "{mesh:?} {report:?}");
        assert_eq!(report.levels.len(), 6);
    }
}

fn scaled<const D: usize>(points: &[[f64; D]], factors: [f64; D]) -> Vec<[f64; D]> {
    points.iter().map(|p| std::array::from_fn(|k| p[k] * factors[k])).collect()
}

#[test]
fn random_points_with_and_without_ties() {
    let mut numbers = Numbers(1);
    for (count, end) in [(3, 1000), (5, 1000), (12, 1000), (12, 4), (9, 3), (12, 1 << 50)] {
        for _ in 0..6 {
            accepted(&brute(&numbers.points::<2>(count, end)));
            accepted(&brute(&numbers.points::<3>(count.min(11), end)));
        }
    }
}

#[test]
fn lattices_are_canonical_in_one_way_only() {
    let square: Vec<[f64; 2]> = (0..12).map(|i| [f64::from(i / 4), f64::from(i % 4)]).collect();
    let cube: Vec<[f64; 3]> =
        (0..12).map(|i| [f64::from(i / 4), f64::from(i / 2 % 2), f64::from(i % 2)]).collect();
    accepted(&brute(&square));
    accepted(&brute(&cube));
    let report = brute(&cube).verify(PERTURBED);
    assert!(report.ties > 0 && report.hull_facets == 20, "{report:?}");
    // The other diagonal of a square is also Delaunay, but not canonical.
    let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let both = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]].map(|cells| Mesh::new(&points, &cells));
    let canonical = brute(&points).as_set();
    for mesh in both {
        assert_eq!(mesh.failed(), [""; 0]);
        let expected: &[&str] = if mesh.as_set() == canonical { &[] } else { &["empty spheres"] };
        assert_eq!(failed(&mesh.verify(PERTURBED)), expected);
    }
}

#[test]
fn any_unit_of_length_and_any_spread() {
    let mut numbers = Numbers(2);
    let (plane, space) = (numbers.points::<2>(10, 50), numbers.points::<3>(9, 6));
    for factor in [1e-120, 1e120, 1e-300, 1e300, 5e-324, 2f64.powi(-398), 1e-3] {
        accepted(&brute(&scaled(&plane, [factor; 2])));
        accepted(&brute(&scaled(&space, [factor; 3])));
    }
    accepted(&brute(&scaled(&plane, [1e150, 1e-150])));
    accepted(&brute(&scaled(&space, [1e120, 1.0, 1e-120])));
    // One cluster lies within another, and their scales differ by 2,000 bits.
    let mut nested = scaled(&plane[..6], [1e300; 2]);
    nested.extend(scaled(&plane[6..], [1e-300; 2]));
    accepted(&brute(&nested));
}

#[test]
fn coincident_points_are_represented() {
    let mut points = vec![[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [5.0, 5.0]];
    points.extend([[-0.0, 0.0], [4.0, -0.0], [5.0, 5.0]]);
    let mesh = brute(&points);
    accepted(&mesh);
    let report = mesh.verify(PERTURBED);
    assert_eq!((report.duplicates, report.vertices_used, report.points), (3, 4, 7));
    // With another representative, the triangulation is valid but not canonical.
    let mut other = mesh.clone();
    other.cells.iter_mut().filter(|v| **v == 3).for_each(|v| *v = 6);
    assert_eq!(other.failed(), [""; 0]);
    assert_eq!(failed(&other.verify(PERTURBED)), ["structure"]);
}

#[test]
fn lower_dimensional_points_have_no_cells() {
    let sets: [(&[[f64; 3]], i32); 5] = [
        (&[], -1),
        (&[[1.0, 2.0, 3.0]; 3], 0),
        (&[[0.1, 0.2, 0.3], [0.1, 0.2, 0.4], [0.1, 0.2, 0.9]], 1),
        (&[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [7.0, 3.0, 1.0]], 2),
        (&[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0], [0.0, 1.0, 2.0]], 2),
    ];
    for (points, dimension) in sets {
        let mesh = Mesh::new::<3, 4>(points, &[]);
        accepted(&mesh);
        assert_eq!(mesh.verify(PERTURBED).dimension_of_points, dimension);
    }
    let line: Vec<[f64; 2]> = (0..5).map(|i| [f64::from(i), 2.0 * f64::from(i)]).collect();
    accepted(&Mesh::new::<2, 3>(&line, &[]));
}

#[test]
fn the_kuhn_lattice_is_delaunay_for_any_number_of_threads() {
    let mesh = kuhn(6, |p| p);
    let reports = [1, 2, 3].map(|threads| mesh.verify(VerifyOptions { threads, ..Default::default() }));
    assert!(reports[0].passed(), "{:?}", reports[0]);
    assert_eq!((reports[0].cells, reports[0].hull_facets), (6 * 216, 6 * 2 * 36));
    assert!(reports.iter().all(|report| *report == reports[0]));
    // It is not the canonical triangulation, which passes in both modes.
    let canonical = VerifyOptions { any_order: true, ..PERTURBED };
    assert_eq!(failed(&mesh.verify(canonical)), ["empty spheres"]);
    accepted(&canonical_lattice(4));
    // A squeezed and jittered lattice has faults, the same for any number of threads.
    let mut numbers = Numbers(3);
    let bad = kuhn(6, |p| p.map(|x| x + numbers.below(1000) as f64 / 2500.0));
    let reports = [1, 2, 3].map(|threads| bad.verify(VerifyOptions { threads, ..Default::default() }));
    assert!(!reports[0].passed());
    assert!(reports.iter().all(|report| *report == reports[0]));
}
