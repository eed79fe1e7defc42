//! In-sphere signs of points with weights, compared with big integers.

use glam::{DVec2, DVec3};

use super::samples::{KINDS, Samples};
use super::*;
use crate::hash::Draw;
use crate::point::{Position, dist2};
use crate::site::Weighted;

/// Ways to choose weights.
const WAYS: usize = 7;

/// Adds weights to points; `way` is below [`WAYS`].
fn weighted<P: Position>(points: &[P], way: usize, random: &mut Draw) -> Vec<Weighted<P>> {
    let reach2 = points.iter().map(|&p| dist2(p, points[0])).fold(0.0, f64::max);
    let largest = points.iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i).abs())).fold(0.0, f64::max);
    let site = |&p: &P| {
        let weight = match way {
            0 => 0.0,
            1 => reach2 * random.unit(),
            // Heights that are nearly equal, so that determinants are nearly zero.
            2 => dist2(p, points[0]),
            3 => dist2(p, points[0]) + reach2 * f64::EPSILON * random.below(3) as f64,
            4 => -largest * largest * random.unit(),
            5 => largest * largest * random.unit().powi(40),
            _ => reach2 * 0.25 * random.below(4) as f64,
        };
        Weighted::new(p, weight)
    };
    points.iter().map(site).collect()
}

fn signs_are_exact<P: Position>() {
    let mut random = Draw::new(3);
    let (mut decided, mut ties, mut asked) = (0, 0, 0);
    for kind in KINDS {
        let mut samples = Samples::new(kind as u64 + 1);
        for round in 0..700 {
            let (mut points, q) = samples.call::<P>(kind);
            points.push(q);
            let sites = weighted(&points, round % WAYS, &mut random);
            if !crate::range::Digits::of(&sites).unwrap().fits() {
                continue;
            }
            let (mut cell, q) = (sites[..=P::DIM].to_vec(), sites[P::DIM + 1]);
            match exact::orientation(&cell) {
                Sign::Zero => continue,
                Sign::Negative => cell.swap(0, 1),
                Sign::Positive => {}
            }
            if cell.iter().any(|p| lex_cmp(p, &q).is_eq()) {
                continue;
            }
            let det = exact::in_sphere(&cell, q);
            let rounded = Weighted::rounded_in_sphere(&cell, q);
            assert!(!rounded.is_certain() || Sign::of(rounded.det) == det, "filter: {cell:?} {q:?}");
            let signs = crate::predicates::weighted::conflict(&cell, q, rounded.reach);
            assert_eq!(signs.det, det, "integers: {cell:?} {q:?}");
            for (i, &sign) in signs.cofactors[..=P::DIM].iter().enumerate() {
                assert_eq!(sign, exact::orientation(&exact::replaced(&cell, i, q)), "{cell:?} {q:?}");
            }
            assert_eq!(in_sphere(&cell, q), exact::conflicts(&cell, q), "{kind:?} {cell:?} {q:?}");
            decided += usize::from(rounded.is_certain());
            ties += usize::from(det == Sign::Zero);
            asked += 1;
        }
    }
    assert!(asked > 3_000 && decided > asked / 4 && ties > 100, "{decided} and {ties} of {asked}");
}

#[test]
fn signs_of_sites_are_exact_in_space() {
    signs_are_exact::<DVec3>();
}

#[test]
fn signs_of_sites_are_exact_in_the_plane() {
    signs_are_exact::<DVec2>();
}

/// Images of sites in a box whose coordinates are of another magnitude, so that sums must be rounded.
fn signs_of_images_are_exact<P: Position>() {
    let mut random = Draw::new(5);
    let (mut decided, mut rounded_orientations, mut ties, mut asked) = (0, 0, 0, 0);
    for kind in KINDS {
        let mut samples = Samples::new(kind as u64 + 1);
        for round in 0..700 {
            let (mut points, q) = samples.call::<P>(kind);
            points.push(q);
            let reach = points.iter().map(|&p| dist2(p, points[0])).fold(0.0, f64::max).sqrt();
            let by = [reach, reach * 0.7, reach * 1e9, reach * f64::EPSILON][round % 4];
            let sites: Vec<Weighted<P>> = weighted(&points, round % WAYS, &mut random)
                .into_iter()
                .map(|site| {
                    let mut translation = P::default();
                    (0..P::DIM).for_each(|i| translation.set_coord(i, by * random.below(2) as f64));
                    if round % 3 == 0 { site } else { site.translated(translation).unwrap() }
                })
                .collect();
            if !crate::range::Digits::of(&sites).unwrap().fits() {
                continue;
            }
            let (mut cell, q) = (sites[..=P::DIM].to_vec(), sites[P::DIM + 1]);
            let sign = exact::orientation(&cell);
            assert_eq!(orientation(&cell), sign, "{cell:?}");
            let of_cell = Weighted::rounded_orientation(&cell);
            rounded_orientations += usize::from(of_cell.is_certain());
            assert!(!of_cell.is_certain() || Sign::of(of_cell.det) == sign, "{cell:?}");
            match sign {
                Sign::Zero => continue,
                Sign::Negative => cell.swap(0, 1),
                Sign::Positive => {}
            }
            if cell.iter().any(|p| lex_cmp(p, &q).is_eq()) {
                continue;
            }
            let det = exact::in_sphere(&cell, q);
            let rounded = Weighted::rounded_in_sphere(&cell, q);
            assert!(!rounded.is_certain() || Sign::of(rounded.det) == det, "filter: {cell:?} {q:?}");
            assert_eq!(in_sphere(&cell, q), exact::conflicts(&cell, q), "{kind:?} {cell:?} {q:?}");
            decided += usize::from(rounded.is_certain());
            ties += usize::from(det == Sign::Zero);
            asked += 1;
        }
    }
    assert!(asked > 2_000 && decided > asked / 4 && ties > 20, "{decided} and {ties} of {asked}");
    assert!(rounded_orientations > asked / 2, "{rounded_orientations} of {asked}");
}

#[test]
fn signs_of_images_are_exact_in_both_dimensions() {
    signs_of_images_are_exact::<DVec3>();
    signs_of_images_are_exact::<DVec2>();
}

#[test]
fn weights_move_the_sphere() {
    let site = |x: f64, y: f64, weight: f64| Weighted::new(DVec2::new(x, y), weight);
    let cell = [site(0.0, 0.0, 0.0), site(2.0, 0.0, 0.0), site(0.0, 2.0, 0.0)];
    // The centre is (1, 1), and the squared radius 2.
    assert!(!in_sphere(&cell, site(3.0, 1.0, 1.9)));
    assert!(in_sphere(&cell, site(3.0, 1.0, 2.1)));
    assert!(in_sphere(&cell, site(1.0, 1.0, -1.9)));
    assert!(!in_sphere(&cell, site(1.0, 1.0, -2.1)), "hidden");
}
