//! Angles between features.
//!
//! **Statement.** Let two features meet in a corner or along a segment, and let neither contain the other. Their angle
//! is the smallest angle between a direction into one feature and a direction into the other.
//! 1. Two facets that meet along a segment: the angle is their dihedral angle.
//! 2. Two segments: the angle is the angle between them in their plane.
//! 3. A segment and a facet: if the projection of the segment runs into the facet, the angle is the angle between the
//!    segment and the plane of the facet. Otherwise, it is the smallest angle between the segment and a segment of
//!    the facet.
//! 4. Two facets that meet only in a corner: their angle is at least as large as one of the angles above.
//!
//! **Work and depth.** One test for each pair of features at each corner and segment.
//!
//! Angles are rounded. Comparisons use cosines, which need only square roots. Only reports use degrees.

use septet_geometry::point::Point;

use crate::domain::{Domain, Feature, Segment};
use crate::space::Space;

/// Two features that meet at a small angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallAngle {
    /// The features.
    pub features: [Feature; 2],
    /// The vertex of the corner in which they meet. For two facets along a segment, it is the first end of the
    /// segment.
    pub at: u32,
    /// The segment along which two facets meet. `None` for other pairs.
    pub along: Option<u32>,
    /// The cosine of the angle.
    pub cosine: f64,
}

impl SmallAngle {
    /// Returns the angle in degrees.
    pub fn degrees(&self) -> f64 {
        self.cosine.clamp(-1.0, 1.0).acos().to_degrees()
    }
}

/// The margin below the limit, as a difference of cosines. Without it, right angles of a slanted box could count as
/// small because of rounded coordinates.
const MARGIN: f64 = 1e-9;

/// Returns the cosine of the angle between two vectors.
pub fn cosine<P: Point>(a: P, b: P) -> f64 {
    a.dot(b) / (a.norm2().sqrt() * b.norm2().sqrt())
}

impl<P: Space> Domain<P> {
    fn direction(&self, segment: &Segment, from: u32) -> P {
        let [a, b] = segment.ends();
        let far = if a == from { b } else { a };
        self.points()[far as usize] - self.points()[from as usize]
    }

    /// Returns the cosine of the plane angle between two segments at a common corner (a vertex).
    pub fn plane_angle(&self, a: u32, b: u32, corner: u32) -> f64 {
        let [a, b] = [a, b].map(|s| self.direction(&self.segments[s as usize], corner));
        cosine(a, b)
    }

    /// Returns the directions into a facet that are perpendicular to a segment: one if the segment is on the boundary
    /// of the facet, two if it is inside.
    fn inward(&self, facet: u32, segment: u32) -> Vec<P> {
        let segment = &self.segments[segment as usize];
        let edge = [segment.chain[0], segment.chain[1]];
        let axis = self.direction(segment, segment.chain[0]);
        let axis = axis / axis.norm2().sqrt();
        let origin = self.points()[edge[0] as usize];
        let walls = self.facets[facet as usize].walls.iter().map(|&w| self.walls()[w as usize]);
        let apexes = walls.filter(|w| edge.iter().all(|v| w.as_ref().contains(v)));
        let apexes = apexes.filter_map(|w| w.as_ref().iter().copied().find(|v| !edge.contains(v)));
        apexes
            .map(|v| {
                let d = self.points()[v as usize] - origin;
                d - axis * d.dot(axis)
            })
            .collect()
    }

    /// Returns the cosine of the smallest dihedral angle between two facets at a common segment. The angle is at most
    /// 180 degrees. Returns `None` if one of the facets does not contain the segment.
    pub fn dihedral_angle(&self, a: u32, b: u32, segment: u32) -> Option<f64> {
        let (a, b) = (self.inward(a, segment), self.inward(b, segment));
        a.iter().flat_map(|&x| b.iter().map(move |&y| cosine(x, y))).max_by(f64::total_cmp)
    }

