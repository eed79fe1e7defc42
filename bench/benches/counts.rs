//! A gate on the instruction counts of the kernels: `cargo bench -p septet-bench --bench counts`.
//!
//! It needs valgrind and `gungraun-runner`, which `tests/run` installs. Sets and seeds are fixed, and the loops use the
//! baseline registers of x86-64. The counts therefore depend only on the compiler. A kernel may need 5 % more
//! instructions than the figure recorded below. Lower the figure if a change makes a kernel cheaper. The benchmark
//! checks the results before it counts.

#![expect(missing_docs, reason = "macros make modules of functions")]

use std::hint::black_box;

use glam::{DVec2, DVec3};
use gungraun::{
    Callgrind, EventKind, LibraryBenchmarkConfig, library_benchmark, library_benchmark_group, main,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use septet_geometry::cost::Cost;
use septet_geometry::hull::StarBuilder;
use septet_geometry::incremental::Incremental;
use septet_geometry::kd_blocks::KdBlocks;
use septet_geometry::neighbourhood::nearest_in_blocks;
use septet_geometry::point::{Point, dist2};
use septet_geometry::simd::use_baseline_registers;

/// Allows 5 % more instructions than the recorded figure.
fn at_most(counted: u64) -> LibraryBenchmarkConfig {
    let mut config = LibraryBenchmarkConfig::default();
    config.tool(Callgrind::default().hard_limits([(EventKind::Ir, counted / 100 * 105)]));
    config
}

fn uniform<P: Point>(n: usize) -> Vec<P> {
    use_baseline_registers();
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    let coords = |rng: &mut ChaCha8Rng| -> [f64; 3] { [rng.random(), rng.random(), rng.random()] };
    (0..n).map(|_| P::from_coords(&coords(rng)[..P::DIM])).collect()
}

fn grid(side: u32) -> Vec<DVec3> {
    use_baseline_registers();
    let at = |i: u32| [i % side, i / side % side, i / side / side].map(f64::from);
    (0..side.pow(3)).map(|i| DVec3::from_array(at(i))).collect()
}

/// Points on a sphere, with rounded coordinates.
fn sphere(n: usize) -> Vec<DVec3> {
    uniform::<DVec3>(n).into_iter().map(|p| (p * 2.0 - 1.0).normalize()).collect()
}

/// The 84 nearest neighbours of each of 1,000 points, among 20,000 points.
fn lists() -> (Vec<DVec3>, Vec<Vec<u32>>) {
    let points: Vec<DVec3> = uniform(20_000);
    let near = |c: usize| {
        let mut near: Vec<u32> = (0..points.len() as u32).collect();
        let distance = |&i: &u32| dist2(points[i as usize], points[c]);
        near.select_nth_unstable_by(84, |a, b| distance(a).total_cmp(&distance(b)));
        near.truncate(84);
        near
    };
    let lists = (0..1000).map(near).collect();
    (points, lists)
}

fn cells<P: Point>(points: Vec<P>) -> usize {
    let n = points.len();
    let cells = Incremental::new(black_box(points)).expect("points that span the space").complex().len();
    assert!(cells > n, "{cells} cells of {n} points");
    cells
}

#[library_benchmark(config = at_most(328_610_728))]
#[bench::uniform(uniform(20_000))]
fn triangulate_space(points: Vec<DVec3>) -> usize {
    cells(points)
}

#[library_benchmark(config = at_most(217_806_145))]
#[bench::grid(grid(20))]
fn triangulate_grid(points: Vec<DVec3>) -> usize {
    cells(points)
}

#[library_benchmark(config = at_most(238_833_035))]
#[bench::sphere(sphere(5_000))]
fn triangulate_sphere(points: Vec<DVec3>) -> usize {
    cells(points)
}

#[library_benchmark(config = at_most(71_445_634))]
#[bench::uniform(uniform(20_000))]
fn triangulate_plane(points: Vec<DVec2>) -> usize {
    cells(points)
}

// Five sweeps of each insertion are charged, which takes 5 % of the instructions.
#[library_benchmark(config = at_most(49_723_370))]
#[bench::uniform(lists())]
fn stars((points, lists): (Vec<DVec3>, Vec<Vec<u32>>)) -> usize {
    let mut builder = StarBuilder::default();
    let mut facets = 0;
    for (c, near) in (0..).zip(black_box(&lists)) {
        assert!(builder.build(&points, c, near, &mut Cost::default()));
        facets += builder.link_size();
    }
    facets
}

#[library_benchmark(config = at_most(8_096_726))]
#[bench::uniform(uniform(700))]
fn nearest(points: Vec<DVec3>) -> usize {
    let nearest = nearest_in_blocks(&KdBlocks::of(&points), 0, 48, &mut Cost::default());
    let found = nearest.items();
    assert_eq!(found, 48 * points.len());
    found
}

library_benchmark_group!(
    name = kernels,
    benchmarks = [triangulate_space, triangulate_grid, triangulate_sphere, triangulate_plane, stars, nearest]
);

main!(library_benchmark_groups = kernels);
