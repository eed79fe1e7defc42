//! Stars against brute force.

use super::*;
use crate::incremental::Incremental;
use crate::incremental::tests::nasty::{KINDS, set};
use crate::predicates::in_sphere;
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

/// Every cell of a tiny set found by brute force, as sorted vertex lists.
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
        let mut cost = Cost::ZERO;
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
    let mut state = 7u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / 1024.0
    };
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
    // Rounded, and with some points inside, so that stars have conflicts of every kind.
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

/// Every star among all points is that of the triangulation, on sets of every kind; the sweeps end before the
/// candidates do.
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
            // A sort and two steps for every candidate but one, were none left out. (Hull facets reach everywhere.)
            let n = points.len() as u64;
            let full = n * (2 * (n - 2) + crate::cost::ceil_log2(n));
            assert!(cost.depth() * 4 < full * 3, "{} of {full}", cost.depth());
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
