//! The constrained Delaunay triangulation of a patch in its plane.
//!
//! **Statement.** The walls of a patch are divided at the points on its parts. Edges that are not locally Delaunay are
//! then exchanged (Lawson 1977). With a point A outside the plane, a sphere through A and three points of the plane
//! meets the plane in their circle. The perturbed sphere test of the triangulation therefore decides, and its
//! perturbation as well, because the cofactor of A is zero. The result is the unique constrained triangulation under this
//! perturbation. The cells around the patch in a constrained triangulation have these faces (Shewchuk 2008).
//!
//! An exchange is always possible. On an edge whose two triangles do not form a strictly convex polygon, the test is
//! negative: the line through three of its points meets their circle only twice.
//!
//! **Work and depth.** O(k^2) exchanges of k triangles in the worst case.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::predicates::Sign;

use super::points::Points;
use crate::space::ascending;

/// Returns the triangles, positive towards `apex`, which lies outside the plane. `chains` are the vertices on the parts
/// of the patch.
pub(super) fn triangulate(
    points: &Points,
    walls: &[[u32; 3]],
    chains: &[&[u32]],
    apex: u32,
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

    fn triangles(&self) -> Vec<[u32; 3]> {
        let first = |(&[a, b], &c): (&[u32; 2], &u32)| (a < b && a < c).then_some([a, b, c]);
        self.at.iter().filter_map(first).collect()
    }
}
