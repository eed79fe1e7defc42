//! Times the predicates on inputs for each stage, next to the expansions of `robust`:
//! `cargo bench -p septet-bench --bench predicates`. The signs of every batch are compared before it is timed.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use septet_geometry::point::Point;
use septet_geometry::predicates::{Sign, in_sphere, orientation};

fn main() {
    divan::main();
}

/// Number of calls in a batch.
const CALLS: usize = 4096;

/// Kinds of inputs: random points; corners of integer cubes; such corners scaled by 0.1; points near a sphere;
/// points on a sphere; points on a sphere with 24 bits; points on a sphere with widely spread last bits.
const SETS: [&str; 7] = ["random", "grid", "decimal", "near sphere", "sphere", "single", "spread"];

type Call<P> = (Vec<P>, P);

fn direction<P: Point>(rng: &mut ChaCha8Rng) -> P {
    loop {
        let mut p = P::default();
        for i in 0..P::DIM {
            p.set_coord(i, rng.random_range(-1.0..1.0));
        }
        if p.norm2() <= 1.0 && p.norm2() > 0.01 {
            return p / p.norm2().sqrt();
        }
    }
}

fn mapped<P: Point>(mut p: P, mut f: impl FnMut(f64) -> f64) -> P {
    for i in 0..P::DIM {
        p.set_coord(i, f(p.coord(i)));
    }
    p
}

fn points<P: Point>(set: &str, rng: &mut ChaCha8Rng) -> Vec<P> {
    let n = P::DIM + 2;
    let base: P = direction(rng);
    let mut draw = || match set {
        "random" => mapped(P::default(), |_| rng.random()),
        "grid" => mapped(P::default(), |_| 1.0 + f64::from(rng.random_range(0..2u8))),
        "decimal" => mapped(P::default(), |_| f64::from(rng.random_range(10..12u8)) * 0.1),
        "near sphere" => {
            let near = base + direction::<P>(rng) * 1e-2;
            near / near.norm2().sqrt()
        }
        "sphere" => direction(rng),
        "single" => mapped(direction(rng), |x| f64::from(x as f32)),
        _ => {
            // Mirror images of one point, translated so that the last bits are small.
            let p: P = direction(rng);
            mapped(p, |x| x * 2f64.powi(-30) + if rng.random() { 0.0 } else { 2f64.powi(-12) })
        }
    };
    let mut points: Vec<P> = Vec::with_capacity(n);
    while points.len() < n {
        let p = draw();
        if !points.contains(&p) {
            points.push(p);
        }
    }
    points
}

/// Positively oriented cells, and query points.
fn calls<P: Point>(set: &str) -> Vec<Call<P>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut calls = Vec::with_capacity(CALLS);
    while calls.len() < CALLS {
        let mut cell: Vec<P> = points(set, &mut rng);
        let q = cell.pop().expect("DIM + 2 points");
        match orientation(&cell) {
            Sign::Zero => continue,
            Sign::Negative => cell.swap(0, 1),
            Sign::Positive => {}
        }
        calls.push((cell, q));
    }
    calls
}

fn planar(p: DVec2) -> robust::Coord<f64> {
    robust::Coord { x: p.x, y: p.y }
}

fn spatial(p: DVec3) -> robust::Coord3D<f64> {
    robust::Coord3D { x: p.x, y: p.y, z: p.z }
}

fn robust_in_sphere((c, q): &Call<DVec3>) -> f64 {
    -robust::insphere(spatial(c[0]), spatial(c[1]), spatial(c[2]), spatial(c[3]), spatial(*q))
}

fn robust_in_circle((c, q): &Call<DVec2>) -> f64 {
    robust::incircle(planar(c[0]), planar(c[1]), planar(c[2]), planar(*q))
}

/// Checks that the stages agree with nonzero signs of the expansions, and that some signs are nonzero.
fn compare<P: Point>(calls: &[Call<P>], expansion: impl Fn(&Call<P>) -> f64) {
    for call in calls {
        let sign = expansion(call);
        assert!(sign == 0.0 || in_sphere(&call.0, call.1) == (sign > 0.0), "{call:?}");
    }
}

fn time<P: Point>(bencher: Bencher, calls: &[Call<P>], f: impl Fn(&Call<P>) -> bool + Sync) {
    bencher.counter(ItemsCount::new(calls.len())).bench(|| black_box(calls).iter().filter(|c| f(c)).count());
}

#[divan::bench(args = SETS)]
fn in_sphere_stages(bencher: Bencher, set: &str) {
    let calls = calls::<DVec3>(set);
    compare(&calls, robust_in_sphere);
    time(bencher, &calls, |(cell, q)| in_sphere(cell, *q));
}

#[divan::bench(args = SETS)]
fn in_sphere_expansions(bencher: Bencher, set: &str) {
    time(bencher, &calls::<DVec3>(set), |call| robust_in_sphere(call) > 0.0);
}

#[divan::bench(args = SETS)]
fn in_circle_stages(bencher: Bencher, set: &str) {
    let calls = calls::<DVec2>(set);
    compare(&calls, robust_in_circle);
    time(bencher, &calls, |(cell, q)| in_sphere(cell, *q));
}

#[divan::bench(args = SETS)]
fn in_circle_expansions(bencher: Bencher, set: &str) {
    time(bencher, &calls::<DVec2>(set), |call| robust_in_circle(call) > 0.0);
}

/// Cells that are flat, exactly or up to rounding: the query point replaces a vertex, in the plane of the other
/// vertices.
fn flat(set: &str) -> Vec<[DVec3; 4]> {
    let on_plane = |(cell, _): &Call<DVec3>| {
        let [a, b, c] = [cell[0], cell[1], cell[2]];
        [a, b, c, a + (b - a) + (c - a)]
    };
    calls::<DVec3>(set).iter().map(on_plane).collect()
}

#[divan::bench(args = SETS)]
fn orientation_stages(bencher: Bencher, set: &str) {
    let cells = flat(set);
    for c in &cells {
        let sign = -robust::orient3d(spatial(c[0]), spatial(c[1]), spatial(c[2]), spatial(c[3]));
        assert_eq!(orientation(c), Sign::of(sign), "{c:?}");
    }
    bencher
        .counter(ItemsCount::new(cells.len()))
        .bench(|| black_box(&cells).iter().filter(|c| orientation(&c[..]) == Sign::Positive).count());
}

#[divan::bench(args = SETS)]
fn orientation_expansions(bencher: Bencher, set: &str) {
    let cells = flat(set);
    let positive =
        |c: &[DVec3; 4]| robust::orient3d(spatial(c[0]), spatial(c[1]), spatial(c[2]), spatial(c[3])) < 0.0;
    bencher
        .counter(ItemsCount::new(cells.len()))
        .bench(|| black_box(&cells).iter().filter(|c| positive(c)).count());
}
