//! Times the sequential kernel on point sets that are hard for the predicates:
//! `cargo run --release -p septet-geometry --example kernel -- KIND N [REPEATS]` with KIND one of
//! `uniform`, `jittered`, `graded`, `grid`, `decimal`, `sphere`, `clusters`, `plane`, `square`.

use std::time::Instant;

use glam::{DVec2, DVec3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use septet_geometry::incremental::{Incremental, insertion_order};
use septet_geometry::point::Point;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let word = |i: usize, default: &str| args.get(i).cloned().unwrap_or_else(|| default.to_string());
    let kind = word(0, "uniform");
    let n: usize = word(1, "100000").parse().expect("a number of points");
    let repeats: usize = word(2, "3").parse().expect("a number of repeats");
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    match kind.as_str() {
        "plane" => time(
            &kind,
            &(0..n).map(|_| DVec2::new(unit(&mut rng), unit(&mut rng))).collect::<Vec<_>>(),
            repeats,
        ),
        "square" => {
            let side = (n as f64).sqrt().round() as usize;
            let at = |i: usize| DVec2::new((i % side) as f64, (i / side) as f64);
            time(&kind, &(0..side * side).map(at).collect::<Vec<_>>(), repeats);
        }
        _ => time(&kind, &space(&kind, n, &mut rng), repeats),
    }
}

fn unit(rng: &mut impl Rng) -> f64 {
    rng.random::<f64>()
}

fn cube(rng: &mut impl Rng) -> DVec3 {
    DVec3::new(unit(rng), unit(rng), unit(rng))
}

/// A direction, uniform by rejection.
fn direction(rng: &mut impl Rng) -> DVec3 {
    loop {
        let v = cube(rng) * 2.0 - DVec3::ONE;
        let length = v.dot(v).sqrt();
        if length <= 1.0 && length > 0.1 {
            return v / length;
        }
    }
}

fn space(kind: &str, n: usize, rng: &mut ChaCha8Rng) -> Vec<DVec3> {
    let side = (n as f64).cbrt().round() as usize;
    let node = |i: usize| DVec3::new((i % side) as f64, (i / side % side) as f64, (i / side / side) as f64);
    match kind {
        "uniform" => (0..n).map(|_| cube(rng)).collect(),
        "jittered" => (0..side.pow(3)).map(|i| node(i) + cube(rng) * 0.5).collect(),
        "grid" => (0..side.pow(3)).map(node).collect(),
        "decimal" => (0..side.pow(3)).map(|i| node(i) * 0.1).collect(),
        "graded" => (0..n).map(|_| direction(rng) * unit(rng).powi(4)).collect(),
        "sphere" => (0..n).map(|_| direction(rng)).collect(),
        "clusters" => {
            let centres: Vec<DVec3> = (0..20).map(|_| cube(rng)).collect();
            (0..n).map(|i| centres[i % 20] + direction(rng) * (unit(rng).powi(2) * 1e-3)).collect()
        }
        _ => panic!("no such kind"),
    }
}

fn time<P: Point>(kind: &str, points: &[P], repeats: usize) {
    let order = insertion_order(points);
    let sorted: Vec<P> = order.iter().map(|&i| points[i as usize]).collect();
    let mut seconds: Vec<f64> = Vec::new();
    let mut cells = 0;
    #[cfg(feature = "stage-counts")]
    septet_geometry::predicates::take_stage_counts();
    for _ in 0..repeats {
        let start = Instant::now();
        let built = Incremental::build(sorted.clone(), None).expect("a triangulation");
        seconds.push(start.elapsed().as_secs_f64());
        cells = built.cells().count();
    }
    #[cfg(feature = "stage-counts")]
    {
        let (orientation, in_sphere, ties) = septet_geometry::predicates::take_stage_counts();
        let per = |count: u64| count as f64 / (points.len() * repeats) as f64;
        println!(
            "{kind}: a point, by filter, exact doubles, integers, expansions: orientation {:.3?}, in-sphere {:.3?}, \
             ties {:.3}",
            orientation.map(per),
            in_sphere.map(per),
            per(ties)
        );
    }
    seconds.sort_by(f64::total_cmp);
    let per_point = seconds[0] * 1e6 / points.len() as f64;
    println!("{kind} n {} cells {cells} best {:.3} s, {per_point:.2} us per point", points.len(), seconds[0]);
}
