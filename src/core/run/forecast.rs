//! The forecast of the memory of a run from a sample of stars.
//!
//! **Statement.** The memory of a run grows with the points and with the cells. A few points are probes. The candidates of
//! the star of a probe are its nearest points and a coarse sample of all points. Near points hide far points if the cells
//! are local. Otherwise the star grows with the sample, as on the moment curve, where it contains every point. Stars of a
//! small and of a large sample give the exponent of the growth, and the forecast extrapolates it to all points. The sample
//! depends only on the points and their order.
//!
//! The star of a hidden site is empty. The nearest points are those of least power, so they hide a probe as all points would.
//! A heavier site at the position of the probe is not seen, so the forecast is too high if many positions have several sites.
//!
//! **Departure.** The plane needs no sample without weights, because its stars have six cells on average.
//!
//! **Work.** One distance for each point and probe, in parallel, and the stars of the probes.

use septet_geometry::cost::Cost;
use septet_geometry::hull::StarBuilder;
use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::range::{scale, scale_exponent};

use crate::run::auto_workers::{PROBES, evenly, near_neighbours};
use crate::spec::{Task, Until};

/// Numbers of points of the coarse samples.
const SAMPLES: [usize; 2] = [256, 1024];

/// A smaller exponent of the growth of stars is that of boundaries, and does not count.
const LEAST_GROWTH: f64 = 0.2;

/// Mean number of cells at a point of random points, in the plane and in space.
const USUAL_STAR: [f64; 2] = [6.0, 27.0];

/// What a run keeps for each point and for each cell, in bytes.
#[derive(Clone, Copy, Debug)]
struct Bytes {
    point: f64,
    cell: f64,
}

/// Returns the entry of a table for a dimension. That of space stands for the higher ones, whose runs need more.
fn of_dimension<P: Point, T: Copy>(table: [T; 2]) -> T {
    table[usize::from(P::DIM > 2)]
}

/// Bytes of `triangulate`, in the plane and in space: three quarters of the least measured values, as the counts stop runs
/// that need more.
const DIRECT: [Bytes; 2] = [Bytes { point: 60.0, cell: 36.0 }, Bytes { point: 80.0, cell: 48.0 }];

/// Bytes of `simulate`, measured in the same way. The edges of the supergraph need more on some sets.
const COUNTED: [Bytes; 2] = [Bytes { point: 300.0, cell: 150.0 }, Bytes { point: 300.0, cell: 120.0 }];

/// Further bytes for each cell of a run in a periodic box: neighbours, and the cells of the box with their offsets. This is half
/// of the measured value, because cells that have only images are not kept.
const CELL_IN_BOX: f64 = 24.0;

/// Bytes of `independent`, which has no cells.
const SITES: [Bytes; 2] = [Bytes { point: 100.0, cell: 0.0 }; 2];

/// The expected size of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forecast {
    points: f64,
    cells: f64,
    bytes: Bytes,
}

impl Forecast {
    /// Estimates the size of a run. `in_box` is set if the points are the sites of a periodic box and their images.
    pub(super) fn of<P: Point>(task: Task, points: &[P], in_box: bool) -> Self {
        // A run that stops early has no cells.
        let (mut bytes, has_cells) = match task {
            Task::Triangulate => (of_dimension::<P, _>(DIRECT), true),
            Task::Simulate => (of_dimension::<P, _>(COUNTED), true),
            Task::Count(Until::Graph | Until::Partition | Until::Neighbours) => {
                (of_dimension::<P, _>(DIRECT), false)
            }
            Task::Independent { .. } => (of_dimension::<P, _>(SITES), false),
        };
        if in_box {
            bytes.cell += CELL_IN_BOX;
        }
        let star = match (has_cells, P::DIM) {
            (false, _) => 0.0,
            (true, 2) if !P::IS_WEIGHTED => USUAL_STAR[0],
            // The stars of a sample would take longer than many runs.
            (true, 4..) => USUAL_STAR[1],
            (true, _) => mean_star(points).unwrap_or(of_dimension::<P, _>(USUAL_STAR)),
        };
        let points = points.len() as f64;
        Forecast { points, cells: points * star / (P::DIM + 1) as f64, bytes }
    }

    /// Returns the bytes that the run adds to the memory of the process.
    pub(super) fn bytes(self) -> u64 {
        (self.points * self.bytes.point + self.cells * self.bytes.cell) as u64
    }
}

