//! The ghost layer: points near the interface, sent before any subdomain is triangulated.
//!
//! **Statement.** A worker *owns* the points of its subdomain. A *ghost* is its copy of a point that another worker
//! owns. Each owned point `x` has a radius `r(x)`, and `B(x, r(x))` is its *halo ball*. The point is sent to every
//! worker that may own a point in this ball. Then:
//! 1. For any radii, the interface exchange completes the star of every owned point ([`crate::direct::interface`]).
//! 2. That exchange may skip a cell if its circumball lies in the halo ball of each owned vertex.
//! 3. A ball around `x` that crosses no separator may replace the halo ball of `x` in 2. If it is larger than the halo
//!    ball, `x` is not sent.
//!
//! **Radii.** A *run* is a sequence of [`RUN`] consecutive points in insertion order. The radius of its points is
//! [`WIDTH`] times the median distance between consecutive points of the run. It follows the density in the dimension
//! that the points span, and gaps between clusters do not affect it. Early insertion rounds are sparser, so distances
//! in a round of `m` out of `n` points are multiplied by `(m/n)^(1/d)`.
//!
//! **Limit.** The insertion order follows a Hilbert curve, which resolves about 20 bits per coordinate. Points in one
//! cell of the curve are in lexicographic order, and their radii may be as large as the subdomain. If there is a
//! distant outlier, all other points may be in one cell. A *layer* has `n^((d-1)/d)` points. A *shared level* is a tree
//! level whose node several workers share. A worker that would send more than [`MOST`] layers per shared level sends
//! none. The interface exchange then finds the missing ghosts.
//!
//! **Purpose.** Without ghosts, a subdomain triangulation ends at its own convex hull. Ghosts that arrive later destroy
//! the cells at this hull, and these cells reveal little about neighbours. Most distributed meshers send ghost layers
//! first (e.g. Peterka, Morozov and Phillips, "High-performance computation of distributed-memory parallel 3D Voronoi
//! and Delaunay tessellation", 2014).
//!
//! **Rounds.** One, after those of [`crate::direct::regions`].
//!
//! **Work.** O(1) per owned point. For each run, one clearance
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)) per shared level. For each separator
//! that is near the run, one clearance and one test for each of its points. For each point whose ball reaches the other
//! side, two tests at each split that the ball reaches there.

use std::cell::Cell;
use std::ops::Range;

use septet_geometry::cost::Sweep;
use septet_geometry::point::{Point, dist2};
use septet_protocol::ids::Phase;
use septet_protocol::message::PointBatch;
use septet_protocol::transport::TransportError;

use crate::direct::copies::{Copies, charge_exchange, receive_copies};
use crate::direct::regions::{Regions, exchange_splits};
use crate::direct::subdomain_triangulation::round_len;
use crate::machine::context::Context;
use crate::state::bits::ones;
use crate::state::frame::{self, FrameOwners};
use crate::state::subdomain::{Shared, Subdomain};
use crate::state::table::Table;
use crate::state::tree::Split;

/// The radius of a halo ball, as a multiple of the distance between consecutive points.
const WIDTH: f64 = 2.2;

/// The number of consecutive points that share a radius.
const RUN: usize = 32;

/// The largest number of layers, of `n^((d-1)/d)` points each, that a worker sends per shared level.
const MOST: f64 = 8.0;

/// A run is near a separator if its clearance is below this multiple of its radius. The points of such a run get
/// separate margins.
const NEAR: f64 = 2.0;

/// A factor that covers rounding: a ball of the reduced radius lies inside the exact one.
const SURE: f64 = 1.0 - 1e-9;

/// The radii of two balls around an owned point. The interface exchange may skip cells that lie in either ball.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Margin {
    /// The radius of a ball that crosses no separator of the path.
    pub(super) free: f64,
    /// The radius of the point's halo ball, slightly reduced; 0 if the worker sent no points.
    pub(super) sent: f64,
}

/// The margins of the owned points, the copies sent, and the ghosts that arrived.
#[derive(Debug)]
pub(crate) struct GhostLayer<P> {
    margins: Vec<Margin>,
    regions: Regions<P>,
    copies: Copies,
    arrived: Vec<u32>,
}

