//! The check of meshes accepts valid meshes and finds each planted defect.

use glam::{DVec2, DVec3};
use septet_geometry::predicates::Sign;

use super::meshes::{canonical, kuhn, mesh_of, squares};
use super::shapes::{add_box, cube, facet, join, segment};
use crate::conformity::{MeshDefect, check};
use crate::domain::{Domain, Feature};
use crate::input::{DomainKind, Input, InputSegment, Region};
use crate::mesh::{Carrier, Mesh, OUTSIDE, point_markers, region_names};
use crate::space::Space;

fn domain<P: crate::facet::Triangulate>(input: &Input<P>) -> Domain<P> {
    crate::check(input).unwrap_or_else(|d| panic!("{d:#?}"))
}

fn clean<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) {
    let found = check(domain, mesh);
    assert_eq!(found.defects, []);
}

/// The cube of side 4 with a facet at half height, a dangling facet, a dangling segment and two regions.
fn divided() -> Input<DVec3> {
    let mut input = cube();
    input.points.extend([[0., 0., 2.], [4., 0., 2.], [4., 4., 2.], [0., 4., 2.]].map(DVec3::from));
    facet(&mut input, &[&[8, 9, 10, 11]]);
    input
        .points
        .extend([[1., 1., 3.], [2., 1., 3.], [2., 2., 3.], [3., 3., 2.], [3., 3., 1.]].map(DVec3::from));
    facet(&mut input, &[&[12, 13, 14]]);
    segment(&mut input, [15, 16]);
    let region = |z, attribute| Region { at: DVec3::new(3.5, 1.5, z), attribute, limit: None };
    input.regions.extend([region(1.5, 7.0), region(3.5, 3.0)]);
    for (i, facet) in input.facets.iter_mut().enumerate() {
        facet.marker = 10 + i as i64;
    }
    input
}

fn divided_mesh() -> (Domain<DVec3>, Mesh<DVec3>) {
    let domain = domain(&divided());
    let (points, cells) = kuhn(4);
    let mesh = mesh_of(&domain, &points, cells);
    (domain, mesh)
}

/// A square of side 4 with a square hole and a segment between.
fn holed() -> Input<DVec2> {
    let square = |low: f64, high: f64| [[low, low], [high, low], [high, high], [low, high]].map(DVec2::from);
    let mut input = Input::new(DomainKind::Complex, [square(0.0, 4.0), square(1.0, 2.0)].concat());
    for base in [0, 4] {
        for i in 0..4 {
            input.segments.push(InputSegment { ends: [base + i, base + (i + 1) % 4], marker: 7 });
        }
    }
    input.segments.push(InputSegment { ends: [6, 2], marker: 8 });
    input.holes.push(DVec2::splat(1.5));
    input
}

#[test]
fn lattices_conform() {
    let (points, cells) = kuhn(4);
    let plain = domain(&cube());
    let mesh = mesh_of(&plain, &points, cells.clone());
    clean(&plain, &mesh);
    assert_eq!(mesh.faces.len(), 6 * 32);
    assert_eq!(mesh.edges.len(), 12 * 4);
    let found = check(&plain, &mesh);
    assert_eq!((found.measure, found.boundary), ([64.0; 2], [96.0; 2]));

    let (divided, mesh) = divided_mesh();
    clean(&divided, &mesh);
    assert_eq!(mesh.faces.len(), 6 * 32 + 32 + 1);
    assert_eq!(check(&divided, &mesh).boundary, [96.0; 2]);

    let mut hollow = cube();
    add_box(&mut hollow, DVec3::splat(1.0), DVec3::splat(3.0));
    hollow.holes.push(DVec3::splat(2.0));
    let hollow = domain(&hollow);
    let mesh = mesh_of(&hollow, &points, cells.clone());
    clean(&hollow, &mesh);
    assert_eq!(check(&hollow, &mesh).boundary, [96.0 + 24.0; 2]);

    let surface = super::shapes::cube_surface();
    let nested = domain(&join(&surface, &surface, DVec3::splat(1.0), 0.5));
    let mesh = mesh_of(&nested, &points, cells);
    clean(&nested, &mesh);
    assert_eq!(check(&nested, &mesh).measure, [56.0; 2]);
}

#[test]
fn five_tetrahedra_and_the_plane() {
    let plain = domain(&cube());
    let points: Vec<DVec3> = plain.points().to_vec();
    let cells = vec![[0, 1, 2, 4], [3, 1, 2, 7], [5, 1, 4, 7], [6, 2, 4, 7], [1, 2, 4, 7]];
    let mesh = mesh_of(&plain, &points, canonical(&points, cells));
    clean(&plain, &mesh);
    assert_eq!(mesh.edges.len(), 12);

    let holed = domain(&holed());
    let (points, cells) = squares(4);
    let mesh = mesh_of(&holed, &points, cells);
    clean(&holed, &mesh);
    assert_eq!(mesh.faces.len(), 16 + 4 + 2);
    assert_eq!(check(&holed, &mesh).measure, [15.0; 2]);
    assert_eq!(check(&holed, &mesh).boundary, [20.0; 2]);
    assert_eq!(point_markers(&holed, &mesh).iter().filter(|&&m| m == 8).count(), 2);
}

