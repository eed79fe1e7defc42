//! Stars of points with weights, compared with those of the triangulation. Covers of hidden points, by the predicates.

use super::*;
use crate::incremental::tests::weighted::{WAYS, sites};
use crate::point::{Position, Vector};
use crate::predicates::orientation;
use crate::range::Digits;
use crate::site::Weighted;

/// Returns the facets of a star of the triangulation, in canonical order. A hidden point has none.
fn expected<P: Point>(triangulation: &Incremental<P>, v: u32) -> Vec<P::Facet> {
    let mut link = Vec::new();
    if !triangulation.is_hidden(v) {
        triangulation.link_of(v, &mut link);
    }
    sorted::<P>(&link)
}

fn sorted<P: Point>(facets: &[P::Facet]) -> Vec<P::Facet> {
    let mut facets: Vec<P::Facet> = facets.iter().map(in_order::<P>).collect();
    facets.sort_unstable();
    facets
}

/// Asserts that the cover of a centre contains it, strictly below it.
fn is_covered<P: Point>(points: &[P], v: u32, cover: Option<P::Cell>) {
    let cover = cover.expect("a hidden point has a cover");
    assert!(!cover.as_ref().contains(&v));
    let mut corners: Vec<P> = cover.as_ref().iter().map(|&i| points[i as usize]).collect();
    if orientation(&corners) == Sign::Negative {
        corners.swap(0, 1);
    }
    assert_eq!(orientation(&corners), Sign::Positive);
    for slot in 0..=P::DIM {
        let corner = std::mem::replace(&mut corners[slot], points[v as usize]);
        assert_ne!(orientation(&corners), Sign::Negative, "the cover contains the point");
        corners[slot] = corner;
    }
    assert!(!in_sphere(&corners, points[v as usize]), "the cover is below the point");
}

/// Extends a star of some points by all. The result is that of the triangulation, and so are the reported changes.
fn check_extension<P: Point>(points: &[P], v: u32, right: &[P::Facet], builder: &mut StarBuilder<P>) -> bool {
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let stride = 2 + v as usize % 5;
    let some: Vec<u32> = everyone.iter().copied().skip(v as usize % 3).step_by(stride).collect();
    let (mut old, mut new, mut fresh, mut cost) = (Vec::new(), Vec::new(), Vec::new(), Cost::default());
    if !builder.build(points, v, &some, &mut cost) || builder.cover().is_some() {
        return false;
    }
    builder.facets(&mut old);
    if builder.extend(points, v, &old, &everyone, &mut cost) == Extended::Same {
        assert_eq!(sorted::<P>(&old), right);
        return false;
    }
    builder.facets(&mut new);
    assert_eq!(sorted::<P>(&new), right);
    builder.created_facets(&mut fresh);
    let removed = builder.removed_facets();
    assert_eq!(removed.len(), builder.removers().len());
    assert_eq!(new.len() - fresh.len(), old.len() - removed.len());
    for (&at, &remover) in removed.iter().zip(builder.removers()) {
        let facet = old[at as usize];
        assert!(right.binary_search(&in_order::<P>(&facet)).is_err());
        if !facet.as_ref().contains(&INFINITE) {
            let corners: Vec<P> = [v].iter().chain(facet.as_ref()).map(|&i| points[i as usize]).collect();
            assert!(in_sphere(&corners, points[remover as usize]));
        }
    }
    if right.is_empty() {
        assert_eq!(removed.len(), old.len());
        is_covered(points, v, builder.cover());
    }
    right.is_empty()
}

/// Stars of all candidates, in order of distance and at random.
fn stars_are_those_of_the_triangulation<P: Position>(n: usize)
where
    Weighted<P>: Vector,
{
    let (mut hidden, mut became_hidden) = (0, 0);
    for kind in KINDS {
        let points = set::<P>(kind, n, 21);
        for way in WAYS {
            let points = sites(&points, way, 3);
            if !Digits::of(&points).unwrap().fits() {
                continue;
            }
            let triangulation = Incremental::new(points.clone()).unwrap();
            let everyone: Vec<u32> = (0..points.len() as u32).collect();
            let mut extending = StarBuilder::default();
            let builders = [LargeStars::AtRandom, LargeStars::ByDistance].map(StarBuilder::new);
            for mut builder in builders {
                for &v in &everyone {
                    let right = expected(&triangulation, v);
                    assert!(builder.build(&points, v, &everyone, &mut Cost::default()));
                    let mut facets = Vec::new();
                    builder.facets(&mut facets);
                    assert_eq!(sorted::<Weighted<P>>(&facets), right, "{kind}, {way}, star of {v}");
                    assert_eq!(builder.cover().is_some(), right.is_empty(), "{kind}, {way}, star of {v}");
                    if right.is_empty() {
                        is_covered(&points, v, builder.cover());
                        hidden += 1;
                    }
                    became_hidden += usize::from(check_extension(&points, v, &right, &mut extending));
                }
            }
        }
    }
    assert!(hidden > 1_000 && became_hidden > 500, "{hidden} hidden, {became_hidden} of them late");
}

#[test]
fn stars_with_weights_in_the_plane() {
    stars_are_those_of_the_triangulation::<DVec2>(100);
}

#[test]
fn stars_with_weights_in_space() {
    stars_are_those_of_the_triangulation::<DVec3>(80);
}
