//! The predicates: conventions in this module, signs compared with big integers in its submodules.

mod bounds;
mod count;
mod exact;
mod general;
mod integers;
mod samples;
mod stages;
mod ties;
mod weighted;

use glam::{DVec2, DVec3};

use super::*;

#[test]
fn orientation_follows_the_file_convention() {
    let cell = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    assert_eq!(orientation(&cell), Sign::Positive);
    assert_eq!(orientation(&[DVec2::ZERO, DVec2::X, DVec2::Y]), Sign::Positive);
    assert!(in_sphere(&cell, DVec3::splat(0.4)));
    assert!(!in_sphere(&cell, DVec3::splat(2.0)));
    assert!(in_sphere(&[DVec2::ZERO, DVec2::X, DVec2::Y], DVec2::splat(0.4)));
}

#[test]
fn ties_are_antisymmetric_across_a_facet() {
    // The corners of a square are cocircular. Exactly one diagonal must be Delaunay, seen from either side.
    let (a, b, c, d) = (DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y);
    let first = in_sphere(&[a, b, c], d);
    let second = in_sphere(&[a, c, d], b);
    assert_eq!(first, second);
    assert_ne!(first, in_sphere(&[a, b, d], c));
}

#[test]
fn half_space_form_agrees_with_the_predicates() {
    let rel = [DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.2, 1.1, 0.0), DVec3::new(0.0, 0.3, 0.9)];
    let (w, v) = DVec3::sphere_plane(&rel);
    let cell = [DVec3::ZERO, rel[0], rel[1], rel[2]];
    assert_eq!(orientation(&cell), Sign::Positive);
    for q in [DVec3::splat(0.4), DVec3::splat(1.5), DVec3::new(-0.1, 0.5, 0.2)] {
        assert_eq!(w * q.dot(q) - v.dot(q) < 0.0, in_sphere(&cell, q));
    }
    let n = DVec3::hull_normal(&rel[..2]);
    let q = DVec3::new(0.3, -0.2, 0.7);
    assert_eq!(n.dot(q) > 0.0, orientation(&[DVec3::ZERO, rel[0], rel[1], q]) == Sign::Positive);
    let n2 = DVec2::hull_normal(&[DVec2::new(1.0, 0.5)]);
    assert!(n2.dot(DVec2::Y) > 0.0);
}

#[test]
fn frames_do_not_depend_on_order() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0, DVec3::Y, DVec3::X + DVec3::Y];
    assert_eq!(affine_frame(&points).0, 2);
    assert_eq!(affine_frame(&points[..3]).0, 1);
    assert_eq!(affine_frame::<DVec3>(&[]).0, -1);
}
