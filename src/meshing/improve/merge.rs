//! The merge of a vertex with a neighbour.
//!
//! **Statement.** The cells around a vertex v that do not contain its neighbour w are joined to w instead. All new
//! cells are positive (exact sign) and cover the star of v, because they have the same boundary. A vertex of the volume
//! may merge with any neighbour, one in a facet with a vertex of that facet, and one on a segment with a neighbour on
//! that segment. Corners and vertices of a remeshed boundary remain. No edge becomes longer than the edges of the old
//! cells.
//!
//! **Source.** Klingner and Shewchuk (2007).
//!
//! **Work and depth.** O(1) for a vertex.

use septet_geometry::point::dist2;

use super::change::{Change, Kind, sorted};
use super::editable::Editable;
use super::rules::{Rules, measured};
use super::shape::Grade;
use crate::mesh::Carrier;
use crate::space::{Space, ascending};

/// Returns the best merge of a vertex.
pub(super) fn merge<P: Space>(mesh: &Editable<P>, rules: &Rules<'_, P>, v: u32) -> Option<Change<P>> {
    let carrier = mesh.carriers[v as usize];
    let is_kept = carrier != Carrier::Volume && (rules.target.fixed || rules.surface.is_some());
    if is_kept || matches!(carrier, Carrier::Corner(_)) {
        return None;
    }
    let star = mesh.star(v);
    let mut neighbours: Vec<u32> =
        star.iter().flat_map(|&c| mesh.cells[c as usize]).filter(|&w| w != v).collect();
    neighbours.sort_unstable();
    neighbours.dedup();
    let (before, worst) = measured(mesh, star);
    let longest = star.iter().map(|&c| longest2(&mesh.corners(c))).fold(0.0, f64::max);
    let faces = mesh.faces_at(v);
    let edges: Vec<([u32; 2], u32)> = neighbours
        .iter()
        .filter_map(|&w| mesh.edges.get(&ascending([v, w])).map(|&s| (ascending([v, w]), s)))
        .collect();
    let with = |w: u32| {
        let is_near = match carrier {
            Carrier::Segment(_) => edges.iter().any(|(e, _)| e.contains(&w)),
            Carrier::Facet(_) => faces.iter().any(|(f, _)| f.contains(&w)),
            _ => true,
        };
        let mut change = is_near.then(|| merged(mesh, rules, (v, w), rules.ratio(worst)))??;
        let fits = change.new.iter().all(|n| longest2(&mesh.places(n.0)) <= longest);
        if !fits || !change.grade.is_worth(before, rules.wanted) {
            return None;
        }
        let renamed = |u: u32| if u == v { w } else { u };
        change.lost_faces = faces.iter().map(|f| f.0).collect();
        change.made_faces = faces
            .iter()
            .filter(|f| !f.0.contains(&w))
            .map(|&(face, facet)| (sorted(face.map(renamed)), facet))
            .collect();
        change.lost_edges = edges.iter().map(|e| e.0).collect();
        change.made_edges = edges
            .iter()
            .filter(|e| !e.0.contains(&w))
            .map(|&(edge, segment)| (ascending(edge.map(renamed)), segment))
            .collect();
        Some(change)
    };
    neighbours.iter().filter_map(|&w| with(w)).reduce(|a, b| if b.grade.sine > a.grade.sine { b } else { a })
}

/// Returns the cells around a vertex v, joined to w.
fn merged<P: Space>(
    mesh: &Editable<P>,
    rules: &Rules<'_, P>,
    (v, w): (u32, u32),
    ratio: f64,
) -> Option<Change<P>> {
    let (mut grade, mut new) = (Grade::BEST, Vec::new());
    for &c in mesh.star(v) {
        let row = mesh.cells[c as usize];
        if !row.contains(&w) {
            let row = row.map(|u| if u == v { w } else { u });
            grade = grade.and(rules.admits(&mesh.places(row), ratio)?);
            new.push((row, mesh.regions[c as usize]));
        }
    }
    Some(Change::of(Kind::Merge, grade, mesh.star(v).to_vec(), new))
}

/// Returns the squared length of the longest edge of a cell.
fn longest2<P: Space>(p: &[P; 4]) -> f64 {
    (0..4).flat_map(|i| (0..i).map(move |j| dist2(p[i], p[j]))).fold(0.0, f64::max)
}
