//! Small holes of surfaces.
//!
//! **Statement.** The edges with an odd number of facets form cycles, because each closed polygon has an even number of
//! edges at every vertex. A cycle that meets no other is closed by triangles between its vertices, of which each new edge
//! has two. So all edges have an even number of facets afterwards. Of all triangulations of the cycle, the one with the
//! least area is taken (Barequet and Sharir, *Filling gaps in the boundary of a polyhedron*, 1995). A cycle is small if it
//! has at most [`MOST_EDGES`] edges, and its triangles cover at most [`MOST_AREA`] of the area of the surface. Others
//! stay. The exact check decides whether the triangles meet the surface.
//!
//! **Work and depth.** `O(m log m)`, and O(1) for each hole.

use std::collections::BTreeMap;

use glam::DVec3;

use super::change::Change;
use super::mending::Mending;
use crate::input::InputFacet;

/// The largest number of edges of a small hole.
pub const MOST_EDGES: usize = 8;

/// The largest part of the area of the surface that a small hole covers.
pub const MOST_AREA: f64 = 0.02;

/// Closes small holes.
pub(super) fn holes(mending: &mut Mending<DVec3>) {
    let same = mending.same();
    let mut count: BTreeMap<[u32; 2], (u32, u32)> = BTreeMap::new();
    for facet in 0..mending.input.facets.len() as u32 {
        for edge in mending.edges_of(facet, &same) {
            count.entry(edge).or_insert((0, facet)).0 += 1;
        }
    }
    let mut at: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (&[a, b], _) in count.iter().filter(|(_, n)| n.0 % 2 == 1) {
        at.entry(a).or_default().push(b);
        at.entry(b).or_default().push(a);
    }
    let cycles = cycles(&at);
    if cycles.is_empty() {
        return;
    }
    let total = mending.area();
    let file = mending.facets_of_file;
    for around in cycles.into_iter().filter(|c| c.len() <= MOST_EDGES) {
        let corners: Vec<DVec3> = around.iter().map(|&v| mending.input.points[v as usize]).collect();
        let (area, triangles) = least_area(&corners);
        if area > MOST_AREA * total {
            continue;
        }
        let neighbour = count[&crate::space::ascending([around[0], around[1]])].1;
        let solids = mending.solids_of(neighbour as usize);
        let marker = mending.input.facets[neighbour as usize].marker;
        for t in &triangles {
            let polygons = vec![t.iter().map(|&k| around[k]).collect()];
            let number = mending.origin.iter().copied().max().map_or(file, |m| (m + 1).max(file));
            mending.push(InputFacet { polygons, holes: Vec::new(), marker }, number, solids.clone());
        }
        let place = Mending::place(corners[0]);
        mending.changes.push(Change::Filled { around, triangles: triangles.len() as u32, area, at: place });
    }
}

/// Returns the cycles of edges that meet no others. Each starts at its smallest vertex, towards the smaller neighbour.
fn cycles(at: &BTreeMap<u32, Vec<u32>>) -> Vec<Vec<u32>> {
    let mut seen = std::collections::BTreeSet::new();
    let mut found = Vec::new();
    for (&start, ends) in at {
        if seen.contains(&start) {
            continue;
        }
        let (mut cycle, mut is_simple) = (vec![start], ends.len() == 2);
        let (mut last, mut next) = (start, ends[0].min(ends[ends.len() - 1]));
        seen.insert(start);
        while is_simple && next != start {
            seen.insert(next);
            cycle.push(next);
            match at.get(&next).map(Vec::as_slice) {
                Some(&[a, b]) => (last, next) = (next, if a == last { b } else { a }),
                _ => is_simple = false,
            }
        }
        if is_simple && cycle.len() > 2 {
            found.push(cycle);
        }
    }
    found
}

/// Returns the triangulation of a polygon in space with the least area, and that area.
fn least_area(corners: &[DVec3]) -> (f64, Vec<[usize; 3]>) {
    let n = corners.len();
    let area = |i: usize, j: usize, k: usize| {
        (corners[j] - corners[i]).cross(corners[k] - corners[i]).length() / 2.0
    };
    // The best area of the part between two corners, and its middle corner.
    let mut best = vec![vec![(0.0, 0); n]; n];
    for span in 2..n {
        for i in 0..n - span {
            let k = i + span;
            let all = (i + 1..k).map(|j| (best[i][j].0 + best[j][k].0 + area(i, j, k), j));
            best[i][k] = all.fold((f64::INFINITY, 0), |m, x| if x.0 < m.0 { x } else { m });
        }
    }
    let (mut triangles, mut stack) = (Vec::new(), vec![(0, n - 1)]);
    while let Some((i, k)) = stack.pop() {
        if k - i < 2 {
            continue;
        }
        let j = best[i][k].1;
        triangles.push([i, j, k]);
        stack.extend([(i, j), (j, k)]);
    }
    (best[0][n - 1].0, triangles)
}
