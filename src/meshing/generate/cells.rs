//! From a triangulation of the vertices to the cells and faces of the domain.
//!
//! **Statement.** A face whose vertices one facet holds, and whose middle lies in it, is part of the facet. A cell
//! whose vertices are all held by one facet is flat but for rounding, and dropped. Cells that share other faces are in
//! one component of the domain, which is found by where the middle of the largest of them lies.

use glam::{DVec2, DVec3};
use septet_geometry::incremental::facet_without;
use septet_geometry::measure::shortest_edge2;
use septet_geometry::point::Simplex;

use super::facets::{Plane, as_space};
use super::machine::{Machine, Triangulation};
use super::vertices::Holders;
use super::work::Work;
use crate::mesh::Carrier;
use crate::sides::{Location, Sets};
use crate::space::Space;

/// Which component of the domain each cell is in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labels {
    /// The component, [`Labels::OUT`] outside of the domain, [`Labels::FLAT`] for a cell on a facet.
    pub of: Vec<u32>,
}

impl Labels {
    /// Outside.
    pub const OUT: u32 = u32::MAX;
    /// All vertices on one facet.
    pub const FLAT: u32 = u32::MAX - 1;

    /// Is the cell part of the mesh?
    pub fn is_inside(&self, cell: u32) -> bool {
        self.of[cell as usize] < Self::FLAT
    }
}

impl<P: Space, M: Machine<P> + Sync> Work<'_, P, M> {
    /// The facet that a face is part of.
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

    /// The middle of a face in the plane of a facet.
    pub(super) fn middle_of(&self, face: &[u32], plane: &Plane) -> DVec2 {
        let sum = face.iter().fold(DVec3::ZERO, |sum, &v| sum + as_space(self.vertices.points[v as usize]));
        plane.of(sum / face.len() as f64)
    }

    /// Labels all cells.
    pub(super) fn labels(&self, delaunay: &Triangulation<P::Cell>, planes: &[Plane]) -> Labels {
        let n = delaunay.cells.len();
        let mut sets = Sets::new(n);
        let flat: Vec<bool> = delaunay
            .cells
            .iter()
            .map(|c| is_flat(&self.flats, &self.vertices.carriers, c.as_ref()))
            .collect();
        let mut face = Vec::with_capacity(P::DIM);
        for (i, (cell, across)) in (0u32..).zip(delaunay.cells.iter().zip(&delaunay.neighbours)) {
            for (slot, &j) in across.as_ref().iter().enumerate() {
                if j == u32::MAX || j > i || flat[i as usize] || flat[j as usize] {
                    continue;
                }
                face.clear();
                face.extend(cell.as_ref().iter().enumerate().filter(|(k, _)| *k != slot).map(|(_, &v)| v));
                if self.facet_of(&face, planes).is_none() {
                    sets.join(i, j);
                }
            }
        }
        let mut best: Vec<(f64, u32)> = vec![(-1.0, u32::MAX); n];
        for i in 0..n as u32 {
            let corners = self.corners(&delaunay.cells[i as usize]);
            let root = sets.find(i) as usize;
            let shortest = shortest_edge2(&corners[..P::Cell::LEN]);
            if shortest > best[root].0 {
                best[root] = (shortest, i);
            }
        }
        let mut of = vec![Labels::OUT; n];
        for i in 0..n as u32 {
            let root = sets.find(i);
            // The root of a set is its first cell.
            of[i as usize] = if flat[i as usize] {
                Labels::FLAT
            } else if root == i {
                self.component_of(&delaunay.cells[best[i as usize].1 as usize])
            } else {
                of[root as usize]
            };
        }
        Labels { of }
    }

    /// The faces on facets beside which there is a cell of the mesh.
    pub(super) fn faces(
        &self,
        delaunay: &Triangulation<P::Cell>,
        labels: &Labels,
        planes: &[Plane],
    ) -> Vec<(u32, P::Facet, [u32; 2])> {
        let inside = |j: u32| j != u32::MAX && labels.is_inside(j);
        let mut found = Vec::new();
        for (i, (cell, across)) in (0u32..).zip(delaunay.cells.iter().zip(&delaunay.neighbours)) {
            for (slot, &j) in across.as_ref().iter().enumerate() {
                if !inside(i) || inside(j) && j < i {
                    continue;
                }
                let face = facet_without::<P>(cell, cell.as_ref()[slot]);
                if let Some(f) = self.facet_of(face.as_ref(), planes) {
                    found.push((f, face, [i, if inside(j) { j } else { u32::MAX }]));
                }
            }
        }
        found.sort_unstable();
        found
    }

    fn component_of(&self, cell: &P::Cell) -> u32 {
        let corners = self.corners(cell);
        let sum = corners[..P::Cell::LEN].iter().fold(P::splat(0.0), |sum, &p| sum + p);
        let middle = sum / P::Cell::LEN as f64;
        match self.domain.sides.locate(self.domain.points(), middle) {
            Some(Location::Component(c)) if self.domain.components[c as usize].inside => c,
            _ => Labels::OUT,
        }
    }

    pub(super) fn corners(&self, cell: &P::Cell) -> [P; 4] {
        let mut corners = [P::default(); 4];
        for (corner, &v) in corners.iter_mut().zip(cell.as_ref()) {
            *corner = self.vertices.points[v as usize];
        }
        corners
    }
}

/// Are all vertices of a cell held by one facet?
pub(super) fn is_flat(holders: &Holders, carriers: &[Carrier], cell: &[u32]) -> bool {
    !cell.iter().any(|&v| carriers[v as usize] == Carrier::Volume)
        && !holders.common(carriers, cell).is_empty()
}
