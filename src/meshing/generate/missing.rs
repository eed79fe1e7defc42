//! Subsegments and subfacets missing from the Delaunay triangulation.
//!
//! **Statement.** Vertices divide a segment into *subsegments*. The *subfacets* of a facet are the triangles of its own
//! planar Delaunay triangulation. With respect to the Delaunay triangulation of all vertices:
//! 1. A subsegment is *missing* if it is not an edge.
//! 2. A subfacet is missing if it is not a face, unless the faces on its facet tile the facet in another way. This
//!    happens if four points of the facet are cocircular up to rounding.
//! 3. A face on a facet inside the domain is *unmatched* if exactly one of its cells is flat. It counts as missing.
//!
//! **Flat cells.** Vertices lie on a facet only up to rounding. Four cocircular vertices can span a flat cell, with one
//! diagonal above and the other below. Generation drops such cells ([`super::cells`]). On the boundary of the domain,
//! only one side matters. Inside the domain, the two sides of the facet then disagree, and the mesh does not conform,
//! because some subfacets are present on one side only. Inserting the common circumcentre repairs this.
//!
//! *Repairs are permanent.* Facets receive no vertices after the volume stage begins. A cell whose vertices lie on
//! facets has an empty circumball, so it is also a cell of the triangulation of the vertices on facets. Unmatched faces
//! therefore appear before the volume stage or never.
//!
//! **Work and depth.** `O(m log m)`: edges and faces are sorted.

use septet_geometry::incremental::facet_without;

use super::cells::is_flat;
use super::facets::{Plane, Subfacet, Subfacets, as_space};
use super::generator::Generator;
use super::machine::{Delaunay, MeshMachine};
use super::segments::{Chains, Subsegment, subsegments_of};
use crate::domain::Feature;
use crate::mesh::Carrier;
use crate::space::Space;

/// The missing subsegments and subfacets of a triangulation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct MissingParts {
    /// The missing subsegments.
    pub(super) subsegments: Vec<Subsegment>,
    /// The missing subfacets.
    pub(super) subfacets: Vec<Subfacet>,
}

impl MissingParts {
    pub(super) fn is_empty(&self) -> bool {
        self.subsegments.is_empty() && self.subfacets.is_empty()
    }

