//! Kinds without a size function: random sets, lattices and curves.
//!
//! **Work.** O(n), plus the choice of ten cluster centres.

use septet_geometry::point::{Point, dist2};

use super::draw::{Draw, Purpose};
use super::kind::Kind;
use super::request::Request;

/// Generates the points of a kind that is not f-spaced. The request must be checked.
pub(super) fn points<P: Point>(request: &Request) -> Vec<P> {
    let Request { kind, n, seed, .. } = *request;
    let mut draw = Draw::new(seed, Purpose::Points);
    let many = |make: &mut dyn FnMut() -> P| (0..n).map(|_| make()).collect();
    match kind {
        Kind::Poisson => {
            let count = Draw::new(seed, Purpose::Count).poisson(n);
            (0..count).map(|_| draw.point()).collect()
        }
        Kind::Ball => many(&mut || centred(draw.in_ball())),
        Kind::Sphere => many(&mut || centred(draw.direction())),
        Kind::Grid => {
            let side = nearest_side(n, |k| k.pow(P::DIM as u32));
            let unit = 1.0 / side.saturating_sub(1).next_power_of_two() as f64;
            lattice::<P>(side).map(|p| p * unit).collect()
        }
        Kind::Jittered => {
            let side = nearest_side(n, |k| k.pow(P::DIM as u32));
            let inside = |p: P, u: P| (p + P::splat(0.25) + u * 0.5) / side as f64;
            lattice::<P>(side).map(|p| inside(p, draw.point())).collect()
        }
        Kind::Fcc => fcc(n),
        Kind::Clusters => clusters(request, &mut draw),
        Kind::Shells => super::shells::points(request, &mut draw),
        Kind::Slab => many(&mut || {
            let mut p: P = draw.point();
            p.set_coord(P::DIM - 1, p.coord(P::DIM - 1) / 1000.0);
            p
        }),
        Kind::Line => {
            let (from, to) = (P::from_coords(&[0.125, 0.25, 0.375]), P::from_coords(&[0.875, 0.6, 0.8]));
            many(&mut || from + (to - from) * draw.unit() + draw.in_ball::<P>() / 1000.0)
        }
        Kind::MomentCurve => {
            let unit = 1.0 / n.saturating_sub(1).next_power_of_two() as f64;
            (0..n).map(|t| moment(t as f64 * unit)).collect()
        }
        // The module `spaced` generates the f-spaced kinds.
        Kind::Uniform | Kind::WellSpaced | Kind::GradedPoint | Kind::GradedLine => many(&mut || draw.point()),
    }
}

/// Maps the ball of radius 1 about the origin into the unit cube.
fn centred<P: Point>(p: P) -> P {
    p * 0.5 + P::splat(0.5)
}

/// Returns the side `k` whose count is closest to `n`. It is at least 1, unless `n` is 0.
fn nearest_side(n: u64, count: impl Fn(u64) -> u64) -> u64 {
    let mut side = 0;
    while count(side) < n {
        side += 1;
    }
    if side > 1 && n - count(side - 1) < count(side) - n { side - 1 } else { side }
}

/// Returns the integer points `0..side` of every axis. The last axis varies fastest.
fn lattice<P: Point>(side: u64) -> impl Iterator<Item = P> {
    (0..side.pow(P::DIM as u32)).map(move |mut i| {
        let mut p = P::default();
        for axis in (0..P::DIM).rev() {
            p.set_coord(axis, (i % side) as f64);
            i /= side;
        }
        p
    })
}

fn fcc<P: Point>(n: u64) -> Vec<P> {
    let per_cell = 1 << (P::DIM - 1);
    let side = 2 * nearest_side(n, |m| per_cell * m.pow(P::DIM as u32));
    let unit = 1.0 / side.next_power_of_two() as f64;
    let even = |p: &P| (0..P::DIM).map(|i| p.coord(i) as u64).sum::<u64>().is_multiple_of(2);
    lattice::<P>(side).filter(even).map(|p| p * unit).collect()
}

/// Draws clusters. Cluster `i` has standard deviation `0.02 / 2^i` and a radius of six deviations. Each centre is the
/// farthest of 64 random places from the previous centres.
fn clusters<P: Point>(request: &Request, draw: &mut Draw) -> Vec<P> {
    const CLUSTERS: u64 = 10;
    let mut places = Draw::new(request.seed, Purpose::Centres);
    let mut centres: Vec<P> = Vec::new();
    while (centres.len() as u64) < CLUSTERS {
        let mut farthest = (-1.0, P::default());
        for _ in 0..64 {
            let place = places.point::<P>() * 0.75 + P::splat(0.125);
            let distance = centres.iter().map(|&c| dist2(c, place)).fold(f64::MAX, f64::min);
            if distance > farthest.0 {
                farthest = (distance, place);
            }
        }
        centres.push(farthest.1);
    }
    let at = |i: u64, offset: P| {
        let which = i % CLUSTERS;
        centres[which as usize] + offset * (0.02 / (1u64 << which) as f64)
    };
    (0..request.n).map(|i| at(i, draw.bell())).collect()
}

fn moment<P: Point>(t: f64) -> P {
    P::from_coords(&[t, t * t, t * t * t])
}
