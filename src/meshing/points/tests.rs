//! Tests of candidates, conflicts and independent sets.

use glam::{DVec2, DVec3};
use proptest::prelude::*;
use septet_geometry::point::Point;

use super::candidates::{LipschitzSize, Name, candidates, cells};
use super::conflicts::{Site, Sites};
use super::independent::{by_rounds, greedy};
use crate::bvh::Bounds;
use crate::size::tests::slit;
use crate::size::{SizeFunction, SizeOptions};

/// Candidates of a box, and earlier points that exclude some of them.
struct Stage<P> {
    names: Vec<Name>,
    sites: Vec<Site<P>>,
    barred: Vec<bool>,
    graph: Vec<Vec<u32>>,
}

fn stage<P: Point>(
    sizing: &LipschitzSize<'_, P>,
    side: f64,
    count: u32,
    seed: u64,
    fixed: &[Site<P>],
) -> Stage<P> {
    let bounds = Bounds { low: P::splat(0.0), high: P::splat(side) };
    let (cube, grown) = cells(&bounds, sizing, 1 << 22).unwrap();
    let all = grown.leaves.iter().flat_map(|&(key, ())| candidates(&cube, key, count, seed, sizing));
    let (names, sites): (Vec<_>, Vec<_>) = all.unzip();
    let earlier = Sites::new(fixed);
    let barred = sites.iter().map(|s| !earlier.against(s).is_empty()).collect();
    let graph = Sites::new(&sites).graph();
    Stage { names, sites, barred, graph }
}

/// Returns the set after a check of its properties over all pairs.
fn checked<P: Point>(stage: &Stage<P>, fixed: &[Site<P>], seed: u64) -> (Vec<Name>, usize) {
    let priorities: Vec<_> = stage.names.iter().map(|n| n.priority(seed)).collect();
    let set = by_rounds(&stage.graph, &priorities, &stage.barred);
    assert_eq!(set.members, greedy(&stage.graph, &priorities, &stage.barred));
    let mut spaced = fixed.to_vec();
    spaced.extend(set.members.iter().map(|&v| stage.sites[v as usize]));
    for (i, a) in spaced.iter().enumerate() {
        assert!(spaced[i + 1..].iter().all(|b| !a.conflicts(b)), "not independent");
    }
    for (v, site) in stage.sites.iter().enumerate() {
        let member = set.members.binary_search(&(v as u32)).is_ok();
        assert!(member || spaced.iter().any(|s| s.conflicts(site)), "not maximal");
    }
    (set.members.iter().map(|&v| stage.names[v as usize]).collect(), set.rounds())
}

#[test]
fn sets_are_independent_and_maximal_in_plane_and_space() {
    let corner = |x, y| Site { at: DVec2::new(x, y), size: 0.02 };
    let fixed = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.5, 0.51)];
    let at = |p: DVec2| 0.02 + 0.25 * p.distance(DVec2::splat(0.5));
    let plane = stage(&LipschitzSize { lipschitz: 0.25, at: &at }, 1.0, 8, 7, &fixed);
    assert!(plane.barred.iter().any(|&b| b));
    let (members, rounds) = checked(&plane, &fixed, 7);
    assert!(members.len() > 80 && rounds > 3, "{} in {rounds}", members.len());

    let at = |p: DVec3| 0.1 + 0.5 * p.distance(DVec3::splat(0.5));
    let space = stage(&LipschitzSize { lipschitz: 0.5, at: &at }, 1.0, 8, 7, &[]);
    checked(&space, &[], 7);
}

/// Points in a domain: corners first, then candidates inside.
#[test]
fn points_of_a_domain() {
    let domain = slit();
    let size = SizeFunction::new(&domain, &SizeOptions::new(0.25)).unwrap();
    let at = |p: DVec2| 0.5 * size.at(p);
    let sizing = LipschitzSize { lipschitz: 0.125, at: &at };
    let corner = |&v: &u32| Site { at: domain.points()[v as usize], size: at(domain.points()[v as usize]) };
    let corners: Vec<Site<DVec2>> = domain.corners.iter().map(corner).collect();
    // Corners are disjoint features, so their distance is at least lfs.
    assert!(corners.iter().enumerate().all(|(i, a)| corners[i + 1..].iter().all(|b| !a.conflicts(b))));
    let bounds = Bounds::of(domain.points().iter().copied());
    let (cube, grown) = cells(&bounds, &sizing, 1 << 20).unwrap();
    let all = grown.leaves.iter().flat_map(|&(key, ())| candidates(&cube, key, 6, 3, &sizing));
    let (names, sites): (Vec<_>, Vec<_>) = all.filter(|(_, s)| domain.is_inside(s.at)).unzip();
    let earlier = Sites::new(&corners);
    let barred: Vec<bool> = sites.iter().map(|s| !earlier.against(s).is_empty()).collect();
    let graph = Sites::new(&sites).graph();
    let stage = Stage { names, sites, barred, graph };
    let (members, rounds) = checked(&stage, &corners, 3);
    assert!(members.len() > 300, "{} in {rounds}", members.len());
    assert!(rounds as f64 <= (stage.sites.len() as f64).log2() + 2.0, "{rounds}");
}

