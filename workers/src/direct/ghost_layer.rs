//! The halo of a piece: foreign points near its border, which come before it is triangulated.
//!
//! **Statement.** Every home point `x` has a radius `r(x)`, and is sent to each worker whose region may hold a point
//! of the ball `B(x, r(x))`. Whatever the radii, what the workers triangulate then is right ([`crate::direct::interface`]); cells whose
//! ball lies in `B(x, r(x))` for each of their vertices at home need not be looked at again. A point that is clear of all
//! separators by more than its radius goes nowhere, and cells that are clear of them by that need not be looked at, either.
//!
//! **Radii.** [`WIDTH`] times the distance between neighbours along the curve of insertion: the median over [`RUN`]
//! points in a row, which goes with the density of the points, in the dimension that they have, and lets no gap
//! between clusters stand for many points. A point of an earlier round has neighbours of later ones: its distance is
//! scaled to the number of all.
//!
//! **A limit.** Where distances along the curve tell nothing (the curve has some 20 bits a coordinate: points of one of its
//! cells stand in no useful order, as beside a point that is very far away) radii may be as large as the piece. A worker
//! that would send more than [`MOST`] layers of its points to each side sends none: what others lack the seams find.
//!
//! **Why it pays.** Without a halo the cells of a piece end in a hull of their own, which foreign points undo when they
//! come; and a hull's cells tell little of where neighbours are. Ghost layers are sent before the work in most
//! distributed meshing (e.g. Peterka, Morozov and Phillips, "High-performance computation of distributed-memory parallel
//! 3D Voronoi and Delaunay tessellation", 2014).
//!
//! **Rounds.** At most one a shared level. **Work.** O(1) a home point, a clearance a shared level for each run
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)), two and a median for runs near a separator, and
//! one and a test for each point of those near that one.

use std::ops::Range;

use septet_geometry::point::{Point, dist2};
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::message::{Body, PointBatch};
use septet_protocol::transport::TransportError;

use crate::direct::subdomain_triangulation::round_len;
use crate::machine::context::Context;
use crate::state::bits::ones;
use crate::state::subdomain::{Shared, Subdomain};
use crate::state::table::Table;

/// The radius of a halo over the distance between neighbours along the curve.
const WIDTH: f64 = 2.2;

/// Points in a row whose distances are taken together.
const RUN: usize = 32;

/// Layers of home points, `n^((d-1)/d)` each, that a worker sends to a shared level's other side at most.
const MOST: f64 = 8.0;

/// A run that is nearer to a separator than so many of its radii has a margin of its own for each point.
const NEAR: f64 = 2.0;

/// What a radius loses, so that the balls that it holds are held for certain.
const SURE: f64 = 1.0 - 1e-9;

/// How far around a home point nothing more has to be told.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Margin {
    /// A radius whose ball crosses no separator of the path.
    pub(crate) free: f64,
    /// The radius of a ball that the point has been sent to all of, somewhat less; 0 where nothing was sent, or where it
    /// need not be known since more is free.
    pub(crate) sent: f64,
}

/// Points for both children of each shared node on the path.
type Batches<P> = Vec<[PointBatch<P>; 2]>;

/// Points in order of insertion, a run at a time, and what their squared radius is over the squared distance of neighbours.
fn runs<P: Point>(positions: &[P]) -> Vec<(Range<usize>, f64)> {
    let mut runs = Vec::with_capacity(positions.len() / RUN + 16);
    let mut start = 0;
    while start < positions.len() {
        let len = round_len(&positions[start..]);
        let density = len as f64 / positions.len() as f64;
        let scale = WIDTH * density.powf(1.0 / P::DIM as f64);
        let end = start + len;
        runs.extend((start..end).step_by(RUN).map(|at| (at..end.min(at + RUN), scale * scale)));
        start = end;
    }
    runs
}

/// Squared distances of neighbours in a run.
#[derive(Debug, Default)]
struct Gaps2(Vec<f64>);

