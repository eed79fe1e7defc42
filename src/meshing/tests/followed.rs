//! Remeshed boundaries that follow a surface, and boundaries that do not.

use glam::DVec3;

use super::meshes::{kuhn, mesh_of};
use super::shapes::cube_surface;
use crate::conformity::{Conformity, Follow, MeshDefect, check_remeshed};
use crate::domain::Domain;
use crate::mesh::{Carrier, Face, Mesh, OUTSIDE};
use crate::space::ascending;

fn lattice() -> (Domain<DVec3>, Mesh<DVec3>) {
    let domain = crate::check(&cube_surface()).unwrap();
    let (points, cells) = kuhn(4);
    let mesh = mesh_of(&domain, &points, cells);
    (domain, mesh)
}

fn checked(domain: &Domain<DVec3>, mesh: &Mesh<DVec3>, distance: Option<f64>) -> Conformity {
    check_remeshed(domain, mesh, &Follow { feature_angle: 60.0, distance })
}

/// Modifies the lattice and expects a defect.
fn spoilt(spoil: impl FnOnce(&mut Mesh<DVec3>), expected: impl Fn(&MeshDefect) -> bool) {
    let (domain, mut mesh) = lattice();
    spoil(&mut mesh);
    let found = checked(&domain, &mesh, None);
    assert!(found.defects.iter().any(expected), "{:?}", found.defects);
}

/// The faces with only one cell, all assigned to one facet.
fn bare(mesh: &mut Mesh<DVec3>) {
    let mut sides: Vec<([u32; 3], u32)> = Vec::new();
    for (i, &[a, b, c, d]) in (0u32..).zip(&mesh.cells) {
        for mut side in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            side.sort_unstable();
            sides.push((side, i));
        }
    }
    sides.sort_unstable();
    let alone = sides.chunk_by(|s, t| s.0 == t.0).filter(|group| group.len() == 1);
    let face = |group: &[([u32; 3], u32)]| Face {
        vertices: group[0].0,
        facet: 0,
        marker: 0,
        cells: [group[0].1, OUTSIDE],
    };
    mesh.faces = alone.map(face).collect();
}

fn drop_face(mesh: &mut Mesh<DVec3>) {
    mesh.faces.remove(3);
}

fn drop_edge(mesh: &mut Mesh<DVec3>) {
    mesh.edges.remove(5);
}

#[test]
fn a_lattice_follows_its_cube() {
    let (domain, mesh) = lattice();
    let found = checked(&domain, &mesh, Some(1e-9));
    assert!(found.is_clean(), "{found:?}");
    assert_eq!((found.measure, found.boundary), ([64.0; 2], [96.0; 2]));
    let deviation = found.deviation.unwrap();
    assert!(deviation.of_boundary < 1e-15 && deviation.of_surface == 0.0, "{deviation:?}");
}

#[test]
fn non_manifold_boundaries() {
    // Two cubes that share only an edge, or only a corner, are removed.
    let at = |mesh: &Mesh<DVec3>, cell: &[u32; 4]| {
        let sum: DVec3 = cell.iter().map(|&v| mesh.points[v as usize]).sum();
        (sum / 4.0).floor()
    };
    for (other, vertices) in [(DVec3::new(2.0, 2.0, 1.0), 2), (DVec3::splat(2.0), 1)] {
        let carve = |mesh: &mut Mesh<DVec3>| {
            let kept: Vec<bool> =
                mesh.cells.iter().map(|c| ![DVec3::ONE, other].contains(&at(mesh, c))).collect();
            let mut of = kept.iter();
            mesh.cells.retain(|_| of.next() == Some(&true));
            mesh.regions.truncate(mesh.cells.len());
            bare(mesh);
        };
        let is_pinched =
            |d: &MeshDefect| matches!(d, MeshDefect::Pinched { vertices: v, .. } if v.len() == vertices);
        spoilt(carve, is_pinched);
    }
    spoilt(drop_face, |d| matches!(d, MeshDefect::Open { .. }));
    spoilt(drop_face, |d| matches!(d, MeshDefect::Pinched { faces: 1, .. }));
    spoilt(|m| m.cells[3].swap(2, 3), |d| matches!(d, MeshDefect::Orientation { .. }));
    spoilt(|m| m.carriers.truncate(3), |d| matches!(d, MeshDefect::Length { .. }));
}

