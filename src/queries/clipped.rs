//! The Voronoi diagram in a box: its vertices, its ridges, and the faces on the sides of the box.
//!
//! **Statement.** The part of a Voronoi cell in a box is convex. Each of its faces lies in the bisector to a neighbour, or on a side of the
//! box. A corner is the common point of the planes of the faces around it. Its *label* is the site with their neighbours and
//! sides, sorted. All cells at a corner give it the same label, by which their corners become one vertex. If more planes meet at a
//! point than the dimension requires, it may have several labels, and is then several vertices.
//!
//! **Method.** As in `clip`, half-spaces cut the cell one after the other. Each edge knows the face on its other side, so the edges of a
//! new face are joined by their neighbours, and not by their coordinates.
//!
//! **Work.** O(k f) for a vertex with k neighbours and f edges of its cell, and O(r log r) for r corners.

use glam::{DVec2, DVec3};

use crate::clip::Heights;
use crate::dimension::Dimension;
use crate::error::QueryError;
use crate::loops;
use crate::ragged::Ragged;
use crate::seen::Seen;
use crate::tessellation::{NONE, Tessellation};

/// Returns the entry of ridges that stands for a side of the box: 0 for the lower side of the first axis, 1 for its upper side, and so on.
/// Read as a signed number, it is `-1 - side`.
pub const fn side(side: usize) -> u32 {
    u32::MAX - side as u32
}

/// An entry of labels in the plane, which no point and no side has.
const NOTHING: u32 = u32::MAX - 6;

/// The Voronoi diagram in a box.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Clipped<P> {
    /// The corners of the parts of all cells in the box.
    pub vertices: Vec<P>,
    /// The two vertices of the triangulation of each ridge, smaller first, or a side of the box ([`side`]) and the vertex of the cell there.
    /// Sorted as signed numbers, so that sides come first.
    pub points: Vec<[u32; 2]>,
    /// The corners of each ridge, in order around it, as positions in [`Clipped::vertices`].
    pub corners: Ragged,
    /// The length or area of each ridge.
    pub areas: Vec<f64>,
}

/// The label of a corner.
type Label = [u32; 4];

/// A face of a cell, with its corners relative to the site.
struct Part<P> {
    side: u32,
    area: f64,
    corners: Vec<(Label, P)>,
}

/// The faces of some cells.
struct Found<P> {
    points: Vec<[u32; 2]>,
    areas: Vec<f64>,
    lengths: Vec<usize>,
    corners: Vec<(Label, P)>,
}

impl<P: Dimension> Tessellation<P> {
    /// Returns the Voronoi diagram in a box.
    ///
    /// # Errors
    /// Fails if the points do not span the space, if the box is empty, or if a vertex lies outside of it.
    pub fn voronoi_in(&self, low: P, high: P) -> Result<Clipped<P>, QueryError> {
        // The volumes check the points and the box.
        self.voronoi_volumes_in(low, high)?;
        let [low, high] = [low, high].map(|p| septet_geometry::range::scale(p, self.exponent));
        let blocks = loops::blocks(self.points.len(), |block| {
            let mut star = Seen::default();
            let mut found = Found { points: vec![], areas: vec![], lengths: vec![], corners: vec![] };
            for v in block.filter(|&v| self.vertex_cell[v] != NONE) {
                self.add_cell(v as u32, [low, high], &mut star, &mut found);
            }
            found
        });
        let mut all = Found { points: vec![], areas: vec![], lengths: vec![], corners: vec![] };
        for block in blocks {
            all.points.extend(block.points);
            all.areas.extend(block.areas);
            all.lengths.extend(block.lengths);
            all.corners.extend(block.corners);
        }
        Ok(all.joined())
    }

