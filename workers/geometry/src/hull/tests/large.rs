//! Large stars.

use super::super::*;
use super::in_order;
use crate::complex::INFINITE;
use crate::cost::Cost;
use crate::incremental::tests::nasty::{KINDS, set};
use crate::point::Point;
use glam::{DVec2, DVec3};

/// The sorted facets of a star.
fn facets_of<P: Point>(builder: &StarBuilder<P>) -> Vec<P::Facet> {
    let mut facets = Vec::new();
    builder.facets(&mut facets);
    let mut facets: Vec<P::Facet> = facets.iter().map(in_order::<P>).collect();
    facets.sort_unstable();
    facets
}

/// Points on a sphere around the first one, up to rounding.
fn hub<P: Point>(n: usize) -> Vec<P> {
    let mut draw = crate::hash::Draw::new(11);
    let mut points = vec![P::splat(0.5)];
    while points.len() <= n {
        let way = draw.point::<P>() - P::splat(0.5);
        if way.norm2() > 0.01 {
            points.push(P::splat(0.5) + way * (0.5 / way.norm2().sqrt()));
        }
    }
    points
}

/// Large stars have the same facets at random as by distance, whatever the numbering, and the same cost for every
/// numbering.
fn large_stars_do_not_depend_on_the_order<P: Point>(points: &[P]) {
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let [mut random, mut turned] = [(); 2].map(|()| StarBuilder::default());
    let mut by_distance = StarBuilder::new(LargeStars::ByDistance);
    let reversed: Vec<P> = points.iter().rev().copied().collect();
    for v in [0, 1, points.len() as u32 / 2] {
        let mut costs = [(); 3].map(|()| Cost::default().nested());
        assert!(random.build(points, v, &everyone, &mut costs[0]));
        assert!(by_distance.build(points, v, &everyone, &mut costs[1]));
        assert_eq!(facets_of(&random), facets_of(&by_distance), "star of {v}");
        let last = points.len() as u32 - 1;
        let repeated = [&everyone[..], &everyone[..]].concat();
        assert!(turned.build(&reversed, last - v, &repeated, &mut Cost::default()));
        let mut renamed: Vec<P::Facet> = facets_of(&turned);
        for facet in &mut renamed {
            facet.as_mut().iter_mut().filter(|v| **v != INFINITE).for_each(|v| *v = last - *v);
            facet.as_mut().sort_unstable();
        }
        renamed.sort_unstable();
        assert_eq!(renamed, facets_of(&random), "star of {v}, other numbers");
        assert!(turned.build(&reversed, last - v, &everyone, &mut costs[2]));
        assert_eq!(costs[0].price(), costs[2].price(), "star of {v}");
        random.link.check().unwrap();
    }
}

#[test]
fn large_stars_of_space_do_not_depend_on_the_order() {
    large_stars_do_not_depend_on_the_order(&hub::<DVec3>(700));
    for kind in KINDS {
        large_stars_do_not_depend_on_the_order(&set::<DVec3>(kind, 300, 4));
    }
}

#[test]
fn large_stars_of_the_plane_do_not_depend_on_the_order() {
    large_stars_do_not_depend_on_the_order(&hub::<DVec2>(700));
    for kind in KINDS {
        large_stars_do_not_depend_on_the_order(&set::<DVec2>(kind, 300, 4));
    }
}

/// The nearest points lie in a plane, so the first simplex has a far point.
#[test]
fn a_hub_in_a_plane_is_a_star() {
    let mut points: Vec<DVec3> = hub::<DVec2>(300).iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
    points.extend([DVec3::new(0.3, 0.2, 4.0), DVec3::new(0.4, 0.3, 5.0)]);
    large_stars_do_not_depend_on_the_order(&points);
}

/// The work of a hub is O(m log m), and its depth O(log^2 m).
#[test]
fn hubs_cost_little() {
    for n in [1000, 4000] {
        let points = hub::<DVec3>(n);
        let everyone: Vec<u32> = (0..points.len() as u32).collect();
        let mut cost = Cost::default().nested();
        assert!(StarBuilder::default().build(&points, 0, &everyone, &mut cost));
        let log = (n as f64).log2();
        assert!((cost.work() as f64) < 70.0 * n as f64 * log, "{n}: {}", cost.work());
        assert!((cost.depth() as f64) < 6.0 * log * log, "{n}: {}", cost.depth());
        let mut by_distance = Cost::default().nested();
        assert!(StarBuilder::new(LargeStars::ByDistance).build(&points, 0, &everyone, &mut by_distance));
        assert!(cost.work() < by_distance.work() && 4 * cost.depth() < by_distance.depth());
    }
}
