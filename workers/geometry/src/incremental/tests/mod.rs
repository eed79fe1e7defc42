//! The kernel compared with brute force and with itself in other orders, and its invariants.

use crate::point::Simplex;
pub(crate) mod nasty;
mod oracle;
mod spheres;
pub(crate) mod weighted;

use crate::complex::INFINITE;
use crate::hash::Draw;
use crate::point::Point;
use crate::predicates::Sign;
use crate::predicates::orientation;
use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::cavity::conflicts;
use super::*;
use crate::point::{dist2, lex_cmp};
use crate::predicates::in_sphere;

/// The cells as sorted rows of coordinate bits, which do not depend on numbering.
fn by_coordinates<P: Point>(dt: &Incremental<P>) -> Vec<Vec<Vec<u64>>> {
    let bits = |&v: &u32| (0..P::DIM).map(|i| dt.vertices()[v as usize].coord(i).to_bits()).collect();
    let mut rows: Vec<Vec<Vec<u64>>> = dt
        .cells()
        .map(|cell| {
            let mut row: Vec<Vec<u64>> = cell.as_ref().iter().map(bits).collect();
            row.sort();
            row
        })
        .collect();
    rows.sort();
    rows
}

fn sorted_cells<P: Point>(dt: &Incremental<P>) -> Vec<P::Cell> {
    let mut cells: Vec<P::Cell> = dt.cells().collect();
    for cell in &mut cells {
        cell.as_mut().sort_unstable();
    }
    cells.sort_unstable();
    cells
}

/// All simplices whose perturbed circumsphere is empty.
fn brute_force<P: Point>(points: &[P]) -> Vec<P::Cell> {
    let n = P::DIM + 1;
    let mut cells = Vec::new();
    let mut chosen: Vec<usize> = (0..n).collect();
    if points.len() < n {
        return cells;
    }
    loop {
        let mut corners: Vec<P> = chosen.iter().map(|&i| points[i]).collect();
        let sign = orientation(&corners);
        if sign == Sign::Negative {
            corners.swap(0, 1);
        }
        let empty = || (0..points.len()).all(|i| chosen.contains(&i) || !in_sphere(&corners, points[i]));
        if sign != Sign::Zero && empty() {
            let mut cell = P::Cell::splat(0);
            for (to, &i) in cell.as_mut().iter_mut().zip(&chosen) {
                *to = i as u32;
            }
            cells.push(cell);
        }
        let Some(k) = (0..n).rev().find(|&k| chosen[k] < points.len() - n + k) else {
            break;
        };
        chosen[k] += 1;
        for j in k + 1..n {
            chosen[j] = chosen[j - 1] + 1;
        }
    }
    cells.sort_unstable();
    cells
}

/// Checks that neighbours are mutual, cells positive, facets locally Delaunay and stored incidences true.
fn check<P: Point>(dt: &Incremental<P>) {
    let n = P::DIM + 1;
    let complex = dt.complex();
    complex.check().unwrap();
    let mut star = Vec::new();
    let mut link = Vec::new();
    let mut incidences = 0;
    for v in (0..dt.vertices().len() as u32).filter(|&v| !dt.is_hidden(v)) {
        dt.star(v, &mut star);
        incidences += star.len();
        assert!(star.iter().all(|&c| complex.is_live(c) && complex.cell(c).as_ref().contains(&v)));
        dt.link_of(v, &mut link);
        for (facet, &cell) in link.iter().zip(&star) {
            if facet.as_ref().contains(&INFINITE) {
                continue;
            }
            let mut corners = vec![dt.vertices()[v as usize]];
            corners.extend(facet.as_ref().iter().map(|&u| dt.vertices()[u as usize]));
            assert_eq!(orientation(&corners), Sign::Positive, "cell {cell}");
        }
        assert!(P::IS_WEIGHTED || dt.nearest_vertex(dt.vertices()[v as usize], None) == v);
    }
    let expected: usize = complex
        .live_cells()
        .map(|c| complex.cell(c).as_ref().iter().filter(|&&v| v != INFINITE).count())
        .sum();
    assert_eq!(incidences, expected);
    for cell in complex.live_cells() {
        let infinite = complex.infinite_slot(cell);
        if infinite.is_none() {
            assert_eq!(orientation(&dt.corners(cell)[..n]), Sign::Positive);
        }
        for slot in (0..n).filter(|&slot| Some(slot) != infinite) {
            let (next, back) = complex.neighbour(cell, slot);
            let opposite = complex.cell(next).as_ref()[back];
            if opposite != INFINITE {
                assert!(!conflicts(&complex.slots, dt.vertices(), cell, dt.vertices()[opposite as usize]));
            }
        }
    }
}

