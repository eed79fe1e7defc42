//! Stars that know too little, told by each other in one worker, against stars built from all points.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::point::dist2;
use septet_geometry::predicates::in_sphere;
use septet_protocol::ids::{NodeId, Phase};

use super::*;
use crate::config::WorkerConfig;
use crate::splaying::exchange::star_by_star;
use crate::state::subdomain::{Leaf, bounds};
use crate::state::table::Table;

fn cloud<P: Point>(count: usize, mut seed: u64) -> Vec<P> {
    let mut unit = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut point = || {
        let mut x = P::default();
        (0..P::DIM).for_each(|k| x.set_coord(k, unit()));
        x
    };
    (0..count).map(|_| point()).collect()
}

/// The star of a point among others.
fn star<P: Point>(points: &[P], home: u32, candidates: &[u32]) -> Vec<P::Facet> {
    let (mut builder, mut link) = (StarBuilder::default(), Vec::new());
    if builder.build(points, home, candidates, &mut Cost::default()) {
        builder.facets(&mut link);
    }
    link
}

/// A worker with one leaf whose stars are those among these candidates.
fn worker<P: Point>(points: &[P], candidates: impl Fn(u32) -> Vec<u32>) -> Worker<P> {
    let mut worker = Worker::new(1, Arc::new(WorkerConfig::plain()), None);
    let n = points.len() as u32;
    worker.table = Table::of_home((0..u64::from(n)).collect(), points.to_vec(), 1);
    worker.subdomain.leaves.push(Leaf {
        id: NodeId::ROOT,
        start: 0,
        end: n,
        bounds: bounds(points.iter().copied()),
        max_radius2: 0.0,
        ghosts: Vec::new(),
    });
    worker.population = u64::from(n);
    for home in 0..n {
        let link = star(points, home, &candidates(home));
        worker.stars.append(&link, &[link.len() as u32]);
    }
    worker.extend_hashes();
    worker
}

/// The nearest others.
fn nearest<P: Point>(points: &[P], home: u32, k: usize) -> Vec<u32> {
    let mut all: Vec<u32> = (0..points.len() as u32).filter(|&v| v != home).collect();
    let from = |v: u32| dist2(points[v as usize], points[home as usize]);
    all.sort_by(|&a, &b| from(a).total_cmp(&from(b)));
    all.truncate(k);
    all
}

/// The cells of a link, each in order.
fn cells<P: Point>(home: u32, link: &[P::Facet]) -> BTreeSet<P::Cell> {
    link.iter().filter_map(|facet| finite_cell::<P>(home, facet)).map(|cell| in_order::<P>(&cell)).collect()
}

fn tell<P: Point>(worker: &Worker<P>, told: &Told<'_, P>, points: &[u32]) -> Reactions<P> {
    let mut out = Reactions::default();
    worker.react(told, points, &mut Tools::new(worker.table.positions.len()), &mut out);
    out
}

/// What a star makes of cells proposed to it by these.
fn propose<P: Point>(worker: &Worker<P>, home: u32, cells: &[(P::Cell, u32)]) -> Reactions<P> {
    let mut proposed: Vec<Proposal<P>> = cells.iter().map(|&(cell, from)| (home, cell, from)).collect();
    proposed.sort_unstable();
    tell(worker, &star_by_star::<P>(&proposed, &[], &[])[0], &[])
}

/// The objections to a cell: who is told, and of which points.
fn against<P: Point>(out: &mut Reactions<P>, cell: &P::Cell) -> Vec<(u32, Vec<u32>)> {
    let (objections, points) = out.objections.sorted();
    let of_it = objections.iter().filter(|o| o.1 == *cell);
    of_it.map(|o| (o.0, points[o.3.clone()].to_vec())).collect()
}

fn exchange_ends_in_the_stars_of_all<P: Point>(points: &[P], few: usize) {
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let mut worker = worker(points, |home| nearest(points, home, few + home as usize % 4));
    let right = |worker: &Worker<P>, home: u32| {
        cells::<P>(home, worker.stars.link(home)) == cells::<P>(home, &star(points, home, &everyone))
    };
    let wrong = everyone.iter().filter(|&&home| !right(&worker, home)).count();
    assert!(wrong * 10 > points.len(), "{wrong} stars to be repaired");
    worker.phase = Phase::Check;
    worker.begin_check();
    worker.phase = Phase::Repair;
    worker.begin_repair();
    while worker.busy() {
        worker.step += 1;
        worker.on_repair(&mut Vec::new());
    }
    assert!(worker.exchange.rounds > 1 && worker.step < 48);
    assert!(everyone.iter().all(|&home| right(&worker, home)), "{few} nearest: a star is wrong");
    worker.begin_certificate();
    assert_eq!(worker.agreement.differing, 0, "what the sums followed is what there is");
    assert!(worker.finish_check().is_empty());
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
    let worker = worker(&points, |_| without.clone());
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
        let mut out = propose(&worker, 0, &[(brings, late), (cell, a), (cell, b)]);
        let mut found = against::<DVec2>(&mut out, &cell);
        for told in &mut found {
            told.1.sort_unstable();
        }
        if cells::<DVec2>(0, &whole).contains(&cell) {
            assert!(found.is_empty() && expected.is_empty());
            continue;
        }
        assert!(!expected.is_empty() || found.is_empty(), "{cell:?}: nothing is against it");
        if worker.stars.link(0).iter().all(|facet| in_order::<DVec2>(&[0, facet[0], facet[1]]) != cell) {
            assert_eq!(found, [(a, expected.clone()), (b, expected.clone())], "{cell:?}");
            with_late += u32::from(expected.contains(&late));
        }
    }
    assert!(with_late > 0);
}

