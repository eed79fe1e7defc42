//! Regular triangulations compared with the oracle, with Delaunay triangulations and with themselves in other orders.

use glam::{DVec2, DVec3};

use super::nasty::{KINDS, set};
use super::*;
use crate::conflict_region::ConflictRegion;
use crate::point::{Position, dist2};
use crate::range::Digits;
use crate::site::Weighted;

/// Ways to choose weights.
pub(crate) const WAYS: [&str; 8] =
    ["equal", "small", "large", "flat", "concave", "one heavy", "negative", "steps"];

/// Adds weights to points.
pub(crate) fn sites<P: Position>(points: &[P], way: &str, seed: u64) -> Vec<Weighted<P>> {
    let mut random = Draw::new(seed);
    let extent2 = points.iter().map(|&p| dist2(p, points[0])).fold(0.0, f64::max);
    let spacing2 = extent2 / (points.len() as f64).powf(2.0 / P::DIM as f64);
    let heavy = points.len() / 3;
    let site = |(i, &p): (usize, &P)| {
        let weight = match way {
            "equal" => spacing2,
            "small" => spacing2 * 0.05 * random.unit(),
            "large" => spacing2 * 2.0 * random.unit(),
            // All heights are equal, up to rounding.
            "flat" => p.norm2(),
            "concave" => 2.0 * p.norm2(),
            "one heavy" => extent2 * f64::from(u8::from(i == heavy)),
            "negative" => -spacing2 * 3.0 * random.unit(),
            _ => spacing2 * random.below(3) as f64,
        };
        Weighted::new(p, weight)
    };
    points.iter().enumerate().map(site).collect()
}

fn agrees_with_the_oracle<P: Position>(n: usize) {
    let mut hidden = 0;
    for kind in KINDS {
        let points = set::<P>(kind, n, 5);
        for way in WAYS {
            let sites = sites(&points, way, 7);
            if !Digits::of(&sites).unwrap().fits() {
                continue;
            }
            let what = format!("{kind}, {way}");
            let expected = oracle::cells(&sites);
            for order in [None, Some(insertion_order(&sites))] {
                let dt = Incremental::build(sites.clone(), order.as_deref()).unwrap();
                check(&dt);
                assert_eq!(as_rows(&dt), expected, "{what}");
                for v in 0..sites.len() as u32 {
                    let is_vertex = expected.iter().any(|cell| cell.contains(&v));
                    assert_eq!(dt.is_hidden(v), !is_vertex, "{what}");
                    hidden += usize::from(!is_vertex);
                }
            }
            if way == "equal" {
                let plain = Incremental::new(points.clone()).unwrap();
                assert_eq!(as_rows(&plain), expected, "{what}");
            }
        }
    }
    assert!(hidden > 1_000, "{hidden} hidden");
}

fn as_rows<P: Point>(dt: &Incremental<P>) -> Vec<Vec<u32>> {
    sorted_cells(dt).iter().map(|cell| cell.as_ref().to_vec()).collect()
}

#[test]
fn sites_of_space_agree_with_the_oracle() {
    agrees_with_the_oracle::<DVec3>(110);
}

#[test]
fn sites_of_the_plane_agree_with_the_oracle() {
    agrees_with_the_oracle::<DVec2>(200);
}

fn small_sets_agree_with_brute_force<P: Position>(n: usize) {
    for kind in KINDS {
        for (seed, way) in (0..).zip(WAYS) {
            let sites = sites(&set::<P>(kind, n, seed), way, seed);
            if !Digits::of(&sites).unwrap().fits() {
                continue;
            }
            let Ok(dt) = Incremental::build(sites.clone(), None) else { continue };
            check(&dt);
            assert_eq!(sorted_cells(&dt), brute_force(&sites), "{kind}, {way}");
        }
    }
}

#[test]
fn small_sets_of_sites_agree_with_brute_force() {
    small_sets_agree_with_brute_force::<DVec3>(13);
    small_sets_agree_with_brute_force::<DVec2>(16);
}

/// Insertion one by one gives the same cells, and points without owned neighbours are skipped.
fn late_sites_are_inserted<P: Position>() {
    for kind in KINDS {
        for way in WAYS {
            let sites = sites(&set::<P>(kind, 120, 5), way, 3);
            if !Digits::of(&sites).unwrap().fits() {
                continue;
            }
            let Ok(whole) = Incremental::new(sites.clone()) else { continue };
            let owned = sites.len() / 2;
            let Ok(mut part) = Incremental::build(sites[..owned].to_vec(), None) else { continue };
            let mut all = part.clone();
            for (&site, v) in sites[owned..].iter().zip(owned as u32..) {
                part.insert_if_adjacent(site, None, owned as u32).unwrap();
                assert_eq!(all.insert(site, None), Ok(v), "{kind}, {way}");
            }
            check(&part);
            check(&all);
            assert_eq!(as_rows(&all), as_rows(&whole), "{kind}, {way}");
            let around = |dt: &Incremental<Weighted<P>>| cells_around(dt, owned, &sites);
            assert_eq!(around(&part), around(&whole), "{kind}, {way}");
        }
    }
}