    /// Returns each feature once, with the number of its missing parts.
    pub(super) fn features(&self) -> Vec<(Feature, u32)> {
        let segments = self.subsegments.iter().map(|p| Feature::Segment(p.0));
        let mut all: Vec<Feature> =
            segments.chain(self.subfacets.iter().map(|t| Feature::Facet(t.0))).collect();
        all.sort_unstable();
        all.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as u32)).collect()
    }
}

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Returns the parts that are missing from the triangulation.
    pub(super) fn missing(
        &self,
        delaunay: &Delaunay<P::Cell>,
        planes: &[Plane],
        chains: &Chains,
        subfacets: &Subfacets,
    ) -> MissingParts {
        let (edges, faces) = self.carried(delaunay);
        let absent = |&(_, [a, b]): &Subsegment| edges.binary_search(&[a.min(b), a.max(b)]).is_err();
        let subsegments = subsegments_of(chains).into_iter().filter(absent).collect();
        let absent = |(_, t): &&Subfacet| {
            let mut t = *t;
            t.sort_unstable();
            faces.binary_search(&t).is_err()
        };
        let mut missing: Subfacets = subfacets.iter().filter(absent).copied().collect();
        missing.sort_unstable();
        let whole = if missing.is_empty() { Vec::new() } else { self.tiled(planes, subfacets, &faces) };
        missing.retain(|(f, _)| !whole[*f as usize]);
        missing.extend(self.unmatched(delaunay, planes));
        missing.sort_unstable();
        missing.dedup();
        MissingParts { subsegments, subfacets: missing }
    }

    /// Returns the faces on facets inside the domain for which exactly one of the two cells is flat.
    fn unmatched(&self, delaunay: &Delaunay<P::Cell>, planes: &[Plane]) -> Subfacets {
        if P::DIM == 2 {
            return Vec::new();
        }
        let flat =
            |cell: u32| is_flat(&self.flats, &self.vertices.carriers, delaunay.cells[cell as usize].as_ref());
        let mut unmatched = Vec::new();
        for j in (0..delaunay.cells.len() as u32).filter(|&j| flat(j)) {
            let (cell, across) = (&delaunay.cells[j as usize], delaunay.neighbours[j as usize]);
            for (&v, &i) in cell.as_ref().iter().zip(across.as_ref()) {
                if i == u32::MAX || flat(i) {
                    continue;
                }
                let mut row = [0; 3];
                row.copy_from_slice(facet_without::<P>(cell, v).as_ref());
                row.sort_unstable();
                unmatched.extend(
                    self.facet_of(&row, planes)
                        .filter(|&f| self.is_between(f, &row, planes))
                        .map(|f| (f, row)),
                );
            }
        }
        unmatched
    }

    /// Returns `true` if the domain lies on both sides of a face on a facet.
    fn is_between(&self, f: u32, face: &[u32; 3], planes: &[Plane]) -> bool {
        let wall = planes[f as usize].wall_at(self.middle_of(face, &planes[f as usize]));
        let inside = |c: u32| self.domain.components[c as usize].inside;
        let components =
            |wall: usize| self.domain.sides.components_at(self.domain.facets[f as usize].walls[wall]);
        wall.is_some_and(|wall| components(wall).into_iter().all(inside))
    }

    /// Returns the edges between vertices of segments, and the faces whose vertices lie on one facet and whose cell
    /// is not flat. Both lists are ascending.
    fn carried(&self, delaunay: &Delaunay<P::Cell>) -> (Vec<[u32; 2]>, Vec<[u32; 3]>) {
        let carriers = &self.vertices.carriers;
        let (mut edges, mut faces) = (Vec::new(), Vec::new());
        let on_segment = |v: u32| matches!(carriers[v as usize], Carrier::Corner(_) | Carrier::Segment(_));
        for cell in &delaunay.cells {
            let vertices = cell.as_ref();
            for (i, &a) in vertices.iter().enumerate().filter(|(_, v)| on_segment(**v)) {
                edges.extend(vertices[..i].iter().filter(|&&b| on_segment(b)).map(|&b| [a.min(b), a.max(b)]));
            }
            if P::DIM == 2
                || vertices.iter().filter(|v| carriers[**v as usize] != Carrier::Volume).count() < 3
            {
                continue;
            }
            if is_flat(&self.flats, carriers, vertices) {
                continue;
            }
            for &v in vertices {
                let face = facet_without::<P>(cell, v);
                if !self.holders.common(carriers, face.as_ref()).is_empty() {
                    let mut row = [0; 3];
                    row.copy_from_slice(face.as_ref());
                    row.sort_unstable();
                    faces.push(row);
                }
            }
        }
        edges.sort_unstable();
        edges.dedup();
        faces.sort_unstable();
        faces.dedup();
        (edges, faces)
    }

    /// Returns, for each facet, whether the faces of the triangulation tile it although they are not its subfacets.
    /// This happens if four points are cocircular up to rounding.
    fn tiled(&self, planes: &[Plane], subfacets: &Subfacets, faces: &[[u32; 3]]) -> Vec<bool> {
        let area = |f: u32, t: &[u32; 3]| {
            let plane = &planes[f as usize];
            let [a, b, c] = t.map(|v| plane.of(as_space(self.vertices.points[v as usize])));
            (b - a).perp_dot(c - a).abs()
        };
        let (mut there, mut whole) = (vec![0.0; planes.len()], vec![0.0; planes.len()]);
        for face in faces {
            if let Some(f) = self.facet_of(face, planes) {
                there[f as usize] += area(f, face);
            }
        }
        for (f, t) in subfacets {
            whole[*f as usize] += area(*f, t);
        }
        there
            .iter()
            .zip(&whole)
            .map(|(there, whole): (&f64, &f64)| (there - whole).abs() <= 1e-12 * whole)
            .collect()
    }
}
