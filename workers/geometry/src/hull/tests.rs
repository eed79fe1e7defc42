//! Stars compared with brute force.

mod general;
mod large;
mod weighted;

use super::*;
use crate::complex::INFINITE;
use crate::cost::Cost;
use crate::incremental::Incremental;
use crate::incremental::tests::nasty::{KINDS, set};
use crate::point::Point;
use crate::point::Simplex;
use crate::predicates::Sign;
use crate::predicates::in_sphere;
use crate::predicates::orientation;
use glam::{DVec2, DVec3};

fn extend<P: Point>(points: &[P], pick: &mut Vec<usize>, out: &mut Vec<Vec<u32>>) {
    if pick.len() > P::DIM {
        let mut cell: Vec<P> = pick.iter().map(|&i| points[i]).collect();
        match orientation(&cell) {
            Sign::Zero => return,
            Sign::Negative => cell.swap(0, 1),
            Sign::Positive => {}
        }
        if (0..points.len()).all(|q| pick.contains(&q) || !in_sphere(&cell, points[q])) {
            out.push(pick.iter().map(|&i| i as u32).collect());
        }
        return;
    }
    for i in pick.last().map_or(0, |l| l + 1)..points.len() {
        pick.push(i);
        extend(points, pick, out);
        pick.pop();
    }
}

/// All cells of a small set by brute force, as sorted vertex lists.
fn brute<P: Point>(points: &[P]) -> Vec<Vec<u32>> {
    let mut cells = Vec::new();
    extend(points, &mut Vec::new(), &mut cells);
    cells
}

fn check_stars<P: Point>(points: &[P]) {
    let cells = brute(points);
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let mut builder = StarBuilder::default();
    for v in everyone.iter().copied() {
        let mut cost = Cost::default();
        assert!(builder.build(points, v, &everyone, &mut cost));
        assert!(cost.work() > 0 && cost.depth() > 0);
        let mut facets = Vec::new();
        builder.facets(&mut facets);
        let mut star: Vec<Vec<u32>> = facets
            .iter()
            .filter(|f| !f.as_ref().contains(&INFINITE))
            .map(|f| {
                let mut c = f.as_ref().to_vec();
                c.push(v);
                c.sort_unstable();
                c
            })
            .collect();
        star.sort();
        let expected: Vec<Vec<u32>> = cells.iter().filter(|c| c.contains(&v)).cloned().collect();
        assert_eq!(star, expected, "star of {v}");
    }
}

#[test]
fn stars_of_a_grid_match_brute_force() {
    let mut points = Vec::new();
    for x in 0..3 {
        for y in 0..3 {
            for z in 0..2 {
                points.push(DVec3::new(x as f64, y as f64, z as f64));
            }
        }
    }
    check_stars(&points);
    let plane: Vec<DVec2> = (0..16).map(|i| DVec2::new((i % 4) as f64, (i / 4) as f64)).collect();
    check_stars(&plane);
}

#[test]
fn stars_of_scattered_points_match_brute_force() {
    let mut draw = crate::hash::Draw::new(7);
    let mut next = || draw.below(1 << 24) as f64 / 1024.0;
    let points: Vec<DVec3> = (0..14).map(|_| DVec3::new(next(), next(), next())).collect();
    check_stars(&points);
    let points: Vec<DVec2> = (0..20).map(|_| DVec2::new(next(), next())).collect();
    check_stars(&points);
}

#[test]
fn stars_of_points_on_a_sphere_match_brute_force() {
    // All integer points at distance 3 from the origin: exactly cospherical.
    let range = -3..=3;
    let all = range.clone().flat_map(|x| range.clone().map(move |y| (x, y)));
    let all = all.flat_map(|(x, y)| range.clone().map(move |z| DVec3::new(x.into(), y.into(), z.into())));
    let lattice: Vec<DVec3> = all.filter(|p| p.dot(*p) == 9.0).collect();
    assert_eq!(lattice.len(), 30);
    check_stars(&lattice);
    // The points are rounded, and some lie inside the sphere, so that stars have conflicts of all kinds.
    let turned = |p: &DVec3| DVec3::new(p.x + 0.3 * p.y, p.y - 0.3 * p.x, p.z * 1.09_f64.sqrt()) / 7.0;
    let mut rounded: Vec<DVec3> = lattice.iter().step_by(2).map(turned).collect();
    check_stars(&rounded);
    rounded.extend([DVec3::new(0.01, 0.02, 0.0), DVec3::new(-0.2, 0.1, 0.05), DVec3::new(0.0, 0.0, 0.3)]);
    check_stars(&rounded);
    let circle = [(5, 0), (4, 3), (3, 4), (0, 5), (-3, 4), (-4, 3), (-5, 0), (-4, -3), (0, -5), (3, -4)];
    let mut plane: Vec<DVec2> = circle.iter().map(|&(x, y)| DVec2::new(x.into(), y.into())).collect();
    check_stars(&plane);
    plane.extend([DVec2::ZERO, DVec2::X, DVec2::new(0.5, -2.0)]);
    check_stars(&plane);
}

