//! The constrained Delaunay triangulation of a patch in its plane.
//!
//! **Statement.** The walls of a patch are divided at the points on its parts. Edges that are not locally Delaunay are
//! then exchanged (Lawson 1977). With a point A outside the plane, a sphere through A and three points of the plane
//! meets the plane in their circle. The perturbed sphere test of the triangulation therefore decides, and its
//! perturbation as well, because the cofactor of A is zero. The result is the unique constrained triangulation under this
//! perturbation. The cells around the patch in a constrained triangulation have these faces (Shewchuk 2008).
//!
//! After exchanges of cells ([`super::segments`]), the cells may have other faces in the plane than these. The edges that
//! they have are then constraints, too.
//!
//! An exchange for the sphere test is always possible. On an edge whose two triangles do not form a strictly convex
//! polygon, the test is negative: the line through three of its points meets their circle only twice.
//!
//! **Work and depth.** O(k^2) exchanges of k triangles in the worst case.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::predicates::Sign;

use super::points::Points;
use crate::space::ascending;

/// Returns the triangles, positive towards `apex`, which lies outside the plane. `chains` are the vertices on the parts
/// of the patch. Edges that are `present` in the cells are kept if they lie in the patch.
pub(super) fn triangulate(
    points: &Points,
    walls: &[[u32; 3]],
    chains: &[&[u32]],
    apex: u32,
    present: &[[u32; 2]],
) -> Vec<[u32; 3]> {
    let mut planar = Flat { points, apex, at: BTreeMap::new(), fixed: BTreeSet::new() };
    for &[a, b, c] in walls {
        let positive = points.orientation([a, b, c, apex]) == Sign::Positive;
        planar.add(if positive { [a, b, c] } else { [a, c, b] });
    }
    for chain in chains {
        let (Some(&first), Some(&last)) = (chain.first(), chain.last()) else { continue };
        let mut from = first;
        for &v in &chain[1..chain.len() - 1] {
            planar.divide([from, last], v);
            from = v;
        }
        planar.fixed.extend(chain.windows(2).map(|w| ascending([w[0], w[1]])));
    }
    for &[v, w] in present {
        planar.insert(v, w);
    }
    planar.exchange();
    planar.triangles()
}

/// Triangles as directed edges with their opposite vertices.
struct Flat<'a> {
    points: &'a Points,
    apex: u32,
    at: BTreeMap<[u32; 2], u32>,
    fixed: BTreeSet<[u32; 2]>,
}

impl Flat<'_> {
    fn add(&mut self, [a, b, c]: [u32; 3]) {
        self.at.extend([([a, b], c), ([b, c], a), ([c, a], b)]);
    }

    fn remove(&mut self, [a, b, c]: [u32; 3]) {
        for edge in [[a, b], [b, c], [c, a]] {
            self.at.remove(&edge);
        }
    }

    /// Divides an edge at a point on it.
    fn divide(&mut self, [a, b]: [u32; 2], v: u32) {
        for [a, b] in [[a, b], [b, a]] {
            if let Some(&c) = self.at.get(&[a, b]) {
                self.remove([a, b, c]);
                self.add([a, v, c]);
                self.add([v, b, c]);
            }
        }
    }

    fn exchange(&mut self) {
        let mut open: Vec<[u32; 2]> = self.at.keys().filter(|[a, b]| a < b).copied().collect();
        while let Some([a, b]) = open.pop() {
            if self.fixed.contains(&ascending([a, b])) {
                continue;
            }
            let (Some(&c), Some(&d)) = (self.at.get(&[a, b]), self.at.get(&[b, a])) else { continue };
            if self.points.in_sphere([a, b, c, self.apex], d) {
                self.remove([a, b, c]);
                self.remove([b, a, d]);
                self.add([a, d, c]);
                self.add([d, b, c]);
                open.extend([[a, d], [d, b], [b, c], [c, a]]);
            }
        }
    }

    /// Returns the edges that a segment between two vertices crosses, in order. Returns `None` if it leaves the patch,
    /// meets a vertex, or is an edge.
    fn crossed(&self, v: u32, w: u32) -> Option<Vec<[u32; 2]>> {
        let left = |a: u32, b: u32, c: u32| self.points.orientation([a, b, c, self.apex]) == Sign::Positive;
        let around = self.at.range([v, 0]..=[v, u32::MAX]).map(|(&[_, x], &y)| [x, y]);
        let mut edge = around.into_iter().find(|&[x, y]| left(v, x, w) && left(v, w, y))?;
        let mut found = Vec::new();
        while !self.fixed.contains(&ascending(edge)) {
            found.push(edge);
            let [x, y] = edge;
            let &z = self.at.get(&[y, x])?;
            if z == w {
                return Some(found);
            }
            edge = match self.points.orientation([v, w, z, self.apex]) {
                Sign::Positive => [x, z],
                Sign::Negative => [z, y],
                Sign::Zero => return None,
            };
        }
        None
    }

    /// Makes a segment between two vertices an edge, if it lies in the patch.
    fn insert(&mut self, v: u32, w: u32) {
        if self.at.contains_key(&[v, w]) || self.at.contains_key(&[w, v]) {
            self.fixed.insert(ascending([v, w]));
            return;
        }
        let Some(mut crossed) = self.crossed(v, w) else { return };
        // Each edge waits for at most as many exchanges as there are edges.
        let mut left = crossed.len() * crossed.len() + 1;
        while let Some([x, y]) = crossed.pop() {
            let (Some(&c), Some(&d)) = (self.at.get(&[x, y]), self.at.get(&[y, x])) else { return };
            left -= 1;
            if left == 0 {
                return;
            }
            let positive =
                |a: u32, b: u32, c: u32| self.points.orientation([a, b, c, self.apex]) == Sign::Positive;
            if !(positive(x, d, c) && positive(d, y, c)) {
                crossed.insert(0, [x, y]);
                continue;
            }
            self.remove([x, y, c]);
            self.remove([y, x, d]);
            self.add([x, d, c]);
            self.add([d, y, c]);
            let sides = [c, d].map(|p| self.points.orientation([v, w, p, self.apex]));
            if ![c, d].contains(&v) && ![c, d].contains(&w) && sides[0] != sides[1] {
                crossed.insert(0, [c, d]);
            }
        }
        self.fixed.insert(ascending([v, w]));
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        let first = |(&[a, b], &c): (&[u32; 2], &u32)| (a < b && a < c).then_some([a, b, c]);
        self.at.iter().filter_map(first).collect()
    }
}
