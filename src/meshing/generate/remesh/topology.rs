//! Violations of the manifold property of the boundary.
//!
//! **Statement.** The boundary of a set of cells is a 2-manifold iff every edge has two faces and the faces at every
//! vertex form one fan. At a violation, the largest surface ball nearby is divided. Once the boundary is a manifold,
//! vertices on facets that have no face are removed, because chords cut them off. For shells without any face, some
//! corners of their walls are added.

use std::collections::BTreeMap;

use septet_geometry::point::Point;

use super::refinement::{Refinement, edges_of};
use super::restricted::Restricted;
use crate::bvh::Bounds;
use crate::generate::generator::Candidate;
use crate::generate::machine::MeshMachine;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::sides::Sets;
use crate::space::Space;

/// Returns the candidates that repair the manifold property.
pub(super) fn crowded<P: Space, M: MeshMachine<P> + Sync>(
    at: &Refinement<'_, P, M>,
    made: &Restricted<P>,
) -> Vec<Candidate<P>> {
    let mut groups = edges(made);
    if groups.is_empty() {
        groups = vertices(made, at.generator.vertices.len());
    }
    let largest = |faces: &Vec<u32>| {
        let faces = faces.iter().map(|&f| &made.faces[f as usize]);
        faces.max_by(|a, b| a.radius.total_cmp(&b.radius).then(b.vertices.cmp(&a.vertices)))
    };
    groups.iter().filter_map(largest).map(|face| at.on_surface(face)).collect()
}

/// Returns the faces at each edge that does not have two faces.
fn edges<P: Point>(made: &Restricted<P>) -> Vec<Vec<u32>> {
    let numbered = (0u32..).zip(&made.faces);
    let mut edges: Vec<([u32; 2], u32)> =
        numbered.flat_map(|(f, face)| edges_of(face.vertices).map(|e| (e, f))).collect();
    edges.sort_unstable();
    let groups = edges.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() != 2);
    groups.map(|group| group.iter().map(|e| e.1).collect()).collect()
}

/// Returns the faces at each vertex with several fans. Every edge must have two faces.
fn vertices<P: Point>(made: &Restricted<P>, count: usize) -> Vec<Vec<u32>> {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); count];
    for (f, face) in (0u32..).zip(&made.faces) {
        face.vertices.iter().for_each(|&v| around[v as usize].push(f));
    }
    let several = |(v, faces): (u32, &Vec<u32>)| {
        let mut sets = Sets::new(faces.len());
        let mut ends: Vec<(u32, u32)> = Vec::new();
        for (i, &f) in (0u32..).zip(faces) {
            let others = made.faces[f as usize].vertices.into_iter().filter(|&w| w != v);
            ends.extend(others.map(|w| (w, i)));
        }
        ends.sort_unstable();
        ends.chunk_by(|a, b| a.0 == b.0).for_each(|group| sets.join(group[0].1, group[group.len() - 1].1));
        (1..faces.len() as u32).any(|i| sets.find(i) != sets.find(0)).then(|| faces.clone())
    };
    (0u32..).zip(&around).filter_map(several).collect()
}

/// Returns, for each vertex, whether it is kept: vertices on facets are kept only if they have a face. The boundary
/// must have no other faults.
pub(super) fn useful<P: Point>(made: &Restricted<P>, carriers: &[Carrier]) -> Vec<bool> {
    let mut useful: Vec<bool> = carriers.iter().map(|c| !matches!(c, Carrier::Facet(_))).collect();
    made.faces.iter().flat_map(|f| f.vertices).for_each(|v| useful[v as usize] = true);
    useful
}

/// Reassigns vertices on facets that have no face to the volume, at the end. Returns, for each vertex, whether a cell
/// inside uses it. Other vertices are removed together with the cells outside.
pub(super) fn unfaced<P: Point>(carriers: &mut [Carrier], made: &Restricted<P>) -> Vec<bool> {
    let useful = useful(made, carriers);
    let mut kept = vec![false; carriers.len()];
    let inside = (0u32..).zip(&made.delaunay.cells).filter(|(i, _)| made.labels.is_inside(*i));
    inside.flat_map(|(_, cell)| cell.as_ref()).for_each(|&v| kept[v as usize] = true);
    for (carrier, _) in carriers.iter_mut().zip(useful).filter(|(_, useful)| !useful) {
        *carrier = Carrier::Volume;
    }
    kept
}

/// Returns corners of walls of those shells on which the boundary has no face. Such shells are too small for the
/// requested size. The corners are a quarter of the shell's extent apart, so about a dozen per shell are inserted.
pub(super) fn lost<P: Space, M: MeshMachine<P> + Sync>(
    at: &Refinement<'_, P, M>,
    made: &Restricted<P>,
) -> Vec<Candidate<P>> {
    let domain = at.generator.domain;
    let mut sets = Sets::new(domain.facets.len());
    for segment in &domain.segments {
        segment.facets.windows(2).for_each(|f| sets.join(f[0], f[1]));
    }
    let shell: Vec<u32> = (0..domain.facets.len() as u32).map(|f| sets.find(f)).collect();
    let mut met = vec![false; shell.len()];
    made.faces.iter().for_each(|f| met[shell[f.place.facet as usize] as usize] = true);
    let mut corners: BTreeMap<u32, Vec<(u32, P)>> = BTreeMap::new();
    for (f, &s) in (0u32..).zip(&shell).filter(|(_, s)| !met[**s as usize]) {
        corners.entry(s).or_default().extend(at.surface.corners_of(f).map(|p| (f, p)));
    }
    let mut found = Vec::new();
    for corners in corners.into_values() {
        let size = 0.25 * Bounds::of(corners.iter().map(|c| c.1)).extent().norm2().sqrt();
        found.extend(corners.into_iter().map(|(f, at)| (Site { at, size }, Carrier::Facet(f))));
    }
    found
}