#[test]
fn names_of_regions_and_markers_of_points() {
    let (divided, mesh) = divided_mesh();
    assert_eq!(region_names(&divided)[0], 0.0);
    let mut names = region_names(&divided);
    names.sort_by(f64::total_cmp);
    assert_eq!(names, [0.0, 3.0, 7.0]);
    let mut plain = divided.clone();
    plain.regions.clear();
    plain.components.iter_mut().for_each(|c| c.region = None);
    assert_eq!(region_names(&plain), [0.0, 1.0, 2.0]);
    let markers = point_markers(&divided, &mesh);
    let at = |p: DVec3| markers[mesh.points.iter().position(|&q| q == p).unwrap()];
    assert_eq!(at(DVec3::new(1.0, 1.0, 0.0)), 10);
    assert_eq!(at(DVec3::new(1.0, 1.0, 2.0)), 16);
    assert_eq!(at(DVec3::splat(1.0)), 0);
    assert!(at(DVec3::ZERO) >= 10);
}

/// Modifies a mesh and expects a defect.
fn spoilt<P: Space>(
    domain: &Domain<P>,
    mesh: &Mesh<P>,
    spoil: impl FnOnce(&mut Mesh<P>),
    expected: impl Fn(&MeshDefect) -> bool,
) -> Vec<MeshDefect> {
    let mut mesh = mesh.clone();
    spoil(&mut mesh);
    let found = check(domain, &mesh).defects;
    assert!(found.iter().any(expected), "{found:#?}");
    assert!(found.iter().all(|d| !d.to_string().is_empty()));
    found
}

#[test]
fn inconsistent_arrays() {
    let (domain, good) = divided_mesh();
    let far = good.points.len() as u32;
    spoilt(
        &domain,
        &good,
        |m| {
            m.sizes.pop();
        },
        |d| matches!(d, MeshDefect::Length { what: "sizes", .. }),
    );
    spoilt(
        &domain,
        &good,
        |m| m.cells[3][1] = far,
        |d| matches!(d, MeshDefect::Index { what: "cell", row: 3, .. }),
    );
    spoilt(
        &domain,
        &good,
        |m| m.cells[3][1] = m.cells[3][0],
        |d| matches!(d, MeshDefect::Repeated { what: "cell", row: 3 }),
    );
    spoilt(&domain, &good, |m| m.faces[2].facet = 99, |d| matches!(d, MeshDefect::Index { row: 2, .. }));
    spoilt(&domain, &good, |m| m.edges[2].segment = 99, |d| matches!(d, MeshDefect::Index { row: 2, .. }));
    spoilt(&domain, &good, |m| m.points[5].x = f64::NAN, |d| matches!(d, MeshDefect::Range(_)));
    spoilt(&domain, &good, |m| m.points[5].x = 1e-300, |d| matches!(d, MeshDefect::Range(_)));
    spoilt(&domain, &good, |m| m.sizes[5] = 0.0, |d| matches!(d, MeshDefect::Size { point: 5, .. }));
    spoilt(&domain, &good, |m| m.regions[5] = 0, |d| matches!(d, MeshDefect::Region { cell: 5, .. }));
    spoilt(
        &domain,
        &good,
        |m| m.carriers[5] = Carrier::Facet(99),
        |d| matches!(d, MeshDefect::Index { what: "carrier", row: 5, .. }),
    );
}

