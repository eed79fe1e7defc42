//! Stars that know too little and hear from each other in one rank, against stars built from all points.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::hash::Draw;
use septet_geometry::point::dist2;
use septet_geometry::predicates::in_sphere;
use septet_protocol::ids::NodeId;
use septet_protocol::transport::TransportError;

use super::*;
use crate::config::WorkerConfig;
use crate::machine::context::{Context, Running};
use crate::splaying::pending::star_by_star;
use crate::splaying::splay::splay;
use crate::stars::check::{Agreement, certificate, check};
use crate::stars::owned::Stars;
use crate::state::subdomain::{Leaf, Subdomain, bounds};
use crate::state::table::Table;

fn cloud<P: Point>(count: usize, seed: u64) -> Vec<P> {
    let mut draw = Draw::new(seed);
    (0..count).map(|_| draw.point()).collect()
}

/// The star of a point among others.
fn star<P: Point>(points: &[P], owned: u32, candidates: &[u32]) -> Vec<P::Facet> {
    let (mut builder, mut link) = (StarBuilder::default(), Vec::new());
    if builder.build(points, owned, candidates, &mut Cost::default()) {
        builder.facets(&mut link);
    }
    link
}

/// A rank with one leaf.
struct Rank<P: Point> {
    subdomain: Subdomain<P>,
    table: Table<P>,
    stars: Stars<P>,
}

impl<P: Point> Rank<P> {
    /// Whose stars are those among these candidates.
    fn of(points: &[P], candidates: impl Fn(u32) -> Vec<u32>) -> Self {
        let n = points.len() as u32;
        let table = Table::of_owned((0..u64::from(n)).collect(), points.to_vec(), 1);
        let mut subdomain = Subdomain::default();
        subdomain.leaves.push(Leaf {
            id: NodeId::ROOT,
            start: 0,
            end: n,
            bounds: bounds(points.iter().copied()),
            max_radius2: 0.0,
        });
        let mut stars = Stars::default();
        for owned in 0..n {
            let link = star(points, owned, &candidates(owned));
            stars.append(&link, &[link.len() as u32]);
        }
        stars.extend_hashes(&table);
        Rank { subdomain, table, stars }
    }

    fn chart(&self) -> Chart<'_, P> {
        Chart { table: &self.table, stars: &self.stars }
    }

    /// Checks the stars and exchanges what they miss; returns the rounds of that, and what a certificate says then.
    async fn exchange(mut self, mut cx: Context<P>) -> Result<(Self, u32, Agreement), TransportError> {
        let Rank { subdomain, table, stars } = &mut self;
        let before = check(&mut cx, subdomain, table, stars).await?;
        let population = u64::from(table.owned);
        let rounds = splay(&mut cx, subdomain, table, stars, &before, Vec::new(), population).await?;
        let after = certificate(&mut cx, subdomain, table, stars).await?;
        Ok((self, rounds, after))
    }
}

/// The nearest others.
fn nearest<P: Point>(points: &[P], owned: u32, k: usize) -> Vec<u32> {
    let mut all: Vec<u32> = (0..points.len() as u32).filter(|&v| v != owned).collect();
    let from = |v: u32| dist2(points[v as usize], points[owned as usize]);
    all.sort_by(|&a, &b| from(a).total_cmp(&from(b)));
    all.truncate(k);
    all
}

/// The cells of a link, each in order.
fn cells<P: Point>(owned: u32, link: &[P::Facet]) -> BTreeSet<P::Cell> {
    link.iter().filter_map(|facet| finite_cell::<P>(owned, facet)).map(|cell| in_order::<P>(&cell)).collect()
}

fn tell<P: Point>(rank: &Rank<P>, news: &StarNews<'_, P>, points: &[u32]) -> Splayed<P> {
    let mut out = Splayed::default();
    rank.chart().splay_star(news, points, &mut Tools::new(rank.table.positions.len()), &mut out);
    out
}

/// What a star makes of cells proposed to it by these.
fn propose<P: Point>(rank: &Rank<P>, owned: u32, cells: &[(P::Cell, u32)]) -> Splayed<P> {
    let mut proposed: Vec<Proposal<P>> = cells.iter().map(|&(cell, from)| (owned, cell, from)).collect();
    proposed.sort_unstable();
    tell(rank, &star_by_star::<P>(&proposed, &[], &[])[0], &[])
}

/// The objections to a cell: the receivers, and the points.
fn against<P: Point>(out: &mut Splayed<P>, cell: &P::Cell) -> Vec<(u32, Vec<u32>)> {
    out.objections.sort();
    let points = out.objections.points();
    let of_it = out.objections.cells().iter().filter(|o| o.1 == *cell);
    of_it.map(|o| (o.0, points[o.3.clone()].to_vec())).collect()
}

fn exchange_ends_in_the_stars_of_all<P: Point>(points: &[P], few: usize) {
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let rank = Rank::of(points, |owned| nearest(points, owned, few + owned as usize % 4));
    let right = |rank: &Rank<P>, owned: u32| {
        cells::<P>(owned, rank.stars.link(owned)) == cells::<P>(owned, &star(points, owned, &everyone))
    };
    let wrong = everyone.iter().filter(|&&owned| !right(&rank, owned)).count();
    assert!(wrong * 10 > points.len(), "{wrong} stars to be repaired");
    let mut running = Running::start(1, Arc::new(WorkerConfig::plain()), None, |cx| rank.exchange(cx));
    for round in 1.. {
        assert!(running.step().unwrap().is_empty(), "nobody else is there");
        if running.is_done() {
            break;
        }
        let active = running.busy();
        running.deliver(round, active.then(Vec::new));
    }
    let (rank, rounds, after) = running.into_result().unwrap();
    assert!(rounds > 1 && rounds < 48);
    assert!(everyone.iter().all(|&owned| right(&rank, owned)), "{few} nearest: a star is wrong");
    assert_eq!(after.differing, 0, "what the sums followed is what there is");
    assert!(after.disagreements.is_empty());
}

