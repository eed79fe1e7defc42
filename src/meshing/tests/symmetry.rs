//! The result does not depend on the position, scale or order of the domain.

use glam::{DMat3, DVec3};
use proptest::prelude::*;
use septet_geometry::hash::Draw;

use super::shapes::{add_box, cube, cube_surface, facet, join, segment};
use crate::check;
use crate::defect::{Defect, Element};
use crate::input::{Input, InputFacet, Region};

/// Domains with many kinds of defects, and some without.
fn domains() -> Vec<Input<DVec3>> {
    let region = |at: [f64; 3]| Region { at: at.into(), attribute: 1.0, limit: None };
    let mut all = vec![cube(), cube_surface()];
    let mut open = cube_surface();
    open.facets.remove(3);
    all.push(open);
    let mut fin = cube_surface();
    fin.points.push(DVec3::new(9.0, 8.0, 7.0));
    fin.facets.push(InputFacet { polygons: vec![vec![6, 7, 8]], holes: vec![], marker: 0 });
    all.push(fin);
    all.push(join(&cube_surface(), &cube_surface(), DVec3::splat(2.0), 1.0));
    all.push(join(&cube_surface(), &cube_surface(), DVec3::new(1.0, 1.0, 4.0), 0.5));
    let mut bent = cube();
    bent.points[7].z += 0.5;
    all.push(bent);
    let mut through = cube();
    through.points.extend([[-1., 1., 1.], [5., 1., 1.], [5., 2., 2.], [-1., 2., 2.]].map(DVec3::from));
    facet(&mut through, &[&[8, 9, 10, 11]]);
    through.points.extend([[2., 3., 2.], [2., 3., 6.]].map(DVec3::from));
    segment(&mut through, [12, 13]);
    all.push(through);
    let mut overlap = cube();
    add_box(&mut overlap, DVec3::new(1.0, 1.0, 4.0), DVec3::new(6.0, 3.0, 5.0));
    all.push(overlap);
    let mut doubled = cube();
    facet(&mut doubled, &[&[0, 2, 3, 1]]);
    facet(&mut doubled, &[&[0, 2]]);
    all.push(doubled);
    let mut places = cube();
    places.regions =
        vec![region([1., 2., 3.]), region([2., 2., 1.]), region([9., 1., 1.]), region([4., 1., 2.])];
    all.push(places.clone());
    places.holes.push(DVec3::splat(3.0));
    all.push(places);
    all
}

/// A defect without its place and indices, but with its elements, in the numbering before the change.
fn key(defect: &Defect, points: &[u32], facets: &[u32]) -> (String, Vec<Element>) {
    let point = |v: u32| points[v as usize];
    let edge = |[a, b]: [u32; 2]| {
        let (a, b) = (point(a), point(b));
        Element::Segment([a.min(b), a.max(b)])
    };
    let facet = |f: u32| Element::Facet(facets[f as usize]);
    let element = |p: Element| match p {
        Element::Point(v) => Element::Point(point(v)),
        Element::Segment(e) => edge(e),
        Element::Facet(f) => facet(f),
        other => other,
    };
    let mut named = match defect {
        Defect::Duplicate { points, .. } => points.iter().map(|&v| Element::Point(point(v))).collect(),
        Defect::NotPlanar { facet: f, point: v, .. } => vec![facet(*f), Element::Point(point(*v))],
        Defect::Degenerate { element: p, .. }
        | Defect::Dangling { element: p, .. }
        | Defect::Misplaced { element: p, .. } => vec![element(*p)],
        Defect::Doubled { elements, .. } | Defect::Intersect { elements, .. } => {
            elements.map(element).to_vec()
        }
        Defect::OpenEdge { ends, facet: f, .. } => vec![edge(*ends), facet(*f)],
        Defect::NonManifoldEdge { ends, facets, .. } => {
            facets.iter().map(|&f| facet(f)).chain([edge(*ends)]).collect()
        }
        Defect::NonManifoldVertex { point: v, .. } => vec![Element::Point(point(*v))],
        Defect::SharedComponent { regions, .. } => regions.map(Element::Region).to_vec(),
        _ => vec![],
    };
    named.sort_unstable();
    (defect.kind().to_string(), named)
}

