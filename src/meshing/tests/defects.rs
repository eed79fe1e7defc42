//! Domains with defects.

use glam::DVec3;

use super::shapes::{add_box, cube, cube_surface, facet, join, segment};
use crate::check;
use crate::defect::{Defect, Element, Misplaced};
use crate::input::{Input, InputFacet, Region};

fn bad(input: &Input<DVec3>) -> Vec<Defect> {
    match check(input) {
        Ok(_) => panic!("no defect found"),
        Err(defects) => defects,
    }
}

fn kinds(input: &Input<DVec3>) -> Vec<&'static str> {
    bad(input).iter().map(Defect::kind).collect()
}

#[test]
fn open_and_pinched_surfaces() {
    let mut open = cube_surface();
    open.facets.pop();
    assert_eq!(kinds(&open), ["open edge"; 3]);
    assert!(bad(&open).iter().all(|d| matches!(d, Defect::OpenEdge { facet: 10 | 2 | 4, .. })));
    let mut fin = cube_surface();
    fin.points.push(DVec3::splat(9.0));
    fin.facets.push(InputFacet { polygons: vec![vec![6, 7, 8]], holes: vec![], marker: 0 });
    let found = kinds(&fin);
    assert_eq!(found.iter().filter(|k| **k == "open edge").count(), 2);
    assert_eq!(found.iter().filter(|k| **k == "edge not manifold").count(), 1);
    // Two cubes that share one vertex.
    let mut pair = join(&cube_surface(), &cube_surface(), DVec3::splat(4.0), 1.0);
    for f in &mut pair.facets {
        for v in f.polygons.iter_mut().flatten().filter(|v| **v == 8) {
            *v = 7;
        }
    }
    let found = bad(&pair);
    assert!(matches!(found[..], [Defect::NonManifoldVertex { point: 7, fans: 2, .. }]), "{found:?}");
}

#[test]
fn overlapping_duplicate_and_degenerate_elements() {
    let mut input = cube();
    input.points.push(DVec3::splat(4.0));
    input.points.push(DVec3::new(2.0, 0.0, 0.0));
    facet(&mut input, &[&[0, 1, 9]]);
    segment(&mut input, [3, 3]);
    facet(&mut input, &[&[0, 2, 3, 1]]);
    facet(&mut input, &[&[0, 2, 99]]);
    let found = bad(&input);
    let is = |f: &dyn Fn(&Defect) -> bool| assert!(found.iter().any(f), "{found:#?}");
    is(&|d| matches!(d, Defect::Duplicate { points, .. } if points[..] == [7, 8]));
    is(&|d| matches!(d, Defect::Degenerate { element: Element::Facet(6), .. }));
    is(&|d| matches!(d, Defect::Degenerate { element: Element::Segment([3, 3]), .. }));
    is(&|d| matches!(d, Defect::Doubled { elements: [Element::Facet(0), Element::Facet(7)], .. }));
    is(&|d| matches!(d, Defect::NoSuchPoint { element: Element::Facet(8), named: 99, count: 10 }));
    assert_eq!(found.len(), 5, "{found:#?}");
}

#[test]
fn facets_that_bend_or_cross() {
    let mut bent = cube();
    bent.points[7].z += 0.5;
    let found = bad(&bent);
    assert!(found.iter().any(|d| matches!(d, Defect::NotPlanar { facet: 1, .. })), "{found:?}");
    let mut through = cube();
    through.points.extend([[-1., 1., 1.], [5., 1., 1.], [5., 2., 2.], [-1., 2., 2.]].map(DVec3::from));
    facet(&mut through, &[&[8, 9, 10, 11]]);
    let found = bad(&through);
    let with = |f| move |d: &&Defect| matches!(d, Defect::Intersect { elements, .. } if *elements == [Element::Facet(f), Element::Facet(6)]);
    assert_eq!((found.iter().filter(with(4)).count(), found.iter().filter(with(5)).count()), (1, 1));
    assert_eq!(found.len(), 2, "{found:?}");
    let mut pierced = cube();
    pierced.points.extend([[2., 2., 2.], [2., 2., 6.]].map(DVec3::from));
    segment(&mut pierced, [8, 9]);
    let found = bad(&pierced);
    assert!(matches!(
        found[..],
        [Defect::Intersect { elements: [Element::Segment([8, 9]), Element::Facet(1)], .. }]
    ));
    // Two boxes that overlap, and two coplanar facets that do.
    let mut overlap = cube();
    add_box(&mut overlap, DVec3::splat(2.0), DVec3::splat(6.0));
    assert_eq!(kinds(&overlap), ["intersection"; 6]);
    let mut flat = cube();
    add_box(&mut flat, DVec3::new(1.0, 1.0, 4.0), DVec3::new(6.0, 3.0, 5.0));
    assert!(kinds(&flat).iter().all(|k| *k == "intersection"));
    let mut tie = cube();
    tie.facets[1].polygons[0] = vec![4, 7, 5, 6];
    assert!(kinds(&tie).contains(&"intersection"), "{:?}", bad(&tie));
}

#[test]
fn holes_and_regions_in_the_wrong_place() {
    let region = |at: f64| Region { at: DVec3::splat(at), attribute: 1.0, limit: None };
    let mut input = cube();
    input.regions = vec![region(1.0), region(2.0), region(9.0), region(4.0)];
    let found = bad(&input);
    let misplaced = |element, place| {
        found.iter().any(
            |d| matches!(d, Defect::Misplaced { element: p, place: q, .. } if (*p, *q) == (element, place)),
        )
    };
    assert!(misplaced(Element::Region(2), Misplaced::Outside));
    assert!(misplaced(Element::Region(3), Misplaced::OnBoundary));
    assert!(found.iter().any(|d| matches!(d, Defect::SharedComponent { regions: [0, 1], .. })));
    input.regions.truncate(1);
    input.holes.push(DVec3::splat(3.0));
    assert_eq!(kinds(&input), ["misplaced hole or region point", "nothing enclosed"]);
    let mut open = cube();
    open.facets.pop();
    assert_eq!(kinds(&open), ["nothing enclosed"]);
}
