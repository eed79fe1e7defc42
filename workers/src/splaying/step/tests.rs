//! Compares stars that splay within one rank with stars built from all points.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::hash::Draw;
use septet_geometry::point::{Position, dist2};
use septet_geometry::predicates::in_sphere;
use septet_geometry::site::Weighted;
use septet_protocol::ids::NodeId;
use septet_protocol::transport::TransportError;

use super::*;
use crate::config::WorkerConfig;
use crate::machine::context::{Context, Running};
use crate::splaying::messages::GatheredPoint;
use crate::splaying::pass::{AllPoints, Passed, Start};
use crate::splaying::pending::Pending;
use crate::splaying::splay::splay;
use crate::splaying::tell::tell;
use crate::stars::check::{Agreement, certificate, check};
use crate::stars::owned::Stars;
use crate::state::subdomain::{Subdomain, Subtree};
use crate::state::table::Table;
use crate::state::tree::{Leaf, bounds};

fn cloud<P: Point>(count: usize, seed: u64) -> Vec<P> {
    let mut draw = Draw::new(seed);
    (0..count).map(|_| draw.point()).collect()
}

/// Returns points with weights of up to `spread` mean squared distances of neighbours.
fn weighted_cloud<P: Position>(count: usize, spread: f64, seed: u64) -> Vec<Weighted<P>> {
    let mut draw = Draw::new(seed);
    let unit = (count as f64).powf(-2.0 / P::DIM as f64);
    (0..count).map(|_| Weighted::new(draw.point(), spread * unit * draw.unit())).collect()
}

/// Returns the link of a point among candidates, or its cover if they hide it.
fn hull<P: Point>(points: &[P], vertex: u32, candidates: &[u32]) -> (Vec<P::Facet>, Option<P::Cell>) {
    let (mut builder, mut link) = (StarBuilder::default(), Vec::new());
    if builder.build(points, vertex, candidates, &mut Cost::default()) {
        builder.facets(&mut link);
    }
    (link, builder.cover())
}

/// Returns the star of a point among candidates.
fn star<P: Point>(points: &[P], vertex: u32, candidates: &[u32]) -> Vec<P::Facet> {
    hull(points, vertex, candidates).0
}

/// A rank with one leaf.
struct Rank<P: Point> {
    subdomain: Subdomain<P>,
    table: Table<P>,
    stars: Stars<P>,
}

impl<P: Point> Rank<P> {
    /// Creates a rank whose stars have the given candidates.
    fn of(points: &[P], candidates: impl Fn(u32) -> Vec<u32>) -> Self {
        let n = points.len() as u32;
        let table = Table::of_owned((0..u64::from(n)).collect(), points.to_vec(), 1);
        let leaf = Leaf::new(NodeId::ROOT, 0..n, bounds(points.iter().copied()));
        let subdomain = Subdomain::new(Vec::new(), None, Some(Subtree::of_leaf(leaf)), Vec::new());
        let mut stars = Stars::default();
        for vertex in 0..n {
            let (link, cover) = hull(points, vertex, &candidates(vertex));
            stars.append(&link, &[link.len() as u32]);
            stars.add_covers(cover.map(|cover| (vertex, cover)));
        }
        stars.extend_hashes(&table);
        Rank { subdomain, table, stars }
    }

    fn view(&self) -> StarsView<'_, P> {
        StarsView::new(&self.table, &self.stars)
    }

    /// Checks and repairs the stars. Returns the rounds and the result of a certificate.
    async fn repaired(
        mut self,
        mut cx: Context<P>,
        repair: Repair,
    ) -> Result<(Self, u32, Agreement), TransportError> {
        let Rank { subdomain, table, stars } = &mut self;
        let before = check(&mut cx, subdomain, table, stars).await?;
        let heaviest = table.positions().iter().map(P::weight).fold(0.0, f64::max);
        let all = AllPoints { count: u64::from(table.owned_len()), heaviest };
        let start = Start::default();
        let Passed { rounds, .. } = match repair {
            Repair::Probe => tell(&mut cx, subdomain, table, stars, &before, start, all).await?,
            Repair::Splay => splay(&mut cx, subdomain, table, stars, &before, start, all).await?,
        };
        let after = certificate(&mut cx, subdomain, table, stars).await?;
        Ok((self, rounds, after))
    }
}

