//! Convex cells as intersections of a box and half-spaces.
//!
//! **Statement.** The part of a box nearer to a site than to other sites is the intersection of the box with a half-space for
//! each of them. The faces of the cell in space are polygons, each in the plane of one half-space or side of the box.
//!
//! **Method.** Half-spaces cut the cell one after the other (Sutherland and Hodgman 1974). Each new face of a polyhedron is the convex
//! polygon of the points where edges cross its plane, sorted by their directions from its middle.
//!
//! **Work.** O(k f) for k half-spaces and f edges of the cell.
//!
//! **Rounding.** All values are rounded. A corner that lies above a plane by no more than the rounding of its height counts as a corner on
//! the plane. Otherwise, a plane through a face would divide the face by noise. Both copies of an edge are cut at the same point.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use septet_geometry::point::Point;

/// The measures of a convex cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measures {
    /// The area or volume.
    pub(crate) volume: f64,
    /// The integral of the place over the cell. In the plane, the third coordinate is 0.
    pub(crate) moment: DVec3,
    /// The length or area of the face in the plane of each half-space.
    pub(crate) faces: Vec<f64>,
}

/// Measures the part of the box from `low` to `high` in which `n . x <= c` for each pair `(n, c)`. The normals have length 1.
pub(crate) fn measure<P: Point>(low: P, high: P, planes: &[(P, f64)]) -> Measures {
    if P::DIM == 2 {
        polygon(low, high, planes).measures(planes.len())
    } else {
        body(low, high, planes).measures(planes.len())
    }
}

/// The corners of a convex cell, and in space its faces.
pub(crate) struct Shape {
    /// In the plane, counter-clockwise, with 0 as the third coordinate. In space, each once.
    pub(crate) corners: Vec<DVec3>,
    /// The corners of each face, counter-clockwise from outside. None in the plane.
    pub(crate) faces: Vec<Vec<u32>>,
}

