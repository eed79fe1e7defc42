//! The sequential kernel on sets of every kind in both dimensions: `cargo bench -p septet-bench --bench kernels`.
//!
//! Every result is verified before it is timed. By the exact predicates, all cells are positively oriented, and each
//! facet is shared by two cells and locally Delaunay.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use septet_geometry::complex::INFINITE;
use septet_geometry::cost::Cost;
use septet_geometry::hull::StarBuilder;
use septet_geometry::incremental::{Incremental, insertion_order};
use septet_geometry::point::{Point, dist2};
use septet_geometry::predicates::{Sign, in_sphere, orientation};

fn main() {
    divan::main();
}

/// The number of points of a set.
const POINTS: usize = 20_000;

/// Graded points at a distance of `u^4` from the origin, for uniform `u`.
const SETS: [&str; 6] = ["uniform", "jittered", "graded", "sphere", "grid", "clusters"];

fn cube<P: Point>(rng: &mut ChaCha8Rng) -> P {
    let coords: [f64; 3] = [rng.random(), rng.random(), rng.random()];
    P::from_coords(&coords[..P::DIM])
}

fn direction<P: Point>(rng: &mut ChaCha8Rng) -> P {
    loop {
        let p = cube::<P>(rng) * 2.0 - P::splat(1.0);
        if p.norm2() <= 1.0 && p.norm2() > 0.01 {
            return p / p.norm2().sqrt();
        }
    }
}

fn lattice<P: Point>() -> Vec<P> {
    let side = (POINTS as f64).powf(1.0 / P::DIM as f64).round() as usize;
    let node = |i: usize| {
        let coords = [i % side, i / side % side, i / side / side].map(|c| c as f64);
        P::from_coords(&coords[..P::DIM])
    };
    (0..side.pow(P::DIM as u32)).map(node).collect()
}

fn points<P: Point>(set: &str) -> Vec<P> {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    match set {
        "grid" => lattice(),
        "jittered" => lattice::<P>().into_iter().map(|p| p + cube::<P>(rng) * 0.8).collect(),
        "sphere" => (0..POINTS).map(|_| direction(rng)).collect(),
        "graded" => (0..POINTS).map(|_| direction::<P>(rng) * rng.random::<f64>().powi(4)).collect(),
        "clusters" => {
            let centres: Vec<P> = (0..10).map(|_| cube(rng)).collect();
            let near = |i: usize| {
                let spread = 0.1 * 0.5f64.powi((i % 10) as i32) * rng.random::<f64>();
                centres[i % 10] + direction::<P>(rng) * spread
            };
            (0..POINTS).map(near).collect()
        }
        _ => (0..POINTS).map(|_| cube(rng)).collect(),
    }
}

/// Returns the vertices of a finite cell.
fn corners<P: Point>(points: &[P], cell: &P::Cell) -> Vec<P> {
    cell.as_ref().iter().map(|&v| points[v as usize]).collect()
}

fn verify<P: Point>(triangulation: &Incremental<P>) {
    let (points, cells) = (triangulation.vertices(), triangulation.complex());
    cells.check().expect("mutual neighbours");
    let mut seen = vec![false; points.len()];
    for (cell, vertices, _) in cells.entries().filter(|(_, v, _)| !v.as_ref().contains(&INFINITE)) {
        let here = corners(points, vertices);
        assert_eq!(orientation(&here), Sign::Positive);
        for (slot, &v) in vertices.as_ref().iter().enumerate() {
            seen[v as usize] = true;
            let (next, back) = cells.neighbour(cell, slot);
            let opposite = cells.cell(next).as_ref()[back];
            assert!(opposite == INFINITE || !in_sphere(&here, points[opposite as usize]));
        }
    }
    assert!(seen.iter().all(|&seen| seen), "a point is in no cell");
}

fn triangulate<P: Point>(bencher: Bencher, set: &str) {
    let points: Vec<P> = points(set);
    verify(&Incremental::new(points.clone()).expect("points that span the space"));
    bencher
        .counter(ItemsCount::new(points.len()))
        .with_inputs(|| points.clone())
        .bench_values(|points| Incremental::new(points).expect("as before").complex().len());
}

#[divan::bench(args = SETS)]
fn space(bencher: Bencher, set: &str) {
    triangulate::<DVec3>(bencher, set);
}

#[divan::bench(args = SETS)]
fn plane(bencher: Bencher, set: &str) {
    triangulate::<DVec2>(bencher, set);
}

/// Times only the insertion order, after a check that it is a permutation.
#[divan::bench]
fn order_in_space(bencher: Bencher) {
    let points: Vec<DVec3> = points("uniform");
    let mut order = insertion_order(&points);
    order.sort_unstable();
    assert!(order.into_iter().eq(0..points.len() as u32));
    bencher.counter(ItemsCount::new(points.len())).bench(|| insertion_order(black_box(&points)));
}

/// Builds stars from their candidates. Their facets must be those of the triangulation.
#[divan::bench(args = SETS)]
fn stars(bencher: Bencher, set: &str) {
    const CANDIDATES: usize = 120;
    const STARS: usize = 300;
    let points: Vec<DVec3> = points(set);
    let triangulation = Incremental::new(points.clone()).expect("points that span the space");
    let near = |c: u32| {
        let distance = |i: u32| dist2(points[i as usize], points[c as usize]);
        let mut link = Vec::new();
        triangulation.link_of(c, &mut link);
        let mut near: Vec<u32> = (0..points.len() as u32).filter(|&i| i != c).collect();
        near.select_nth_unstable_by(CANDIDATES, |&a, &b| distance(a).total_cmp(&distance(b)));
        near.truncate(CANDIDATES);
        near.extend(link.iter().flatten().filter(|&&v| v != INFINITE));
        near.sort_unstable();
        near.dedup();
        (c, near, link.len())
    };
    let stars: Vec<(u32, Vec<u32>, usize)> = (0..STARS).map(|i| near((i * 61) as u32)).collect();
    let mut builder = StarBuilder::default();
    for (c, near, facets) in &stars {
        assert!(builder.build(&points, *c, near, &mut Cost::default()));
        assert_eq!(builder.link_size(), *facets, "star of {c}");
    }
    bencher.counter(ItemsCount::new(stars.len())).bench_local(|| {
        for (c, near, _) in black_box(&stars) {
            builder.build(&points, *c, near, &mut Cost::default());
        }
    });
}