impl<P> GhostLayer<P> {
    /// Removes and returns the ghosts that arrived, as local indices.
    pub(crate) fn take_ghosts(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.arrived)
    }

    /// Returns the margin of each owned point, the regions of the other workers, and the copies sent.
    pub(super) fn into_parts(self) -> (Vec<Margin>, Regions<P>, Copies) {
        (self.margins, self.regions, self.copies)
    }
}

/// Consecutive points of one insertion round.
#[derive(Clone, Debug)]
struct Run {
    points: Range<usize>,
    /// The squared radius of a point, as a multiple of the squared median distance.
    scale2: f64,
}

/// The balls of a run: their centres, and the squared radius of each.
#[derive(Clone, Copy)]
struct Balls<'a, P> {
    centres: &'a [P],
    radius2: f64,
}

/// Divides points in insertion order into runs.
fn runs<P: Point>(positions: &[P]) -> Vec<Run> {
    let mut runs = Vec::with_capacity(positions.len() / RUN + 16);
    let mut start = 0;
    while start < positions.len() {
        let len = round_len(&positions[start..]);
        let density = len as f64 / positions.len() as f64;
        let scale = WIDTH * density.powf(1.0 / P::DIM as f64);
        let end = start + len;
        let range = |at: usize| at..end.min(at + RUN);
        runs.extend((start..end).step_by(RUN).map(|at| Run { points: range(at), scale2: scale * scale }));
        start = end;
    }
    runs
}

/// Returns the squared radius of the points of a run. `gaps2` is reused storage. A single point has radius 0, because
/// the interface exchange finds the ghosts that it needs.
fn radius2_of<P: Point>(run: &[P], scale2: f64, gaps2: &mut Vec<f64>) -> f64 {
    gaps2.clear();
    gaps2.extend(run.windows(2).map(|pair| dist2(pair[0], pair[1])));
    let middle = gaps2.len() / 2;
    if gaps2.is_empty() {
        return 0.0;
    }
    let radius2 = scale2 * *gaps2.select_nth_unstable_by(middle, f64::total_cmp).1;
    if radius2.is_finite() { radius2 } else { 0.0 }
}

/// Returns a point of a run as its centre, and the radius of a ball around the centre that contains the run.
fn around<P: Point>(run: &[P]) -> (P, f64) {
    let centre = run[run.len() / 2];
    let farthest2 = run.iter().fold(0.0, |most: f64, &x| most.max(dist2(x, centre)));
    (centre, farthest2.sqrt() / SURE)
}

/// Appends the margins of a run's points. Calls `send` with the level and the position in the run of each point whose
/// ball may contain points beyond the separator of that level. Returns the number of clearances that it computed.
fn add_margins<P: Point>(
    path: &[Shared<P>],
    balls: Balls<'_, P>,
    margins: &mut Vec<Margin>,
    mut send: impl FnMut(usize, usize),
) -> usize {
    let Balls { centres, radius2 } = balls;
    let radius = radius2.sqrt();
    let (centre, extent) = around(centres);
    let (mut near, mut far) = (0, f64::INFINITY);
    for (level, shared) in path.iter().enumerate() {
        let clear = shared.split().separator().clearance(centre) - extent;
        // A clearance of NaN counts as near.
        if clear >= NEAR * radius {
            far = far.min(clear);
        } else {
            near |= 1 << level;
        }
    }
    for (at, &x) in centres.iter().enumerate() {
        let mut free = far;
        for level in ones(near) {
            let split = path[level].split();
            let clear = split.separator().clearance(x);
            free = free.min(clear);
            if clear * SURE <= radius && split.reaches(x, radius2, 1 - path[level].mine()) {
                send(level, at);
            }
        }
        margins.push(Margin { free: free * SURE, sent: radius * SURE });
    }
    path.len() + centres.len() * near.count_ones() as usize
}