#[test]
fn missing_ridges() {
    spoilt(drop_edge, |d| matches!(d, MeshDefect::Chain { at: Some(_), .. }));
    let all_of_one = |m: &mut Mesh<DVec3>| {
        let segment = m.edges[0].segment;
        m.edges.retain(|e| e.segment != segment);
        for carrier in &mut m.carriers {
            if *carrier == Carrier::Segment(segment) {
                *carrier = Carrier::Facet(0);
            }
        }
    };
    spoilt(all_of_one, |d| matches!(d, MeshDefect::Chain { .. }));
    let astray = |m: &mut Mesh<DVec3>| {
        let mut edge = m.edges[0];
        edge.vertices = [m.edges[0].vertices[0], m.edges[7].vertices[1]];
        m.edges.push(edge);
    };
    spoilt(astray, |d| matches!(d, MeshDefect::LooseEdge { .. }));
    let corner = |m: &mut Mesh<DVec3>| {
        let at = m.carriers.iter().position(|c| matches!(c, Carrier::Corner(_))).unwrap();
        m.carriers[at] = Carrier::Volume;
    };
    spoilt(corner, |d| matches!(d, MeshDefect::Corner { count: 0, .. }));
    spoilt(corner, |d| matches!(d, MeshDefect::Carried { what: "face", .. }));
}

#[test]
fn distant_boundaries() {
    let dented = |depth: f64| {
        move |m: &mut Mesh<DVec3>| {
            let at = m.points.iter().position(|&p| p == DVec3::new(2.0, 2.0, 4.0)).unwrap();
            m.points[at].z -= depth;
        }
    };
    spoilt(dented(0.1), |d| matches!(d, MeshDefect::OffCarrier { .. }));
    let (domain, mut mesh) = lattice();
    dented(0.5)(&mut mesh);
    let size = mesh.sizes.iter().copied().fold(0.0, f64::max);
    let is_astray = |d: &MeshDefect| matches!(d, MeshDefect::Astray { what: "face", .. });
    assert!(checked(&domain, &mesh, Some(0.3)).defects.iter().any(is_astray));
    assert!(!checked(&domain, &mesh, Some(0.6)).defects.iter().any(is_astray), "size {size}");
    let deviation = checked(&domain, &mesh, None).deviation.unwrap();
    assert!(deviation.of_boundary > 0.3 && deviation.of_boundary <= 0.5, "{deviation:?}");
    // A layer of cells is removed, so the surface is far from the rest.
    let (domain, mut mesh) = lattice();
    let low = |mesh: &Mesh<DVec3>, c: &[u32; 4]| c.iter().any(|&v| mesh.points[v as usize].z < 0.5);
    let kept: Vec<bool> = mesh.cells.iter().map(|c| !low(&mesh, c)).collect();
    let mut of = kept.iter();
    mesh.cells.retain(|_| of.next() == Some(&true));
    mesh.regions.truncate(mesh.cells.len());
    bare(&mut mesh);
    let found = checked(&domain, &mesh, Some(0.5));
    assert!(
        found.defects.iter().any(|d| matches!(d, MeshDefect::Astray { what: "vertex", .. })),
        "{found:?}"
    );
    // All cells are removed.
    spoilt(
        |m| {
            m.cells.clear();
            m.regions.clear();
            m.faces.clear();
            m.edges.clear();
        },
        |d| matches!(d, MeshDefect::Volume { .. }),
    );
    let listed = |m: &mut Mesh<DVec3>| {
        let [a, b, c] = m.faces[0].vertices;
        m.edges.retain(|e| ascending(e.vertices) != ascending([a, b]));
        m.faces[0].vertices = [c, a, b];
        m.faces[0].cells = [0, 1];
    };
    spoilt(listed, |d| matches!(d, MeshDefect::Inner { face: 0 }));
}
