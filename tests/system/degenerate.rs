//! Inputs with ties, coincidences, few points and extreme coordinates.

use crate::common::sets::{Draw, flat_grid, grid, plane, space};
use crate::common::transports::{TestTransport, each_transport};
use crate::common::{base, check, check_counted, check_over, simulated, with_workers, within};
use glam::{DMat3, DVec2, DVec3};
use septet_core::generate::Kind;
use septet_core::spec::Workers;
use septet_core::{Error, Outcome, triangulate};
use septet_geometry::point::Point;
use septet_geometry::range::RangeError;

/// Seconds after which a run of a few points has hung.
const PATIENCE: u64 = 60;

/// The size of the largest small sets.
const MOST_POINTS: usize = 9;

fn small_sets() -> Vec<(String, Vec<DVec3>)> {
    let unit = |i: usize| DVec3::from_array(std::array::from_fn(|axis| f64::from(axis == i)));
    let octahedron: Vec<DVec3> = (0..6).map(|i| unit(i / 2) * if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let mut draw = Draw::new(11);
    let random: Vec<DVec3> = (0..9).map(|_| draw.point()).collect();
    let collinear: Vec<DVec3> = (0..9).map(|i| DVec3::new(1.0, 2.0, -3.0) * i as f64).collect();
    let coplanar: Vec<DVec3> = grid([3, 3, 1], 0.5);
    let slanted: Vec<DVec3> = coplanar.iter().map(|p| DVec3::new(p.x, p.y, p.x - 2.0 * p.y)).collect();
    let with = |set: &[DVec3], extra: DVec3| [set, &[extra]].concat();
    let mut all = Vec::new();
    for (name, set) in [
        ("octahedron", with(&with(&octahedron, DVec3::ZERO), DVec3::ONE)),
        ("cube", with(&grid([2, 2, 2], 1.0), DVec3::splat(0.5))),
        ("collinear", collinear.clone()),
        (
            "collinear and one",
            with(&[DVec3::new(0.0, 1.0, 7.0)], DVec3::ZERO).into_iter().chain(collinear).collect(),
        ),
        ("coplanar", coplanar),
        (
            "slanted plane and one",
            with(&[DVec3::new(0.25, 0.25, 9.0)], DVec3::ZERO).into_iter().chain(slanted).collect(),
        ),
        ("coincident", vec![DVec3::new(0.1, 0.2, 0.3); 9]),
        ("two places", (0..9).map(|i| unit(i % 2)).collect()),
        ("four places", (0..9).map(|i| unit(i % 4)).collect()),
        ("random", random),
    ] {
        for n in 0..=set.len().min(MOST_POINTS) {
            all.push((format!("{name}, {n} points"), set[..n].to_vec()));
        }
    }
    all
}

/// A result that verifies, or no cells for a set that spans less.
fn small<P: Point>(what: &str, points: &[P]) {
    let mut reference: Option<Outcome> = None;
    for workers in [1, 3, 16] {
        let spec = with_workers(Workers::Count(workers), 2);
        let mut same = |start: TestTransport| {
            for counted in [false, true] {
                let (points, of) = (points.to_vec(), spec.clone());
                let label = format!("{what}, {start:?}, counted {counted}, {spec:?}");
                let run = within(PATIENCE, &label, move || check_over(start, &points, &of, counted));
                assert_eq!(run.dimension < P::DIM as isize, run.cell_count() == 0, "{label}");
                let accounted = run.points.used + run.left_out.duplicates.len() as u64;
                assert_eq!((accounted, run.left_out.refused.len()), (run.points.input, 0), "{label}");
                let reference = reference.get_or_insert_with(|| run.clone());
                assert_eq!(reference.cells(), run.cells(), "{label}");
            }
        };
        // The largest set of each kind, on every transport.
        if workers == 3 && points.len() >= MOST_POINTS {
            each_transport(same);
        } else {
            [TestTransport::Sim(3), TestTransport::Channel(2)].into_iter().for_each(&mut same);
        }
    }
}

#[test]
fn few_points_in_space_and_in_the_plane() {
    for (what, points) in small_sets() {
        small(&what, &points);
        let flat: Vec<DVec2> = points.iter().map(|p| p.truncate()).collect();
        small(&format!("{what}, plane"), &flat);
    }
}

/// Verified, without a fallback, and equal for some numbers of workers.
fn tied<P: Point>(what: &str, points: &[P]) -> Outcome {
    let run = check(points, &base());
    assert_eq!(run.fallback, None, "{what}");
    let spec = simulated(Workers::Count(7), 1, 200);
    let counted = septet_core::simulate(points, &spec).unwrap_or_else(|e| panic!("{what}: {e}"));
    assert!(counted.cells() == run.cells(), "{what}: other cells with 7 workers");
    assert_eq!(counted.fallback, None, "{what}");
    run
}

fn rotated(points: &[DVec3]) -> Vec<DVec3> {
    let matrix = DMat3::from_rotation_x(0.4) * DMat3::from_rotation_z(1.1);
    points.iter().map(|&p| matrix * p).collect()
}

#[test]
fn lattices_are_triangulated_without_a_fallback() {
    let run = tied("20^3", &grid([20, 20, 20], 1.0));
    // Cubes of five or six cells.
    assert!((5 * 6859..=6 * 6859).contains(&run.cell_count()), "{} cells", run.cell_count());
    let run = tied("60^2", &flat_grid(60, 60));
    assert_eq!(run.cell_count(), 2 * 59 * 59);
    tied("fcc", &space(Kind::Fcc, 4000, 0));
    tied("fcc in the plane", &plane(Kind::Fcc, 4000, 0));
    tied("rotated grid", &rotated(&grid([14, 14, 14], 1.0)));
    let turned: Vec<DVec2> = flat_grid(50, 50).iter().map(|p| DVec2::from_angle(0.3).rotate(*p)).collect();
    tied("rotated grid in the plane", &turned);
    tied("long grid", &grid([200, 4, 3], 0.125));
}

#[test]
fn spheres_are_triangulated_without_a_fallback() {
    tied("sphere", &space(Kind::Sphere, 4000, 1));
    tied("circle", &plane(Kind::Sphere, 4000, 1));
}

/// Almost all pairs of points are neighbours.
#[test]
fn cells_of_the_moment_curve_are_quadratic() {
    let run = within(PATIENCE, "moment curve", || check(&space(Kind::MomentCurve, 300, 0), &base()));
    assert_eq!(run.cell_count(), 298 * 297 / 2, "the cyclic polytope's lower hull");
}

fn skew_lines(n: usize) -> Vec<DVec3> {
    let point = |i: usize| {
        let t = (i / 2) as f64 / (n / 2) as f64;
        if i.is_multiple_of(2) { DVec3::new(t, 0.0, 0.0) } else { DVec3::new(0.5, t - 0.5, 1.0) }
    };
    (0..n).map(point).collect()
}

#[test]
fn cells_of_two_skew_lines_are_quadratic() {
    let run = within(PATIENCE, "skew lines", || check(&skew_lines(300), &base()));
    assert_eq!(run.cell_count(), 149 * 149);
}

#[test]
fn cells_of_two_skew_lines_are_quadratic_in_simulate() {
    let sim = simulated(Workers::Count(5), 1, 60);
    let run = within(PATIENCE, "skew lines, counted", move || check_counted(&skew_lines(300), &sim));
    assert_eq!(run.cell_count(), 149 * 149);
}

#[test]
fn cells_do_not_change_with_scale_and_position() {
    let points = space(Kind::Uniform, 1500, 4);
    let lattice = grid([9, 9, 9], 1.0);
    let flat = plane(Kind::Clusters, 1500, 4);
    let (cells, tied_cells, flat_cells) = (
        tied("unscaled", &points).cells().to_vec(),
        tied("grid", &lattice).cells().to_vec(),
        tied("plane", &flat).cells().to_vec(),
    );
    for exponent in [-398, 398] {
        // In two steps, because the factor itself may be out of range.
        let factor = 2f64.powi(exponent);
        let scale = |p: &DVec3| *p * factor;
        let scaled: Vec<DVec3> = points.iter().map(scale).collect();
        assert!(tied("scaled", &scaled).cells().to_vec() == cells, "2^{exponent}");
        let scaled: Vec<DVec3> = lattice.iter().map(scale).collect();
        assert!(tied("scaled grid", &scaled).cells().to_vec() == tied_cells, "2^{exponent}");
        let scaled: Vec<DVec2> = flat.iter().map(|p| *p * factor).collect();
        assert!(tied("scaled plane", &scaled).cells().to_vec() == flat_cells, "2^{exponent}");
    }
    for factor in [1e-120, 1e120] {
        tied("scaled by a power of ten", &points.iter().map(|p| *p * factor).collect::<Vec<_>>());
        tied("grid scaled by a power of ten", &lattice.iter().map(|p| *p * factor).collect::<Vec<_>>());
        tied("plane scaled by a power of ten", &flat.iter().map(|p| *p * factor).collect::<Vec<_>>());
    }
    tied("far away", &points.iter().map(|p| *p + 1e9).collect::<Vec<_>>());
    tied("plane far away", &flat.iter().map(|p| *p + 1e9).collect::<Vec<_>>());
    let moved: Vec<DVec3> = lattice.iter().map(|p| *p + 1e9).collect();
    assert!(tied("grid far away", &moved).cells().to_vec() == tied_cells);
}

#[test]
fn coincident_points_count_once() {
    let mut draw = Draw::new(5);
    let places = space(Kind::Uniform, 700, 4);
    let points: Vec<DVec3> = (0..2500).map(|_| places[draw.below(700)]).collect();
    let run = tied("duplicates", &points);
    assert_eq!(run.points.used + run.left_out.duplicates.len() as u64, 2500);
    for &(copy, of) in &run.left_out.duplicates {
        assert!(of < copy && points[of as usize] == points[copy as usize]);
    }
    assert!(run.left_out.duplicates.is_sorted());
    let signed: Vec<DVec2> =
        [[0.0, 0.0], [-0.0, 0.0], [1.0, -0.0], [0.0, 1.0], [1.0, 0.0]].map(DVec2::from).into();
    assert_eq!(tied("signed zeros", &signed).left_out.duplicates, [(1, 0), (4, 2)]);
}

#[test]
fn points_out_of_range_are_refused_by_index() {
    let mut points = space(Kind::Uniform, 50, 4);
    points[7] = DVec3::new(1e-300, 0.5, 0.5);
    points[9] = DVec3::new(1e200, 0.5, 0.5);
    let error = triangulate(&points, &base()).unwrap_err();
    assert!(matches!(error, Error::Points(RangeError::Spread { low: 7, high: 9, .. })), "{error}");
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        points[9] = DVec3::new(0.5, value, 0.5);
        points[7] = DVec3::splat(0.1);
        let error = triangulate(&points, &base()).unwrap_err();
        assert!(matches!(error, Error::Points(RangeError::NotFinite { index: 9, .. })), "{error}");
        let run = triangulate(&points, &base().with(|c| c.input.skip_invalid = true)).unwrap();
        assert_eq!((run.points.used, run.left_out.refused), (49, vec![9]));
    }
}
