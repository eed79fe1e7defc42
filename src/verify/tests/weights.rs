//! Sites with weights: regular triangulations are accepted, and altered ones rejected.

use std::array::from_fn;
use std::cmp::Ordering;

use super::fixtures::{
    Mesh, Numbers, PERTURBED, canonical_lattice, failed, integers, regular, representatives, subsets, turn,
};
use crate::exact::{Site, exact_power};
use crate::facets::Facets;
use crate::hidden::{Found, Moved, Walk};
use crate::predicates::power;
use crate::runner::Runner;
use crate::soup::Soup;
use crate::{Fault, HIDDEN_SITES, VerifyOptions};

pub const ANY_ORDER: VerifyOptions = VerifyOptions { any_order: true, ..PERTURBED };

/// Returns the vertices of a mesh, in ascending order.
fn vertices(mesh: &Mesh) -> Vec<u64> {
    let mut all = mesh.cells.clone();
    all.sort_unstable();
    all.dedup();
    all
}

/// Accepts a mesh of [`regular`], and compares its counts with those of the definition.
fn accepted<const D: usize>(points: &[[f64; D]], weights: &[f64]) -> Mesh {
    let mesh = regular(points, weights);
    let (lifted, used) = (integers(points, weights), vertices(&mesh));
    let kept = representatives(&lifted);
    for options in [PERTURBED, VerifyOptions::default()] {
        let report = mesh.verify(options);
        assert!(report.passed(), "{mesh:?} {report:?}");
        assert_eq!(report.levels.len(), 7);
        if !used.is_empty() {
            let all = (report.vertices_used, report.hidden.unwrap() + report.duplicates);
            assert_eq!(all, (used.len() as u64, points.len() as u64 - used.len() as u64));
        }
    }
    if !used.is_empty() {
        for &q in &kept {
            assert_eq!(used.contains(&(q as u64)), !is_above::<D>(&lifted, &kept, q), "{mesh:?}");
        }
    }
    mesh
}

/// Returns `true` if the lift of `q` is strictly above the lower hull, by all simplices.
fn is_above<const D: usize>(lifted: &[Vec<num_bigint::BigInt>], kept: &[usize], q: usize) -> bool {
    subsets(kept, D + 1).into_iter().any(|cell| {
        let rows: Vec<_> = cell.iter().map(|&i| &lifted[i]).collect();
        let volume = turn(&rows, D);
        let contains = (0..=D).all(|slot| {
            let mut rows = rows.clone();
            rows[slot] = &lifted[q];
            turn(&rows, D) != volume.reverse()
        });
        let with_query: Vec<_> = rows.iter().copied().chain([&lifted[q]]).collect();
        volume.is_ne() && contains && turn(&with_query, D + 1) == volume
    })
}

/// Returns the numbers of sites for a set: coordinates below `end`, and weights from `-spread` to `spread`.
fn sites<const D: usize>(
    numbers: &mut Numbers,
    count: usize,
    end: u64,
    spread: u64,
) -> (Vec<[f64; D]>, Vec<f64>) {
    let points = numbers.points::<D>(count, end);
    let weights = points.iter().map(|_| numbers.below(2 * spread + 1) as f64 - spread as f64).collect();
    (points, weights)
}

#[test]
fn random_sites_with_and_without_ties() {
    let mut numbers = Numbers(21);
    let mut hidden = 0;
    for (count, end, spread) in [(4, 1000, 90_000), (9, 1000, 200_000), (10, 4, 3), (9, 3, 1), (9, 3, 0)] {
        for _ in 0..12 {
            let (points, weights) = sites::<2>(&mut numbers, count, end, spread);
            hidden += accepted(&points, &weights).verify(PERTURBED).hidden.unwrap();
            let (points, weights) = sites::<3>(&mut numbers, count, end, spread);
            hidden += accepted(&points, &weights).verify(PERTURBED).hidden.unwrap();
        }
    }
    assert!(hidden > 100, "{hidden}");
}

