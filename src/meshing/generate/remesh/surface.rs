//! The surface: its walls, with crossings, samples and distances.

use septet_geometry::cost::Sweep;
use septet_geometry::evaluation::At;
use septet_geometry::point::dist2;

use crate::bvh::{Bounds, Bvh};
use crate::distance::closest_on_triangle;
use crate::domain::Domain;
use crate::generate::generator::{CANDIDATES, Rules};
use crate::generate::subdivision::Division;
use crate::mesh::Carrier;
use crate::octree::CellKey;
use crate::points::candidates::Name;
use crate::space::Space;

/// A point on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfacePoint<P> {
    pub(super) at: P,
    pub(super) facet: u32,
    /// The normal of the wall there.
    pub(super) normal: P,
}

/// The walls of a surface.
pub(super) struct Surface<P> {
    walls: Vec<[P; 3]>,
    /// The facet of each wall.
    facets: Vec<u32>,
    tree: Bvh<P>,
    diagonal: f64,
}

/// The maximum number of times that a wall is quartered for candidates.
const DEEPEST: u8 = 15;

/// The number of candidates per area `f^2`. A quartered wall has about four cells per area `f^2`.
const PER_AREA: f64 = 2.0 * CANDIDATES as f64;

/// The tolerance for a crossing outside a wall, in barycentric coordinates. It makes adjacent walls overlap in spite
/// of rounding.
const EDGE: f64 = 1e-9;

/// The offset at which a segment that leaves the surface starts, relative to its length.
const AGAIN: f64 = 1e-3;

impl<P: Space> Surface<P> {
    pub(super) fn new(domain: &Domain<P>) -> Self {
        let corners = |w: u32| {
            let wall = domain.walls()[w as usize];
            [0, 1, 2].map(|i| domain.points()[wall.as_ref()[i] as usize])
        };
        let (mut walls, mut facets) = (Vec::new(), Vec::new());
        for (f, facet) in (0u32..).zip(&domain.facets) {
            walls.extend(facet.walls.iter().map(|&w| corners(w)));
            facets.resize(walls.len(), f);
        }
        let tree = Bvh::new(walls.iter().map(|w: &[P; 3]| Bounds::of(*w)).collect());
        let diagonal = if walls.is_empty() { 0.0 } else { tree.bounds().extent().norm2().sqrt() };
        Surface { walls, facets, tree, diagonal }
    }

    pub(super) fn diagonal(&self) -> f64 {
        self.diagonal
    }

    fn place(&self, wall: u32, at: P) -> SurfacePoint<P> {
        let [a, b, c] = self.walls[wall as usize];
        SurfacePoint { at, facet: self.facets[wall as usize], normal: P::hull_normal(&[b - a, c - a]) }
    }

    /// Returns the crossing of the segment from p to q with the surface that is farthest from `from`.
    pub(super) fn crossing(&self, p: P, q: P, from: P) -> Option<SurfacePoint<P>> {
        let [p, q] = self.near(p, q);
        let mut best: Option<(f64, u32, P)> = None;
        self.tree.visit_along(p, q, |wall| {
            if let Some(x) = crossed(&self.walls[wall as usize], p, q) {
                let d = dist2(x, from);
                if best.is_none_or(|(e, w, _)| d > e || d == e && wall < w) {
                    best = Some((d, wall, x));
                }
            }
            true
        });
        best.map(|(_, wall, x)| self.place(wall, x))
    }

    /// Clips a segment to a part of twice the diagonal of the box, around its point nearest to the middle of the box.
    /// Only this part can meet the surface.
    fn near(&self, p: P, q: P) -> [P; 2] {
        let (bounds, along) = (self.tree.bounds(), q - p);
        let length = along.norm2().sqrt();
        let reach = 2.0 * self.diagonal;
        // A face with collinear corners has no axis, and points on it have NaN coordinates.
        if length.is_nan() || length <= reach {
            return [p, q];
        }
        let middle = (bounds.low + bounds.high) * 0.5;
        let nearest = (along.dot(middle - p) / length).max(0.0).min(length);
        let at = |s: f64| p + along * (s / length);
        [
            if nearest > reach { at(nearest - reach) } else { p },
            if length - nearest > reach { at(nearest + reach) } else { q },
        ]
    }

    /// Returns the squared distance at which the segment along `d` from a point of the surface meets the surface again.
    pub(super) fn again(&self, at: P, d: P) -> Option<f64> {
        // The offset skips the wall itself and its neighbours.
        let start = at + d * AGAIN;
        let mut least: Option<f64> = None;
        self.tree.visit_along(start, at + d, |wall| {
            if let Some(x) = crossed(&self.walls[wall as usize], start, at + d) {
                least = Some(least.map_or(dist2(x, at), |l| l.min(dist2(x, at))));
            }
            true
        });
        least
    }