/// The numbers of corners, segments, facets and components of a valid domain, or the keys of all defects.
fn keys(
    input: &Input<DVec3>,
    points: &[u32],
    facets: &[u32],
) -> Result<[usize; 4], Vec<(String, Vec<Element>)>> {
    match check(input) {
        Ok(d) => {
            let inside = d.components.iter().filter(|c| c.inside).count();
            Ok([d.corners.len(), d.segments.len(), d.facets.len(), inside])
        }
        Err(defects) => {
            let mut keys: Vec<_> = defects.iter().map(|d| key(d, points, facets)).collect();
            keys.sort();
            Err(keys)
        }
    }
}

/// A shuffle: the old position for each new one.
fn shuffle(n: usize, seed: u64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..n as u32).collect();
    Draw::new(seed).shuffle(&mut order);
    order
}

/// The input with its points and facets in another order.
fn reordered(input: &Input<DVec3>, points: &[u32], facets: &[u32]) -> Input<DVec3> {
    let mut new = vec![0; points.len()];
    for (i, &old) in points.iter().enumerate() {
        new[old as usize] = i as u32;
    }
    let mut out = input.clone();
    out.points = points.iter().map(|&v| input.points[v as usize]).collect();
    out.facets = facets.iter().map(|&f| input.facets[f as usize].clone()).collect();
    for v in out.facets.iter_mut().flat_map(|f| f.polygons.iter_mut().flatten()) {
        *v = new[*v as usize];
    }
    for v in out.segments.iter_mut().flat_map(|s| s.ends.iter_mut()) {
        *v = new[*v as usize];
    }
    out
}

fn moved(input: &Input<DVec3>, by: impl Fn(DVec3) -> DVec3) -> Input<DVec3> {
    let mut out = input.clone();
    out.points.iter_mut().for_each(|p| *p = by(*p));
    out.holes.iter_mut().for_each(|p| *p = by(*p));
    out.regions.iter_mut().for_each(|r| r.at = by(r.at));
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, ..ProptestConfig::default() })]

    /// Permutations and reflections of axes, powers of two and shuffles are exact, so nothing may change.
    #[test]
    fn exact_changes(axes in 0..6usize, signs in 0..8u32, power in -300..300i32, seed in any::<u64>()) {
        const AXES: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        let factor = f64::from_bits(((1023 + power) as u64) << 52);
        let sign = |i: u32| if signs >> i & 1 == 0 { factor } else { -factor };
        let by = |p: DVec3| {
            let [x, y, z] = AXES[axes].map(|i| p[i]);
            DVec3::new(x * sign(0), y * sign(1), z * sign(2))
        };
        for (i, input) in domains().into_iter().enumerate() {
            let (points, facets) = (shuffle(input.points.len(), seed), shuffle(input.facets.len(), !seed));
            let same: [Vec<u32>; 2] = [(0..points.len() as u32).collect(), (0..facets.len() as u32).collect()];
            let changed = moved(&reordered(&input, &points, &facets), by);
            let before = keys(&input, &same[0], &same[1]);
            prop_assert_eq!(before, keys(&changed, &points, &facets), "domain {}", i);
        }
    }

    /// Rotations are rounded. Surfaces of triangles keep their structure and their volume.
    #[test]
    fn rotations(x in -1.0..1.0f64, y in -1.0..1.0f64, angle in 0.0..6.2f64, shift in -9.0..9.0f64) {
        let turn = DMat3::from_axis_angle(DVec3::new(x, y, 1.0).normalize(), angle);
        let surfaces = [
            (cube_surface(), 64.0),
            (join(&cube_surface(), &cube_surface(), DVec3::splat(1.0), 0.5), 56.0),
            (join(&cube_surface(), &cube_surface(), DVec3::splat(9.0), 0.5), 72.0),
        ];
        for (surface, volume) in surfaces {
            let domain = check(&moved(&surface, |p| turn * p + DVec3::splat(shift)));
            let domain = domain.map_err(|d| TestCaseError::fail(format!("{d:?}")))?;
            prop_assert!((domain.measure() - volume).abs() < 1e-11 * volume);
            prop_assert!(domain.small_angles(44.9).is_empty());
        }
        let mut open = cube_surface();
        open.facets.pop();
        let found = check(&moved(&open, |p| turn * p)).err().unwrap_or_default();
        prop_assert!(found.len() == 3 && found.iter().all(|d| d.kind() == "open edge"));
    }
}
