//! Inputs that are accepted or repaired, and those that stay refused.

use glam::{DMat3, DVec2, DVec3};

use super::shapes::{cube, cube_surface, facet, join};
use crate::accept;
use crate::check;
use crate::defect::Defect;
use crate::input::{DomainKind, Input, InputFacet, InputSegment, Solid};
use crate::repair::{Change, Dropped, Repair, Tolerance};

fn repair() -> Tolerance {
    Tolerance::default().with(|t| t.repair = true)
}

fn accepted<P: Repair>(input: &Input<P>, tolerance: &Tolerance) -> (f64, Vec<Change>) {
    let made = accept(input, tolerance).unwrap_or_else(|defects| panic!("{defects:#?}"));
    (made.domain.measure() / 2f64.powi(P::DIM as i32 * made.domain.simplices.frame.exponent), made.changes)
}

fn refused(input: &Input<DVec3>, tolerance: &Tolerance) -> Vec<Defect> {
    accept(input, tolerance).map(|made| made.changes).unwrap_err()
}

#[test]
fn equal_points_count_as_one() {
    let whole = cube_surface();
    let points = whole.facets.iter().flat_map(|f| &f.polygons[0]).map(|&v| whole.points[v as usize]);
    let soup = Input::surface(points.collect(), (0..12).map(|i| vec![3 * i, 3 * i + 1, 3 * i + 2]));
    let (volume, changes) = accepted(&soup, &Tolerance::default());
    assert_eq!(volume, 64.0);
    assert!(matches!(changes[..], [Change::Welded { places: 8, points: 28, .. }]), "{changes:?}");
    assert_eq!(check(&soup).unwrap_err().len(), 8);
    assert_eq!(refused(&soup, &Tolerance::default().with(|t| t.strict = true)).len(), 8);
    // An isolated point of a complex, twice, is one corner.
    let mut twice = cube();
    twice.points.extend([DVec3::ONE; 2]);
    let made = accept(&twice, &Tolerance::default()).unwrap();
    assert_eq!(made.domain.corners, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    // In the plane.
    let corners = [[0., 0.], [2., 0.], [2., 1.], [0., 1.], [0., 0.], [2., 0.], [2., 1.], [0., 1.]];
    let mut square = Input::new(DomainKind::Complex, corners.map(DVec2::from).to_vec());
    square.segments = [[0, 1], [5, 2], [6, 3], [7, 4]].map(|ends| InputSegment { ends, marker: 0 }).to_vec();
    assert_eq!(accepted(&square, &Tolerance::default()).0, 2.0);
}

#[test]
fn facets_flat_within_the_digits_become_triangles() {
    let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(0.4);
    let rounded = |p: DVec3, digits: usize| -> DVec3 {
        let text = |x: f64| -> f64 { format!("{x:.digits$}").parse().unwrap() };
        let p = turn * p;
        DVec3::new(text(p.x), text(p.y), text(p.z))
    };
    for (digits, limit) in [(6, 1e-6), (9, 1e-9)] {
        let mut turned = cube();
        turned.points = turned.points.iter().map(|&p| rounded(p, digits)).collect();
        let (volume, changes) = accepted(&turned, &Tolerance::default());
        assert!((volume - 64.0).abs() < 100.0 * limit, "{volume}");
        let [Change::NotFlat { facets, most, .. }] = changes[..] else { panic!("{changes:?}") };
        assert!(facets > 0 && most > 0.0 && most <= 2.0 * limit, "{changes:?}");
        assert!(check(&turned).unwrap_err().iter().all(|d| matches!(d, Defect::NotPlanar { .. })));
        let made = accept(&turned, &Tolerance::default()).unwrap();
        assert!(made.domain.facets.iter().all(|f| f.of.len() == 1 && f.of[0] < 6));
    }
    // Few digits are exact, and so is a corner off by more than the digits.
    let mut bent = cube();
    bent.points[7].z += 0.5;
    assert!(matches!(refused(&bent, &Tolerance::default())[..], [Defect::NotPlanar { .. }, ..]));
    let mut off = cube();
    off.points = off.points.iter().map(|&p| rounded(p, 6)).collect();
    off.points[7].z += 1e-3;
    assert!(matches!(refused(&off, &Tolerance::default())[..], [Defect::NotPlanar { .. }, ..]));
    // A facet with a hole, and a facet in it.
    let mut framed = cube();
    framed.points.extend([[1., 1., 4.], [3., 1., 4.], [3., 3., 4.], [1., 3., 4.]].map(DVec3::from));
    framed.facets[1].polygons.push(vec![8, 9, 10, 11]);
    framed.facets[1].holes.push(DVec3::new(2.0, 2.0, 4.0));
    facet(&mut framed, &[&[8, 9, 10, 11]]);
    framed.facets[1].holes[0] = turn * framed.facets[1].holes[0];
    framed.points = framed.points.iter().map(|&p| rounded(p, 7)).collect();
    let (volume, _) = accepted(&framed, &Tolerance::default());
    assert!((volume - 64.0).abs() < 1e-4, "{volume}");
}

#[test]
fn bent_polygons_of_surfaces_are_repaired() {
    let mut bent = Input::surface(cube().points, super::shapes::SQUARES.map(|s| s.to_vec()));
    bent.points[7] += DVec3::splat(0.5);
    assert!(matches!(refused(&bent, &Tolerance::default())[..], [Defect::NotPlanar { .. }, ..]));
    let (volume, changes) = accepted(&bent, &repair());
    assert!(volume > 64.0 && volume < 80.0, "{volume}");
    assert_eq!(changes.iter().filter(|c| matches!(c, Change::Bent { .. })).count(), 3, "{changes:?}");
}

#[test]
fn edges_of_four_facets_are_accepted_and_those_of_three_are_not() {
    let mut pair = join(&cube_surface(), &cube_surface(), DVec3::new(4.0, 4.0, 0.0), 1.0);
    // An edge.
    let (volume, changes) = accepted(&pair, &Tolerance::default());
    assert_eq!(volume, 128.0);
    assert!(
        matches!(changes[..], [Change::Welded { .. }, Change::NotManifold { edges: 1, vertices: 0, .. }]),
        "{changes:?}"
    );
    let made = accept(&pair, &Tolerance::default()).unwrap();
    assert!(!made.domain.manifold && accept(&cube_surface(), &Tolerance::default()).unwrap().domain.manifold);
    // A fin at an edge.
    pair.points.push(DVec3::new(9.0, 1.0, 9.0));
    pair.facets.push(InputFacet { polygons: vec![vec![6, 7, 16]], holes: vec![], marker: 0 });
    let found = refused(&pair, &Tolerance::default());
    assert!(
        found.iter().any(|d| matches!(d, Defect::NonManifoldEdge { facets, .. } if facets.len() == 3)),
        "{found:?}"
    );
    // A corner.
    let corner = join(&cube_surface(), &cube_surface(), DVec3::splat(4.0), 1.0);
    let (volume, changes) = accepted(&corner, &Tolerance::default());
    assert_eq!(volume, 128.0);
    assert!(matches!(changes[..], [_, Change::NotManifold { edges: 0, vertices: 1, .. }]), "{changes:?}");
    // A face: it is listed twice, and neither is needed.
    let face = join(&cube_surface(), &cube_surface(), DVec3::new(4.0, 0.0, 0.0), 1.0);
    assert!(refused(&face, &Tolerance::default()).iter().any(|d| d.kind() == "overlap"));
}

#[test]
fn double_and_flat_facets_go_on_request() {
    let dropped = |changes: &[Change]| -> Vec<Dropped> {
        changes
            .iter()
            .filter_map(|c| if let Change::Dropped { why, .. } = c { Some(*why) } else { None })
            .collect()
    };
    // A face listed twice is needed once.
    let mut twice = cube_surface();
    twice.facets.push(twice.facets[3].clone());
    assert!(refused(&twice, &Tolerance::default()).iter().any(|d| matches!(d, Defect::Doubled { .. })));
    let (volume, changes) = accepted(&twice, &repair());
    assert_eq!((volume, dropped(&changes)), (64.0, vec![Dropped::Double]));
    // A slit is not needed at all.
    let mut slit = cube_surface();
    slit.points.extend([[1., 1., 1.], [2., 1., 1.], [1., 2., 1.]].map(DVec3::from));
    for polygon in [vec![8, 9, 10], vec![8, 10, 9]] {
        slit.facets.push(InputFacet { polygons: vec![polygon], holes: vec![], marker: 0 });
    }
    let (volume, changes) = accepted(&slit, &repair());
    assert_eq!((volume, dropped(&changes)), (64.0, vec![Dropped::Double; 2]));
    // A triangle without area, whose long edge is that of its neighbour.
    let mut cap = cube_surface();
    cap.points.push(DVec3::new(2.0, 0.0, 0.0));
    let at = |t: [u32; 3]| InputFacet { polygons: vec![t.to_vec()], holes: vec![], marker: 0 };
    let with = |f: &InputFacet<DVec3>| f.polygons[0].contains(&0) && f.polygons[0].contains(&1);
    let split = cap.facets.iter().position(with).unwrap();
    let third = cap.facets[split].polygons[0].iter().copied().find(|v| *v > 1).unwrap();
    cap.facets[split] = at([0, 8, third]);
    cap.facets.extend([at([8, 1, third]), at([0, 8, 1])]);
    assert!(refused(&cap, &Tolerance::default()).iter().any(|d| matches!(d, Defect::Degenerate { .. })));
    let (volume, changes) = accepted(&cap, &repair());
    assert_eq!((volume, dropped(&changes)), (64.0, vec![Dropped::Degenerate]));
    assert!(
        changes.iter().any(|c| matches!(c, Change::Divided { point: 8, distance: 0.0, .. })),
        "{changes:?}"
    );
}

#[test]
fn junctions_and_small_holes_are_closed_on_request() {
    // A point within the digits of an open edge.
    let mut rounded = cube_surface();
    rounded.points.iter_mut().for_each(|p| *p += DVec3::splat(0.123_456));
    rounded.points.push(DVec3::new(2.123_456, 0.123_457, 0.123_456));
    let with = |f: &InputFacet<DVec3>| f.polygons[0].contains(&0) && f.polygons[0].contains(&1);
    let split = rounded.facets.iter().position(with).unwrap();
    let third = rounded.facets[split].polygons[0].iter().copied().find(|v| *v > 1).unwrap();
    rounded.facets[split].polygons[0] = vec![0, 8, third];
    let second = InputFacet { polygons: vec![vec![8, 1, third]], ..rounded.facets[split].clone() };
    rounded.facets.push(second);
    assert!(refused(&rounded, &Tolerance::default()).iter().any(|d| matches!(d, Defect::OpenEdge { .. })));
    let (volume, changes) = accepted(&rounded, &repair());
    assert!((volume - 64.0).abs() < 1e-4, "{volume}");
    assert!(
        changes.iter().any(|c| matches!(c, Change::Divided { point: 8, distance, .. } if *distance > 0.0))
    );
    // A hole of a coarse surface is large, one of a fine surface is small.
    let mut open = cube_surface();
    open.facets.pop();
    assert!(refused(&open, &repair()).iter().all(|d| matches!(d, Defect::OpenEdge { .. })));
    let fine = |n: u32| {
        let grid = move |axis: usize, side: u32| {
            let point = move |i: u32, j: u32| {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) =
                    (f64::from(side * n), f64::from(i), f64::from(j));
                DVec3::from(p)
            };
            (0..n * n).flat_map(move |k| {
                let (i, j) = (k / n, k % n);
                let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
        };
        (0..3).flat_map(move |axis| (0..2).flat_map(move |side| grid(axis, side)))
    };
    let mut triangles: Vec<[DVec3; 3]> = fine(4).collect();
    triangles.drain(11..13);
    triangles.remove(100);
    let count = triangles.len() as u32;
    let soup = Input::surface(triangles.concat(), (0..count).map(|i| vec![3 * i, 3 * i + 1, 3 * i + 2]));
    assert!(!refused(&soup, &Tolerance::default()).is_empty());
    let (volume, changes) = accepted(&soup, &repair());
    assert_eq!(volume, 64.0);
    let filled = |c: &&Change| matches!(c, Change::Filled { .. });
    assert!(changes.iter().filter(filled).count() >= 2, "{changes:?}");
}

#[test]
fn welds_move_no_point_further_than_asked() {
    let mut near = join(&cube_surface(), &cube_surface(), DVec3::new(4.0 + 3e-4, 0.0, 0.0), 1.0);
    near.solids = vec![Solid { name: "a".into(), end: 12 }, Solid { name: "b".into(), end: 24 }];
    assert!((accepted(&near, &Tolerance::default()).0 - 128.0).abs() < 1e-9);
    let weld = |d| Tolerance::default().with(|t| t.weld = Some(d));
    let (volume, changes) = accepted(&near, &weld(1e-3));
    assert!((volume - 128.0).abs() < 0.01 && volume != 128.0, "{volume}");
    assert!(
        matches!(changes[0], Change::Moved { points: 4, most, .. } if (most - 3e-4).abs() < 1e-12),
        "{changes:?}"
    );
    assert!(changes.iter().any(|c| matches!(c, Change::Regions { shared: 2, .. })), "{changes:?}");
    // A gap that is narrower than the distance.
    let mut short = cube_surface();
    short.points.push(short.points[7] - DVec3::X * 1e-5);
    for f in short.facets.iter_mut().filter(|f| f.polygons[0].contains(&7) && f.polygons[0].contains(&6)) {
        let replaced = f.polygons[0].iter_mut().filter(|v| **v == 7);
        replaced.for_each(|v| *v = 8);
    }
    assert!(!refused(&short, &Tolerance::default()).is_empty());
    assert!((accepted(&short, &weld(1e-4)).0 - 64.0).abs() < 1e-3);
}