#[test]
fn special_sites() {
    let grid: Vec<[f64; 2]> = (0..12).map(|i| [f64::from(i / 4), f64::from(i % 4)]).collect();
    let cube: Vec<[f64; 3]> =
        (0..12).map(|i| [f64::from(i / 4), f64::from(i / 2 % 2), f64::from(i % 2)]).collect();
    // All lifts are in one plane: all sites are vertices.
    let flat: Vec<f64> = grid.iter().map(|p| p[0] * p[0] + p[1] * p[1]).collect();
    assert_eq!(accepted(&grid, &flat).verify(PERTURBED).hidden, Some(0));
    let flat: Vec<f64> = cube.iter().map(|p| p.iter().map(|x| x * x).sum::<f64>() - 7.5).collect();
    assert_eq!(accepted(&cube, &flat).verify(PERTURBED).hidden, Some(0));
    // One heavy site hides the other sites in the interior.
    let mut heavy = vec![0.0; 12];
    heavy[5] = 1e6;
    assert_eq!(accepted(&grid, &heavy).verify(PERTURBED).hidden, Some(1));
    // All but the corners of the hull are hidden.
    let low: Vec<f64> =
        grid.iter().map(|p| if p[0] % 2.0 == 0.0 && p[1] % 3.0 == 0.0 { 0.0 } else { -9.0 }).collect();
    assert_eq!(accepted(&grid, &low).verify(PERTURBED).hidden, Some(8));
    // A hidden site on the boundary, and one outside the hull of the other sites, which is a vertex for any weight.
    let points = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [1.0, 0.0], [3.0, 3.0]];
    assert_eq!(accepted(&points, &[0.0, 0.0, 0.0, -1.5, -1e300]).verify(PERTURBED).hidden, Some(1));
    // On the hull of the lifts, it is a vertex.
    assert_eq!(accepted(&points, &[0.0, 0.0, 0.0, -1.0, -1e300]).verify(PERTURBED).hidden, Some(0));
    // Sets without cells.
    let line: Vec<[f64; 2]> = (0..5).map(|i| [f64::from(i), 2.0 * f64::from(i)]).collect();
    accepted(&line, &[0.0, -5.0, 3.0, 0.0, 0.0]);
    accepted::<3>(&[], &[]);
    let report = accepted(&[[1.0, 2.0, 3.0]; 3], &[1.0, 2.0, 2.0]).verify(PERTURBED);
    assert_eq!((report.hidden, report.duplicates), (Some(1), 1));
}

#[test]
fn sites_at_one_position() {
    let points =
        [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [5.0, 5.0], [4.0, -0.0], [4.0, 0.0], [1.0, 1.0], [1.0, 1.0]];
    let weights = [0.0, -1.0, 0.0, 0.0, 2.0, 2.0, -30.0, -30.0];
    let mesh = accepted(&points, &weights);
    let report = mesh.verify(PERTURBED);
    assert_eq!((report.hidden, report.duplicates, report.vertices_used), (Some(2), 2, 4));
    let renamed = |old: u64, new: u64| {
        let mut other = mesh.clone();
        other.cells.iter_mut().filter(|v| **v == old).for_each(|v| *v = new);
        other
    };
    // Another heaviest site is valid but not canonical. A lighter one is not valid.
    assert_eq!(renamed(4, 5).failed(), [""; 0]);
    assert_eq!(failed(&renamed(4, 5).verify(PERTURBED)), ["structure"]);
    assert_eq!(renamed(4, 1).fault("structure"), Fault::Lighter { vertex: 1, heavier: 4 });
    let mut both = mesh.clone();
    let at = both.cells.iter().position(|&v| v == 4).unwrap();
    both.cells[at] = 1;
    assert!(matches!(both.fault("structure"), Fault::CoincidentVertices { .. } | Fault::Lighter { .. }));
}

