//! Determinism, counts, spacing, completion and quality of the generated sets.

use septet_geometry::incremental::Incremental;
use septet_geometry::point::{Simplex, dist2};

use super::completion::{circumsphere, in_domain};
use super::sizing::{Centre, Sizing};
use super::*;

/// What the theorems speak about, measured.
#[derive(Debug, Default)]
struct Quality {
    /// Greatest `R / f(c)` over cells with centre in the domain.
    gap: f64,
    /// Greatest radius-edge ratio over those cells.
    inner_ratio: f64,
    /// Greatest radius-edge ratio over all cells.
    ratio: f64,
    /// Greatest `|uv| / min(nn_u, nn_v)` over Delaunay edges.
    alpha: f64,
}

fn quality<P: Point>(points: &[P], sizing: &Sizing) -> Quality {
    let dt = Incremental::new(points.to_vec()).unwrap();
    let mut nearest = vec![f64::MAX; points.len()];
    let mut out = Quality::default();
    for pass in 0..2 {
        for cell in dt.complex().live_cells() {
            if dt.complex().infinite_slot(cell).is_some() {
                continue;
            }
            let ids = dt.complex().cell(cell).as_ref();
            let mut shortest = f64::MAX;
            for (i, &u) in ids.iter().enumerate() {
                for &v in &ids[..i] {
                    let length = dist2(points[u as usize], points[v as usize]).sqrt();
                    shortest = shortest.min(length);
                    let (u, v) = (u as usize, v as usize);
                    if pass == 0 {
                        nearest[u] = nearest[u].min(length);
                        nearest[v] = nearest[v].min(length);
                    } else {
                        out.alpha = out.alpha.max(length / nearest[u].min(nearest[v]));
                    }
                }
            }
            let (centre, radius) = circumsphere(&dt.corners(cell)[..P::Cell::LEN]);
            out.ratio = out.ratio.max(radius / shortest);
            if pass == 1 && radius / shortest > 1.3 && std::env::var("DIAG").is_ok() {
                let f = sizing.at(&centre);
                let h: Vec<String> = ids.iter().map(|&v| { let p = points[v as usize]; (0..P::DIM).map(|i| format!("{:.2}", p.coord(i).min(1.0-p.coord(i))/f)).collect::<Vec<_>>().join(",") }).collect();
                println!("  bad {:.3} r {:.3}: {}", radius/shortest, radius/f, h.join(" | "));
            }
            if in_domain(&centre) {
                out.inner_ratio = out.inner_ratio.max(radius / shortest);
                out.gap = out.gap.max(radius / sizing.at(&centre));
            }
        }
    }
    out
}

/// Speeds and quality at several sizes; run with `--ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn measure() {
    let sizes: Vec<f64> = std::env::var("SIZES").map_or(vec![0.08, 0.04], |s| {
        s.split(',').map(|x| x.parse().unwrap()).collect()
    });
    for &f in &sizes {
        for seed in 0..4 {
            one::<DVec3>(Sizing { centre: Centre::Point, slope: 0.0, least: f }, seed);
        }
        one::<DVec2>(Sizing { centre: Centre::Point, slope: 0.0, least: f * f }, 0);
    }
    if std::env::var("SIZES").is_ok() { return; }
    for (slope, offset) in [(0.06, 0.3), (0.06, 0.1), (0.25, 0.1), (0.25, 0.01), (0.5, 0.02)] {
        for centre in [Centre::Point, Centre::Line] {
            one::<DVec3>(Sizing { centre, slope, least: slope * offset }, 1);
            one::<DVec2>(Sizing { centre, slope, least: slope * offset * offset }, 1);
        }
    }
}

fn one<P: Point>(sizing: Sizing, seed: u64) {
    let start = std::time::Instant::now();
    let points: Vec<P> = spaced::build(sizing, seed, &mut |_| {}).unwrap();
    let time = start.elapsed().as_secs_f64();
    let q = quality(&points, &sizing);
    let limit = 2.5 * (1.0 + sizing.slope) / (1.0 - sizing.slope);
    println!(
        "d {} {:?} L {} least {:.5} seed {seed}: n {} ({:.3} of estimate) {:.1} us/pt; gap {:.9} C in {:.4} all {:.3}; alpha {:.3} of {limit:.2}",
        P::DIM, sizing.centre, sizing.slope, sizing.least, points.len(),
        points.len() as f64 / search::estimate::<P>(&sizing),
        time * 1e6 / points.len() as f64, q.gap, q.inner_ratio, q.ratio, q.alpha,
    );
}