/// Returns the cell that [`measure`] measures. It has no corners if it is empty.
pub(crate) fn shape<P: Point>(low: P, high: P, planes: &[(P, f64)]) -> Shape {
    if P::DIM == 2 {
        let corners =
            polygon(low, high, planes).0.into_iter().map(|(corner, _)| corner.extend(0.0)).collect();
        return Shape { corners, faces: Vec::new() };
    }
    let (mut corners, mut numbers) = (Vec::new(), BTreeMap::new());
    // Both copies of a corner have the same bits, but for the signs of zeros.
    let mut number = |corner: &DVec3| {
        *numbers.entry((*corner + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert_with(|| {
            corners.push(*corner);
            corners.len() as u32 - 1
        })
    };
    let mut faces = Vec::new();
    for face in body(low, high, planes).0 {
        let mut face: Vec<u32> = face.corners.iter().map(&mut number).collect();
        face.dedup();
        if face.first() == face.last() {
            face.pop();
        }
        if face.len() > 2 {
            faces.push(face);
        }
    }
    Shape { corners, faces }
}

/// Returns the coordinates of a point; the third is 0 in the plane.
fn at<P: Point>(p: &P) -> DVec3 {
    DVec3::new(p.coord(0), p.coord(1), if P::DIM == 2 { 0.0 } else { p.coord(2) })
}

fn polygon<P: Point>(low: P, high: P, planes: &[(P, f64)]) -> Polygon {
    let mut polygon = Polygon::of_box(at(&low).truncate(), at(&high).truncate());
    for (side, (n, c)) in planes.iter().enumerate() {
        polygon.cut(at(n).truncate(), *c, Some(side));
    }
    polygon
}

fn body<P: Point>(low: P, high: P, planes: &[(P, f64)]) -> Body {
    let mut body = Body::of_box(at(&low), at(&high));
    for (side, (n, c)) in planes.iter().enumerate() {
        body.cut(at(n), *c, Some(side));
    }
    body
}

/// The heights of corners above a plane.
pub(crate) struct Heights<P> {
    normal: P,
    level: f64,
    /// The largest error of a height.
    error: f64,
}

impl<P: Point> Heights<P> {
    /// Returns `None` if no corner lies above the plane.
    pub(crate) fn of(normal: P, level: f64, corners: impl Iterator<Item = P> + Clone) -> Option<Self> {
        let largest =
            corners.clone().map(septet_geometry::point::Vector::norm2).fold(level * level, f64::max).sqrt();
        let heights = Heights { normal, level, error: 16.0 * f64::EPSILON * largest };
        let mut corners = corners;
        corners.any(|x| heights.is_above(x)).then_some(heights)
    }

    pub(crate) fn is_above(&self, x: P) -> bool {
        self.normal.dot(x) - self.level > self.error
    }

    /// Returns the point of the plane between a corner that is not above it and one that is.
    pub(crate) fn crossing(&self, low: P, high: P) -> P {
        let [below, above] = [low, high].map(|x| self.normal.dot(x) - self.level);
        let below = below.min(0.0);
        low + (high - low) * (below / (below - above))
    }
}

/// A convex polygon: its corners in order, each with the side that starts at it.
struct Polygon(Vec<(DVec2, Option<usize>)>);

impl Polygon {
    fn of_box(low: DVec2, high: DVec2) -> Self {
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        Polygon(corners.map(|corner| (corner, None)).to_vec())
    }

    /// Keeps the part with `n . x <= c`.
    fn cut(&mut self, n: DVec2, c: f64, side: Option<usize>) {
        let heights = Heights::of(n, c, self.0.iter().map(|corner| corner.0));
        let Some(heights) = heights else { return };
        let mut kept = Vec::with_capacity(self.0.len() + 1);
        for (i, &(a, own)) in self.0.iter().enumerate() {
            let b = self.0[(i + 1) % self.0.len()].0;
            match (heights.is_above(a), heights.is_above(b)) {
                (false, false) => kept.push((a, own)),
                (false, true) => kept.extend([(a, own), (heights.crossing(a, b), side)]),
                (true, false) => kept.push((heights.crossing(b, a), own)),
                (true, true) => {}
            }
        }
        self.0 = kept;
    }

    fn measures(&self, sides: usize) -> Measures {
        let mut measures = Measures { faces: vec![0.0; sides], ..Measures::default() };
        for (i, &(a, side)) in self.0.iter().enumerate() {
            let b = self.0[(i + 1) % self.0.len()].0;
            let area = a.perp_dot(b) / 2.0;
            measures.volume += area;
            measures.moment += ((a + b) * (area / 3.0)).extend(0.0);
            if let Some(side) = side {
                measures.faces[side] += a.distance(b);
            }
        }
        measures
    }
}

/// A face of a polyhedron: its corners, counter-clockwise from outside, and the half-space in whose plane it lies.
struct Face {
    corners: Vec<DVec3>,
    side: Option<usize>,
}

/// A convex polyhedron.
struct Body(Vec<Face>);

impl Body {
    fn of_box(low: DVec3, high: DVec3) -> Self {
        let ends = [low, high];
        let at = |i: usize| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Body(faces.map(|face| Face { corners: face.map(at).to_vec(), side: None }).into())
    }

    /// Keeps the part with `n . x <= c`.
    fn cut(&mut self, n: DVec3, c: f64, side: Option<usize>) {
        let heights = Heights::of(n, c, self.0.iter().flat_map(|face| face.corners.iter().copied()));
        let Some(heights) = heights else { return };
        let mut cap: Vec<DVec3> = Vec::new();
        for face in &mut self.0 {
            let mut kept = Vec::with_capacity(face.corners.len() + 1);
            for (i, &a) in face.corners.iter().enumerate() {
                let b = face.corners[(i + 1) % face.corners.len()];
                let above = [heights.is_above(a), heights.is_above(b)];
                if !above[0] {
                    kept.push(a);
                }
                if above[0] != above[1] {
                    let x = if above[1] { heights.crossing(a, b) } else { heights.crossing(b, a) };
                    kept.push(x);
                    cap.push(x);
                }
            }
            face.corners = kept;
        }
        self.0.retain(|face| face.corners.len() > 2);
        if cap.len() > 2 {
            around(n, &mut cap);
            self.0.push(Face { corners: cap, side });
        }
    }

    fn measures(&self, sides: usize) -> Measures {
        let mut measures = Measures { faces: vec![0.0; sides], ..Measures::default() };
        for Face { corners, side } in &self.0 {
            let mut twice = DVec3::ZERO;
            for edge in corners.windows(2).skip(1) {
                let normal = (edge[0] - corners[0]).cross(edge[1] - corners[0]);
                let volume = corners[0].dot(normal) / 6.0;
                measures.volume += volume;
                measures.moment += (corners[0] + edge[0] + edge[1]) * (volume / 4.0);
                twice += normal;
            }
            if let Some(side) = *side {
                measures.faces[side] += twice.length() / 2.0;
            }
        }
        measures
    }
}

/// Sorts points of a plane counter-clockwise around their middle, as seen from the tip of the normal `n`.
fn around(n: DVec3, points: &mut [DVec3]) {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let u = n.any_orthonormal_vector();
    let v = n.cross(u);
    // Grows with the angle, from -2 to 2.
    let turn = |p: &DVec3| {
        let (x, y) = ((*p - middle).dot(u), (*p - middle).dot(v));
        let slope = x / (x.abs() + y.abs());
        if y < 0.0 { slope - 1.0 } else { 1.0 - slope }
    };
    points.sort_unstable_by(|a, b| turn(a).total_cmp(&turn(b)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_corner_has_the_measures_of_a_simplex() {
        let n = DVec3::ONE.normalize();
        let cut = measure(-DVec3::ONE, DVec3::ONE, &[(n, 2.0 / 3f64.sqrt()), (DVec3::X, 5.0)]);
        // The corner above `x + y + z = 2` is a tetrahedron with legs of length 1.
        assert!((cut.volume - (8.0 - 1.0 / 6.0)).abs() < 1e-14);
        // Its centroid is a quarter of a leg below the corner, on each axis.
        assert!((cut.moment + DVec3::splat(0.75 / 6.0)).length() < 1e-14);
        assert!((cut.faces[0] - 3f64.sqrt() / 2.0).abs() < 1e-14 && cut.faces[1] == 0.0);
        let cut = measure(-DVec2::ONE, DVec2::ONE, &[(DVec2::ONE.normalize(), 0.5f64.sqrt())]);
        assert!((cut.volume - 3.5).abs() < 1e-14 && (cut.faces[0] - 2f64.sqrt()).abs() < 1e-14);
    }
}
