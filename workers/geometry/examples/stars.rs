//! Times stars among the nearest points, on sets whose points are cospherical:
//! `cargo run --release -p septet-geometry --example stars -- KIND N [K]`, KIND `grid`, `sphere`, `uniform`.

use std::time::Instant;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use septet_geometry::cost::Cost;
use septet_geometry::hull::StarBuilder;
use septet_geometry::point::dist2;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let word = |i: usize, default: &str| args.get(i).cloned().unwrap_or_else(|| default.to_string());
    let (kind, n) = (word(0, "sphere"), word(1, "1000").parse::<usize>().expect("a number of points"));
    let k: usize = word(2, "48").parse().expect("a number of candidates");
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut cube = || DVec3::new(rng.random(), rng.random(), rng.random());
    let side = (n as f64).cbrt().round() as usize;
    let node = |i: usize| DVec3::new((i % side) as f64, (i / side % side) as f64, (i / side / side) as f64);
    let points: Vec<DVec3> = match kind.as_str() {
        "grid" => (0..side.pow(3)).map(node).collect(),
        "sphere" => (0..n).map(|_| (cube() - DVec3::splat(0.5)).normalize()).collect(),
        _ => (0..n).map(|_| cube()).collect(),
    };
    let near = |c: usize| {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        order.sort_by(|&a, &b| {
            dist2(points[a as usize], points[c]).total_cmp(&dist2(points[b as usize], points[c]))
        });
        order.truncate(k + 1);
        order
    };
    let candidates: Vec<Vec<u32>> = (0..points.len()).map(near).collect();
    let mut builder = StarBuilder::default();
    let (mut cost, mut facets) = (Cost::default(), 0);
    let start = Instant::now();
    for (c, near) in (0u32..).zip(&candidates) {
        builder.build(&points, c, near, &mut cost);
        facets += builder.link_size();
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{kind}: {:.2} us a star, {:.2} facets, work {}, depth {}",
        seconds * 1e6 / points.len() as f64,
        facets as f64 / points.len() as f64,
        cost.work(),
        cost.depth()
    );
}