fn agrees_with_brute_force<P: Point>(points: &[P]) {
    let dt = Incremental::new(points.to_vec()).unwrap();
    check(&dt);
    assert_eq!(sorted_cells(&dt), brute_force(points));
    // In the order of the slice, the first points may be coplanar, and the start must skip some of them.
    let dt = Incremental::build(points.to_vec(), None).unwrap();
    check(&dt);
    assert_eq!(sorted_cells(&dt), brute_force(points));
}

fn grid3(k: u32) -> Vec<DVec3> {
    let at = |i: u32| DVec3::new((i % k).into(), (i / k % k).into(), (i / k / k).into());
    (0..k.pow(3)).map(at).collect()
}

fn grid2(k: u32) -> Vec<DVec2> {
    (0..k * k).map(|i| DVec2::new((i % k).into(), (i / k).into())).collect()
}

#[test]
fn grids_agree_with_brute_force() {
    agrees_with_brute_force(&grid3(2));
    agrees_with_brute_force(&grid3(3));
    agrees_with_brute_force(&grid2(2));
    agrees_with_brute_force(&grid2(6));
}

#[test]
fn flat_prefixes_and_collinear_runs_agree_with_brute_force() {
    let mut points: Vec<DVec3> = (0..6).map(|i| DVec3::X * f64::from(i)).collect();
    points.extend((0..6).map(|i| DVec3::new(f64::from(i), 1.0, 0.0)));
    points.extend([DVec3::new(2.0, 0.5, 1.0), DVec3::new(2.0, 0.5, -1.0), DVec3::new(9.0, 9.0, 0.0)]);
    agrees_with_brute_force(&points);
    let mut plane: Vec<DVec2> = (0..9).map(|i| DVec2::X * f64::from(i)).collect();
    plane.extend([DVec2::new(4.0, 1.0), DVec2::new(4.0, -2.0), DVec2::new(4.0, 5.0)]);
    agrees_with_brute_force(&plane);
}

#[test]
fn cospherical_points_agree_with_brute_force() {
    // All integer vectors of squared length 9: (±3,0,0) and (±1,±2,±2) in every arrangement.
    let range = -3i32..=3;
    let mut points = Vec::new();
    for x in range.clone() {
        for y in range.clone() {
            for z in range.clone() {
                if x * x + y * y + z * z == 9 {
                    points.push(DVec3::new(x.into(), y.into(), z.into()));
                }
            }
        }
    }
    assert_eq!(points.len(), 30);
    agrees_with_brute_force(&points);
    points.push(DVec3::ZERO);
    agrees_with_brute_force(&points);
    let circle = [(5, 0), (4, 3), (3, 4), (0, 5)].into_iter();
    let circle = circle
        .flat_map(|(x, y)| [(x, y), (-x, y), (x, -y), (-x, -y)])
        .map(|(x, y)| DVec2::new(x.into(), y.into()));
    let circle = distinct(circle.collect());
    assert_eq!(circle.len(), 12);
    agrees_with_brute_force(&circle);
}

#[test]
fn a_grid_has_one_triangulation_in_every_order() {
    let points = grid3(8);
    let dt = Incremental::new(points.clone()).unwrap();
    check(&dt);
    let volume: f64 =
        dt.cells().map(|c| DVec3::rounded_orientation(&c.map(|v| points[v as usize])).det / 6.0).sum();
    assert!((volume - 343.0).abs() < 1e-9);
    let mut random = Draw::new(1);
    for _ in 0..3 {
        let mut shuffled = points.clone();
        random.shuffle(&mut shuffled);
        for dt2 in [Incremental::new(shuffled.clone()), Incremental::build(shuffled, None)] {
            assert_eq!(by_coordinates(&dt2.unwrap()), by_coordinates(&dt));
        }
    }
    let plane = Incremental::new(grid2(12)).unwrap();
    check(&plane);
    assert_eq!(plane.cells().count(), 2 * 11 * 11);
    let mut shuffled = grid2(12);
    random.shuffle(&mut shuffled);
    assert_eq!(by_coordinates(&Incremental::build(shuffled, None).unwrap()), by_coordinates(&plane));
}

