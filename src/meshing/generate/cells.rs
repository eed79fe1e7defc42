//! From a triangulation of the vertices to the cells and faces of the domain.
//!
//! **Statement.** The facets' own faces are the [`super::barrier`]. Cells that share a face which is not part of it are in
//! one *class*; the outside of the hull is one more cell, beside all faces of the hull. Each class lies in one
//! component of the domain: the one on its side of any barrier face beside it. A cell whose vertices one facet (or one group
//! of coplanar facets) holds is flat but for rounding. It passes its class on like any other cell, and is dropped.
//!
//! *Proof.* With the cell beyond the hull the cells are a triangulation of the sphere of one dimension more than a facet's.
//! The own faces of a facet tile it: their edges are shared by two of them, but for pieces of its segments, which are edges
//! of the triangulation. So the barrier is the complex of the domain's walls, as far as they have the domain beside them, with
//! its vertices moved by no more than rounding. It separates the sphere in as many parts as the walls do (Alexander
//! duality), and the parts are the classes: a way through cells that avoids the barrier's vertices and edges is a way through
//! faces. Around an edge that two faces of one facet share, and no other face of the barrier, all cells
//! on one side are in one class. So a class beside one face of a facet is beside all of them up to the next segment, where the
//! domain names the component. Two components without the domain between them may be one class; neither is inside.
//!
//! *Why labels depend on no order.* Classes are the connected components of a graph. A label is the largest of those that the faces
//! beside a class name, all of them equal by the proof. The faces name them by directions along pieces and by exact
//! signs ([`super::barrier`]). No rounded place decides: a flat cell across coplanar facets gets the label of its class, with its middle on
//! either side of the facets.
//!
//! **Source.** Alexander duality: Hatcher (2002), section 3.3.
//!
//! **Departures.** If faces of a facet were lacking, classes of several components would be one. Then the largest label counts,
//! which is outside before inside, and [`crate::conformity`] refuses the mesh. A face of the mesh beside a dropped cell may be the other
//! diagonal of the facet's own. Its facet is the one in which its middle lies, rounded; such a face has an area, as its cell is not flat.
//!
//! **Work and depth.** `O(n a(n) + m log m)` for n cells and m faces whose vertices lie on facets.

use glam::{DVec2, DVec3};
use septet_geometry::incremental::facet_without;
use septet_geometry::point::lex_cmp;

use super::barrier::Barrier;
use super::facets::{Plane, as_space};
use super::generator::Generator;
use super::machine::{Machine, Triangulation};
use super::vertices::Holders;
use crate::mesh::Carrier;
use crate::sides::Sets;
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

impl<P: Space, M: Machine<P> + Sync> Generator<'_, P, M> {
    /// The facet that a face is part of, as rounding has it. For faces with an area, as those of cells that are not flat.
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

    /// The middle of a face in the plane of a facet, rounded alike whatever the order of its vertices.
    pub(super) fn middle_of(&self, face: &[u32], plane: &Plane) -> DVec2 {
        let mut corners: Vec<DVec3> =
            face.iter().map(|&v| as_space(self.vertices.points[v as usize])).collect();
        corners.sort_unstable_by(lex_cmp);
        plane.of(corners.iter().sum::<DVec3>() / face.len() as f64)
    }

    /// Labels all cells.
    pub(super) fn labels(&self, delaunay: &Triangulation<P::Cell>, barrier: &Barrier<P::Facet>) -> Labels {
        let n = delaunay.cells.len();
        // The outside of the hull is one more cell.
        let mut sets = Sets::new(n + 1);
        let mut named = vec![None; n + 1];
        named[n] = Some(Labels::OUT);
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
                return Labels::FLAT;
            }
            named[sets.find(i) as usize].unwrap_or(Labels::OUT)
        };
        Labels { of: (0u32..).zip(&delaunay.cells).map(label).collect() }
    }

    /// Whether no vertex of a face is in the volume.
    fn is_carried(&self, face: &[u32]) -> bool {
        face.iter().all(|&v| self.vertices.carriers[v as usize] != Carrier::Volume)
    }

    /// The faces on facets beside which there is a cell of the mesh.
    pub(super) fn faces(
        &self,
        delaunay: &Triangulation<P::Cell>,
        labels: &Labels,
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
                // Beside a cell that is left out the face that is seen may have the other diagonal.
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

/// Are all vertices of a cell held by one facet?
pub(super) fn is_flat(holders: &Holders, carriers: &[Carrier], cell: &[u32]) -> bool {
    !cell.iter().any(|&v| carriers[v as usize] == Carrier::Volume)
        && !holders.common(carriers, cell).is_empty()
}