    /// Returns the segments that are ridges, in ascending order. A segment is a ridge if its number of facets is not
    /// two, or if its dihedral angle differs from 180 degrees by at least `feature_angle` (in degrees). The ridges
    /// are not joined into chains.
    pub fn ridges(&self, feature_angle: f64) -> Vec<u32> {
        let limit = -feature_angle.to_radians().cos();
        let is_ridge = |&s: &u32| match self.segments[s as usize].facets[..] {
            [a, b] => self.dihedral_angle(a, b, s).is_none_or(|c| c >= limit),
            _ => true,
        };
        (0..self.segments.len() as u32).filter(is_ridge).collect()
    }

    /// Returns all pairs of features that meet at less than `limit` degrees, in ascending order of the angle.
    pub fn small_angles(&self, limit: f64) -> Vec<SmallAngle> {
        // The cosine of 90 degrees must be exactly 0.
        let least = if limit == 90.0 { 0.0 } else { limit.to_radians().cos() } + MARGIN;
        let mut found = Vec::new();
        for (&at, segments) in &self.segments_at() {
            for (i, &a) in segments.iter().enumerate() {
                for &b in &segments[i + 1..] {
                    let features = [Feature::Segment(a), Feature::Segment(b)];
                    found.push(SmallAngle { features, at, along: None, cosine: self.plane_angle(a, b, at) });
                }
            }
        }
        self.dihedral_angles(&mut found);
        self.segments_and_facets(&mut found);
        found.retain(|s| s.cosine > least);
        found.sort_by(|a, b| {
            b.cosine.total_cmp(&a.cosine).then((a.features, a.at, a.along).cmp(&(b.features, b.at, b.along)))
        });
        found
    }

    fn dihedral_angles(&self, found: &mut Vec<SmallAngle>) {
        for (s, segment) in self.segments.iter().enumerate() {
            for (i, &a) in segment.facets.iter().enumerate() {
                for &b in &segment.facets[i + 1..] {
                    if let Some(cosine) = self.dihedral_angle(a, b, s as u32) {
                        let features = [Feature::Facet(a), Feature::Facet(b)];
                        found.push(SmallAngle {
                            features,
                            at: segment.chain[0],
                            along: Some(s as u32),
                            cosine,
                        });
                    }
                }
            }
        }
    }

    /// Adds the angles between segments and the facets that they meet in a corner.
    fn segments_and_facets(&self, found: &mut Vec<SmallAngle>) {
        let segments_at = self.segments_at();
        for (f, facet) in self.facets.iter().enumerate() {
            let own = |s: &u32| self.segments[*s as usize].facets.contains(&(f as u32));
            for &at in &facet.corners {
                for &s in segments_at.get(&at).into_iter().flatten().filter(|s| !own(s)) {
                    let direction = self.direction(&self.segments[s as usize], at);
                    if let Some(cosine) = self.angle_with_walls(&facet.walls, at, direction) {
                        let features = [Feature::Segment(s), Feature::Facet(f as u32)];
                        found.push(SmallAngle { features, at, along: None, cosine });
                    }
                }
            }
        }
    }

    /// Returns the cosine of the angle between a direction from a vertex and the plane of the walls. Returns `None` if
    /// the projection of the direction runs into none of them.
    fn angle_with_walls(&self, walls: &[u32], at: u32, direction: P) -> Option<f64> {
        let origin = self.points()[at as usize];
        walls.iter().find_map(|&wall| {
            let corners = self.walls()[wall as usize];
            let others: Vec<P> = corners
                .as_ref()
                .iter()
                .filter(|&&v| v != at)
                .map(|&v| self.points()[v as usize] - origin)
                .collect();
            let [a, b] = others[..] else { return None };
            // Least squares: direction = x a + y b + normal.
            let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
            let (da, db) = (direction.dot(a), direction.dot(b));
            let det = aa * bb - ab * ab;
            let (x, y) = ((da * bb - db * ab) / det, (db * aa - da * ab) / det);
            let shadow = a * x + b * y;
            (x >= 0.0 && y >= 0.0 && shadow.norm2() > 0.0).then(|| cosine(direction, shadow))
        })
    }
}