#[test]
fn random_points_satisfy_the_invariants() {
    let mut random = Draw::new(7);
    let points: Vec<DVec3> =
        (0..1500).map(|_| DVec3::new(random.unit(), random.unit(), random.unit())).collect();
    let dt = Incremental::new(points.clone()).unwrap();
    check(&dt);
    for _ in 0..50 {
        let q = DVec3::new(random.unit(), random.unit(), random.unit()) * 1.5;
        let brute = (0..1500u32)
            .min_by(|&a, &b| dist2(points[a as usize], q).total_cmp(&dist2(points[b as usize], q)));
        assert_eq!(Some(dt.nearest_vertex(q, None)), brute);
    }
    let plane: Vec<DVec2> = points.iter().map(|p| p.truncate()).collect();
    let dt = Incremental::new(plane).unwrap();
    check(&dt);
    let hull = dt.complex().len() - dt.cells().count();
    assert_eq!(dt.cells().count(), 2 * 1500 - 2 - hull);
}

fn check_insertion_in_place<P: Point>() {
    for kind in nasty::KINDS {
        let points = nasty::set::<P>(kind, 150, 5);
        let Ok(whole) = Incremental::new(points.clone()) else { continue };
        let n = points.len() as u32;
        let orders = [
            (0..n).collect(),
            (0..n).rev().collect(),
            (0..n).map(|i| i / 2 + i % 2 * n.div_ceil(2)).collect(),
        ];
        for order in orders as [Vec<u32>; 3] {
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..n));
            let mut room = Vec::with_capacity(2 * points.len());
            room.extend_from_slice(&points);
            let dt = Incremental::build_in_place(room, order, &mut |_| true).unwrap();
            check(&dt);
            assert!(dt.vertices().iter().zip(&points).all(|(a, b)| *a == *b), "{kind}");
            assert_eq!(by_coordinates(&dt), by_coordinates(&whole), "{kind}");
        }
    }
}

#[test]
fn insertion_in_place_gives_the_same_cells() {
    check_insertion_in_place::<DVec3>();
    check_insertion_in_place::<DVec2>();
}

/// The cells that have one of the first `owned` vertices, by coordinates.
fn cells_around<P: Point>(dt: &Incremental<P>, owned: usize, points: &[P]) -> Vec<Vec<Vec<u64>>> {
    let bits = |p: &P| (0..P::DIM).map(|i| p.coord(i).to_bits()).collect::<Vec<u64>>();
    let own: Vec<Vec<u64>> = points[..owned].iter().map(bits).collect();
    // Infinity has no coordinates.
    let corner = |&v: &u32| dt.vertices().get(v as usize).map_or_else(Vec::new, bits);
    let corners = |cell: &P::Cell| {
        let mut row: Vec<Vec<u64>> = cell.as_ref().iter().map(corner).collect();
        row.sort();
        row
    };
    let mut cells: Vec<_> = dt.complex().entries().map(|(_, cell, _)| corners(cell)).collect();
    cells.retain(|cell| cell.iter().any(|corner| own.contains(corner)));
    cells.sort();
    cells
}

fn check_skipped_points<P: Point>() {
    for kind in nasty::KINDS {
        let points = nasty::set::<P>(kind, 150, 5);
        let Ok(whole) = Incremental::new(points.clone()) else { continue };
        for owned in [10, 40, 100].into_iter().filter(|&owned| owned < points.len()) {
            let Ok(mut part) = Incremental::build(points[..owned].to_vec(), None) else { continue };
            let mut skipped = 0;
            for &p in &points[owned..] {
                skipped += usize::from(part.insert_if_adjacent(p, None, owned as u32).unwrap().is_none());
            }
            check(&part);
            assert_eq!(part.vertices().len() + skipped, points.len(), "{kind}");
            assert_eq!(
                cells_around(&part, owned, &points),
                cells_around(&whole, owned, &points),
                "{kind} {owned}"
            );
        }
    }
}

#[test]
fn points_without_owned_neighbours_are_skipped() {
    check_skipped_points::<DVec3>();
    check_skipped_points::<DVec2>();
    let far: Vec<DVec2> = (0..20).map(|i| DVec2::new(f64::from(i), f64::from(i * i % 7))).collect();
    let mut dt = Incremental::build(far[..4].to_vec(), None).unwrap();
    let kept = far[4..].iter().filter(|&&p| dt.insert_if_adjacent(p, None, 4).unwrap().is_some()).count();
    assert!(kept < 16, "{kept}");
}

