//! Domains in map coordinates.

use glam::{DMat3, DVec3};

use super::{is_sound, meshed};
use crate::distance::Features;
use crate::generate::{Coarse, Missing, Reason};
use crate::input::{DomainKind, Input};
use crate::tests::shapes::{add_box, facet};

fn boxed(at: DVec3, sides: DVec3) -> Input<DVec3> {
    let mut input = Input::new(DomainKind::Complex, Vec::new());
    add_box(&mut input, at, at + sides);
    input
}

#[test]
fn a_cube_is_as_easy_far_from_the_origin() {
    for offset in [0.0, 2e5, 4e5, 1e6, 1e7, 1e9, -1e9] {
        let (domain, made) = meshed(&boxed(DVec3::splat(offset), DVec3::ONE), 0.5, None);
        is_sound(&domain, &made);
        assert!(made.vertices.len() < 100, "{offset}: {}", made.vertices.len());
        assert_eq!(domain.simplices.frame.is_translated(), offset != 0.0);
        // The numbers that are written are the vertices of the triangulation.
        let frame = &domain.simplices.frame;
        let mesh = made.clone().into_mesh(&domain);
        let back: Vec<DVec3> = mesh.points.iter().map(|&p| frame.inward(p)).collect();
        assert_eq!(back, made.vertices.points);
    }
}

#[test]
fn slanted_boxes_in_map_coordinates() {
    let turn = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(0.7);
    for at in [DVec3::new(447_000.0, 5_411_000.0, 100.0), DVec3::new(-4e6, 3e5, 4.9e6)] {
        let mut input = boxed(DVec3::ZERO, DVec3::new(10.0, 10.0, 5.0));
        // Triangles are planar wherever their corners are rounded to.
        let squares: Vec<Vec<u32>> = input.facets.iter().map(|f| f.polygons[0].clone()).collect();
        input.facets.clear();
        for square in squares {
            facet(&mut input, &[&[square[0], square[1], square[2]]]);
            facet(&mut input, &[&[square[0], square[2], square[3]]]);
        }
        input.points.iter_mut().for_each(|p| *p = turn * *p + at);
        let (domain, made) = meshed(&input, 0.5, None);
        is_sound(&domain, &made);
        assert!(made.vertices.len() < 400, "{at}: {}", made.vertices.len());
    }
}

#[test]
fn grids_too_coarse_for_the_features_are_refused() {
    // Doubles near 1e9 are 1.2e-7 apart, and the plate is 8 of these steps thick.
    let input = boxed(DVec3::splat(1e9), DVec3::new(1.0, 1.0, 8.0 * 2f64.powi(-23)));
    let coarse = |input: &Input<DVec3>| {
        let domain = crate::check(input).unwrap();
        Coarse::of(&domain, &Features::new(&domain))
    };
    let Coarse { size, step, .. } = coarse(&input).unwrap();
    assert!(step == 2f64.powi(-23) && size <= 8.0 * step, "{size} {step}");
    assert_eq!(coarse(&boxed(DVec3::splat(1e9), DVec3::ONE)), None);
}

#[test]
fn small_angles_are_blamed_only_where_they_are() {
    let reason = |degrees: f64| {
        let domain = crate::check(&wedge(degrees)).unwrap();
        let all: Vec<_> = domain.features().map(|f| (f, 1)).collect();
        [true, false].map(|is_rounded| Missing::of(&domain, all.clone(), is_rounded).reason)
    };
    assert_eq!(reason(1.0), [Reason::Rounding, Reason::Angles]);
    let boxed = crate::check(&boxed(DVec3::ZERO, DVec3::ONE)).unwrap();
    let all = boxed.features().map(|f| (f, 1)).collect();
    assert_eq!(Missing::of(&boxed, all, false).reason, Reason::Rounds);
}

/// A wedge with an angle.
fn wedge(degrees: f64) -> Input<DVec3> {
    let (x, y) = (degrees.to_radians().cos(), degrees.to_radians().sin());
    let mut input = Input::new(DomainKind::Complex, Vec::new());
    for z in [0.0, 1.0] {
        input.points.extend([[0., 0., z], [1., 0., z], [x, y, z]].map(DVec3::from));
    }
    for f in [&[0, 1, 2][..], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]] {
        facet(&mut input, &[f]);
    }
    input
}