/// Of what it gained a star tells the smallest vertex, or if that is itself the others, but nobody who told it.
#[test]
fn who_is_told_of_fresh_cells() {
    let points = cloud::<DVec2>(40, 9);
    let everyone: Vec<u32> = (0..40).collect();
    let worker = worker(&points, |home| nearest(&points, home, 4));
    let (mut told_others, mut told_smallest) = (0, 0);
    for home in 0..40 {
        let held = cells::<DVec2>(home, worker.stars.link(home));
        for cell in cells::<DVec2>(home, &star(&points, home, &everyone)).difference(&held) {
            let others: Vec<u32> = cell.iter().copied().filter(|&v| v != home).collect();
            for from in [&others[..1], &others[1..], &others[..]] {
                let tellers: Vec<([u32; 3], u32)> = from.iter().map(|&v| (*cell, v)).collect();
                let out = propose(&worker, home, &tellers);
                let smallest = worker.smallest(cell);
                let asked = others.iter().filter(|&&v| smallest == home || v == smallest);
                let expected: Vec<u32> = asked.copied().filter(|v| !from.contains(v)).collect();
                let of_it = out.proposals.iter().filter(|p| p.1 == *cell);
                let mut found: Vec<u32> = of_it.map(|p| p.0).collect();
                found.sort_unstable();
                assert_eq!(found, expected, "{cell:?} at {home}");
                let count = if smallest == home { &mut told_others } else { &mut told_smallest };
                *count += found.len();
            }
        }
    }
    assert!(told_others > 0 && told_smallest > 0);
}

/// A cell that is objected to and one that is proposed, in one step: the star loses the one, does not answer the
/// objector, and tells the others.
#[test]
fn an_objection_and_a_proposal_in_one_step() {
    let points = cloud::<DVec2>(40, 4);
    let everyone: Vec<u32> = (0..40).collect();
    let mut met = 0;
    for home in 0..40 {
        let right = cells::<DVec2>(home, &star(&points, home, &everyone));
        let late = *right.iter().flatten().find(|&&v| v != home).unwrap();
        let without: Vec<u32> = everyone.iter().copied().filter(|&v| v != late).collect();
        let worker = worker(&points, |_| without.clone());
        let held = cells::<DVec2>(home, worker.stars.link(home));
        let brings = *right.iter().find(|cell| cell.contains(&late)).unwrap();
        for lost in held.difference(&right) {
            let objector = *lost.iter().find(|&&v| v != home).unwrap();
            let proposed: Vec<Proposal<DVec2>> = vec![(home, brings, late)];
            let mut said = Said::<DVec2>::default();
            said.add([home].into_iter(), lost, objector, &[late]);
            let (objected, named) = said.sorted();
            let mut out = tell(&worker, &star_by_star::<DVec2>(&proposed, objected, &[])[0], named);
            let mut found = None;
            out.each_change(|_, link, _, _| found = Some(cells::<DVec2>(home, link)));
            assert_eq!(found.as_ref(), Some(&right), "{home}");
            let smallest = worker.smallest(lost);
            let asked = lost
                .iter()
                .copied()
                .filter(|&v| v != home && (smallest == home || v == smallest) && v != objector);
            let told: Vec<u32> = against::<DVec2>(&mut out, lost).into_iter().map(|told| told.0).collect();
            assert_eq!(told, asked.collect::<Vec<u32>>(), "{lost:?} at {home}");
            met += told.len();
        }
    }
    assert!(met > 0);
}

/// A star without a link takes the first cell that is proposed; one with a hole is whole after a gathering.
#[test]
fn stars_without_a_link_or_with_a_hole_are_built_anew() {
    let points = cloud::<DVec3>(50, 7);
    let everyone: Vec<u32> = (0..50).collect();
    let whole = star(&points, 5, &everyone);
    let right = cells::<DVec3>(5, &whole);
    let first = *right.iter().next().unwrap();
    let empty = worker(&points, |_| Vec::new());
    let mut found = None;
    propose(&empty, 5, &[(first, first[0])]).each_change(|_, link, _, _| {
        found = Some(cells::<DVec3>(5, link));
    });
    assert_eq!(found, Some(BTreeSet::from([first])));

    let mut holed = worker(&points, |_| everyone.clone());
    let place = whole.iter().position(|facet| finite_cell::<DVec3>(5, facet).is_some()).unwrap();
    let mut link = whole.clone();
    link.remove(place);
    holed.stars.replace(5, &link);
    let gathered: Vec<(u32, u32)> = link_points::<DVec3>(&whole, &mut Marks::new(50), &mut Cost::default())
        .into_iter()
        .map(|v| (5, v))
        .collect();
    let mut found = None;
    tell(&holed, &star_by_star::<DVec3>(&[], &[], &gathered)[0], &[]).each_change(|_, link, _, _| {
        found = Some(cells::<DVec3>(5, link));
    });
    assert_eq!(found, Some(right));
}
