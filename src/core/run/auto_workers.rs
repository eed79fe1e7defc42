//! The number of workers of a triangulation for which the caller leaves it open.
//!
//! **Statement.** The interface exchange sends a point to every region that a circumball of its cells meets. On a curved
//! surface, most circumballs are as large as the surface, so every point goes to every worker. Then p workers do nearly p
//! times the work of one, and take as long. So a run gets as many workers as cores, but only while
//! - a worker holds at least [`POINTS_PER_WORKER`] points, because the ghost layer of a small subdomain is as large as the
//!   subdomain, and
//! - a point goes to at most [`MOST_FOREIGN`] other regions on average.
//!
//! **Method.** A few points are probes. The spheres through a probe and its nearest neighbours that contain no other near
//! neighbour are approximately its circumballs. The regions are the boxes of a k-d tree over a sample. Rounded arithmetic
//! suffices, because results do not depend on the number of workers.
//!
//! **Source.** `bench/critical-path`: on surfaces, the processor time is about `1 + x/2` times that of one worker, where a
//! point meets x other regions. **Work.** One distance for each point and probe, in parallel.

use std::cmp::Ordering;

use septet_geometry::neighbourhood::{Bounds, bounds, box_dist2};
use septet_geometry::point::{Point, dist2, lex_cmp};
use septet_workers::config::cores;

/// The smallest number of points of a worker.
const POINTS_PER_WORKER: usize = 16_000;

/// The largest mean number of regions, other than its own, that the circumballs of a point meet.
const MOST_FOREIGN: f64 = 2.0;

/// A point cannot meet more than [`MOST_FOREIGN`] other regions of this number.
const ALWAYS: u32 = MOST_FOREIGN as u32 + 1;

/// Number of probes.
pub(super) const PROBES: usize = 24;

/// Number of near neighbours that a circumball must not contain.
const NEAREST: usize = 48;

/// Number of near neighbours that are vertices of spheres.
const VERTICES: usize = 12;

/// Number of points in the tree of regions.
const SAMPLE: usize = 8192;

/// Number of points that one task scans.
const CHUNK: usize = 1 << 16;

/// Returns a number of workers, at most the number of cores.
pub(crate) fn auto_workers<P: Point>(points: &[P], cores: u32) -> u32 {
    let enough = u32::try_from(points.len() / POINTS_PER_WORKER).unwrap_or(u32::MAX);
    let mut workers = cores.min(enough).max(1);
    if workers <= ALWAYS {
        return workers;
    }
    let probes: Vec<P> = evenly(points, PROBES);
    let balls: Vec<Vec<Ball<P>>> = probes
        .iter()
        .zip(near_neighbours(points, &probes))
        .map(|(&probe, near)| circumballs(probe, &near))
        .collect();
    let sample: Vec<P> = evenly(points, SAMPLE).into_iter().filter(|x| is_finite(*x)).collect();
    while workers > ALWAYS && foreign_regions(&balls, sample.clone(), workers) > MOST_FOREIGN {
        workers /= 2;
    }
    workers
}

/// A ball.
#[derive(Clone, Copy, Debug)]
struct Ball<P> {
    centre: P,
    radius2: f64,
}

/// Returns `count` points at even distances in the input, or all.
pub(super) fn evenly<P: Point>(points: &[P], count: usize) -> Vec<P> {
    let count = count.min(points.len());
    (0..count).map(|i| points[i * points.len() / count]).collect()
}

fn is_finite<P: Point>(x: P) -> bool {
    (0..P::DIM).all(|k| x.coord(k).is_finite())
}

/// The nearest points of a probe at other positions, by power: the squared distance minus the weight.
pub(super) type Near<P> = Vec<(f64, P)>;

/// Returns the order of two neighbours: by distance, and by coordinates if the distances are equal.
fn nearer<P: Point>(a: &(f64, P), b: &(f64, P)) -> Ordering {
    a.0.total_cmp(&b.0).then_with(|| lex_cmp(&a.1, &b.1))
}

/// Keeps the nearest ones. Returns the squared distance of the farthest of them, or infinity if there are too few.
fn keep_nearest<P: Point>(near: &mut Near<P>) -> f64 {
    if near.len() <= NEAREST {
        return f64::INFINITY;
    }
    let (_, last, _) = near.select_nth_unstable_by(NEAREST - 1, nearer);
    let limit2 = last.0;
    near.truncate(NEAREST);
    limit2
}

/// Returns the nearest points of each probe, nearest first, without those that coincide with it.
pub(super) fn near_neighbours<P: Point>(points: &[P], probes: &[P]) -> Vec<Near<P>> {
    let in_chunk = |chunk: &[P]| -> Vec<Near<P>> {
        let near = |&probe: &P| {
            let (mut near, mut limit2) = (Near::new(), f64::INFINITY);
            for &x in chunk {
                let d2 = dist2(x, probe);
                let power = d2 - x.weight();
                if power <= limit2 && d2 > 0.0 {
                    near.push((power, x));
                    if near.len() == 2 * NEAREST {
                        limit2 = keep_nearest(&mut near);
                    }
                }
            }
            near
        };
        probes.iter().map(near).collect()
    };
    let join = |mut all: Vec<Near<P>>, part: Vec<Near<P>>| {
        for (near, more) in all.iter_mut().zip(part) {
            near.extend(more);
            keep_nearest(near);
        }
        all
    };
    let parts = cores::map_blocks(points.len(), CHUNK, |at| in_chunk(&points[at]));
    let mut all = parts.into_iter().fold(vec![Near::new(); probes.len()], join);
    for near in &mut all {
        keep_nearest(near);
        near.sort_unstable_by(nearer);
    }
    all
}