#[test]
fn any_unit_of_length() {
    let mut numbers = Numbers(22);
    for exponent in [-500, -170, 80, 400] {
        let factor = 2f64.powi(exponent);
        let (points, weights) = sites::<2>(&mut numbers, 9, 50, 400);
        let points: Vec<_> = points.iter().map(|p| p.map(|x| x * factor)).collect();
        let weights: Vec<_> = weights.iter().map(|w| w * factor * factor).collect();
        accepted(&points, &weights);
    }
    // The exponents of weights and coordinates are unrelated.
    let (points, _) = sites::<2>(&mut numbers, 9, 50, 0);
    for weight in [5e-324, 1e-200, 1e200, f64::MAX, -f64::MAX] {
        let weights: Vec<_> = points.iter().map(|_| numbers.below(3) as f64 * (weight / 2.0)).collect();
        accepted(&points, &weights);
        let tiny: Vec<_> = points.iter().map(|p| p.map(|x| x * 1e-300)).collect();
        accepted(&tiny, &weights);
    }
}

#[test]
fn faults_of_weights() {
    let mesh = regular(&[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [1.0, 1.0]], &[0.0, 0.0, 0.0, -2.5]);
    assert_eq!((mesh.failed(), mesh.as_set().len()), (vec![], 3));
    let with = |weights: &[f64]| Mesh { weights: Some(weights.to_vec()), ..mesh.clone() };
    assert!(matches!(with(&[0.0; 3]).fault("structure"), Fault::Shape { .. }));
    let wrong = with(&[0.0, f64::INFINITY, 0.0, f64::NAN]).verify(PERTURBED);
    let faults = [Fault::WeightNotFinite { point: 1 }, Fault::WeightNotFinite { point: 3 }];
    assert_eq!(wrong.levels[0].faults, faults);
    assert_eq!(wrong.levels[6].stopped_by, Some("structure"));
    // A site on the plane of the others is a vertex. A site above it is not.
    assert_eq!(with(&[0.0, 0.0, 0.0, -6.0]).failed(), [""; 0]);
    let shown = with(&[0.0, 0.0, 0.0, -6.5]).verify(VerifyOptions::default());
    assert_eq!(failed(&shown), ["empty spheres"]);
    assert_eq!(shown.levels[6].stopped_by, Some("empty spheres"));
    let without = |weight: f64| Mesh { cells: vec![0, 1, 2], ..with(&[0.0, 0.0, 0.0, weight]) };
    assert_eq!(without(-6.5).failed(), [""; 0]);
    assert_eq!(without(-6.0).fault(HIDDEN_SITES), Fault::NotHidden { point: 3, cell: 0 });
    let mut outside = without(-1e9);
    outside.coordinates[6] = 4.0;
    assert_eq!(outside.fault(HIDDEN_SITES), Fault::Outside { point: 3, cell: 0 });
}

/// Returns the sign of the in-sphere form from integers.
fn expected<const D: usize, const N: usize>(cell: &[Site<[f64; D]>; N], q: &Site<[f64; D]>) -> Ordering {
    let all = || cell.iter().chain([q]);
    let points: Vec<[f64; D]> = all().map(|site| site.place).collect();
    let weights: Vec<f64> = all().map(|site| site.weight).collect();
    let lifted = integers(&points, &weights);
    turn(&lifted.iter().collect::<Vec<_>>(), D + 1).reverse()
}

