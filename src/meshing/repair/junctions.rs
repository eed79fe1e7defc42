//! T-junctions: points on edges of facets that do not have them as corners.
//!
//! **Statement.** A point strictly between the ends of an edge of a surface, and on it by an exact sign, becomes a corner
//! of every facet with this edge. So does a point within the given distance of an edge with an odd number of facets. Such
//! an edge is open, so its facets end there, while others end at the parts of it. The points are taken in the order
//! along the edge. All facets at an edge are divided alike, so edges that were shared remain so. Facets with new corners
//! are triangulated later: exactly ([`crate::facet`]), or in a projection ([`super::flat`]).
//!
//! **Work and depth.** `O(m log m)`, plus the points in the boxes of edges, sequential.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::change::Change;
use super::mending::Mending;
use crate::bvh::{Bounds, Bvh};
use crate::space::{ascending, on_segment};

/// Divides edges of a surface at the points on them. `scaled` are the points in the range of exact signs, and `reach` is
/// the distance in the unit of the file.
pub(super) fn junctions(mending: &mut Mending<DVec3>, scaled: &[DVec3], reach: f64) {
    let same = mending.same();
    let mut count: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for facet in 0..mending.input.facets.len() as u32 {
        for edge in mending.edges_of(facet, &same) {
            *count.entry(edge).or_default() += 1;
        }
    }
    let used: Vec<u32> = count.keys().flatten().copied().collect::<BTreeSet<_>>().into_iter().collect();
    let points = &mending.input.points;
    let tree = Bvh::new(used.iter().map(|&v| Bounds::of([points[v as usize]])).collect());
    let mut inner: BTreeMap<[u32; 2], Vec<(u32, f64)>> = BTreeMap::new();
    for (&edge, &number) in &count {
        let [a, b] = edge.map(|v| points[v as usize]);
        let [exact_a, exact_b] = edge.map(|v| scaled[v as usize]);
        let grown = if number % 2 == 1 { reach } else { 0.0 };
        let bounds = Bounds::of([a, b]);
        let bounds = Bounds { low: bounds.low - grown, high: bounds.high + grown };
        let mut on: Vec<(f64, u32, f64)> = Vec::new();
        for v in tree.meeting(&bounds).into_iter().map(|i| used[i as usize]).filter(|v| !edge.contains(v)) {
            let p = points[v as usize];
            let along = (p - a).dot(b - a) / (b - a).length_squared();
            let distance = (p - a - (b - a) * along).length();
            let is_near = distance <= grown && along > 0.0 && along < 1.0;
            if on_segment(exact_a, exact_b, scaled[v as usize]) {
                on.push((along, v, 0.0));
            } else if grown > 0.0 && is_near {
                on.push((along, v, distance));
            }
        }
        if !on.is_empty() {
            on.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
            inner.insert(edge, on.into_iter().map(|(_, v, distance)| (v, distance)).collect());
        }
    }
    if !inner.is_empty() {
        insert(mending, &same, &inner);
    }
}

/// Inserts the points into the polygons.
fn insert(mending: &mut Mending<DVec3>, same: &[u32], inner: &BTreeMap<[u32; 2], Vec<(u32, f64)>>) {
    let points = &mending.input.points;
    for (facet, &origin) in mending.input.facets.iter_mut().zip(&mending.origin) {
        for polygon in facet.polygons.iter_mut().filter(|l| l.len() > 2) {
            let ids: Vec<u32> = polygon.iter().filter_map(|&v| same.get(v as usize).copied()).collect();
            if ids.len() < polygon.len() {
                continue;
            }
            let mut longer = Vec::with_capacity(ids.len() + 1);
            for (k, &a) in ids.iter().enumerate() {
                let b = ids[(k + 1) % ids.len()];
                longer.push(polygon[k]);
                let Some(on) = inner.get(&ascending([a, b])) else { continue };
                let fresh = |&&(v, _): &&(u32, f64)| !ids.contains(&v);
                let mut on: Vec<(u32, f64)> = on.iter().filter(fresh).copied().collect();
                if a > b {
                    on.reverse();
                }
                for (point, distance) in on {
                    longer.push(point);
                    let at = Mending::place(points[point as usize]);
                    let ends = ascending([a, b]);
                    mending.changes.push(Change::Divided { facet: origin, ends, point, distance, at });
                }
            }
            *polygon = longer;
        }
    }
}