#[test]
fn late_sites_are_inserted_in_space() {
    late_sites_are_inserted::<DVec3>();
}

#[test]
fn late_sites_are_inserted_in_the_plane() {
    late_sites_are_inserted::<DVec2>();
}

/// All translations of a box of unit length by at most one box along each axis.
fn images<P: Position>(sites: &[Weighted<P>], length: f64) -> Vec<Weighted<P>> {
    let mut all = Vec::new();
    for code in 0..3usize.pow(P::DIM as u32) {
        let mut by = P::default();
        for i in 0..P::DIM {
            by.set_coord(i, length * ((code / 3usize.pow(i as u32) % 3) as f64 - 1.0));
        }
        all.extend(sites.iter().map(|site| site.translated(by)));
    }
    all
}

/// Sites with all their images agree with the oracle, and images conflict alike.
fn images_agree_with_the_oracle<P: Position>(n: usize) {
    for kind in ["random", "grid", "decimal", "clusters", "single", "shaken grid"] {
        for way in ["equal", "small", "large", "steps"] {
            let sites = sites(&set::<P>(kind, n, 5), way, 7);
            for length in [9.1, 7.0, 1.0 / 3.0] {
                let images = images(&sites, length);
                let mut all: Vec<Weighted<P>> = images;
                all.sort_by(lex_cmp);
                all.dedup_by(|a, b| lex_cmp(a, b).is_eq());
                Draw::new(3).shuffle(&mut all);
                if !Digits::of(&all).unwrap().fits() {
                    continue;
                }
                let dt = Incremental::new(all.clone()).unwrap();
                check(&dt);
                assert_eq!(as_rows(&dt), oracle::cells(&all), "{kind}, {way}, {length}");
            }
        }
    }
}

#[test]
fn images_agree_with_the_oracle_in_both_dimensions() {
    images_agree_with_the_oracle::<DVec3>(8);
    images_agree_with_the_oracle::<DVec2>(20);
}

/// Regions and balls contain every conflicting site of weight at most the largest. Some sites are images.
fn regions_contain_all_conflicts<P: Position>() {
    let (mut met, mut balls) = (0, 0);
    for kind in KINDS {
        for (number, way) in WAYS.into_iter().enumerate() {
            let sites = sites(&set::<P>(kind, 140, 2), way, 11);
            let by = [P::splat(0.0), P::splat(1.0 / 3.0), P::splat(1e8 / 3.0)][number % 3];
            let moved =
                |(i, &site): (usize, &Weighted<P>)| if i % 3 == 0 { site } else { site.translated(by) };
            let mut sites: Vec<Weighted<P>> = sites.iter().enumerate().map(moved).collect();
            sites.sort_by(lex_cmp);
            sites.dedup_by(|a, b| lex_cmp(a, b).is_eq());
            Draw::new(3).shuffle(&mut sites);
            if !Digits::of(&sites).unwrap().fits() {
                continue;
            }
            let heaviest = sites.iter().map(Point::weight).fold(f64::NEG_INFINITY, f64::max);
            let half = sites.len() / 2;
            let first = (sites[..half].to_vec(), heaviest);
            let Ok(dt) = Incremental::build_below(first, 0..half as u32, &mut |_| true) else { continue };
            for (slot, _, _) in
                dt.complex().entries().filter(|(_, cell, _)| !cell.as_ref().contains(&INFINITE))
            {
                let corners = dt.corners(slot);
                let region = ConflictRegion::of_cell(&corners[..=P::DIM], heaviest);
                for &q in sites[half..].iter().filter(|&&q| in_sphere(&corners[..=P::DIM], q)) {
                    assert!(region.meets_box(q, q), "{kind}, {way}: {corners:?} {q:?}");
                    met += 1;
                    if let Some((centre, radius2)) = dt.ball(slot) {
                        assert!(dist2(centre, q) <= radius2, "{kind}, {way}: {corners:?} {q:?}");
                        let near = corners[..=P::DIM]
                            .iter()
                            .all(|&p| dist2(p, q).sqrt() <= 2.0 * dt.radius_bound(slot));
                        assert!(near, "{kind}, {way}: {corners:?} {q:?}");
                        balls += 1;
                    }
                }
            }
        }
    }
    assert!(met > 10_000 && balls > met / 2, "{met} conflicts, {balls} with balls");
}

#[test]
fn regions_of_sites_contain_all_conflicts() {
    regions_contain_all_conflicts::<DVec3>();
    regions_contain_all_conflicts::<DVec2>();
}