impl Gaps2 {
    fn measure<P: Point>(&mut self, run: &[P]) {
        self.0.clear();
        self.0.extend(run.windows(2).map(|pair| dist2(pair[0], pair[1])));
    }

    /// The largest; 0 if there is none.
    fn largest(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }

    /// The median; 0 of a point alone, which has no halo: what it lacks the seams find.
    fn median(&mut self) -> f64 {
        let middle = self.0.len() / 2;
        if self.0.is_empty() { 0.0 } else { *self.0.select_nth_unstable_by(middle, f64::total_cmp).1 }
    }

    /// The squared radius of the points.
    fn radius2(&mut self, scale2: f64) -> f64 {
        let radius2 = scale2 * self.median();
        if radius2.is_finite() { radius2 } else { 0.0 }
    }
}

/// A centre of a run, and a radius around it that holds all of it.
fn around<P: Point>(run: &[P]) -> (P, f64) {
    let centre = run[run.len() / 2];
    let farthest2 = run.iter().fold(0.0, |most: f64, &x| most.max(dist2(x, centre)));
    (centre, farthest2.sqrt() / SURE)
}

/// How far a run is from those separators that are farther than `least`, and a bit for each of the others.
fn near_and_far<P: Point>(path: &[Shared<P>], clear: impl Fn(&Shared<P>) -> f64, least: f64) -> (u64, f64) {
    let (mut near, mut far) = (0, f64::INFINITY);
    for (level, shared) in path.iter().enumerate() {
        let clear = clear(shared);
        if clear >= least {
            far = far.min(clear);
        } else {
            near |= 1 << level;
        }
    }
    (near, far)
}

/// Appends the margins of a run's points, and calls `send` with each place on the path and each point whose ball, of its
/// squared radius, crosses that separator, as far as it reaches something. Most runs are far from all separators: their
/// points have one margin, and nobody has to know their radius.
fn look_around<P: Point>(
    path: &[Shared<P>],
    (points, scale2): (&[P], f64),
    gaps2: &mut Gaps2,
    margins: &mut Vec<Margin>,
    mut send: impl FnMut(usize, usize, f64),
) {
    let (centre, extent) = around(points);
    let clear = |shared: &Shared<P>| shared.split.separator.clearance(centre) - extent;
    gaps2.measure(points);
    let (near, far) = near_and_far(path, clear, NEAR * (scale2 * gaps2.largest()).sqrt());
    if near == 0 {
        // At least the radius is free.
        margins.extend(std::iter::repeat_n(Margin { free: far * SURE, sent: 0.0 }, points.len()));
        return;
    }
    let radius2 = gaps2.radius2(scale2);
    let radius = radius2.sqrt();
    let (near, far) = near_and_far(path, clear, NEAR * radius);
    let margin = |free: f64| Margin { free: free * SURE, sent: radius * SURE };
    for (at, &x) in points.iter().enumerate() {
        let mut free = far;
        for level in ones(near) {
            let split = &path[level].split;
            let clear = split.separator.clearance(x);
            free = free.min(clear);
            if clear * SURE <= radius && split.reaches(x, radius2, 1 - path[level].mine) {
                send(level, at, radius2);
            }
        }
        margins.push(margin(free));
    }
}

/// What the halo leaves to the phases after it.
#[derive(Debug, Default)]
pub(crate) struct GhostLayer {
    /// For each home point how far around it nothing more has to be told.
    pub(crate) margins: Vec<Margin>,
    /// Foreign points that came, by their local numbers.
    pub(crate) arrived: Vec<u32>,
}

