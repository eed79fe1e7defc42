//! Point sets that are difficult for rounding, for ties or for the search, compared with the [`oracle`].

use super::*;
use crate::point::Point;

/// Names of the sets made by [`set`].
pub(crate) const KINDS: [&str; 14] = [
    "random",
    "grid",
    "squeezed grid",
    "far grid",
    "shaken grid",
    "decimal",
    "sphere",
    "shells",
    "plane",
    "line",
    "clusters",
    "graded",
    "steep",
    "single",
];

fn cube<P: Point>(random: &mut Draw) -> P {
    random.point()
}

fn node<P: Point>(random: &mut Draw, side: usize) -> P {
    let coords = [0; 3].map(|_: i32| random.below(side) as f64);
    P::from_coords(&coords[..P::DIM])
}

fn direction<P: Point>(random: &mut Draw) -> P {
    loop {
        let p = cube::<P>(random) - P::splat(0.5);
        if p.norm2() > 0.01 && p.norm2() < 0.25 {
            return p / p.norm2().sqrt();
        }
    }
}

fn each<P: Point>(mut p: P, f: impl Fn(usize, f64) -> f64) -> P {
    for i in 0..P::DIM {
        p.set_coord(i, f(i, p.coord(i)));
    }
    p
}

/// A point of the set called `kind`.
fn point<P: Point>(kind: &str, i: usize, random: &mut Draw) -> P {
    match kind {
        "random" => cube(random),
        "grid" => node(random, 7),
        "squeezed grid" => each(node(random, 7), |axis, x| x * 1e-7f64.powi(axis as i32)),
        "far grid" => node::<P>(random, 7) + P::splat(1e9),
        "shaken grid" => {
            let ulps = random.below(3) as u64;
            each(node(random, 6), |axis, x| f64::from_bits((x + 1.0).to_bits() + ulps * (axis as u64 + 1)))
        }
        "decimal" => each(node(random, 9), |_, x| x * 0.1),
        "sphere" => direction(random),
        "shells" => direction::<P>(random) * (1.0 + random.below(3) as f64),
        // A quarter of the points lie outside the plane or the line.
        "plane" => {
            each(node(random, 12), |axis, x| if axis + 1 == P::DIM && !i.is_multiple_of(4) { 3.0 } else { x })
        }
        "line" => each(node(random, 40), |axis, x| if axis > 0 && !i.is_multiple_of(4) { 7.0 } else { x }),
        "clusters" => node::<P>(random, 3) + direction::<P>(random) * 1e-9 * random.unit(),
        "graded" => direction::<P>(random) * random.unit().powi(4),
        // Points as near to the origin as the range of exact signs admits.
        "steep" => direction::<P>(random) * random.unit().powi(40).max(1e-40),
        _ => each(cube(random), |_, x| f64::from(x as f32)),
    }
}

pub(crate) fn set<P: Point>(kind: &str, n: usize, seed: u64) -> Vec<P> {
    let mut random = Draw::new(seed);
    // Compression may produce a minus zero, which the order of coordinates excludes.
    let points = (0..n).map(|i| each(point::<P>(kind, i, &mut random), |_, x| x + 0.0)).collect();
    let mut points = distinct(points);
    random.shuffle(&mut points);
    points
}

fn as_rows<P: Point>(dt: &Incremental<P>) -> Vec<Vec<u32>> {
    sorted_cells(dt).iter().map(|cell| cell.as_ref().to_vec()).collect()
}

fn agrees_with_the_oracle<P: Point>(n: usize) {
    for kind in KINDS {
        let points = set::<P>(kind, n, 5);
        assert!(points.len() > 40, "{kind}");
        let expected = oracle::cells(&points);
        for order in [None, Some(insertion_order(&points))] {
            let dt = Incremental::build(points.clone(), order.as_deref()).unwrap();
            check(&dt);
            assert_eq!(as_rows(&dt), expected, "{kind}");
        }
    }
}

#[test]
fn nasty_points_of_space_agree_with_the_oracle() {
    agrees_with_the_oracle::<DVec3>(260);
}

#[test]
fn nasty_points_of_the_plane_agree_with_the_oracle() {
    agrees_with_the_oracle::<DVec2>(400);
}

fn holds_after_every_insertion<P: Point>(n: usize) {
    for kind in KINDS {
        let points = set::<P>(kind, n, 9);
        // The first points that span a cell; the skipped points are inserted later.
        let least = (1..n).find(|&k| Incremental::build(points[..k].to_vec(), None).is_ok()).unwrap();
        let mut dt = Incremental::build(points[..least].to_vec(), None).unwrap();
        for (k, &p) in points.iter().enumerate().skip(least) {
            assert_eq!(dt.insert(p, None), Ok(k as u32), "{kind}");
            check(&dt);
        }
        assert_eq!(as_rows(&dt), oracle::cells(&points), "{kind}");
    }
}

#[test]
fn space_is_sound_after_every_insertion() {
    holds_after_every_insertion::<DVec3>(50);
}

#[test]
fn the_plane_is_sound_after_every_insertion() {
    holds_after_every_insertion::<DVec2>(60);
}

/// Inserting a batch has the same result as single insertions, and finds existing vertices.
#[test]
fn batches_are_added_along_the_curve() {
    for kind in KINDS {
        let points = set::<DVec3>(kind, 200, 3);
        let half = points.len() / 2;
        let mut dt = Incremental::new(points[..half].to_vec()).unwrap();
        let numbers = dt.insert_all(&points[half / 2..], &mut |_| true).unwrap();
        assert_eq!(numbers.len(), points.len() - half / 2);
        for (&vertex, p) in numbers.iter().zip(&points[half / 2..]) {
            assert_eq!(dt.vertices()[vertex as usize], *p);
        }
        assert_eq!(dt.vertices().len(), points.len());
        check(&dt);
        let expected = Incremental::new(points).unwrap();
        assert_eq!(by_coordinates(&dt), by_coordinates(&expected), "{kind}");
        let stopped = dt.insert_all(&[DVec3::splat(0.123)], &mut |_| false);
        assert_eq!(stopped, Err(IncrementalError::Stopped));
    }
}

/// Points outside the frame of the first ones: their spheres may be unknown, but their cells are correct.
#[test]
fn points_far_outside_the_frame_are_added() {
    let mut points = set::<DVec3>("random", 40, 1);
    let mut dt = Incremental::new(points.clone()).unwrap();
    for exponent in [3, 9, 14, 30, 60] {
        for sign in [1.0, -1.0] {
            let far = DVec3::new(0.3, -0.7, 0.5) * sign * 10f64.powi(exponent);
            dt.insert(far, None).unwrap();
            points.push(far);
            check(&dt);
        }
    }
    assert_eq!(as_rows(&dt), oracle::cells(&points));
}