fn signs<const D: usize, const N: usize>(seed: u64, counts: &mut [u32; 3]) {
    const UNITS: [f64; 6] = [1.0, 0.1, 1e-120, 1e120, 5e-324, f64::from_bits((1023 - 100) << 52)];
    let mut numbers = Numbers(seed);
    for round in 0..15_000 {
        let unit = if round % 10 == 0 { UNITS[numbers.below(6) as usize] } else { 1.0 };
        let number = |numbers: &mut Numbers| {
            let x = (numbers.below(4) as f64 - 1.0) * unit;
            match numbers.below(8) {
                0 => x.next_up(),
                1 => x + unit * 2f64.powi(-40),
                _ => x,
            }
        };
        let site = |numbers: &mut Numbers| {
            let place: [f64; D] = from_fn(|_| number(numbers));
            let square: f64 = place.iter().map(|x| x * x).sum();
            // Most lifts are near one plane.
            let weight = match numbers.below(9) {
                0 => square.next_down(),
                1 => -0.0,
                2 => square + unit * unit * 2f64.powi(-44),
                3 => square - numbers.below(3) as f64 * 1e-300,
                4 if round % 7 == 0 => f64::MAX * (numbers.below(3) as f64 - 1.0),
                5 if round % 7 == 0 => 1e60 * (numbers.below(3) as f64 - 1.0),
                _ => square,
            };
            Site { place, weight: weight.clamp(-f64::MAX, f64::MAX) }
        };
        let (cell, q) = (from_fn::<_, N, _>(|_| site(&mut numbers)), site(&mut numbers));
        let sign = expected(&cell, &q);
        assert_eq!(power(&cell, &q), sign, "{cell:?} {q:?}");
        assert_eq!(exact_power(&cell, &q), sign, "{cell:?} {q:?}");
        counts[(sign as i8 + 1) as usize] += 1;
    }
}

#[test]
fn signs_with_weights_are_exact() {
    let mut counts = [0; 3];
    signs::<2, 3>(31, &mut counts);
    signs::<3, 4>(32, &mut counts);
    assert!(counts.iter().all(|&count| count > 1000), "{counts:?}");
}

/// Returns a mesh with one alteration of the cells or the weights, and its name.
fn altered<const D: usize>(mesh: &Mesh, points: &[[f64; D]], numbers: &mut Numbers) -> (&'static str, Mesh) {
    let weights = mesh.weights.clone().unwrap();
    let at = numbers.below(points.len() as u64) as usize;
    let row = numbers.below((mesh.cells.len() / (D + 1)) as u64) as usize * (D + 1);
    let mut other = mesh.clone();
    let what = match numbers.below(6) {
        0 => {
            // The cells of the set in which this site is heavier.
            let mut heavier = weights;
            heavier[at] += heavier.iter().fold(1.0, |m: f64, w| m.max(w.abs()));
            other.cells = regular(points, &heavier).cells;
            "shown"
        }
        1 => {
            let rest = |i: usize| i + usize::from(i >= at);
            let others: Vec<[f64; D]> = (0..points.len() - 1).map(|i| points[rest(i)]).collect();
            let of_others: Vec<f64> = (0..points.len() - 1).map(|i| weights[rest(i)]).collect();
            let cells = regular(&others, &of_others).cells;
            other.cells = cells.iter().map(|&v| rest(v as usize) as u64).collect();
            "hidden"
        }
        2 => {
            let mut twice = other.cells[row..=row + D].to_vec();
            twice.rotate_left(numbers.below(D as u64 + 1) as usize);
            other.cells.extend(twice);
            "twice"
        }
        3 => {
            other.cells.drain(row..=row + D);
            "removed"
        }
        4 => {
            other.weights.as_mut().unwrap()[at] += numbers.below(7) as f64 - 3.0;
            "weight"
        }
        _ => {
            other.cells[row] = at as u64;
            "vertex"
        }
    };
    (what, other)
}

/// Alters triangulations. Returns the numbers of all alterations, and of those that passed.
fn alterations<const D: usize>(seed: u64, end: u64, spread: u64, counts: &mut [u32; 2]) {
    let mut numbers = Numbers(seed);
    for _ in 0..25 {
        let (points, weights) = sites::<D>(&mut numbers, 8, end, spread);
        let mesh = regular(&points, &weights);
        if mesh.cells.is_empty() {
            continue;
        }
        for _ in 0..14 {
            let (what, other) = altered(&mesh, &points, &mut numbers);
            let good = regular(&points, other.weights.as_ref().unwrap()).as_set() == other.as_set();
            let report = other.verify(ANY_ORDER);
            assert_eq!(report.passed(), good, "{what}: {other:?} {report:?}");
            // Without the perturbation, more may pass if there are ties.
            let passed = other.verify(VerifyOptions::default()).passed();
            assert!(if end > 100 { passed == good } else { passed >= good }, "{what}: {other:?}");
            counts[0] += 1;
            counts[1] += u32::from(good);
        }
    }
}

