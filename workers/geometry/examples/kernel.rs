//! Times the sequential kernel, or runs it once under an instruction counter.
//!
//! `kernel SET N [DIMENSION [REPEATS]]`: sets are uniform, jittered, graded, clusters, sphere, grid.
//! Prints nanoseconds of the processor per point, best of the repeats, of the ordering and of the
//! triangulation. `valgrind --tool=callgrind` on it counts instructions.

use glam::{DVec2, DVec3};
use septet_geometry::hash::Draw;
use septet_geometry::incremental::{Incremental, insertion_order};
use septet_geometry::point::Point;

/// A random direction.
fn direction<P: Point>(random: &mut Draw) -> P {
    loop {
        let p = random.point::<P>() * 2.0 - P::splat(1.0);
        if p.norm2() > 0.01 && p.norm2() < 1.0 {
            return p / p.norm2().sqrt();
        }
    }
}

fn lattice<P: Point>(n: usize) -> Vec<P> {
    let side = (n as f64).powf(1.0 / P::DIM as f64).round() as usize;
    let point = |i: usize| {
        let coords = [i % side, i / side % side, i / side / side].map(|c| c as f64);
        P::from_coords(&coords[..P::DIM])
    };
    (0..side.pow(P::DIM as u32)).map(point).collect()
}

fn points<P: Point>(kind: &str, n: usize) -> Vec<P> {
    let mut random = Draw::new(42);
    match kind {
        "jittered" => lattice::<P>(n).into_iter().map(|p| p + random.point::<P>() * 0.8).collect(),
        "grid" => lattice(n),
        "graded" => (0..n).map(|_| direction::<P>(&mut random) * random.unit().powi(4)).collect(),
        "sphere" => (0..n).map(|_| direction::<P>(&mut random)).collect(),
        "clusters" => {
            let centres: Vec<P> = (0..10).map(|_| random.point()).collect();
            let spread = |i: usize| 0.1 * 0.5f64.powi((i % 10) as i32);
            let near = |r: &mut Draw| direction::<P>(r) * r.unit();
            (0..n).map(|i| centres[i % 10] + near(&mut random) * spread(i)).collect()
        }
        _ => (0..n).map(|_| random.point()).collect(),
    }
}

/// Seconds that this process has had a processor, as Linux counts them: other programs' share is not
/// in it, though what they do to the caches is.
fn seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").expect("Linux with schedstat");
    let nanoseconds: f64 = text.split(' ').next().and_then(|word| word.parse().ok()).expect("a number");
    nanoseconds * 1e-9
}

fn time<P: Point>(kind: &str, n: usize, repeats: usize) {
    let points: Vec<P> = points(kind, n);
    let (mut ordering, mut building, mut cells) = (f64::INFINITY, f64::INFINITY, 0);
    for _ in 0..repeats {
        let start = seconds();
        let order = insertion_order(&points);
        let sorted: Vec<P> = order.iter().map(|&i| points[i as usize]).collect();
        ordering = ordering.min(seconds() - start);
        let start = seconds();
        let triangulation = Incremental::build(sorted, None).expect("points that span the space");
        building = building.min(seconds() - start);
        cells = triangulation.cells().count();
    }
    let each = 1e9 / points.len() as f64;
    println!(
        "{kind} {n} {}D: order {:.0} + build {:.0} = {:.0} ns per point, {cells} cells",
        P::DIM,
        ordering * each,
        building * each,
        (ordering + building) * each
    );
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| words.get(i).and_then(|w| w.parse().ok()).unwrap_or(default);
    let kind = words.first().map_or("uniform", String::as_str);
    let (n, repeats) = (number(1, 100_000), number(3, 1));
    if number(2, 3) == 2 { time::<DVec2>(kind, n, repeats) } else { time::<DVec3>(kind, n, repeats) }
}