    /// Adds the faces of a cell on sides of the box, and those to larger vertices.
    fn add_cell(&self, v: u32, [low, high]: [P; 2], star: &mut Seen, found: &mut Found<P>) {
        self.star(v, star);
        let site = self.points[v as usize];
        let mut around: Vec<u32> = self.vertices_of(star.list()).filter(|&w| w != v).collect();
        around.sort_unstable();
        around.dedup();
        // Near bisectors first: most of the far ones then cut nothing.
        let mut planes: Vec<(f64, u32)> =
            around.iter().map(|&w| ((self.points[w as usize] - site).norm2().sqrt(), w)).collect();
        planes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let planes: Vec<(P, f64, u32)> = planes
            .iter()
            .map(|&(length, w)| ((self.points[w as usize] - site) / length, length / 2.0, w))
            .collect();
        for part in parts(v, [low - site, high - site], &planes) {
            let is_side = part.side > NOTHING;
            if !is_side && part.side < v {
                continue;
            }
            found.points.push(if is_side { [part.side, v] } else { [v, part.side] });
            found.areas.push(self.unscaled(part.area, P::DIM as i32 - 1));
            found.lengths.push(part.corners.len());
            for (label, at) in part.corners {
                let mut place = at + site;
                (0..P::DIM).for_each(|i| place.set_coord(i, self.unscaled(place.coord(i), 1)));
                found.corners.push((label, place));
            }
        }
    }
}

impl<P: Dimension> Found<P> {
    /// Joins corners of equal labels, and sorts the ridges.
    fn joined(self) -> Clipped<P> {
        let mut labels: Vec<(Label, usize)> =
            self.corners.iter().enumerate().map(|(at, corner)| (corner.0, at)).collect();
        labels.sort_unstable();
        let mut vertices = Vec::new();
        let mut ids = vec![0; self.corners.len()];
        for (i, &(label, at)) in labels.iter().enumerate() {
            if i == 0 || labels[i - 1].0 != label {
                vertices.push(self.corners[at].1);
            }
            ids[at] = vertices.len() as u32 - 1;
        }
        let mut starts = Vec::with_capacity(self.lengths.len());
        let mut start = 0;
        for &length in &self.lengths {
            starts.push(start);
            start += length;
        }
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        order.sort_unstable_by_key(|&ridge| self.points[ridge].map(u32::cast_signed));
        let mut corners = Ragged::default();
        for &ridge in &order {
            corners.push(&ids[starts[ridge]..starts[ridge] + self.lengths[ridge]]);
        }
        Clipped {
            vertices,
            points: order.iter().map(|&ridge| self.points[ridge]).collect(),
            corners,
            areas: order.iter().map(|&ridge| self.areas[ridge]).collect(),
        }
    }
}

/// Returns the faces of the part of a box in which `n . x <= c` for each `(n, c, side)`. The origin lies in it.
fn parts<P: Dimension>(v: u32, corners: [P; 2], planes: &[(P, f64, u32)]) -> Vec<Part<P>> {
    let at = |p: P| DVec3::new(p.coord(0), p.coord(1), if P::DIM == 2 { 0.0 } else { p.coord(2) });
    let back = |x: DVec3| {
        let mut p = P::default();
        (0..P::DIM).for_each(|i| p.set_coord(i, x[i]));
        p
    };
    let [low, high] = corners.map(at);
    let finish = |(side, area, corners): (u32, f64, Vec<(Label, DVec3)>)| {
        let corners = corners.into_iter().map(|(label, x)| (label, back(x))).collect();
        Part { side, area, corners }
    };
    if P::DIM == 2 {
        let mut polygon = Polygon::of_box(low.truncate(), high.truncate());
        for &(n, c, side) in planes {
            polygon.cut(at(n).truncate(), c, side);
        }
        return polygon.parts(v).into_iter().map(finish).collect();
    }
    let mut body = Body::of_box([low, high]);
    for &(n, c, side) in planes {
        body.cut(at(n), c, side);
    }
    body.parts(v).into_iter().map(finish).collect()
}

/// A side, its length or area, and its corners.
type Measured = (u32, f64, Vec<(Label, DVec3)>);

/// Returns the label of a corner.
fn label(mut of: Label) -> Label {
    of.sort_unstable();
    of
}

/// A convex polygon: its corners in order, each with the side that starts at it.
struct Polygon(Vec<(DVec2, u32)>);

impl Polygon {
    fn of_box(low: DVec2, high: DVec2) -> Self {
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        Polygon(corners.into_iter().zip([2, 1, 3, 0].map(side)).collect())
    }