#[test]
fn rounds_grow_no_faster_than_the_logarithm() {
    for (size, seed) in [(0.05, 1), (0.025, 2), (0.0125, 3), (0.00625, 4)] {
        let at = |_: DVec2| size;
        let stage = stage(&LipschitzSize { lipschitz: 0.25, at: &at }, 1.0, 6, seed, &[]);
        let priorities: Vec<_> = stage.names.iter().map(|n| n.priority(seed)).collect();
        let set = by_rounds(&stage.graph, &priorities, &stage.barred);
        let bound = (stage.sites.len() as f64).log2() + 2.0;
        assert!((set.rounds() as f64) <= bound, "{} rounds, bound {bound}", set.rounds());
        assert!(set.undecided.windows(2).all(|w| w[1] < w[0]));
    }
}

#[test]
fn places_lie_in_their_cells_and_priorities_differ() {
    let at = |_: DVec3| 0.2;
    let sizing = LipschitzSize { lipschitz: 0.25, at: &at };
    let bounds = Bounds { low: DVec3::ZERO, high: DVec3::splat(1.0) };
    let (cube, grown) = cells(&bounds, &sizing, 1 << 20).unwrap();
    let mut priorities = Vec::new();
    for &(key, ()) in &grown.leaves {
        let cell = cube.cell(key);
        for (name, site) in candidates(&cube, key, 5, 42, &sizing) {
            let gap = (site.at - cell.centre).abs().max_element();
            assert!(gap <= 0.5 * cell.side && name.cell == key);
            priorities.push(name.priority(42).0);
        }
    }
    let all = priorities.len();
    priorities.sort_unstable();
    priorities.dedup();
    assert_eq!((priorities.len(), all), (all, 5 * 512 * 8));
    let name = Name { cell: grown.leaves[3].0, number: 1 };
    assert_ne!(name.priority(1), name.priority(2));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    /// The properties hold for any sizes, even if they are not Lipschitz, and for any order of the candidates.
    #[test]
    fn any_sites(places in prop::collection::vec((0.0..1.0f64, 0.0..1.0f64, 0.01..0.4f64), 1..120),
                 fixed in prop::collection::vec((0.0..1.0f64, 0.0..1.0f64), 0..4), seed in any::<u64>()) {
        let sites: Vec<Site<DVec2>> =
            places.iter().map(|&(x, y, size)| Site { at: DVec2::new(x, y), size }).collect();
        let fixed: Vec<Site<DVec2>> =
            fixed.into_iter().map(|p| Site { at: p.into(), size: 1e-3 }).collect();
        let cell = crate::octree::CellKey::ROOT;
        let names: Vec<Name> = (0..sites.len() as u32).map(|number| Name { cell, number }).collect();
        let make = |names: Vec<Name>, sites: Vec<Site<DVec2>>| {
            let earlier = Sites::new(&fixed);
            let barred = sites.iter().map(|s| !earlier.against(s).is_empty()).collect();
            let graph = Sites::new(&sites).graph();
            Stage { names, sites, barred, graph }
        };
        let stage = make(names.clone(), sites.clone());
        for (i, near) in stage.graph.iter().enumerate() {
            let all = (0..sites.len()).filter(|&j| j != i && sites[i].conflicts(&sites[j]));
            prop_assert!(near.iter().map(|&j| j as usize).eq(all));
        }
        let (members, _) = checked(&stage, &fixed, seed);
        let back = make(names.into_iter().rev().collect(), sites.into_iter().rev().collect());
        let (mut again, _) = checked(&back, &fixed, seed);
        again.reverse();
        prop_assert_eq!(members, again);
    }
}
