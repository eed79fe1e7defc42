//! Converts the result to a mesh in the unit of the file and in canonical order.

use septet_geometry::point::{Point, Simplex};
use septet_geometry::range::scale;

use super::{CellLabels, GeneratedMesh, Subsegment};
use crate::domain::Domain;
use crate::mesh::{Edge, Face, Mesh, OUTSIDE};
use crate::space::Space;

impl<P: Space> GeneratedMesh<P> {
    /// Returns the mesh: the cells inside the domain, their faces on facets, and their edges on segments.
    pub fn into_mesh(self, domain: &Domain<P>) -> Mesh<P> {
        let back = -domain.simplices.frame.exponent;
        let mut rows: Vec<(P::Cell, u32)> = Vec::new();
        for (i, cell) in (0u32..).zip(&self.delaunay.cells).filter(|(i, _)| self.labels.is_inside(*i)) {
            rows.push((canonical::<P>(*cell), i));
        }
        rows.sort_unstable();
        let mut number = vec![OUTSIDE; self.delaunay.cells.len()];
        for (new, (_, old)) in (0u32..).zip(&rows) {
            number[*old as usize] = new;
        }
        let renumbered = |c: u32| if c == u32::MAX { OUTSIDE } else { number[c as usize] };
        let marker = |f: u32| match P::DIM {
            2 => domain.segments[f as usize].marker,
            _ => domain.facets[f as usize].marker,
        };
        let face = |&(facet, mut vertices, cells): &(u32, P::Facet, [u32; 2])| {
            vertices.as_mut().sort_unstable();
            let mut cells = cells.map(renumbered);
            cells.sort_unstable();
            Face { vertices, facet, marker: marker(facet), cells }
        };
        let mut faces: Vec<Face<P>> = self.faces.iter().map(face).collect();
        faces.sort_unstable_by_key(|face| (face.facet, face.vertices));
        let edge = |&(segment, vertices): &Subsegment| Edge {
            vertices,
            segment,
            marker: domain.segments[segment as usize].marker,
        };
        Mesh {
            points: self.vertices.points.iter().map(|&p| domain.simplices.frame.outward(p)).collect(),
            sizes: self.vertices.sizes.iter().map(|&s| scale(P::splat(s), back).coord(0)).collect(),
            regions: rows.iter().map(|(_, old)| self.labels.of[*old as usize]).collect(),
            cells: rows.into_iter().map(|r| r.0).collect(),
            faces,
            edges: if P::DIM == 2 { Vec::new() } else { self.subsegments.iter().map(edge).collect() },
            dropped: self.labels.of.iter().filter(|l| **l == CellLabels::FLAT).count() as u64,
            carriers: self.vertices.carriers,
        }
    }
}

/// Reorders the vertices without changing the orientation. The smallest vertex comes first. In space, the second
/// smallest vertex follows.
pub(crate) fn canonical<P: Point>(mut cell: P::Cell) -> P::Cell {
    let row = cell.as_mut();
    let smallest = |row: &[u32]| (0..row.len()).min_by_key(|&i| row[i]).unwrap_or(0);
    let first = smallest(row);
    if P::DIM == 2 {
        row.rotate_left(first);
        return cell;
    }
    if first != 0 {
        // Two swaps preserve the orientation.
        row.swap(0, first);
        let [a, b] = [1, 2, 3].into_iter().filter(|&i| i != first).fold([0, 0], |[_, b], i| [b, i]);
        row.swap(a, b);
    }
    let second = smallest(&row[1..]);
    row[1..].rotate_left(second);
    debug_assert_eq!(P::Cell::LEN, 4);
    cell
}
