//! The cells and faces of the domain in the triangulation of all vertices.
//!
//! **Statement.** The primary faces of the facets form the [`super::barrier`]. Cells that share a face outside the
//! barrier are in one *class*. The outside of the hull counts as an additional cell that is adjacent to all faces of
//! the hull. Each class lies in one component of the domain. Any barrier face adjacent to the class determines this
//! component. A cell is *flat* if one facet, or one group of coplanar facets, contains all its vertices. A flat cell
//! belongs to a class like any other cell but is dropped from the mesh.
//!
//! *Proof.*
//! 1. With the outside as a cell, the cells triangulate a sphere of the dimension of the space.
//! 2. The primary faces of a facet tile it. Two of them share each edge, except for the subsegments of its segments,
//!    which are edges of the triangulation. Up to rounding of the vertices, the barrier is therefore the complex of
//!    those walls that have the domain on at least one side.
//! 3. By Alexander duality, the barrier separates the sphere into as many parts as the walls do. These parts are the
//!    classes: a path through cells that avoids the vertices and edges of the barrier passes through faces.
//! 4. Consider an edge shared by two faces of one facet and by no other barrier face. All cells around it on one side
//!    are in one class. A class adjacent to one face of a facet is therefore adjacent to all faces up to the next
//!    segment. At the segment, the domain determines the component.
//! 5. Two components that no part of the domain separates may form one class. Neither is inside. QED.
//!
//! *Why labels do not depend on any order.* Classes are the connected components of a graph. A class receives the
//! largest label that an adjacent face gives. By the proof, all these labels are equal. The faces give labels by
//! directions along subsegments and by exact signs ([`super::barrier`]). No rounded point affects them. A flat cell
//! across coplanar facets receives the label of its class, regardless of the side on which its centroid lies.
//!
//! **Source.** Alexander duality: Hatcher (2002), section 3.3.
//!
//! **Departures.** If subfacets were missing, classes of several components could merge. The largest label would then
//! apply, so that outside takes precedence over inside, and [`crate::conformity`] would reject the mesh. A face of
//! the mesh next to a dropped cell may be on the other diagonal of its facet. Such a face belongs to the facet that
//! contains its rounded centroid. It has an area, because its cell is not flat.
//!
//! **Work and depth.** `O(n a(n) + m log m)` for n cells and m faces whose vertices lie on facets, where a is the
//! inverse Ackermann function.

use glam::{DVec2, DVec3};
use septet_geometry::incremental::facet_without;
use septet_geometry::point::lex_cmp;

use super::barrier::Barrier;
use super::cell_labels::CellLabels;
use super::facets::{Plane, as_space};
use super::generator::Generator;
use super::machine::{Delaunay, MeshMachine};
use super::vertices::Holders;
use crate::mesh::Carrier;
use crate::sides::Sets;
use crate::space::Space;

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Returns the facet that contains the rounded centroid of a face. The face must have an area. Faces of cells
    /// that are not flat do.
    pub(super) fn facet_of(&self, face: &[u32], planes: &[Plane]) -> Option<u32> {
        let common = self.holders.common(&self.vertices.carriers, face);
        if P::DIM == 2 {
            return common.first().copied();
        }
        if common.is_empty() {
            return None;
        }
        common.into_iter().find(|&f| planes[f as usize].holds(self.middle_of(face, &planes[f as usize])))
    }

    /// Returns the centroid of a face in the plane of a facet. The rounding does not depend on the order of its
    /// vertices.
    pub(super) fn middle_of(&self, face: &[u32], plane: &Plane) -> DVec2 {
        let mut corners: Vec<DVec3> =
            face.iter().map(|&v| as_space(self.vertices.points[v as usize])).collect();
        corners.sort_unstable_by(lex_cmp);
        plane.of(corners.iter().sum::<DVec3>() / face.len() as f64)
    }

    /// Labels all cells.
    pub(super) fn labels(&self, delaunay: &Delaunay<P::Cell>, barrier: &Barrier<P::Facet>) -> CellLabels {
        let n = delaunay.cells.len();
        // The outside of the hull is an additional cell.
        let mut sets = Sets::new(n + 1);
        let mut named = vec![None; n + 1];
        named[n] = Some(CellLabels::OUT);
        for (i, (cell, across)) in (0u32..).zip(delaunay.cells.iter().zip(&delaunay.neighbours)) {
            for (&v, &j) in cell.as_ref().iter().zip(across.as_ref()) {
                let face = facet_without::<P>(cell, v);
                let parts = if self.is_carried(face.as_ref()) { barrier.at(&face) } else { &[] };
                let label = parts.iter().filter_map(|part| part.towards(&face)).max();
                named[i as usize] = named[i as usize].max(label);
                if parts.is_empty() {
                    sets.join(i, j.min(n as u32));
                }
            }
        }
        for i in 0..=n {
            let root = sets.find(i as u32) as usize;
            named[root] = named[root].max(named[i]);
        }
        let label = |(i, cell): (u32, &P::Cell)| {
            if is_flat(&self.flats, &self.vertices.carriers, cell.as_ref()) {
                return CellLabels::FLAT;
            }
            named[sets.find(i) as usize].unwrap_or(CellLabels::OUT)
        };
        CellLabels { of: (0u32..).zip(&delaunay.cells).map(label).collect() }
    }

    /// Returns `true` if no vertex of a face is in the volume.
    fn is_carried(&self, face: &[u32]) -> bool {
        face.iter().all(|&v| self.vertices.carriers[v as usize] != Carrier::Volume)
    }

    /// Returns the faces on facets that are adjacent to a cell of the mesh.
    pub(super) fn faces(
        &self,
        delaunay: &Delaunay<P::Cell>,
        labels: &CellLabels,
        barrier: &Barrier<P::Facet>,
        planes: &[Plane],
    ) -> Vec<(u32, P::Facet, [u32; 2])> {
        let inside = |j: u32| j != u32::MAX && labels.is_inside(j);
        let mut found = Vec::new();
        for (i, (cell, across)) in (0u32..).zip(delaunay.cells.iter().zip(&delaunay.neighbours)) {
            for (&v, &j) in cell.as_ref().iter().zip(across.as_ref()) {
                if !inside(i) || inside(j) && j < i {
                    continue;
                }
                let face = facet_without::<P>(cell, v);
                if !self.is_carried(face.as_ref()) {
                    continue;
                }
                // The face next to a dropped or outside cell may be on the other diagonal.
                let seen = || if inside(j) { None } else { self.facet_of(face.as_ref(), planes) };
                if let Some(f) = barrier.at(&face).first().map(|part| part.facet).or_else(seen) {
                    found.push((f, face, [i, if inside(j) { j } else { u32::MAX }]));
                }
            }
        }
        found.sort_unstable();
        found
    }

    pub(super) fn corners(&self, cell: &P::Cell) -> [P; 4] {
        let mut corners = [P::default(); 4];
        for (corner, &v) in corners.iter_mut().zip(cell.as_ref()) {
            *corner = self.vertices.points[v as usize];
        }
        corners
    }
}

/// Returns `true` if one facet contains all vertices of a cell.
pub(super) fn is_flat(holders: &Holders, carriers: &[Carrier], cell: &[u32]) -> bool {
    !cell.iter().any(|&v| carriers[v as usize] == Carrier::Volume)
        && !holders.common(carriers, cell).is_empty()
}
