//! Domains without defects.

use glam::{DVec2, DVec3};

use super::shapes::{add_box, cube, cube_surface, facet, join, segment};
use crate::check;
use crate::distance::Features;
use crate::domain::{Domain, Feature};
use crate::input::{DomainKind, Input, InputSegment, Region};
use crate::space::Space;

fn good<P: crate::facet::Triangulate>(input: &Input<P>) -> Domain<P> {
    check(input).unwrap_or_else(|d| panic!("{d:#?}"))
}

fn sizes<P: Space>(d: &Domain<P>) -> [usize; 3] {
    [d.corners.len(), d.segments.len(), d.facets.len()]
}

#[test]
fn a_cube_and_its_surface_are_the_same() {
    for input in [cube(), cube_surface()] {
        let domain = good(&input);
        assert_eq!(sizes(&domain), [8, 12, 6]);
        assert_eq!(domain.measure(), 64.0);
        assert!(domain.is_inside(DVec3::splat(0.1)) && !domain.is_inside(DVec3::splat(-0.1)));
        assert!(domain.small_angles(90.0).is_empty());
        assert_eq!(domain.small_angles(91.0).len(), 24 + 12);
        assert_eq!(domain.ridges(60.0).len(), 12);
        assert!(domain.facets.iter().all(|f| f.boundary.len() == 4 && f.internal.is_empty()));
    }
}

#[test]
fn local_size_in_a_cube() {
    let domain = good(&cube());
    let features = Features::new(&domain);
    let size = |x, y, z| features.local_size(DVec3::new(x, y, z)).radius;
    assert_eq!(size(2.0, 2.0, 2.0), 2.0);
    // The far facet at 3 does not count, because two opposite facets are at distance 2.
    assert_eq!(size(1.0, 2.0, 2.0), 2.0);
    assert_eq!(size(0.0, 0.0, 0.0), 4.0);
    assert_eq!(size(2.0, 0.0, 0.0), 2.0);
    assert_eq!(size(1.0, 0.0, 0.0), 3.0);
    assert_eq!(features.distance(Feature::Corner(0), DVec3::new(3.0, 4.0, 0.0)), 5.0);
}

#[test]
fn shells_cavities_and_regions() {
    let (outer, inner) = (cube_surface(), cube_surface());
    let cavity = join(&outer, &inner, DVec3::splat(1.0), 0.5);
    let domain = good(&cavity);
    assert_eq!(domain.measure(), 56.0);
    assert!(!domain.is_inside(DVec3::splat(2.0)) && domain.is_inside(DVec3::splat(0.5)));
    let island = join(&cavity, &inner, DVec3::splat(1.5), 0.25);
    assert_eq!(good(&island).measure(), 57.0);
    let apart = join(&outer, &inner, DVec3::splat(9.0), 0.5);
    assert_eq!(good(&apart).measure(), 72.0);

    let mut hollow = cube();
    add_box(&mut hollow, DVec3::splat(1.0), DVec3::splat(3.0));
    assert_eq!(good(&hollow).measure(), 64.0);
    hollow.holes.push(DVec3::splat(2.0));
    let domain = good(&hollow);
    assert_eq!((domain.measure(), sizes(&domain)), (56.0, [16, 24, 12]));
}

#[test]
fn internal_and_dangling_elements() {
    let mut input = cube();
    // An internal facet halfway, with its corners in the middle of edges of the cube.
    input.points.extend([[0., 0., 2.], [4., 0., 2.], [4., 4., 2.], [0., 4., 2.]].map(DVec3::from));
    facet(&mut input, &[&[8, 9, 10, 11]]);
    let region = |z, attribute| Region { at: DVec3::new(3.0, 1.0, z), attribute, limit: None };
    input.regions.extend([region(1.0, 1.0), region(3.0, 2.0)]);
    let domain = good(&input);
    assert_eq!(sizes(&domain), [12, 20, 7]);
    assert_eq!(domain.components.iter().filter(|c| c.inside && c.measure == 32.0).count(), 2);
    assert_eq!(domain.facets.iter().filter(|f| f.internal.len() == 1).count(), 4);

    // A dangling facet, a dangling segment from a corner, one from inside the internal facet, and a point.
    input.points.extend(
        [[1., 1., 3.], [2., 1., 3.], [2., 2., 3.], [1., 1., 1.], [3., 3., 2.], [3., 3., 1.]].map(DVec3::from),
    );
    input.points.push(DVec3::new(3.5, 3.5, 3.5));
    facet(&mut input, &[&[12, 13, 14]]);
    segment(&mut input, [0, 15]);
    facet(&mut input, &[&[16, 17]]);
    let domain = good(&input);
    assert_eq!(sizes(&domain), [12 + 7, 20 + 5, 8]);
    assert_eq!(domain.measure(), 64.0);
    assert!(domain.left_out.is_empty());
    let small = domain.small_angles(90.0);
    // The diagonal at the corner and its three edges and facets.
    let with_diagonal =
        |f: Feature| matches!(f, Feature::Segment(s) if domain.segments[s as usize].ends() == [0, 15]);
    let diagonal = small.iter().filter(|s| s.features.iter().any(|&f| with_diagonal(f)));
    assert_eq!(diagonal.clone().count(), 6);
    assert!(diagonal.clone().any(|s| (s.degrees() - 35.264_389_682_754_654).abs() < 1e-9));
    let features = Features::new(&domain);
    let size = features.local_size(DVec3::new(3.0, 3.0, 1.5));
    assert_eq!(size.radius, 0.5);
}

#[test]
fn polygons_with_holes_in_the_plane_and_in_facets() {
    let square = |low: f64, high: f64| [[low, low], [high, low], [high, high], [low, high]].map(DVec2::from);
    let mut input = Input::new(DomainKind::Complex, [square(0.0, 8.0), square(2.0, 4.0)].concat());
    for base in [0, 4] {
        for i in 0..4 {
            input.segments.push(InputSegment { ends: [base + i, base + (i + 1) % 4], marker: 7 });
        }
    }
    assert_eq!(good(&input).measure(), 64.0);
    input.holes.push(DVec2::splat(3.0));
    let domain = good(&input);
    assert_eq!((domain.measure(), sizes(&domain)), (60.0, [8, 8, 0]));
    assert!(domain.segments.iter().all(|s| s.marker == 7));
    let size = Features::new(&domain).local_size(DVec2::new(1.0, 3.0));
    assert_eq!(size.radius, 1.0);

    let mut tunnel = cube();
    tunnel.facets.truncate(4);
    tunnel.points.extend([[0., 1., 1.], [0., 1., 3.], [0., 3., 3.], [0., 3., 1.]].map(DVec3::from));
    tunnel.points.extend([[4., 1., 1.], [4., 1., 3.], [4., 3., 3.], [4., 3., 1.]].map(DVec3::from));
    facet(&mut tunnel, &[&[0, 4, 6, 2], &[8, 9, 10, 11]]);
    facet(&mut tunnel, &[&[1, 3, 7, 5], &[12, 13, 14, 15]]);
    for (f, x) in [(4, 0.0), (5, 4.0)] {
        tunnel.facets[f].holes.push(DVec3::new(x, 2.0, 2.0));
    }
    for i in 0..4 {
        let j = (i + 1) % 4;
        facet(&mut tunnel, &[&[8 + i, 8 + j, 12 + j, 12 + i]]);
    }
    let domain = good(&tunnel);
    assert_eq!((domain.measure(), sizes(&domain)), (64.0 - 16.0, [16, 24, 10]));
    assert!(!domain.is_inside(DVec3::splat(2.0)));
}