/// Sends owned points near the interface to the workers that their balls reach. Returns the margins of the owned points and
/// the ghosts that arrive.
pub(crate) async fn ghost_layer<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    frame: &mut PointBatch<P>,
) -> Result<GhostLayer<P>, TransportError> {
    cx.enter(Phase::Halo)?;
    let regions = exchange_splits(cx, subdomain).await?;
    frame::report(cx, table, frame);
    let (margins, mut copies, tests) = own_points(subdomain, table, &regions);
    copies.send(cx, table);
    let (mut arrived, mut owners) = (Vec::new(), FrameOwners::default());
    while cx.exchange().await? {
        owners.receive(cx, table, frame);
        receive_copies(cx, table, &mut arrived);
    }
    charge_exchange(cx, subdomain.root(), tests, arrived.len());
    Ok(GhostLayer { margins, regions, copies, arrived })
}

/// Computes the margins of the owned points, and collects the copies to be sent. Also counts the clearances and the tests of
/// splits.
fn own_points<P: Point>(
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    regions: &Regions<P>,
) -> (Vec<Margin>, Copies, Sweep) {
    let (path, mut tests) = (subdomain.path(), Sweep::default());
    let visits = Cell::new(0usize);
    let (mut copies, mut sent) = (Copies::default(), 0u64);
    if path.is_empty() {
        return (Vec::new(), copies, tests);
    }
    let mut margins: Vec<Margin> = Vec::with_capacity(table.owned_len() as usize);
    let mut gaps2 = Vec::new();
    let layer = f64::from(table.owned_len()).powf((P::DIM - 1) as f64 / P::DIM as f64);
    let most = (MOST * layer * path.len() as f64) as u64;
    for Run { points: run, scale2 } in runs(table.owned_positions()) {
        let centres = &table.positions()[run.clone()];
        let radius2 = radius2_of(centres, scale2, &mut gaps2);
        let clearances = add_margins(path, Balls { centres, radius2 }, &mut margins, |level, at| {
            sent += 1;
            if sent > most {
                return;
            }
            let reaches = |split: &Split<P>, side| {
                visits.set(visits.get() + 1);
                split.reaches(centres[at], radius2, side)
            };
            regions.each_reached(level, &reaches, &mut |worker| copies.add((run.start + at) as u32, worker));
        });
        visits.set(visits.get() + clearances);
    }
    if sent > most {
        for margin in &mut margins {
            margin.sent = 0.0;
        }
        copies = Copies::default();
    }
    (0..visits.get()).for_each(|_| tests.visit());
    (margins, copies, tests)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::hash::Draw;
    use septet_geometry::incremental::insertion_order;
    use septet_geometry::separator::Separator;

    use super::*;
    use crate::direct::interface_cells::tests::{sets, shared, sphere};

    fn random<P: Point>(n: usize, seed: u64) -> Vec<P> {
        let mut draw = Draw::new(seed);
        let points: Vec<P> = (0..n).map(|_| draw.point()).collect();
        insertion_order(&points).into_iter().map(|i| points[i as usize]).collect()
    }

    /// Returns the radius of each point.
    fn radii<P: Point>(points: &[P]) -> Vec<f64> {
        let mut gaps2 = Vec::new();
        let radius = |run: Run| {
            let radius2 = radius2_of(&points[run.points.clone()], run.scale2, &mut gaps2);
            std::iter::repeat_n(radius2.sqrt(), run.points.len())
        };
        runs(points).into_iter().flat_map(radius).collect()
    }

    fn radii_follow_the_density<P: Point>() {
        let points = random::<P>(20_000, 3);
        let spacing = (1.0 / 20_000.0f64).powf(1.0 / P::DIM as f64);
        let radii = radii(&points);
        assert_eq!(radii.len(), points.len());
        let usual = radii.iter().filter(|&&r| r > spacing && r < 4.0 * spacing).count();
        assert!(usual > 19_500, "{usual} of 20,000");
    }

    #[test]
    fn radii_follow_the_density_in_both_dimensions() {
        radii_follow_the_density::<DVec3>();
        radii_follow_the_density::<DVec2>();
    }

    #[test]
    fn gaps_between_clusters_do_not_count() {
        let near = random::<DVec3>(4000, 5);
        let both: Vec<DVec3> = near.iter().flat_map(|&x| [x, x + DVec3::splat(1e6)]).collect();
        let both: Vec<DVec3> = insertion_order(&both).into_iter().map(|i| both[i as usize]).collect();
        let far = radii(&both).into_iter().filter(|&r| r > 2.0).count();
        assert!(far < 50, "{far} of 8000");
    }

    #[test]
    fn small_and_empty_sets_have_radii() {
        for n in 0..9 {
            let points = random::<DVec3>(n, 7);
            assert_eq!(radii(&points).len(), n);
        }
        let huge = [DVec3::splat(-1e300), DVec3::splat(1e300)];
        assert!(radii(&huge).iter().all(|r| r.is_finite()));
    }

    /// For runs near separators and far from them, free balls cross no separator and every point whose ball reaches
    /// another subdomain is sent.
    fn margins_and_sent_points_are_right<P: Point>() {
        let middle = P::splat(0.5);
        let mut aside = P::splat(0.3);
        aside.set_coord(0, 0.6);
        let (ball, small) = (sphere(middle, 0.35), sphere(aside, 0.2));
        let plane = Separator::plane(P::DIM - 1, 0.55);
        let (mut near, mut far, mut all_sent) = (0, 0, 0);
        let sets = sets::<P>().into_iter().chain([random::<P>(20_000, 11)]);
        for points in sets {
            for (split, factor) in [
                (vec![(ball, 0)], 1.0),
                (vec![(ball, 1)], 0.0),
                (vec![(plane, 1), (small, 1)], 1.0),
                (vec![(ball, 0), (plane, 0), (small, 1)], 0.3),
            ] {
                let path: Vec<Shared<P>> = split.iter().map(|&(s, mine)| shared(s, mine, &points)).collect();
                let is_owned = |x: &&P| path.iter().all(|s| s.split().side(**x) == s.mine());
                let owned: Vec<P> = points.iter().filter(is_owned).copied().collect();
                let owned: Vec<P> = insertion_order(&owned).into_iter().map(|i| owned[i as usize]).collect();
                let (mut margins, mut gaps2) = (Vec::new(), Vec::new());
                for Run { points: range, scale2 } in runs(&owned) {
                    let (start, run) = (range.start, &owned[range]);
                    let radius2 = radius2_of(run, scale2 * factor, &mut gaps2);
                    let balls = Balls { centres: run, radius2 };
                    let mut sent = Vec::new();
                    add_margins(&path, balls, &mut margins, |level, at| sent.push((level, at)));
                    let places = (0..run.len()).flat_map(|at| (0..path.len()).map(move |level| (level, at)));
                    let expected: Vec<(usize, usize)> = places
                        .filter(|&(level, at)| {
                            path[level].split().reaches(run[at], radius2, 1 - path[level].mine())
                        })
                        .collect();
                    assert_eq!(sent, expected);
                    assert_eq!(margins.len(), start + run.len());
                    for (x, margin) in run.iter().zip(&margins[start..]) {
                        assert!(margin.sent * margin.sent <= radius2);
                        assert!(margin.sent.max(margin.free) >= radius2.sqrt() * SURE);
                        let crosses = |s: &Shared<P>| s.split().separator().crosses(*x, margin.free);
                        assert!(margin.free <= 0.0 || !path.iter().any(crosses), "{x:?} {}", margin.free);
                    }
                    let one = margins[start..].iter().all(|margin| margin.free == margins[start].free);
                    if one && run.len() > 1 {
                        far += 1;
                    } else {
                        near += 1;
                    }
                    all_sent += sent.len();
                }
            }
        }
        assert!(near > 100 && far > 100 && all_sent > 1000, "{near} near, {far} far, {all_sent} sent");
    }

    #[test]
    fn margins_and_sent_points_are_right_in_both_dimensions() {
        margins_and_sent_points_are_right::<DVec3>();
        margins_and_sent_points_are_right::<DVec2>();
    }

    #[test]
    fn the_ball_around_a_run_contains_it() {
        let points = random::<DVec3>(3000, 9);
        for run in points.chunks(RUN) {
            let (centre, extent) = around(run);
            assert!(run.iter().all(|&x| dist2(x, centre).sqrt() <= extent));
        }
    }
}