#[test]
fn the_exchange_ends_in_the_stars_of_all() {
    for seed in 1..6 {
        exchange_ends_in_the_stars_of_all::<DVec2>(&cloud(150, seed), 5);
        exchange_ends_in_the_stars_of_all::<DVec3>(&cloud(150, seed), 9);
    }
}

/// Every cell that is not Delaunay is refused, with just those points of the new link that are in its sphere, to those who
/// proposed it.
#[test]
fn what_is_refused_is_refused_with_points_of_the_new_link() {
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
        let mut found = against::<DVec2>(&mut out, &cell);
        for news in &mut found {
            news.1.sort_unstable();
        }
        if cells::<DVec2>(0, &whole).contains(&cell) {
            assert!(found.is_empty() && expected.is_empty());
            continue;
        }
        assert!(!expected.is_empty() || found.is_empty(), "{cell:?}: nothing is against it");
        if rank.stars.link(0).iter().all(|facet| in_order::<DVec2>(&[0, facet[0], facet[1]]) != cell) {
            assert_eq!(found, [(a, expected.clone()), (b, expected.clone())], "{cell:?}");
            with_late += u32::from(expected.contains(&late));
        }
    }
    assert!(with_late > 0);
}

/// A star tells the smallest vertex what it gained, or if that is itself the others, but no star that proposed it.
#[test]
fn fresh_cells_go_to_the_smallest_vertex_or_from_it() {
    let points = cloud::<DVec2>(40, 9);
    let everyone: Vec<u32> = (0..40).collect();
    let rank = Rank::of(&points, |owned| nearest(&points, owned, 4));
    let (mut to_others, mut to_smallest) = (0, 0);
    for owned in 0..40 {
        let held = cells::<DVec2>(owned, rank.stars.link(owned));
        for cell in cells::<DVec2>(owned, &star(&points, owned, &everyone)).difference(&held) {
            let others: Vec<u32> = cell.iter().copied().filter(|&v| v != owned).collect();
            for from in [&others[..1], &others[1..], &others[..]] {
                let tellers: Vec<([u32; 3], u32)> = from.iter().map(|&v| (*cell, v)).collect();
                let out = propose(&rank, owned, &tellers);
                let smallest = rank.chart().smallest(cell);
                let asked = others.iter().filter(|&&v| smallest == owned || v == smallest);
                let expected: Vec<u32> = asked.copied().filter(|v| !from.contains(v)).collect();
                let of_it = out.proposals.iter().filter(|p| p.1 == *cell);
                let mut found: Vec<u32> = of_it.map(|p| p.0).collect();
                found.sort_unstable();
                assert_eq!(found, expected, "{cell:?} at {owned}");
                let count = if smallest == owned { &mut to_others } else { &mut to_smallest };
                *count += found.len();
            }
        }
    }
    assert!(to_others > 0 && to_smallest > 0);
}

/// A cell that is objected to and one that is proposed, in one step: the star loses the one, does not answer the
/// objector, and tells the others.
#[test]
fn an_objection_and_a_proposal_in_one_step() {
    let points = cloud::<DVec2>(40, 4);
    let everyone: Vec<u32> = (0..40).collect();
    let mut met = 0;
    for owned in 0..40 {
        let right = cells::<DVec2>(owned, &star(&points, owned, &everyone));
        let late = *right.iter().flatten().find(|&&v| v != owned).unwrap();
        let without: Vec<u32> = everyone.iter().copied().filter(|&v| v != late).collect();
        let rank = Rank::of(&points, |_| without.clone());
        let held = cells::<DVec2>(owned, rank.stars.link(owned));
        let brings = *right.iter().find(|cell| cell.contains(&late)).unwrap();
        for lost in held.difference(&right) {
            let objector = *lost.iter().find(|&&v| v != owned).unwrap();
            let proposed: Vec<Proposal<DVec2>> = vec![(owned, brings, late)];
            let mut said = Announced::<DVec2>::default();
            said.add([owned].into_iter(), lost, objector, &[late]);
            said.sort();
            let (objected, named) = (said.cells(), said.points());
            let mut out = tell(&rank, &star_by_star::<DVec2>(&proposed, objected, &[])[0], named);
            let mut found = None;
            out.each_change(|_, change| found = Some(cells::<DVec2>(owned, change.link)));
            assert_eq!(found.as_ref(), Some(&right), "{owned}");
            let smallest = rank.chart().smallest(lost);
            let asked = lost
                .iter()
                .copied()
                .filter(|&v| v != owned && (smallest == owned || v == smallest) && v != objector);
            let news: Vec<u32> = against::<DVec2>(&mut out, lost).into_iter().map(|news| news.0).collect();
            assert_eq!(news, asked.collect::<Vec<u32>>(), "{lost:?} at {owned}");
            met += news.len();
        }
    }
    assert!(met > 0);
}

/// A star without a link takes the first cell that is proposed; one with a hole is whole after a gathering.
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
    holed.stars.replace(5, &link);
    let gathered: Vec<(u32, u32)> = link_points::<DVec3>(&whole, &mut Marks::new(50), &mut Cost::default())
        .into_iter()
        .map(|v| (5, v))
        .collect();
    let mut found = None;
    tell(&holed, &star_by_star::<DVec3>(&[], &[], &gathered)[0], &[]).each_change(|_, change| {
        found = Some(cells::<DVec3>(5, change.link));
    });
    assert_eq!(found, Some(right));
}