/// Returns the spheres through the probe and its nearest neighbours that contain no near neighbour.
fn circumballs<P: Point>(probe: P, near: &[(f64, P)]) -> Vec<Ball<P>> {
    let near: Vec<(f64, P)> = near.iter().map(|&(_, x)| (dist2(x, probe), x - probe)).collect();
    let vertices = &near[..VERTICES.min(near.len())];
    let mut balls = Vec::new();
    each_subset(vertices, P::DIM, &mut Vec::new(), &mut |corners: &[P]| {
        let (w, v) = P::sphere_plane(corners);
        let centre = v * (0.5 / w);
        let radius2 = centre.norm2();
        // Neighbours on the sphere are not inside: on a curved surface, all of them may be on it.
        let contains = |&(d2, x): &(f64, P)| d2 - 2.0 * centre.dot(x) < -1e-9 * radius2;
        if radius2.is_finite() && !near.iter().any(contains) {
            balls.push(Ball { centre: probe + centre, radius2 });
        }
    });
    balls
}

/// Calls `f` with each set of `size` vectors.
fn each_subset<P: Point>(near: &[(f64, P)], size: usize, chosen: &mut Vec<P>, f: &mut impl FnMut(&[P])) {
    if chosen.len() == size {
        return f(chosen);
    }
    for (at, &(_, x)) in near.iter().enumerate() {
        chosen.push(x);
        each_subset(&near[at + 1..], size, chosen, f);
        chosen.pop();
    }
}

/// Returns the mean number of regions that the balls of a probe meet, without one, the region of the probe itself.
fn foreign_regions<P: Point>(balls: &[Vec<Ball<P>>], mut sample: Vec<P>, workers: u32) -> f64 {
    let mut regions = Vec::new();
    divide(&mut sample, workers as usize, &mut regions);
    let meets = |ball: &Ball<P>, &(low, high): &Bounds<P>| box_dist2(ball.centre, low, high) <= ball.radius2;
    let met = |balls: &Vec<Ball<P>>| {
        let met = regions.iter().filter(|region| balls.iter().any(|ball| meets(ball, region))).count();
        met.saturating_sub(1) as f64
    };
    balls.iter().map(met).sum::<f64>() / balls.len().max(1) as f64
}

/// Divides points at medians across the longest side of their box. Appends the boxes of `parts` regions.
fn divide<P: Point>(points: &mut [P], parts: usize, regions: &mut Vec<Bounds<P>>) {
    let (low, high) = bounds(points.iter().copied());
    if parts == 1 || points.len() < 2 {
        regions.push((low, high));
        return;
    }
    let side = |k: &usize| high.coord(*k) - low.coord(*k);
    let axis = (0..P::DIM).max_by(|a, b| side(a).total_cmp(&side(b))).unwrap_or(0);
    let middle = points.len() * (parts / 2) / parts;
    points.select_nth_unstable_by(middle, |a, b| a.coord(axis).total_cmp(&b.coord(axis)));
    let (left, right) = points.split_at_mut(middle);
    divide(left, parts / 2, regions);
    divide(right, parts - parts / 2, regions);
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::generate::{Kind, Request, generate};
    use crate::model::Points;

    /// Uniform points in the unit cube, changed by `place`.
    fn points(n: u64, place: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
        let request = Request { kind: Kind::Uniform, n, dimension: 3, seed: 5, lipschitz: None, ratio: None };
        match generate(&request, &mut |_, _, _| {}).unwrap().points {
            Points::Plane(_) | Points::Higher(_) => Vec::new(),
            Points::Space(points) => points.into_iter().map(place).collect(),
        }
    }

    #[test]
    fn volumes_get_all_cores_and_surfaces_few() {
        let volume = points(512_000, |x| x);
        assert_eq!([1, 2, 16, 32].map(|cores| auto_workers(&volume, cores)), [1, 2, 16, 32]);
        let sphere = points(512_000, |x| (x - DVec3::splat(0.5)).normalize());
        assert_eq!([2, 3, 8, 16, 64].map(|cores| auto_workers(&sphere, cores)), [2, 3, 2, 2, 2]);
        let circle: Vec<DVec2> = sphere.iter().map(|x| x.truncate().normalize()).collect();
        assert_eq!(auto_workers(&circle, 16), 2);
        let plane: Vec<DVec2> = volume.iter().map(|x| x.truncate()).collect();
        assert_eq!(auto_workers(&plane, 16), 16);
    }

    #[test]
    fn a_worker_holds_enough_points() {
        let volume = points(5 * POINTS_PER_WORKER as u64, |x| x);
        assert_eq!(auto_workers(&volume, 64), 5);
        assert_eq!(auto_workers(&volume[..2 * POINTS_PER_WORKER - 1], 64), 1);
        assert_eq!(auto_workers::<DVec3>(&[], 64), 1);
    }

    #[test]
    fn degenerate_points_have_an_answer() {
        let n = 5 * POINTS_PER_WORKER as u64;
        let invalid = points(n, |x| if x.x < 0.5 { DVec3::NAN } else { x * 1e300 });
        let same = vec![DVec3::ONE; n as usize];
        let line = points(n, |x| DVec3::splat(x.x));
        for points in [invalid, same, line] {
            assert!((1..=5).contains(&auto_workers(&points, 64)));
        }
    }
}