#[test]
fn only_the_canonical_triangulation_passes() {
    let mut counts = [0; 2];
    for (end, spread) in [(1000, 200_000), (4, 4)] {
        alterations::<2>(41, end, spread, &mut counts);
        alterations::<3>(42, end, spread, &mut counts);
    }
    let [all, passed] = counts;
    assert!(all - passed > 1000 && passed > 20, "{counts:?}");
}

/// Returns the canonical cubic lattice with hidden sites: `-w` exceeds the power of the cell by `margin`.
fn lattice(side: usize, sites: usize, margin: f64) -> Mesh {
    let mut mesh = canonical_lattice(side);
    let mut weights = vec![0.0; mesh.coordinates.len() / 3];
    let mut numbers = Numbers(51);
    for _ in 0..sites {
        let place: [f64; 3] = from_fn(|_| numbers.below(16 * side as u64) as f64 / 16.0 + 1.0 / 32.0);
        let depth: f64 = place.iter().map(|x| x.fract() * (1.0 - x.fract())).sum();
        mesh.coordinates.extend(place);
        weights.push(-depth - margin);
    }
    mesh.weights = Some(weights);
    mesh
}

#[test]
fn walks_find_the_cells_of_many_hidden_sites() {
    let mesh = lattice(8, 20_000, 2f64.powi(-30));
    let reports = [1, 2, 3].map(|threads| mesh.verify(VerifyOptions { threads, ..ANY_ORDER }));
    assert!(reports[0].passed(), "{:?}", reports[0]);
    assert!(reports.iter().all(|report| *report == reports[0]));
    let level = reports[0].level(HIDDEN_SITES).unwrap();
    assert_eq!(level.checked + reports[0].duplicates, 20_000);
    assert_eq!(reports[0].hidden, Some(level.checked));
    // Exactly on the hull of the lifts, they should be vertices.
    let shown = lattice(4, 300, 0.0);
    let reports = [1, 3].map(|threads| shown.verify(VerifyOptions { threads, ..ANY_ORDER }));
    assert_eq!(failed(&reports[0]), [HIDDEN_SITES]);
    assert_eq!(reports[0], reports[1]);
    let level = reports[0].level(HIDDEN_SITES).unwrap();
    assert_eq!(level.fault_count, level.checked);
}

#[test]
fn the_search_does_not_depend_on_the_walk() {
    let mesh = lattice(3, 0, 0.0);
    let mut report = |_: &str, _: u64, _: u64| {};
    let mut runner = Runner::new(1, &mut report);
    let (mut soup, _) = Soup::<[f64; 3], 3, 4>::load(&mesh.view(), &mut runner);
    soup.structure(true, &mut runner);
    soup.orient(true, &mut runner);
    let (facets, _) = Facets::new(&soup, &mut runner);
    let mut numbers = Numbers(52);
    for _ in 0..200 {
        let place: [f64; 3] = from_fn(|_| numbers.below(100) as f64 / 25.0 + 0.01);
        let start = Moved { cell: numbers.below(soup.cells.len() as u64) as u32, by: () };
        let [long, short] =
            [1000, 0].map(|most| Walk { soup: &soup, facets: &facets, most }.to(start, &place));
        match (long, short) {
            (Found::In(cell), Found::In(other)) => assert_eq!(cell, other),
            (Found::Beyond(_), Found::Beyond(_)) => assert!(place.iter().any(|x| *x > 3.0)),
            _ => panic!("{place:?}: {long:?} {short:?}"),
        }
    }
}