/// Returns the nearest other points.
fn nearest<P: Point>(points: &[P], vertex: u32, k: usize) -> Vec<u32> {
    let mut all: Vec<u32> = (0..points.len() as u32).filter(|&v| v != vertex).collect();
    let from = |v: u32| dist2(points[v as usize], points[vertex as usize]);
    all.sort_by(|&a, &b| from(a).total_cmp(&from(b)));
    all.truncate(k);
    all
}

/// Returns the finite cells of a link.
fn cells<P: Point>(vertex: u32, link: &[P::Facet]) -> BTreeSet<P::Cell> {
    link.iter().filter_map(|facet| finite_cell::<P>(vertex, facet)).map(|cell| in_order::<P>(&cell)).collect()
}

/// Runs the step of the one star that has messages.
fn step<P: Point>(rank: &Rank<P>, mut pending: Pending<P>) -> Splayed<P> {
    let (mut tools, mut out) =
        (Tools::new(rank.table.positions().len(), Cost::default(), Repair::Splay), Splayed::default());
    pending.sort();
    StarStep::new(rank.view(), pending.by_star()[0], &mut tools, &mut out).run();
    out
}

/// Proposes cells to a star, each with its sender.
fn propose<P: Point>(rank: &Rank<P>, to: u32, cells: &[(P::Cell, u32)]) -> Splayed<P> {
    let mut pending = Pending::new(Vec::new());
    pending.proposals = cells.iter().map(|&(cell, from)| Proposal { to, cell, from }).collect();
    step(rank, pending)
}

/// Returns the objections to a cell: the receivers and the witnesses.
fn objections_to<P: Point>(out: &mut Splayed<P>, cell: &P::Cell) -> Vec<(u32, Vec<u32>)> {
    out.objections.sort();
    let witnesses = out.objections.witnesses();
    let of_cell = out.objections.list().iter().filter(|o| o.cell == *cell);
    of_cell.map(|o| (o.to, witnesses[o.witnesses.clone()].to_vec())).collect()
}

fn repair_ends_in_the_stars_of_all<P: Point>(points: &[P], few: usize, repair: Repair) {
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let rank = Rank::of(points, |vertex| nearest(points, vertex, few + vertex as usize % 4));
    let is_right = |rank: &Rank<P>, vertex: u32| {
        cells::<P>(vertex, rank.stars.link(vertex)) == cells::<P>(vertex, &star(points, vertex, &everyone))
    };
    let wrong = everyone.iter().filter(|&&vertex| !is_right(&rank, vertex)).count();
    assert!(wrong * 10 > points.len(), "{wrong} wrong stars");
    let mut running =
        Running::start(1, Arc::new(WorkerConfig::plain()), None, |cx| rank.repaired(cx, repair));
    for round in 1.. {
        assert!(running.step().unwrap().is_empty(), "there is no other rank");
        if running.is_done() {
            break;
        }
        let active = running.busy();
        running.deliver(round, active.then(Vec::new));
    }
    let (rank, rounds, after) = running.into_result().unwrap();
    assert!(rounds > 1 && rounds < 48);
    assert!(everyone.iter().all(|&vertex| is_right(&rank, vertex)), "{few} nearest: a star is wrong");
    let is_decided = |&v: &u32| rank.stars.link(v).is_empty() == rank.stars.cover(v).is_some();
    assert!(everyone.iter().all(is_decided), "a point is hidden iff it has a cover");
    assert_eq!(after.differing(), 0, "the sums follow the stars");
    assert!(after.disagreements().is_empty());
}