/// Sends the home points near the border to where their balls reach; those of others that reach this piece stay, and
/// all go on to where they reach.
pub(crate) async fn halo<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    frame: &mut PointBatch<P>,
) -> Result<GhostLayer, TransportError> {
    cx.enter(Phase::Halo)?;
    crate::state::frame::report(cx, table, &subdomain.leaves, frame);
    let (margins, batches) = own_points(subdomain, table, cx.rank);
    send_halos(cx, subdomain, batches);
    let mut arrived = Vec::new();
    while cx.exchange().await? {
        crate::state::frame::learn(cx, table, frame);
        let mut batches = empty_batches(&subdomain.path);
        for (node, points) in cx.take(|m| match &mut m.body {
            Body::Ghosts(points) => Some((m.node, std::mem::take(points))),
            _ => None,
        }) {
            if let Some(holder) = subdomain.relayed(node, cx.rank) {
                cx.send(holder, node, 0, Body::Ghosts(points));
                continue;
            }
            let start = subdomain.position(node);
            if start == subdomain.path.len() {
                // Most of them stay.
                table.reserve_ghosts(points.len());
            }
            for at in 0..points.len() {
                if goes_on(&subdomain.path[start..], &points, at, &mut batches[start..]) {
                    table.arrive(&points, at, cx.rank, &mut arrived);
                }
            }
        }
        send_halos(cx, subdomain, batches);
    }
    Ok(GhostLayer { margins, arrived })
}

/// The margins of the home points, and those of them that are sent.
fn own_points<P: Point>(subdomain: &Subdomain<P>, table: &Table<P>, rank: Rank) -> (Vec<Margin>, Batches<P>) {
    let path = &subdomain.path;
    if path.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let mut batches = empty_batches(path);
    let mut margins: Vec<Margin> = Vec::with_capacity(table.owned as usize);
    let mut gaps2 = Gaps2::default();
    for (run, scale2) in runs(&table.positions[..table.owned as usize]) {
        let (ids, points) = (&table.ids[run.clone()], &table.positions[run]);
        look_around(path, (points, scale2), &mut gaps2, &mut margins, |level, at, radius2| {
            batches[level][1 - path[level].mine].push(ids[at], points[at], rank, radius2);
        });
    }
    let sent: usize = batches.iter().flatten().map(PointBatch::len).sum();
    let layer = f64::from(table.owned).powf((P::DIM - 1) as f64 / P::DIM as f64);
    if sent as f64 > MOST * layer * path.len() as f64 {
        for margin in &mut margins {
            margin.sent = 0.0;
        }
        batches = empty_batches(path);
    }
    (margins, batches)
}

/// Sends a point on along a path. Does it reach the piece below?
fn goes_on<P: Point>(
    path: &[Shared<P>],
    points: &PointBatch<P>,
    at: usize,
    batches: &mut [[PointBatch<P>; 2]],
) -> bool {
    let (x, radius2) = (points.positions[at], points.radii2[at]);
    for (shared, batch) in path.iter().zip(batches) {
        let mut push = |side: usize| batch[side].push(points.ids[at], x, points.owners[at], radius2);
        if shared.split.reaches(x, radius2, 1 - shared.mine) {
            push(1 - shared.mine);
        }
        let mine = shared.split.reaches(x, radius2, shared.mine);
        if mine && !shared.goes_on {
            push(shared.mine);
        }
        if !mine || !shared.goes_on {
            return false;
        }
    }
    true
}

fn empty_batches<P: Point>(path: &[Shared<P>]) -> Batches<P> {
    path.iter().map(|_| <[PointBatch<P>; 2]>::default()).collect()
}