#[test]
fn wrong_cells() {
    let (domain, good) = divided_mesh();
    spoilt(
        &domain,
        &good,
        |m| m.cells[3].swap(2, 3),
        |d| matches!(d, MeshDefect::Orientation { cell: 3, sign: Sign::Negative }),
    );
    spoilt(&domain, &good, |m| m.cells.swap(3, 4), |d| matches!(d, MeshDefect::Order { cell: 4 }));
    // A point in the middle moves into the plane of a facet opposite.
    let middle = good.points.iter().position(|&p| p == DVec3::new(2.0, 2.0, 1.0)).unwrap();
    let found = spoilt(
        &domain,
        &good,
        |m| m.points[middle].x = 3.0,
        |d| matches!(d, MeshDefect::Orientation { sign: Sign::Zero, .. }),
    );
    assert!(found.iter().all(|d| matches!(d, MeshDefect::Orientation { .. })), "{found:#?}");
    // One cell is removed: open facets and a hole in the volume.
    let inner = good.cells.iter().position(|c| c.contains(&(middle as u32))).unwrap();
    let found = spoilt(
        &domain,
        &good,
        |m| {
            m.cells.remove(inner);
            m.regions.remove(inner);
            for cell in m.faces.iter_mut().flat_map(|f| &mut f.cells).filter(|c| **c != OUTSIDE) {
                *cell -= u32::from(*cell > inner as u32);
            }
        },
        |d| matches!(d, MeshDefect::Open { .. }),
    );
    assert!(found.iter().any(|d| matches!(d, MeshDefect::Volume { .. })));
    // One cell is duplicated.
    let found = spoilt(
        &domain,
        &good,
        |m| {
            m.cells.insert(inner, m.cells[inner]);
            m.regions.insert(inner, m.regions[inner]);
        },
        |d| matches!(d, MeshDefect::Crowded { count: 3, .. }),
    );
    assert!(found.iter().any(|d| matches!(d, MeshDefect::Volume { .. })));
    assert!(found.iter().any(|d| matches!(d, MeshDefect::Order { .. })));
    let other = good.regions.iter().copied().find(|&r| r != good.regions[inner]).unwrap();
    let found =
        spoilt(&domain, &good, |m| m.regions[inner] = other, |d| matches!(d, MeshDefect::Unmarked { .. }));
    assert_eq!(found.iter().filter(|d| matches!(d, MeshDefect::Volume { .. })).count(), 2);
}

#[test]
fn two_cells_on_one_side() {
    // Two triangles that overlap, on the same side of their common edge.
    let mut input = Input::new(DomainKind::Complex, [[0., 0.], [4., 0.], [0., 4.]].map(DVec2::from).to_vec());
    input.segments.extend([[0, 1], [1, 2], [2, 0]].map(|ends| InputSegment { ends, marker: 0 }));
    let domain = domain(&input);
    let points = [[0., 0.], [4., 0.], [0., 4.], [1., 1.]].map(DVec2::from);
    let mesh = mesh_of(&domain, &points, vec![[0, 1, 2], [0, 1, 3]]);
    let found = check(&domain, &mesh).defects;
    assert!(found.iter().any(|d| matches!(d, MeshDefect::SameSide { .. })), "{found:#?}");
}

#[test]
fn wrong_faces() {
    let (domain, good) = divided_mesh();
    let inner = good.faces.iter().position(|f| f.cells[1] != OUTSIDE).unwrap();
    let outer = good.faces.iter().position(|f| f.cells[1] == OUTSIDE).unwrap();
    let facet = good.faces[outer].facet;
    let found = spoilt(
        &domain,
        &good,
        |m| {
            m.faces.remove(outer);
        },
        |d| matches!(d, MeshDefect::Open { .. }),
    );
    let of_facet = |d: &&MeshDefect| d.feature() == Some(Feature::Facet(facet));
    assert!(found.iter().filter(of_facet).any(|d| matches!(d, MeshDefect::Area { .. })));
    assert!(found.iter().filter(of_facet).any(|d| matches!(d, MeshDefect::FacetEdge { .. })));
    spoilt(&domain, &good, |m| m.faces.push(m.faces[outer]), |d| matches!(d, MeshDefect::Twice { .. }));
    spoilt(
        &domain,
        &good,
        |m| m.faces[inner].cells[1] = OUTSIDE,
        |d| matches!(d, MeshDefect::FaceCells { face, .. } if *face == inner as u32),
    );
    spoilt(&domain, &good, |m| m.faces[outer].marker += 1, |d| matches!(d, MeshDefect::Marker { .. }));
    // A face is assigned to another facet.
    let other = good.faces.iter().map(|f| f.facet).find(|&f| f != facet).unwrap();
    let found =
        spoilt(&domain, &good, |m| m.faces[outer].facet = other, |d| matches!(d, MeshDefect::Carried { .. }));
    assert!(found.iter().any(|d| matches!(d, MeshDefect::Area { .. })));
    // The dangling facet: one face, between cells of one component.
    let dangling = good.faces.iter().position(|f| f.marker == 17).unwrap();
    let found = spoilt(
        &domain,
        &good,
        |m| {
            m.faces.remove(dangling);
        },
        |d| matches!(d, MeshDefect::Area { found, .. } if *found == 0.0),
    );
    assert!(found.iter().any(|d| matches!(d, MeshDefect::FacetEdge { sides: [0, 0], required: 1, .. })));
    // A face without cells.
    let hollow = good.faces[outer].vertices[0];
    let far = (0..good.points.len() as u32).max_by(|&a, &b| {
        let to = |v: u32| (good.points[v as usize] - good.points[hollow as usize]).length();
        to(a).total_cmp(&to(b))
    });
    spoilt(
        &domain,
        &good,
        |m| m.faces[outer].vertices[1] = far.unwrap(),
        |d| matches!(d, MeshDefect::FaceCells { found, .. } if found.is_empty()),
    );
}