#[test]
fn the_repair_ends_in_the_stars_of_all() {
    for (seed, repair) in (1..6).flat_map(|seed| [(seed, Repair::Probe), (seed, Repair::Splay)]) {
        repair_ends_in_the_stars_of_all::<DVec2>(&cloud(150, seed), 5, repair);
        repair_ends_in_the_stars_of_all::<DVec3>(&cloud(150, seed), 9, repair);
        let spread = seed as f64 - 1.0;
        repair_ends_in_the_stars_of_all(&weighted_cloud::<DVec2>(150, spread, seed), 5, repair);
        repair_ends_in_the_stars_of_all(&weighted_cloud::<DVec3>(150, spread, seed), 9, repair);
    }
}

/// A star objects to every cell that is not Delaunay. It sends its proposers the points of the new link in the circumsphere.
#[test]
fn rejected_cells_have_witnesses_from_the_new_link() {
    let points = cloud::<DVec2>(30, 3);
    let everyone: Vec<u32> = (0..30).collect();
    let late = star(&points, 0, &everyone)[0].as_ref()[0];
    let without: Vec<u32> = everyone.iter().copied().filter(|&v| v != late).collect();
    let rank = Rank::of(&points, |_| without.clone());
    let whole = star(&points, 0, &everyone);
    let brings = *cells::<DVec2>(0, &whole).iter().find(|cell| cell.contains(&late)).unwrap();
    let mut seen = Marks::new(30);
    let link = link_points::<DVec2>(&whole, &mut seen, &mut Cost::default());
    let mut with_late = 0;
    for (a, b) in (1..30).flat_map(|a| (a + 1..30).map(move |b| (a, b))) {
        let cell = [0, a, b];
        let mut corners = cell.map(|v| points[v as usize]);
        if (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]) < 0.0 {
            corners.swap(0, 1);
        }
        let inside = |&&v: &&u32| !cell.contains(&v) && in_sphere(&corners, points[v as usize]);
        let mut expected: Vec<u32> = link.iter().filter(inside).copied().collect();
        expected.sort_unstable();
        let mut out = propose(&rank, 0, &[(brings, late), (cell, a), (cell, b)]);
        let mut found = objections_to::<DVec2>(&mut out, &cell);
        for objection in &mut found {
            objection.1.sort_unstable();
        }
        if cells::<DVec2>(0, &whole).contains(&cell) {
            assert!(found.is_empty() && expected.is_empty());
            continue;
        }
        assert!(!expected.is_empty() || found.is_empty(), "{cell:?}: an objection to a Delaunay cell");
        if rank.stars.link(0).iter().all(|facet| in_order::<DVec2>(&[0, facet[0], facet[1]]) != cell) {
            assert_eq!(found, [(a, expected.clone()), (b, expected.clone())], "{cell:?}");
            with_late += u32::from(expected.contains(&late));
        }
    }
    assert!(with_late > 0);
}

/// A star proposes a gained cell to its smallest vertex, or to the others if its own vertex is the smallest. It skips stars
/// that proposed the cell.
#[test]
fn gained_cells_go_to_the_smallest_vertex_or_from_it() {
    let points = cloud::<DVec2>(40, 9);
    let everyone: Vec<u32> = (0..40).collect();
    let rank = Rank::of(&points, |vertex| nearest(&points, vertex, 4));
    let (mut to_others, mut to_smallest) = (0, 0);
    for vertex in 0..40 {
        let held = cells::<DVec2>(vertex, rank.stars.link(vertex));
        for cell in cells::<DVec2>(vertex, &star(&points, vertex, &everyone)).difference(&held) {
            let others: Vec<u32> = cell.iter().copied().filter(|&v| v != vertex).collect();
            for from in [&others[..1], &others[1..], &others[..]] {
                let proposed: Vec<([u32; 3], u32)> = from.iter().map(|&v| (*cell, v)).collect();
                let out = propose(&rank, vertex, &proposed);
                let smallest = rank.view().smallest(cell);
                let receivers = others.iter().filter(|&&v| smallest == vertex || v == smallest);
                let expected: Vec<u32> = receivers.copied().filter(|v| !from.contains(v)).collect();
                let of_cell = out.proposals.iter().filter(|p| p.cell == *cell);
                let mut found: Vec<u32> = of_cell.map(|p| p.to).collect();
                found.sort_unstable();
                assert_eq!(found, expected, "{cell:?} at {vertex}");
                let count = if smallest == vertex { &mut to_others } else { &mut to_smallest };
                *count += found.len();
            }
        }
    }
    assert!(to_others > 0 && to_smallest > 0);
}