#[test]
fn flat_candidates_span_nothing() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
    let mut builder = StarBuilder::default();
    assert!(!builder.build(&points, 0, &[0, 1, 2, 3], &mut Cost::default()));
}

/// On sets of every kind, each star among all points equals the star in the triangulation. The sweeps end before all
/// candidates are tested.
fn stars_are_those_of_the_triangulation<P: Point>(n: usize) {
    let sorted = |mut facets: Vec<P::Facet>| {
        for facet in &mut facets {
            facet.as_mut().sort_unstable();
        }
        facets.sort_unstable();
        facets
    };
    for kind in KINDS {
        let points = set::<P>(kind, n, 21);
        let everyone: Vec<u32> = (0..points.len() as u32).collect();
        let triangulation = Incremental::new(points.clone()).unwrap();
        let (mut builder, mut cost, mut link) = (StarBuilder::default(), Cost::default(), Vec::new());
        for &v in &everyone {
            assert!(builder.build(&points, v, &everyone, &mut cost));
            builder.link.check().unwrap();
            let mut facets = Vec::new();
            builder.facets(&mut facets);
            triangulation.link_of(v, &mut link);
            assert_eq!(sorted(facets), sorted(link.clone()), "{kind}, star of {v}");
        }
        if kind == "random" {
            // The charge without early termination: a sort, and five sweeps for all candidates except one. (Hull facets
            // are always within reach.)
            let n = points.len() as u64;
            let full = n * (10 * (n - 2) + crate::cost::ceil_log2(n));
            assert!(cost.depth() * 4 < full, "{} of {full}", cost.depth());
        }
    }
}

#[test]
fn stars_of_space_are_those_of_the_triangulation() {
    stars_are_those_of_the_triangulation::<DVec3>(150);
}

#[test]
fn stars_of_the_plane_are_those_of_the_triangulation() {
    stars_are_those_of_the_triangulation::<DVec2>(150);
}

/// A facet with its vertices in canonical order, for comparison.
fn in_order<P: Point>(facet: &P::Facet) -> P::Facet {
    let mut facet = *facet;
    facet.as_mut().sort_unstable();
    facet
}

/// A star of some points that is extended by the rest equals the star of all. The reported removed and created facets
/// are correct. The witnesses in the spheres of removed cells are those that the predicates find.
fn check_extended<P: Point>(kind: &str, points: &[P]) -> usize {
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let (mut builder, mut direct) = (StarBuilder::default(), StarBuilder::default());
    let mut witnesses = Witnesses::default();
    let (mut cost, mut changed) = (Cost::default(), 0);
    for &v in &everyone {
        let stride = 2 + v as usize % 5;
        let some: Vec<u32> = everyone.iter().copied().skip(v as usize % 3).step_by(stride).collect();
        if !direct.build(points, v, &some, &mut cost) {
            continue;
        }
        let (mut old, mut new, mut anew) = (Vec::new(), Vec::new(), Vec::new());
        direct.facets(&mut old);
        let became = builder.extend(points, v, &old, &everyone, &mut cost);
        direct.build(points, v, &everyone, &mut cost);
        direct.facets(&mut anew);
        let set = |facets: &[P::Facet]| -> std::collections::BTreeSet<P::Facet> {
            facets.iter().map(in_order::<P>).collect()
        };
        if became == Extended::Same {
            assert_eq!(set(&old), set(&anew), "{kind}, star of {v}");
            continue;
        }
        assert_eq!(became, Extended::Changed, "{kind}, star of {v}");
        if P::DIM <= 3 {
            builder.link.check().unwrap();
        }
        builder.facets(&mut new);
        assert_eq!(set(&new), set(&anew), "{kind}, star of {v}");
        let (old_set, new_set) = (set(&old), set(&new));
        let mut fresh = Vec::new();
        builder.created_facets(&mut fresh);
        assert_eq!(set(&fresh), &new_set - &old_set, "{kind}: fresh facets of {v}");
        let gone: Vec<P::Facet> = builder.removed_facets().iter().map(|&at| old[at as usize]).collect();
        assert_eq!(set(&gone), &old_set - &new_set, "{kind}: removed facets of {v}");
        changed += gone.len();
        witnesses_of_removed(points, v, &gone, &new, &mut witnesses);
    }
    changed
}

