//! The check that a surface is a closed manifold.
//!
//! **Statement.** Every edge of a closed manifold has two faces, and the faces at every vertex form one fan.
//! [`crate::contact`] finds faces that intersect elsewhere.
//!
//! **Work and depth.** `O(m log m)`.

use std::collections::{BTreeMap, BTreeSet};

use crate::defect::{Defect, Element};
use crate::facet::wall_edges;
use crate::input::Input;
use crate::resolve::Simplices;
use crate::sides::Sets;
use crate::space::{Space, ascending};

/// Reports edges that do not have two faces, and vertices with several fans. Edges of faces with other defects are
/// included.
pub fn manifold<P: Space>(input: &Input<P>, simplices: &Simplices<P>) -> Vec<Defect> {
    let mut faces: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for (i, facet) in input.facets.iter().enumerate() {
        for polygon in &facet.polygons {
            let Some(corners) = simplices.represent(polygon) else { continue };
            for (k, &a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % corners.len()];
                if a != b {
                    faces.entry(ascending([a, b])).or_default().push(i as u32);
                }
            }
        }
    }
    let mut defects: Vec<Defect> = input
        .segments
        .iter()
        .filter_map(|s| Some((s.ends, simplices.represent(&s.ends)?)))
        .map(|(ends, at)| Defect::Dangling { element: Element::Segment(ends), at: simplices.place(at[0]) })
        .collect();
    for (&ends, facets) in faces.iter().filter(|(_, f)| f.len() != 2) {
        let at = simplices.middle(ends);
        defects.push(match facets[..] {
            [facet] => Defect::OpenEdge { ends, facet, at },
            _ => Defect::NonManifoldEdge { ends, facets: facets.clone(), at },
        });
    }
    defects.extend(pinched(input, simplices));
    defects
}

/// Reports vertices at which the walls form several fans. Skips vertices of faces with other defects.
fn pinched<P: Space>(input: &Input<P>, simplices: &Simplices<P>) -> Vec<Defect> {
    let whole: BTreeSet<u32> = simplices.owner.iter().copied().collect();
    let incomplete = (0..input.facets.len() as u32).filter(|f| !whole.contains(f));
    let incomplete = incomplete.flat_map(|f| input.facets[f as usize].polygons.concat());
    let incomplete: BTreeSet<u32> =
        incomplete.filter_map(|v| simplices.same.get(v as usize).copied()).collect();
    let mut at: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (i, wall) in simplices.walls.iter().enumerate() {
        for &v in wall.as_ref() {
            at.entry(v).or_default().push(i as u32);
        }
    }
    let edges = wall_edges::<P>(&simplices.walls);
    let mut defects = Vec::new();
    for (&v, walls) in at.iter().filter(|(v, _)| !incomplete.contains(v)) {
        let mut sets = Sets::new(walls.len());
        for (k, &wall) in walls.iter().enumerate() {
            for edge in P::edges(&simplices.walls[wall as usize]).iter().filter(|e| e.contains(&v)) {
                for other in edges.get(edge).into_iter().flatten() {
                    if let Ok(j) = walls.binary_search(other) {
                        sets.join(k as u32, j as u32);
                    }
                }
            }
        }
        let fans = (0..walls.len() as u32).filter(|&k| sets.find(k) == k).count() as u32;
        if fans > 1 {
            defects.push(Defect::NonManifoldVertex { point: v, fans, at: simplices.place(v) });
        }
    }
    defects
}

/// Returns the Euler characteristic of a surface: vertices minus edges plus triangles.
pub(crate) fn euler(triangles: impl IntoIterator<Item = [u32; 3]>) -> i64 {
    let (mut vertices, mut edges, mut count) = (Vec::new(), Vec::new(), 0);
    for [a, b, c] in triangles {
        vertices.extend([a, b, c]);
        edges.extend([[a, b], [b, c], [c, a]].map(ascending));
        count += 1;
    }
    vertices.sort_unstable();
    vertices.dedup();
    edges.sort_unstable();
    edges.dedup();
    vertices.len() as i64 - edges.len() as i64 + count
}