    fn cut(&mut self, n: DVec2, c: f64, side: u32) {
        let Some(heights) = Heights::of(n, c, self.0.iter().map(|corner| corner.0)) else { return };
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

    fn parts(&self, v: u32) -> Vec<Measured> {
        let n = self.0.len();
        let corner = |i: usize| {
            let (x, side) = self.0[i % n];
            (label([v, self.0[(i + n - 1) % n].1, side, NOTHING]), x.extend(0.0))
        };
        let edge = |i: usize| {
            let ends = vec![corner(i), corner(i + 1)];
            (self.0[i].1, self.0[i].0.distance(self.0[(i + 1) % n].0), ends)
        };
        (0..n).map(edge).collect()
    }
}

/// A face of a polyhedron: its side, and its corners counter-clockwise from outside, each with the side across the edge that
/// starts at it.
struct Face {
    side: u32,
    corners: Vec<(DVec3, u32)>,
}

/// A convex polyhedron.
struct Body(Vec<Face>);

impl Body {
    fn of_box(ends: [DVec3; 2]) -> Self {
        let at = |i: usize| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z);
        // The faces of the sides 0 to 5.
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let across = |own: usize, a: usize, b: usize| {
            let other = |(other, face): (usize, &[usize; 4])| {
                (other != own && face.contains(&a) && face.contains(&b)).then(|| side(other))
            };
            faces.iter().enumerate().find_map(other).unwrap_or(NONE)
        };
        let face = |own: usize| {
            let corner = |i: usize| (at(faces[own][i]), across(own, faces[own][i], faces[own][(i + 1) % 4]));
            Face { side: side(own), corners: (0..4).map(corner).collect() }
        };
        Body((0..6).map(face).collect())
    }

    /// Keeps the part with `n . x <= c`.
    fn cut(&mut self, n: DVec3, c: f64, side: u32) {
        let corners = self.0.iter().flat_map(|face| face.corners.iter().map(|corner| corner.0));
        let Some(heights) = Heights::of(n, c, corners) else { return };
        // Of each face that is cut: its side, the point at which its boundary comes back below the plane, and the side across the
        // edge on which it rises above the plane.
        let mut crossed: Vec<(u32, DVec3, u32)> = Vec::new();
        for face in &mut self.0 {
            let mut kept = Vec::with_capacity(face.corners.len() + 1);
            let (mut back, mut rise) = (None, None);
            for (i, &(a, next)) in face.corners.iter().enumerate() {
                let b = face.corners[(i + 1) % face.corners.len()].0;
                match (heights.is_above(a), heights.is_above(b)) {
                    (false, false) => kept.push((a, next)),
                    (false, true) => {
                        kept.extend([(a, next), (heights.crossing(a, b), side)]);
                        rise = Some(next);
                    }
                    (true, false) => {
                        let x = heights.crossing(b, a);
                        kept.push((x, next));
                        back = Some(x);
                    }
                    (true, true) => {}
                }
            }
            face.corners = kept;
            crossed.extend(back.zip(rise).map(|(back, rise)| (face.side, back, rise)));
        }
        self.0.retain(|face| !face.corners.is_empty());
        let mut corners = Vec::with_capacity(crossed.len());
        let mut at = crossed.first().copied();
        while let Some((of, back, rise)) = at.filter(|_| corners.len() < crossed.len()) {
            corners.push((back, of));
            at = crossed.iter().find(|face| face.0 == rise).copied();
        }
        if !corners.is_empty() {
            self.0.push(Face { side, corners });
        }
    }

    fn parts(&self, v: u32) -> Vec<Measured> {
        let part = |face: &Face| {
            let corners = &face.corners;
            let n = corners.len();
            let fan = corners.windows(2).skip(1);
            let first = corners[0].0;
            let twice: DVec3 = fan.map(|edge| (edge[0].0 - first).cross(edge[1].0 - first)).sum();
            let labelled = (0..n).map(|i| {
                let (x, next) = corners[i];
                (label([v, face.side, corners[(i + n - 1) % n].1, next]), x)
            });
            (face.side, twice.length() / 2.0, labelled.collect())
        };
        self.0.iter().map(part).collect()
    }
}