    /// Returns the point of the surface nearest to a point.
    pub(super) fn nearest(&self, q: P) -> Option<SurfacePoint<P>> {
        let mut best = None;
        let closest = |w: u32| {
            let [a, b, c] = self.walls[w as usize];
            closest_on_triangle(a, b, c, q)
        };
        self.tree.nearest(
            q,
            |w| dist2(closest(w), q),
            |w, _| {
                best = Some(self.place(w, closest(w)));
                false
            },
        );
        best
    }

    /// Returns the surface point nearest to `p` or to `q`, whichever is closer.
    pub(super) fn nearer(&self, p: P, q: P) -> Option<SurfacePoint<P>> {
        let [p, q] = [p, q].map(|x| self.nearest(x).map(|near| (dist2(near.at, x), near)));
        match (p?, q?) {
            (p, q) if q.0 < p.0 => Some(q.1),
            (p, _) => Some(p.1),
        }
    }

    /// Returns the walls as roots of trees of parts.
    pub(super) fn roots(&self) -> Vec<WallPart> {
        (0..self.walls.len() as u32).map(|wall| (wall, CellKey::ROOT)).collect()
    }

    /// Returns the corners of a part of a wall. The digits of its place, to the base 4, are the quarters that contain it.
    fn corners_of_part(&self, (wall, key): WallPart) -> Option<[P; 3]> {
        let mut corners = *self.walls.get(wall as usize)?;
        for level in (0..key.level.min(DEEPEST)).rev() {
            let [a, b, c] = corners;
            let (x, y, z) = ((b + c) * 0.5, (c + a) * 0.5, (a + b) * 0.5);
            let quarters = [[a, z, y], [z, b, x], [y, x, c], [x, y, z]];
            corners = quarters[(key.at[0] >> (2 * level) & 3) as usize];
        }
        Some(corners)
    }

    /// Decides about a part: it is quartered until its edges are at most f at its centroid. A leaf has this size.
    pub(super) fn decide_part(
        &self,
        part: WallPart,
        rules: &Rules<'_, P>,
        visits: &mut Sweep,
    ) -> Division<WallPart, (WallPart, f64)> {
        let Some([a, b, c]) = self.corners_of_part(part) else { return Division::Drop };
        let size = rules.size.at_counted((a + b + c) / 3.0, visits);
        let longest = dist2(a, b).max(dist2(b, c)).max(dist2(c, a));
        let is_wide = longest > size * size && part.1.level < DEEPEST;
        if is_wide { Division::Divide(part) } else { Division::Leaf((part, size)) }
    }

    /// Returns the candidates on a part of a wall: on average [`PER_AREA`] per area `f^2`, if `size` is f at its
    /// centroid.
    pub(super) fn candidates(&self, part: WallPart, size: f64, seed: u64) -> Vec<At<P>> {
        let Some([a, b, c]) = self.corners_of_part(part) else { return Vec::new() };
        let name = |number| Name { cell: part.1, number };
        let area = 0.5 * P::hull_normal(&[b - a, c - a]).norm2().sqrt();
        let count = (PER_AREA * area / (size * size) + name(u32::MAX).unit(seed, 0)) as u32;
        let place = |number| {
            let [mut x, mut y] = [1, 2].map(|purpose| name(number).unit(seed, purpose));
            if x + y > 1.0 {
                (x, y) = (1.0 - x, 1.0 - y);
            }
            At(a + (b - a) * x + (c - a) * y)
        };
        (0..count).map(place).collect()
    }

    /// Returns the carrier of points on a wall.
    pub(super) fn carrier(&self, wall: u32) -> Carrier {
        Carrier::Facet(self.facets[wall as usize])
    }

    /// Returns the corners of the first wall of a facet.
    pub(super) fn corners_of(&self, facet: u32) -> [P; 3] {
        self.walls[self.facets.partition_point(|&f| f < facet)]
    }
}

/// A part of a wall: the wall, and the place of the part in the tree of its quarters.
pub(super) type WallPart = (u32, CellKey);

/// Returns the quarters of a part.
pub(super) fn quarters(&(wall, key): &WallPart) -> Vec<WallPart> {
    (0..4).map(|i| (wall, CellKey { level: key.level + 1, at: [4 * key.at[0] + i, 0, 0] })).collect()
}

/// Returns the point at which a segment crosses a triangle, rounded.
fn crossed<P: Space>(&[a, b, c]: &[P; 3], p: P, q: P) -> Option<P> {
    let normal = P::hull_normal(&[b - a, c - a]);
    let (from, to) = (normal.dot(p - a), normal.dot(q - a));
    if (from > 0.0) == (to > 0.0) {
        return None;
    }
    let x = p + (q - p) * (from / (from - to));
    let (u, v, e) = (b - a, c - a, x - a);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let det = uu * vv - uv * uv;
    let (eu, ev) = (e.dot(u), e.dot(v));
    let (s, t) = ((eu * vv - ev * uv) / det, (ev * uu - eu * uv) / det);
    (s >= -EDGE && t >= -EDGE && s + t <= 1.0 + EDGE).then_some(x)
}