/// A star receives an objection to one cell and a proposal of another. It loses the first cell and sends objections to the
/// others, but not to the objector.
#[test]
fn an_objection_and_a_proposal_in_one_step() {
    let points = cloud::<DVec2>(40, 4);
    let everyone: Vec<u32> = (0..40).collect();
    let mut count = 0;
    for vertex in 0..40 {
        let right = cells::<DVec2>(vertex, &star(&points, vertex, &everyone));
        let late = *right.iter().flatten().find(|&&v| v != vertex).unwrap();
        let without: Vec<u32> = everyone.iter().copied().filter(|&v| v != late).collect();
        let rank = Rank::of(&points, |_| without.clone());
        let held = cells::<DVec2>(vertex, rank.stars.link(vertex));
        let brings = *right.iter().find(|cell| cell.contains(&late)).unwrap();
        for lost in held.difference(&right) {
            let objector = *lost.iter().find(|&&v| v != vertex).unwrap();
            let mut pending = Pending::<DVec2>::new(Vec::new());
            pending.proposals.push(Proposal { to: vertex, cell: brings, from: late });
            pending.objections.add([vertex].into_iter(), *lost, objector, &[late]);
            let mut out = step(&rank, pending);
            let mut changed = None;
            out.each_change(|_, change| changed = Some(cells::<DVec2>(vertex, change.link)));
            assert_eq!(changed.as_ref(), Some(&right), "{vertex}");
            let smallest = rank.view().smallest(lost);
            let receivers = lost
                .iter()
                .copied()
                .filter(|&v| v != vertex && (smallest == vertex || v == smallest) && v != objector);
            let found: Vec<u32> = objections_to::<DVec2>(&mut out, lost).into_iter().map(|o| o.0).collect();
            assert_eq!(found, receivers.collect::<Vec<u32>>(), "{lost:?} at {vertex}");
            count += found.len();
        }
    }
    assert!(count > 0);
}

/// A star without a link takes the first cell that is proposed. A link with a hole is complete after gathering.
#[test]
fn stars_without_a_link_or_with_a_hole_are_rebuilt() {
    let points = cloud::<DVec3>(50, 7);
    let everyone: Vec<u32> = (0..50).collect();
    let whole = star(&points, 5, &everyone);
    let right = cells::<DVec3>(5, &whole);
    let first = *right.iter().next().unwrap();
    let empty = Rank::of(&points, |_| Vec::new());
    let mut found = None;
    propose(&empty, 5, &[(first, first[0])]).each_change(|_, change| {
        found = Some(cells::<DVec3>(5, change.link));
    });
    assert_eq!(found, Some(BTreeSet::from([first])));

    let mut holed = Rank::of(&points, |_| everyone.clone());
    let place = whole.iter().position(|facet| finite_cell::<DVec3>(5, facet).is_some()).unwrap();
    let mut link = whole.clone();
    link.remove(place);
    holed.stars.splay(&holed.table, 5, &Change { link: &link, gained: &[], lost: &[], cover: None });
    let gathered: Vec<GatheredPoint> =
        link_points::<DVec3>(&whole, &mut Marks::new(50), &mut Cost::default())
            .into_iter()
            .map(|point| GatheredPoint { star: 5, point })
            .collect();
    let mut found = None;
    step(&holed, Pending::new(gathered)).each_change(|_, change| {
        found = Some(cells::<DVec3>(5, change.link));
    });
    assert_eq!(found, Some(right));
}
