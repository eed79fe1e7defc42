//! Meshes for tests, built by brute force from lattices with exact coordinates.

use glam::{DVec2, DVec3};
use septet_geometry::point::{Point, Simplex};

use crate::domain::{Domain, Feature};
use crate::mesh::{Carrier, Edge, Face, Mesh, OUTSIDE};
use crate::sides::Location;
use crate::space::{Space, ascending, on_segment};

/// A lattice of `k` cubes of side 1 along each axis, six tetrahedra each.
pub fn kuhn(k: u32) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let at = |c: [u32; 3]| c[0] + (k + 1) * (c[1] + (k + 1) * c[2]);
    let all = |n: u32| (0..n * n * n).map(move |i| [i % n, i / n % n, i / (n * n)]);
    let points = all(k + 1).map(|c| DVec3::from(c.map(f64::from))).collect();
    let paths = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut cells = Vec::new();
    for cube in all(k) {
        for path in paths {
            let mut corner = cube;
            let mut cell = [at(corner); 4];
            for (slot, axis) in cell[1..].iter_mut().zip(path) {
                corner[axis] += 1;
                *slot = at(corner);
            }
            cells.push(cell);
        }
    }
    (points, cells)
}

/// A lattice of `k` by `k` squares of two triangles each.
pub fn squares(k: u32) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let at = |x: u32, y: u32| x + (k + 1) * y;
    let n = k + 1;
    let points = (0..n * n).map(|i| DVec2::new(f64::from(i % n), f64::from(i / n))).collect();
    let pair = |i: u32| {
        let (x, y) = (i % k, i / k);
        let (a, b) = (at(x, y), at(x + 1, y + 1));
        [[a, at(x + 1, y), b], [a, b, at(x, y + 1)]]
    };
    (points, (0..k * k).flat_map(pair).collect())
}

/// Sorts cells and their rows into canonical order.
pub fn canonical<P: Point>(points: &[P], cells: Vec<P::Cell>) -> Vec<P::Cell> {
    let mut cells = cells;
    for cell in &mut cells {
        let row = cell.as_mut();
        row.sort_unstable();
        let corners: Vec<P> = row.iter().map(|&v| points[v as usize]).collect();
        if crate::quality::angles::measure(&corners) < 0.0 {
            row.swap(P::DIM - 1, P::DIM);
        }
    }
    cells.sort_unstable();
    cells
}

/// Returns `true` if the feature contains the point. Exact.
fn holds<P: Space>(domain: &Domain<P>, feature: Feature, p: P) -> bool {
    let at = |v: u32| domain.points()[v as usize];
    match feature {
        Feature::Corner(c) => at(domain.corners[c as usize]) == p,
        Feature::Segment(s) => {
            let [a, b] = domain.segments[s as usize].ends().map(at);
            on_segment(a, b, p)
        }
        Feature::Facet(f) => {
            let wall = |&w: &u32| P::corners(domain.points(), &domain.walls()[w as usize]);
            domain.facets[f as usize].walls.iter().any(|w| P::on_wall(&wall(w), p))
        }
    }
}

/// The mean of points.
fn mean<P: Point>(points: &[P], of: &[u32]) -> P {
    of.iter().fold(P::splat(0.0), |sum, &v| sum + points[v as usize] / of.len() as f64)
}

/// Returns the mesh of the cells whose means lie in the domain. The size is 1 everywhere. The domain must not be
/// scaled.
pub fn mesh_of<P: Space>(domain: &Domain<P>, points: &[P], cells: Vec<P::Cell>) -> Mesh<P> {
    assert_eq!(domain.simplices.frame.exponent, 0);
    let component = |cell: &P::Cell| match domain.sides.locate(domain.points(), mean(points, cell.as_ref())) {
        Some(Location::Component(c)) => c,
        other => panic!("{other:?}"),
    };
    let mut cells = canonical(points, cells);
    cells.retain(|cell| domain.components[component(cell) as usize].inside);
    let mut used: Vec<u32> = cells.iter().flat_map(|c| c.as_ref().to_vec()).collect();
    used.sort_unstable();
    used.dedup();
    for v in cells.iter_mut().flat_map(AsMut::as_mut) {
        *v = used.binary_search(v).unwrap() as u32;
    }
    let points: Vec<P> = used.iter().map(|&v| points[v as usize]).collect();
    let carrier =
        |&p: &P| domain.features().find(|&f| holds(domain, f, p)).map_or(Carrier::Volume, Carrier::from);
    let mut mesh = Mesh {
        sizes: vec![1.0; points.len()],
        carriers: points.iter().map(carrier).collect(),
        regions: Vec::new(),
        points,
        ..Mesh::default()
    };
    let component =
        |cell: &P::Cell| match domain.sides.locate(domain.points(), mean(&mesh.points, cell.as_ref())) {
            Some(Location::Component(c)) => c,
            other => panic!("{other:?}"),
        };
    mesh.regions = cells.iter().map(component).collect();
    mesh.cells = cells;
    mesh.faces = faces(domain, &mesh);
    mesh.edges = if P::DIM == 3 { edges(domain, &mesh) } else { Vec::new() };
    mesh
}

fn faces<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) -> Vec<Face<P>> {
    let mut of = std::collections::BTreeMap::<P::Facet, Vec<u32>>::new();
    for (row, cell) in mesh.cells.iter().enumerate() {
        for skipped in cell.as_ref() {
            let mut facet = P::Facet::splat(0);
            let rest = cell.as_ref().iter().filter(|v| *v != skipped);
            facet.as_mut().iter_mut().zip(rest).for_each(|(slot, &v)| *slot = v);
            facet.as_mut().sort_unstable();
            of.entry(facet).or_default().push(row as u32);
        }
    }
    let own = |f: &Feature| matches!((P::DIM, f), (2, Feature::Segment(_)) | (3, Feature::Facet(_)));
    let mut found = Vec::new();
    for (vertices, cells) in of {
        let middle = mean(&mesh.points, vertices.as_ref());
        let all = |&f: &Feature| {
            holds(domain, f, middle)
                && vertices.as_ref().iter().all(|&v| holds(domain, f, mesh.points[v as usize]))
        };
        let Some(feature) = domain.features().filter(own).find(all) else { continue };
        let (facet, marker) = match feature {
            Feature::Segment(s) => (s, domain.segments[s as usize].marker),
            Feature::Facet(f) => (f, domain.facets[f as usize].marker),
            Feature::Corner(_) => unreachable!(),
        };
        let cells = [cells[0], cells.get(1).copied().unwrap_or(OUTSIDE)];
        found.push(Face { vertices, facet, marker, cells });
    }
    found
}

fn edges<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) -> Vec<Edge> {
    let mut found = Vec::new();
    for vertices in mesh.cell_edges() {
        let [p, q] = vertices.map(|v| mesh.points[v as usize]);
        let on = |s: &usize| [p, q].iter().all(|&p| holds(domain, Feature::Segment(*s as u32), p));
        if let Some(segment) = (0..domain.segments.len()).find(on) {
            let marker = domain.segments[segment].marker;
            found.push(Edge { vertices: ascending(vertices), segment: segment as u32, marker });
        }
    }
    found
}
