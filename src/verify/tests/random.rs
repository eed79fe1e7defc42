//! Random input: signs are compared with big integers, and a mesh passes if and only if it is Delaunay.

use std::cmp::Ordering;

use super::fixtures::{Mesh, Numbers, PERTURBED, brute};
use crate::dyadic::sign_of;
use crate::exact::{exact_sign, form, integers};
use crate::predicates::sign;
use crate::ring::Ring;

/// Returns the sign in big integers, without a filter.
fn big<const D: usize, const K: usize>(base: &[f64; D], others: &[[f64; D]; K]) -> Ordering {
    let mut all = others.to_vec();
    all.push(*base);
    let whole = integers(&all);
    let rows = std::array::from_fn(|i| std::array::from_fn(|k| whole[i][k].minus(&whole[K][k])));
    sign_of(&form::<_, D, K>(&rows))
}

/// Returns a point with small integer coordinates times the unit, some moved by an ulp or by a tiny length. Such points
/// are nearly or exactly degenerate.
fn nearly<const D: usize>(unit: f64, numbers: &mut Numbers) -> [f64; D] {
    std::array::from_fn(|_| {
        let x = (numbers.below(4) as f64 - 1.0) * unit;
        match numbers.below(8) {
            0 => x.next_up(),
            1 => x + unit * 2f64.powi(-40),
            2 => x + numbers.below(9) as f64 * 1e-30,
            _ => x,
        }
    })
}

const UNITS: [f64; 7] = [1.0, 0.1, 1e-120, 1e120, 1e-300, 5e-324, f64::from_bits((1023 - 100) << 52)];

fn signs<const D: usize, const K: usize>(seed: u64, counts: &mut [u32; 3]) {
    let mut numbers = Numbers(seed);
    for _ in 0..20_000 {
        let unit = UNITS[numbers.below(UNITS.len() as u64) as usize];
        let other = UNITS[numbers.below(UNITS.len() as u64) as usize];
        let mut point = || {
            let unit = if numbers.below(10) == 0 { other } else { unit };
            nearly::<D>(unit, &mut numbers)
        };
        let (base, others) = (point(), std::array::from_fn::<_, K, _>(|_| point()));
        let expected = big(&base, &others);
        assert_eq!(sign(&base, &others), expected, "{base:?} {others:?}");
        assert_eq!(exact_sign(&base, &others), expected, "{base:?} {others:?}");
        counts[(expected as i8 + 1) as usize] += 1;
    }
}

#[test]
fn signs_are_exact() {
    let mut counts = [0; 3];
    signs::<2, 2>(1, &mut counts);
    signs::<2, 3>(2, &mut counts);
    signs::<3, 3>(3, &mut counts);
    signs::<3, 4>(4, &mut counts);
    assert!(counts.iter().all(|&count| count > 1000), "{counts:?}");
}

/// Makes one random change to a mesh.
fn mutate(mesh: &mut Mesh, numbers: &mut Numbers) {
    let n = mesh.dimension + 1;
    let points = (mesh.coordinates.len() / mesh.dimension) as u64;
    let at = numbers.below(mesh.cells.len() as u64) as usize;
    match numbers.below(6) {
        0 => mesh.cells[at] = numbers.below(points),
        1 => {
            let row = at / n * n;
            mesh.cells.drain(row..row + n);
        }
        2 => {
            let row: Vec<u64> = (0..n).map(|_| numbers.below(points)).collect();
            mesh.cells.extend(row);
        }
        3 => {
            let other = numbers.below(mesh.cells.len() as u64) as usize;
            mesh.cells.swap(at, other);
        }
        4 => {
            let (old, new) = (mesh.cells[at], numbers.below(points));
            mesh.cells.iter_mut().filter(|v| **v == old).for_each(|v| *v = new);
        }
        _ => {
            let other = mesh.cells[numbers.below(mesh.cells.len() as u64) as usize];
            let here = mesh.cells[at];
            for v in &mut mesh.cells {
                *v = if *v == here {
                    other
                } else if *v == other {
                    here
                } else {
                    *v
                };
            }
        }
    }
}

fn mutations(mesh: &Mesh, seed: u64) -> u32 {
    let mut numbers = Numbers(seed);
    let mut passed = 0;
    for round in 0..1500 {
        let mut changed = mesh.clone();
        for _ in 0..=round % 3 {
            if !changed.cells.is_empty() {
                mutate(&mut changed, &mut numbers);
            }
        }
        let options = crate::VerifyOptions { any_order: true, ..PERTURBED };
        let report = changed.verify(options);
        assert_eq!(report.passed(), changed.as_set() == mesh.as_set(), "{changed:?} {report:?}");
        passed += u32::from(report.passed());
        for fault in report.levels.iter().flat_map(|level| &level.faults) {
            assert!(!fault.to_string().contains('{'), "{fault}");
        }
    }
    passed
}

#[test]
fn only_the_canonical_triangulation_passes() {
    for end in [1000, 3] {
        assert!(mutations(&brute(&Numbers(5).points::<2>(7, end)), 6) > 0);
        assert!(mutations(&brute(&Numbers(7).points::<3>(7, end)), 8) > 0);
    }
}
