//! Improved meshes: the least angle, conformity, and independence of the executor.

use glam::DVec3;

use super::{add_box, cube, meshed};
use crate::conformity::check;
use crate::domain::Domain;
use crate::executor::{Executor, Sequential};
use crate::improve::{Target, improve};
use crate::input::{DomainKind, Input};
use crate::mesh::Mesh;
use crate::quality::angles::angles;
use crate::tests::shapes::{facet, segment};

/// Computes the items in descending order.
struct Backwards;

impl Executor for Backwards {
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        let mut made: Vec<U> = items.iter().rev().map(f).collect();
        made.reverse();
        made
    }
}

fn least(mesh: &Mesh<DVec3>) -> f64 {
    let of = |c: u32| angles(&mesh.corners(c)).into_iter().fold(180.0, f64::min);
    (0..mesh.cells.len() as u32).map(of).fold(180.0, f64::min)
}

fn improved(input: &Input<DVec3>, size: Option<f64>, due: f64) -> (Domain<DVec3>, Mesh<DVec3>) {
    let (domain, made) = meshed(input, 0.5, size);
    let before = made.into_mesh(&domain);
    let [mut mesh, mut other] = [before.clone(), before.clone()];
    let done = improve(&domain, &mut mesh, &Target::default(), &Sequential);
    improve(&domain, &mut other, &Target::default(), &Backwards);
    assert!(mesh == other, "the executor changes the mesh");
    assert!(done.changes() > 0, "{done:?}");
    let found = check(&domain, &mesh);
    assert!(found.is_clean(), "{:?}", found.defects);
    assert!(least(&mesh) >= due.max(least(&before)), "{} to {}: {done:?}", least(&before), least(&mesh));
    (domain, mesh)
}

#[test]
fn boxes_reach_the_target() {
    for size in [None, Some(0.8)] {
        improved(&cube(), size, 15.99);
    }
}

/// Two components, a facet that hangs inside, and a segment in the volume.
#[test]
fn inner_facets_and_segments_remain() {
    let mut input = Input::new(DomainKind::Complex, Vec::new());
    add_box(&mut input, DVec3::ZERO, DVec3::splat(4.0));
    add_box(&mut input, DVec3::splat(1.0), DVec3::new(2.0, 2.0, 2.5));
    let base = input.points.len() as u32;
    let corners = [[2.8, 0.9, 0.7], [3.5, 0.9, 0.7], [3.5, 2.9, 0.7], [2.8, 2.9, 0.7]];
    input.points.extend(corners.map(DVec3::from));
    facet(&mut input, &[&[base, base + 1, base + 2, base + 3]]);
    input.points.extend([DVec3::new(0.6, 3.0, 3.1), DVec3::new(3.2, 3.1, 3.3)]);
    segment(&mut input, [base + 4, base + 5]);
    improved(&input, None, 12.0);
}

/// Acute edges: the improvement cannot reach the target, but it ends, and no angle decreases.
#[test]
fn a_wedge_ends() {
    let mut input = Input::new(DomainKind::Complex, Vec::new());
    let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 0.5]];
    for z in [0.0, 2.0] {
        input.points.extend(points.map(|[x, y]| DVec3::new(x, y, z)));
    }
    facet(&mut input, &[&[0, 1, 2]]);
    facet(&mut input, &[&[3, 4, 5]]);
    for [a, b] in [[0, 1], [1, 2], [2, 0]] {
        facet(&mut input, &[&[a, b, b + 3, a + 3]]);
    }
    let (domain, mesh) = improved(&input, None, 0.0);
    assert!(!mesh.cells.is_empty() && !domain.small_angles(8.0).is_empty());
}

#[test]
fn a_fixed_boundary_keeps_its_faces() {
    let (domain, made) = meshed(&cube(), 0.5, Some(1.0));
    let mut mesh = made.into_mesh(&domain);
    let target = Target { fixed: true, ..Target::default() };
    let faces: Vec<[u32; 3]> = mesh.faces.iter().map(|f| f.vertices).collect();
    improve(&domain, &mut mesh, &target, &Sequential);
    assert_eq!(mesh.faces.iter().map(|f| f.vertices).collect::<Vec<_>>(), faces);
    assert!(check(&domain, &mesh).is_clean());
}

/// The tip of a cone: twelve triangles meet there at angles of few degrees, and the searches of the improvement are
/// limited.
#[test]
fn a_tip_ends() {
    let mut input = Input::new(DomainKind::Complex, Vec::new());
    let turn = std::f64::consts::TAU / 12.0;
    input.points.extend((0..12).map(|i| glam::DVec2::from_angle(f64::from(i) * turn).extend(0.0)));
    input.points.extend([DVec3::new(0.0, 0.0, 12.0), DVec3::ZERO]);
    for [a, b] in (0..12).map(|i| [i, (i + 1) % 12]) {
        facet(&mut input, &[&[a, b, 12]]);
        facet(&mut input, &[&[b, a, 13]]);
    }
    let (domain, _) = improved(&input, None, 0.0);
    assert!(!domain.small_angles(4.0).is_empty());
}
