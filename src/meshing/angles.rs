//! Angles between features, and where they are small.
//!
//! **Statement.** Where two features meet in a corner or along a segment, and neither holds the other, their angle
//! is the smallest one between a direction into the one and a direction into the other. For two facets
//! along a segment it is their dihedral angle; for two segments the plane angle; for a segment and a facet the angle
//! with the facet's plane, if the segment's projection runs into the facet (if not, the smallest angle is one with a
//! segment of the facet). Two facets that meet in a corner only have no smaller angle than one of those.
//!
//! **Work and depth.** All pairs at each corner and segment.
//!
//! Angles are rounded. They are compared by their cosines, which need square roots alone; degrees are for reports.

use septet_geometry::point::Point;

use crate::domain::{Domain, Feature, Segment};
use crate::space::Space;

/// A place where two features meet at a small angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallAngle {
    /// The features.
    pub features: [Feature; 2],
    /// The corner where they meet (for facets: the first end of their segment), a vertex.
    pub at: u32,
    /// The segment along which two facets meet.
    pub along: Option<u32>,
    /// Cosine of the angle.
    pub cosine: f64,
}

impl SmallAngle {
    /// The angle in degrees.
    pub fn degrees(&self) -> f64 {
        self.cosine.clamp(-1.0, 1.0).acos().to_degrees()
    }
}

/// How far below the limit an angle has to be, as a difference of cosines: rounded coordinates of a slanted box do
/// not make its right angles small.
const MARGIN: f64 = 1e-9;

/// The cosine of the angle between two vectors.
pub fn cosine<P: Point>(a: P, b: P) -> f64 {
    a.dot(b) / (a.norm2().sqrt() * b.norm2().sqrt())
}

impl<P: Space> Domain<P> {
    fn direction(&self, segment: &Segment, from: u32) -> P {
        let [a, b] = segment.ends();
        let far = if a == from { b } else { a };
        self.points()[far as usize] - self.points()[from as usize]
    }

    /// The cosine of the plane angle between two segments at a common corner (a vertex).
    pub fn plane_angle(&self, a: u32, b: u32, corner: u32) -> f64 {
        let [a, b] = [a, b].map(|s| self.direction(&self.segments[s as usize], corner));
        cosine(a, b)
    }

    /// The directions into a facet perpendicular to a segment: one on the boundary, two inside.
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

    /// The cosine of the smallest dihedral angle, at most 180 degrees, between two facets at a common segment.
    /// `None` if one of them does not hold the segment.
    pub fn dihedral_angle(&self, a: u32, b: u32, segment: u32) -> Option<f64> {
        let (a, b) = (self.inward(a, segment), self.inward(b, segment));
        a.iter().flat_map(|&x| b.iter().map(move |&y| cosine(x, y))).max_by(f64::total_cmp)
    }

    /// The segments that are ridges: with one facet or more than two, or with two whose dihedral angle differs
    /// from 180 degrees by at least `feature_angle` (degrees). Ascending. Marks only: nothing is joined.
    pub fn ridges(&self, feature_angle: f64) -> Vec<u32> {
        let limit = -feature_angle.to_radians().cos();
        let is_ridge = |&s: &u32| match self.segments[s as usize].facets[..] {
            [a, b] => self.dihedral_angle(a, b, s).is_none_or(|c| c >= limit),
            _ => true,
        };
        (0..self.segments.len() as u32).filter(is_ridge).collect()
    }

    /// All places where features meet at less than `limit` degrees, the smallest angle first.
    pub fn small_angles(&self, limit: f64) -> Vec<SmallAngle> {
        // The cosine of 90 degrees is 0, without rounding.
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

    /// Segments against the facets that they meet in a corner.
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

    /// The cosine of the angle between a direction from a vertex and the plane of those walls, if the projection
    /// runs into one of them.
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
