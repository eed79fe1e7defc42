//! Where the boundary is no manifold.
//!
//! **Statement.** The boundary of cells is a 2-manifold iff every edge has two faces and the faces at every vertex are one
//! fan. Where it is not, the largest surface ball around is divided; at a vertex of the surface without any face, the
//! corners of a wall of its facet join.

use septet_geometry::point::Point;

use super::refine::{Candidate, Refinement, edges_of};
use super::restricted::Restricted;
use crate::generate::machine::Machine;
use crate::mesh::Carrier;
use crate::sides::Sets;
use crate::space::Space;

/// The candidates that make it one.
pub(super) fn crowded<P: Space, M: Machine<P> + Sync>(
    at: &Refinement<'_, P, M>,
    made: &Restricted<P>,
) -> Vec<Candidate<P>> {
    let mut groups = edges(made);
    if groups.is_empty() {
        groups = vertices(made, at.work.vertices.len());
    }
    let largest = |faces: &Vec<u32>| {
        let faces = faces.iter().map(|&f| &made.faces[f as usize]);
        faces.max_by(|a, b| a.radius.total_cmp(&b.radius).then(b.vertices.cmp(&a.vertices)))
    };
    let mut found: Vec<Candidate<P>> =
        groups.iter().filter_map(largest).map(|face| at.on_surface(face)).collect();
    if groups.is_empty() {
        found.extend(lonely(at, made));
    }
    found
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

/// Corners of walls, for vertices on facets that no face has.
fn lonely<P: Space, M: Machine<P> + Sync>(
    at: &Refinement<'_, P, M>,
    made: &Restricted<P>,
) -> Vec<Candidate<P>> {
    let vertices = &at.work.vertices;
    let mut met = vec![false; vertices.len()];
    made.faces.iter().flat_map(|f| f.vertices).for_each(|v| met[v as usize] = true);
    let mut found = Vec::new();
    for (carrier, _) in vertices.carriers.iter().zip(met).filter(|(_, met)| !met) {
        if let Carrier::Facet(f) = *carrier {
            let new = at.surface.corners_of(f).into_iter().filter(|p| !vertices.points.contains(p));
            found.extend(new.map(|p| at.at_surface(at.work.rules.site(p), f)));
        }
    }
    found
}