/// Returns the expected mean size of a star. Returns `None` if the sample has no stars.
fn mean_star<P: Point>(points: &[P]) -> Option<f64> {
    let finite = |count| -> Vec<P> {
        let sample = evenly(points, count).into_iter();
        sample.filter(|x| (0..P::DIM).all(|k| x.coord(k).is_finite())).collect()
    };
    let probes = finite(PROBES);
    let near = near_neighbours(points, &probes);
    let mut builder = StarBuilder::default();
    let [small, large] = SAMPLES.map(|count| {
        let coarse = finite(count);
        let size = |(&probe, near): (&P, &Vec<(f64, P)>)| {
            let mut candidates: Vec<P> = near.iter().map(|&(_, x)| x).chain(coarse.iter().copied()).collect();
            // The heaviest of the sites at one position stays.
            candidates.sort_unstable_by(|a, b| lex_cmp(a, b).then_with(|| b.weight().total_cmp(&a.weight())));
            candidates.dedup_by(|a, b| lex_cmp(a, b).is_eq());
            star_size(&mut builder, probe, candidates)
        };
        probes.iter().zip(&near).map(size).sum::<Option<usize>>()
    });
    let (small, large) = (small? as f64, large? as f64);
    let sampled = SAMPLES.map(|count| count as f64);
    let growth = (large / small).ln() / (sampled[1] / sampled[0]).ln();
    let growth = if growth < LEAST_GROWTH || !growth.is_finite() { 0.0 } else { growth.min(1.0) };
    let rest = (points.len() as f64 / sampled[1]).max(1.0);
    Some(large / probes.len().max(1) as f64 * rest.powf(growth))
}

/// Returns the number of cells at a probe among the candidates. Returns `None` if their signs are not exact.
fn star_size<P: Point>(builder: &mut StarBuilder<P>, probe: P, candidates: Vec<P>) -> Option<usize> {
    let mut table = vec![probe];
    table.extend(candidates.into_iter().filter(|x| lex_cmp(x, &probe).is_ne()));
    let exponent = scale_exponent(&table).ok()?;
    for x in &mut table {
        *x = scale(*x, exponent);
    }
    let others: Vec<u32> = (1..table.len() as u32).collect();
    let spans = builder.build(&table, 0, &others, &mut Cost::default());
    Some(if spans { builder.link_size() } else { 0 })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use septet_geometry::site::Weighted;

    use super::*;
    use crate::generate::{Kind, Request, generate};
    use crate::model::Points;

    fn star_of(kind: Kind, n: u64) -> f64 {
        let request = Request { kind, n, dimension: 3, seed: 5, lipschitz: None, ratio: None };
        match generate(&request, &mut |_, _, _| {}).unwrap().points {
            Points::Plane(_) | Points::Higher(_) => 0.0,
            Points::Space(points) => mean_star(&points).unwrap(),
        }
    }

    #[test]
    fn stars_of_local_cells_do_not_grow() {
        for kind in [Kind::Uniform, Kind::Ball, Kind::Grid, Kind::Clusters, Kind::Slab] {
            let [few, many] = [3000, 50_000].map(|n| star_of(kind, n));
            assert!(
                (15.0..40.0).contains(&few) && (15.0..40.0).contains(&many),
                "{kind:?}: {few} and {many}"
            );
        }
    }

    #[test]
    fn stars_of_the_moment_curve_contain_all_points() {
        for n in [500, 3000, 10_000] {
            let (found, expected) = (star_of(Kind::MomentCurve, n), 2.0 * n as f64);
            assert!((0.8 * expected..1.2 * expected).contains(&found), "{n}: {found}");
        }
    }

    /// Random sites, of which every 47th has the weight `heavy`, and the others none.
    fn weighted(n: u64, heavy: f64) -> Vec<Weighted<DVec3>> {
        let request = Request { kind: Kind::Uniform, n, dimension: 3, seed: 6, lipschitz: None, ratio: None };
        let Points::Space(points) = generate(&request, &mut |_, _, _| {}).unwrap().points else {
            return vec![];
        };
        let site = |(i, x)| Weighted::new(x, if i % 47 == 5 { heavy } else { 0.0 });
        points.into_iter().enumerate().map(site).collect()
    }

    #[test]
    fn hidden_sites_have_no_cells() {
        let star = |heavy| mean_star(&weighted(20_000, heavy)).unwrap();
        assert!((15.0..40.0).contains(&star(0.0)), "{}", star(0.0));
        assert!(star(1.0) < 3.0, "{}", star(1.0));
        // Sites at one position count once.
        let mut twice = weighted(3000, 0.0);
        twice.extend(weighted(3000, 1e-9));
        assert!((15.0..40.0).contains(&mean_star(&twice).unwrap()));
    }

    #[test]
    fn degenerate_points_have_a_forecast() {
        let nowhere = vec![DVec3::NAN; 50];
        let same = vec![DVec3::ONE; 50];
        let far: Vec<DVec3> = (0..50).map(|i| DVec3::splat(2f64.powi(40 * i - 1000))).collect();
        let line: Vec<DVec3> = (0..5000).map(|i| DVec3::splat(f64::from(i))).collect();
        for points in [nowhere, same, far, line, Vec::new()] {
            let bytes = Forecast::of(Task::Triangulate, &points, false).bytes();
            assert!(bytes <= 1000 * points.len() as u64, "{bytes}");
        }
    }
}