fn check_extended_stars<P: Point>(n: usize) {
    for kind in KINDS {
        let changed = check_extended(kind, &set::<P>(kind, n, 5));
        assert!(changed > 0, "{kind}: no star changes");
    }
}

fn witnesses_of_removed<P: Point>(
    points: &[P],
    v: u32,
    gone: &[P::Facet],
    link: &[P::Facet],
    witnesses: &mut Witnesses<P>,
) {
    let all = link.iter().flat_map(AsRef::as_ref).copied().filter(|&q| q != INFINITE);
    let around: Vec<u32> = all.collect::<std::collections::BTreeSet<_>>().into_iter().collect();
    let mut step = crate::cost::Sweep::default();
    witnesses.load(points, v, &around, &mut step);
    for facet in gone.iter().filter(|f| !f.as_ref().contains(&INFINITE)) {
        let mut cell = P::Cell::splat(v);
        cell.as_mut()[1..].copy_from_slice(facet.as_ref());
        cell.as_mut().swap(0, 1);
        let corners: Vec<P> = [v].iter().chain(facet.as_ref()).map(|&i| points[i as usize]).collect();
        let mut found = Vec::new();
        witnesses.append_inside(points, &cell, &mut found, &mut step);
        let inside = |q: &u32| !facet.as_ref().contains(q) && in_sphere(&corners, points[*q as usize]);
        let expected: Vec<u32> = around.iter().copied().filter(inside).collect();
        assert_eq!(found, expected, "cell {facet:?} of {v}");
        assert!(!expected.is_empty(), "a removed cell has witnesses");
    }
}

#[test]
fn extended_stars_match_rebuilt_stars_of_space() {
    check_extended_stars::<DVec3>(90);
}

#[test]
fn extended_stars_match_rebuilt_stars_of_the_plane() {
    check_extended_stars::<DVec2>(90);
}

#[test]
fn a_star_with_a_hole_is_not_extended() {
    let points = set::<DVec3>("random", 60, 2);
    let everyone: Vec<u32> = (0..60).collect();
    let (mut builder, mut cost, mut link) = (StarBuilder::default(), Cost::default(), Vec::new());
    assert!(builder.build(&points, 7, &everyone, &mut cost));
    builder.facets(&mut link);
    link.remove(3);
    assert_eq!(builder.extend(&points, 7, &link, &everyone, &mut cost), Extended::Open);
    assert_eq!(builder.link_size(), 0);
}

/// Small lattices and scattered points, scaled by powers of two to the ends of the range.
fn stars_do_not_depend_on_scale<P: Point>() {
    let mut state = 7;
    let mut draw = || {
        state = crate::hash::mix(state, 1);
        f64::from((state >> 60) as u32)
    };
    for round in 0..40 {
        let coordinates = |draw: &mut dyn FnMut() -> f64| P::from_coords(&[0; 3].map(|_| draw())[..P::DIM]);
        let mut points: Vec<P> = (0..4 + round % 5).map(|_| coordinates(&mut draw)).collect();
        points.sort_unstable_by(crate::point::lex_cmp);
        points.dedup();
        if !(P::DIM + 1..=points.len()).any(|n| orientation(&points[n - P::DIM - 1..n]) != Sign::Zero) {
            continue;
        }
        for exponent in [-140, -127, -100, 0, 60, 100, 120, 124, 125, 126, 127, 128, 129, 130, 140] {
            let scaled: Vec<P> = points.iter().map(|&x| x * 2f64.powi(exponent)).collect();
            check_stars(&scaled);
        }
    }
}

#[test]
fn stars_of_scaled_points_match_brute_force() {
    stars_do_not_depend_on_scale::<DVec2>();
    stars_do_not_depend_on_scale::<DVec3>();
}