#[test]
fn points_in_an_empty_region_do_not_all_search_the_same_cells() {
    // A ball of owned points and a shell of others, then further points on the far side of the shell. The latter are
    // not adjacent to owned points.
    let mut random = Draw::new(3);
    let mut in_box = |low: f64, size: f64| {
        DVec3::new(low + size * random.unit(), low + size * random.unit(), low + size * random.unit())
    };
    let owned: Vec<DVec3> = (0..200).map(|_| in_box(0.0, 0.1)).collect();
    let shell: Vec<DVec3> = (0..4000).map(|_| in_box(-2.0, 4.0).normalize()).collect();
    let mut dt = Incremental::build(owned, None).unwrap();
    for &p in &shell {
        dt.insert(p, None).unwrap();
    }
    let before = dt.vertices().len();
    let late: Vec<DVec3> = (0..50).map(|_| in_box(2.0, 1.0)).collect();
    let kept = late.iter().filter(|&&p| dt.insert_if_adjacent(p, None, 200).unwrap().is_some()).count();
    check(&dt);
    assert_eq!(dt.vertices().len(), before + kept);
    // The first of them has a very large cavity in the hull, and is inserted only for that reason.
    assert!(kept > 0 && kept < 50, "{kept}");
}

#[test]
fn a_star_of_many_cells_is_complete() {
    // All points of a circle around a pole are in the star of the pole.
    let mut points: Vec<DVec3> = Vec::new();
    for i in 0..200 {
        let t = f64::from(i) / 100.0 - 1.0;
        points.push(DVec3::new((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t), 0.0));
    }
    points.push(DVec3::new(0.0, 0.0, 1.0));
    points.push(DVec3::new(0.0, 0.0, -1.0));
    let dt = Incremental::new(points).unwrap();
    check(&dt);
    let mut link = Vec::new();
    dt.link_of(200, &mut link);
    assert!(link.len() > 256);
}

#[test]
fn errors_state_their_reason() {
    let flat = Incremental::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE.with_z(0.0)]);
    assert_eq!(flat.unwrap_err(), IncrementalError::Flat { dimension: 2 });
    let none = Incremental::<DVec2>::new(Vec::new());
    assert_eq!(none.unwrap_err(), IncrementalError::Flat { dimension: -1 });
    let nan = Incremental::new(vec![DVec2::ZERO, DVec2::NAN]);
    assert_eq!(nan.unwrap_err(), IncrementalError::NotFinite { point: 1 });
    let twice = vec![DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::new(-0.0, 1.0)];
    let twice = Incremental::build(twice, None);
    assert_eq!(twice.unwrap_err(), IncrementalError::Coincident { point: 3, vertex: 2 });
    let mut dt = Incremental::new(vec![DVec2::ZERO, DVec2::X, DVec2::Y]).unwrap();
    let again = dt.insert(DVec2::X, None);
    assert_eq!(again, Err(IncrementalError::Coincident { point: 3, vertex: 1 }));
    assert_eq!(dt.insert(DVec2::ONE, Some(77)), Ok(3));
    assert_eq!(dt.insert(DVec2::splat(0.25), Some(0)), Ok(4));
    check(&dt);
}

fn distinct<P: Point>(mut points: Vec<P>) -> Vec<P> {
    points.sort_by(lex_cmp);
    points.dedup();
    points
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn small_integer_points_in_space(
        rows in prop::collection::vec((0i8..4, 0i8..4, 0i8..3), 5..14), seed: u64
    ) {
        let mut points = distinct(
            rows.iter().map(|&(x, y, z)| DVec3::new(x.into(), y.into(), z.into())).collect(),
        );
        Draw::new(seed).shuffle(&mut points);
        match Incremental::build(points.clone(), None) {
            Ok(dt) => {
                check(&dt);
                prop_assert_eq!(sorted_cells(&dt), brute_force(&points));
                let other = Incremental::new(points).unwrap();
                prop_assert_eq!(sorted_cells(&dt), sorted_cells(&other));
            }
            Err(error) => {
                let dimension = crate::predicates::affine_frame(&points).0;
                prop_assert_eq!(error, IncrementalError::Flat { dimension });
            }
        }
    }

    #[test]
    fn small_integer_points_in_the_plane(
        rows in prop::collection::vec((0i8..6, 0i8..5), 3..20), seed: u64
    ) {
        let mut points =
            distinct(rows.iter().map(|&(x, y)| DVec2::new(x.into(), y.into())).collect());
        Draw::new(seed).shuffle(&mut points);
        match Incremental::build(points.clone(), None) {
            Ok(dt) => {
                check(&dt);
                prop_assert_eq!(sorted_cells(&dt), brute_force(&points));
            }
            Err(error) => {
                let dimension = crate::predicates::affine_frame(&points).0;
                prop_assert_eq!(error, IncrementalError::Flat { dimension });
            }
        }
    }
}