fn send_halos<P: Point>(cx: &mut Context<P>, subdomain: &Subdomain<P>, batches: Batches<P>) {
    for (shared, batch) in subdomain.path.iter().zip(batches) {
        for (side, points) in batch.into_iter().enumerate().filter(|(_, points)| !points.is_empty()) {
            let (to, node) = (shared.member_below(cx.rank, side), shared.id.child(side));
            cx.send(to, node, 0, Body::Ghosts(points));
        }
    }
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

    /// The radius of each point.
    fn radii<P: Point>(points: &[P]) -> Vec<f64> {
        let mut gaps2 = Gaps2::default();
        let radius = |(run, scale2): (Range<usize>, f64)| {
            gaps2.measure(&points[run.clone()]);
            std::iter::repeat_n(gaps2.radius2(scale2).sqrt(), run.len())
        };
        runs(points).into_iter().flat_map(radius).collect()
    }

    fn radii_go_with_the_density<P: Point>() {
        let points = random::<P>(20_000, 3);
        let spacing = (1.0 / 20_000.0f64).powf(1.0 / P::DIM as f64);
        let radii = radii(&points);
        assert_eq!(radii.len(), points.len());
        let usual = radii.iter().filter(|&&r| r > spacing && r < 4.0 * spacing).count();
        assert!(usual > 19_500, "{usual} of 20,000");
    }

    #[test]
    fn radii_go_with_the_density_in_both_dimensions() {
        radii_go_with_the_density::<DVec3>();
        radii_go_with_the_density::<DVec2>();
    }

    #[test]
    fn gaps_between_clusters_are_no_distances() {
        let near = random::<DVec3>(4000, 5);
        let both: Vec<DVec3> = near.iter().flat_map(|&x| [x, x + DVec3::splat(1e6)]).collect();
        let both: Vec<DVec3> = insertion_order(&both).into_iter().map(|i| both[i as usize]).collect();
        let far = radii(&both).into_iter().filter(|&r| r > 2.0).count();
        assert!(far < 50, "{far} of 8000");
    }

    #[test]
    fn nothing_and_little_have_radii() {
        for n in 0..9 {
            let points = random::<DVec3>(n, 7);
            assert_eq!(radii(&points).len(), n);
        }
        let huge = [DVec3::splat(-1e300), DVec3::splat(1e300)];
        assert!(radii(&huge).iter().all(|r| r.is_finite()));
    }

    /// What is free crosses nothing, and all that reaches something is sent, by runs near and far.
    fn margins_and_what_is_sent_are_right<P: Point>() {
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
                let is_owned = |x: &&P| path.iter().all(|s| s.split.side(**x) == s.mine);
                let owned: Vec<P> = points.iter().filter(is_owned).copied().collect();
                let owned: Vec<P> = insertion_order(&owned).into_iter().map(|i| owned[i as usize]).collect();
                let (mut margins, mut gaps2) = (Vec::new(), Gaps2::default());
                for (range, scale2) in runs(&owned) {
                    let (start, run, scale2) = (range.start, &owned[range], scale2 * factor);
                    gaps2.measure(run);
                    let radius2 = gaps2.radius2(scale2);
                    let mut sent = Vec::new();
                    look_around(&path, (run, scale2), &mut gaps2, &mut margins, |level, at, own2| {
                        assert_eq!(own2, radius2);
                        sent.push((level, at));
                    });
                    let places = (0..run.len()).flat_map(|at| (0..path.len()).map(move |level| (level, at)));
                    let expected: Vec<(usize, usize)> = places
                        .filter(|&(level, at)| {
                            path[level].split.reaches(run[at], radius2, 1 - path[level].mine)
                        })
                        .collect();
                    assert_eq!(sent, expected);
                    assert_eq!(margins.len(), start + run.len());
                    for (x, margin) in run.iter().zip(&margins[start..]) {
                        assert!(margin.sent * margin.sent <= radius2);
                        assert!(margin.sent.max(margin.free) >= radius2.sqrt() * SURE);
                        let crosses = |s: &Shared<P>| s.split.separator.crosses(*x, margin.free);
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
    fn margins_and_what_is_sent_are_right_in_both_dimensions() {
        margins_and_what_is_sent_are_right::<DVec3>();
        margins_and_what_is_sent_are_right::<DVec2>();
    }

    #[test]
    fn the_ball_around_a_run_holds_it() {
        let points = random::<DVec3>(3000, 9);
        for run in points.chunks(RUN) {
            let (centre, extent) = around(run);
            assert!(run.iter().all(|&x| dist2(x, centre).sqrt() <= extent));
        }
    }
}