#[test]
fn wrong_edges() {
    let (domain, good) = divided_mesh();
    let segment = good.edges[5].segment;
    spoilt(
        &domain,
        &good,
        |m| {
            m.edges.remove(5);
        },
        |d| matches!(d, MeshDefect::Chain { segment: s, at: Some(_) } if *s == segment),
    );
    spoilt(
        &domain,
        &good,
        |m| m.edges.retain(|e| e.segment != segment),
        |d| matches!(d, MeshDefect::Chain { segment: s, at: None } if *s == segment),
    );
    spoilt(
        &domain,
        &good,
        |m| m.edges.push(m.edges[5]),
        |d| matches!(d, MeshDefect::Twice { what: "edge", .. }),
    );
    spoilt(
        &domain,
        &good,
        |m| m.edges[5].marker = 3,
        |d| matches!(d, MeshDefect::Marker { what: "edge", .. }),
    );
    let far = good.points.iter().position(|&p| p == DVec3::splat(3.0)).unwrap() as u32;
    let found =
        spoilt(&domain, &good, |m| m.edges[5].vertices[0] = far, |d| matches!(d, MeshDefect::Carried { .. }));
    assert!(found.iter().any(|d| matches!(d, MeshDefect::LooseEdge { edge: 5 })));
}

#[test]
fn wrong_carriers() {
    let (domain, good) = divided_mesh();
    let segment = good.edges[5].segment;
    let at = |p: [f64; 3]| good.points.iter().position(|&q| q == DVec3::from(p)).unwrap();
    // A point of an edge, a point of a facet and a corner are moved off their carriers.
    for (p, limit) in [([1.0, 0.0, 0.0], 1e-9), ([1.0, 1.0, 0.0], 1e-9), ([4.0; 3], 1e-15)] {
        let moved = at(p);
        let shift = DVec3::new(0.0, -limit, -limit);
        spoilt(
            &domain,
            &good,
            |m| m.points[moved] += shift,
            |d| matches!(d, MeshDefect::OffCarrier { point, .. } if *point == moved as u32),
        );
    }
    // Displacements within the rounding are accepted.
    let mut mesh = good.clone();
    mesh.points[at([1.0, 1.0, 0.0])].z = 1e-15;
    clean(&domain, &mesh);
    let on_facet = at([1.0, 1.0, 0.0]);
    spoilt(
        &domain,
        &good,
        |m| m.carriers[on_facet] = Carrier::Volume,
        |d| matches!(d, MeshDefect::Carried { carrier: Carrier::Volume, .. }),
    );
    let inside = at([1.0, 1.0, 1.0]);
    let face = good.faces[0].facet;
    spoilt(
        &domain,
        &good,
        |m| m.carriers[inside] = Carrier::Facet(face),
        |d| matches!(d, MeshDefect::Unused { what: "face", .. }),
    );
    let corner = at([0.0; 3]);
    spoilt(
        &domain,
        &good,
        |m| m.carriers[corner] = Carrier::Segment(segment),
        |d| matches!(d, MeshDefect::Corner { count: 0, .. }),
    );
    spoilt(
        &domain,
        &good,
        |m| {
            m.points.push(DVec3::splat(0.5));
            m.sizes.push(1.0);
            m.carriers.push(Carrier::Volume);
        },
        |d| matches!(d, MeshDefect::Unused { what: "cell", .. }),
    );
}

#[test]
fn the_plane_is_checked_in_the_same_way() {
    let domain = domain(&holed());
    let (points, cells) = squares(4);
    let good = mesh_of(&domain, &points, cells);
    let outer = good.faces.iter().position(|f| f.cells[1] == OUTSIDE).unwrap();
    let segment = good.faces[outer].facet;
    let found = spoilt(
        &domain,
        &good,
        |m| {
            m.faces.remove(outer);
        },
        |d| matches!(d, MeshDefect::Open { .. }),
    );
    let of = |d: &&MeshDefect| d.feature() == Some(Feature::Segment(segment));
    assert!(found.iter().filter(of).any(|d| matches!(d, MeshDefect::Chain { .. })));
    assert!(found.iter().filter(of).any(|d| matches!(d, MeshDefect::Area { .. })));
    let dangling = good.faces.iter().position(|f| f.marker == 8).unwrap();
    spoilt(
        &domain,
        &good,
        |m| {
            m.faces.remove(dangling);
        },
        |d| matches!(d, MeshDefect::Chain { .. }),
    );
    spoilt(
        &domain,
        &good,
        |m| m.cells[3].swap(1, 2),
        |d| matches!(d, MeshDefect::Orientation { cell: 3, .. }),
    );
}
