//! Where the boundary is no manifold.
//!
//! **Statement.** The boundary of cells is a 2-manifold iff every edge has two faces and the faces at every vertex are one
//! fan. Where it is not, the largest surface ball around is divided. If it is one, vertices on facets that have no face are taken
//! away (chords cut them off), and of shells without any face some corners of walls join.

use std::collections::BTreeMap;

use septet_geometry::point::Point;

use super::refinement::{Candidate, Refinement, edges_of};
use super::restricted::Restricted;
use crate::bvh::Bounds;
use crate::generate::machine::Machine;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::sides::Sets;
use crate::space::Space;

/// The candidates that make it one.
pub(super) fn crowded<P: Space, M: Machine<P> + Sync>(
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

/// The faces at edges with other than two of them.
fn edges<P: Point>(made: &Restricted<P>) -> Vec<Vec<u32>> {
    let numbered = (0u32..).zip(&made.faces);
    let mut edges: Vec<([u32; 2], u32)> =
        numbered.flat_map(|(f, face)| edges_of(face.vertices).map(|e| (e, f))).collect();
    edges.sort_unstable();
    let groups = edges.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() != 2);
    groups.map(|group| group.iter().map(|e| e.1).collect()).collect()
}

/// The faces at vertices with more than one fan, if every edge has two faces.
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

/// Which vertices stay: all but those on facets that no face has, in an otherwise faultless boundary.
pub(super) fn useful<P: Point>(made: &Restricted<P>, carriers: &[Carrier]) -> Vec<bool> {
    let mut useful: Vec<bool> = carriers.iter().map(|c| !matches!(c, Carrier::Facet(_))).collect();
    made.faces.iter().flat_map(|f| f.vertices).for_each(|v| useful[v as usize] = true);
    useful
}

/// Vertices on facets that no face has, at the end: those of cells inside are the volume's then. Which vertices are left, with all that no
/// cell inside has taken away (outside cells have them, and go)?
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

/// Corners of walls of the shells that the boundary has no face on: too small for the size asked for. A quarter of a shell's
/// extent apart, so that some dozen stand for it.
pub(super) fn lost<P: Space, M: Machine<P> + Sync>(
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
