//! The check that the arrays of a mesh are consistent.

use septet_geometry::point::Simplex;

use super::defect::MeshDefect;
use crate::domain::Domain;
use crate::mesh::{Carrier, Mesh, OUTSIDE};
use crate::space::Space;

/// Returns the defects that make all other checks meaningless.
pub(super) fn shape<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) -> Vec<MeshDefect> {
    let mut found = Vec::new();
    let (points, cells) = (mesh.points.len(), mesh.cells.len());
    let lengths = [
        ("sizes", points, mesh.sizes.len()),
        ("carriers", points, mesh.carriers.len()),
        ("regions", cells, mesh.regions.len()),
    ];
    for (what, expected, length) in lengths {
        if expected != length {
            found.push(MeshDefect::Length { what, expected, found: length });
        }
    }
    for (row, p) in mesh.points.iter().enumerate() {
        if !(0..P::DIM).all(|i| p.coord(i).is_finite()) {
            found.push(MeshDefect::Range(format!("point {row} is not finite")));
        }
    }
    for (point, &size) in mesh.sizes.iter().enumerate() {
        if !(size > 0.0 && size.is_finite()) {
            found.push(MeshDefect::Size { point: point as u32, size });
        }
    }
    let mut rows = Rows { points: points as u32, found };
    let facets = if P::DIM == 2 { domain.segments.len() } else { domain.facets.len() };
    for (row, cell) in mesh.cells.iter().enumerate() {
        rows.simplex("cell", row, cell);
    }
    for (row, face) in mesh.faces.iter().enumerate() {
        rows.simplex("face", row, &face.vertices);
        rows.index("face", row, face.facet, facets);
        face.cells.iter().filter(|&&c| c != OUTSIDE).for_each(|&c| rows.index("face", row, c, cells));
    }
    for (row, edge) in mesh.edges.iter().enumerate() {
        rows.simplex("edge", row, &edge.vertices);
        rows.index("edge", row, edge.segment, domain.segments.len());
    }
    for (row, carrier) in mesh.carriers.iter().enumerate() {
        match *carrier {
            Carrier::Corner(c) => rows.index("carrier", row, c, domain.corners.len()),
            Carrier::Segment(s) => rows.index("carrier", row, s, domain.segments.len()),
            Carrier::Facet(f) => rows.index("carrier", row, f, domain.facets.len()),
            Carrier::Volume => {}
        }
    }
    for (cell, &component) in mesh.regions.iter().enumerate() {
        if !domain.components.get(component as usize).is_some_and(|c| c.inside) {
            rows.found.push(MeshDefect::Region { cell: cell as u32, component });
        }
    }
    rows.found
}

struct Rows {
    points: u32,
    found: Vec<MeshDefect>,
}

impl Rows {
    fn index(&mut self, what: &'static str, row: usize, value: u32, count: usize) {
        if value as usize >= count {
            self.found.push(MeshDefect::Index { what, row: row as u32, value });
        }
    }

    fn simplex<S: Simplex>(&mut self, what: &'static str, row: usize, simplex: &S) {
        let vertices = simplex.as_ref();
        for (i, &v) in vertices.iter().enumerate() {
            self.index(what, row, v, self.points as usize);
            if vertices[..i].contains(&v) {
                self.found.push(MeshDefect::Repeated { what, row: row as u32 });
            }
        }
    }
}
