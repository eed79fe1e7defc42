//! The comparison of a remeshed boundary with its surface.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::point::dist2;

use super::checker::Checker;
use super::defect::MeshDefect;
use super::findings::Deviation;
use crate::bvh::{Bounds, Bvh};
use crate::distance::closest_on_triangle;
use crate::domain::Feature;
use crate::manifold::euler;
use crate::mesh::{Carrier, OUTSIDE};
use crate::sides::Sets;
use crate::space::{Space, ascending};
use crate::sum::Sum;

/// The default limit of the deviation, relative to the largest size at the corners of a face.
pub const LOOSE: f64 = 0.5;

/// The tolerance for rounded distances, relative to the limit.
const SLACK: f64 = 1e-9;

/// The requirements for a remeshed boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follow {
    /// The feature angle in degrees. An edge is kept if the surface turns by more than this angle there.
    pub feature_angle: f64,
    /// The largest [`Deviation`], in the unit of the file. The default is [`LOOSE`] times the size at a face.
    pub distance: Option<f64>,
}

/// Triangles, with a tree for distance queries.
struct Sheet<P: Space> {
    triangles: Vec<[P; 3]>,
    tree: Bvh<P>,
}

impl<P: Space> Sheet<P> {
    fn new(triangles: Vec<[P; 3]>) -> Self {
        let tree = Bvh::new(triangles.iter().map(|t| Bounds::of(*t)).collect());
        Sheet { triangles, tree }
    }

    /// Returns the distance to the nearest triangle, and the triangle.
    fn nearest(&self, from: P) -> (f64, usize) {
        let distance = |t: u32| {
            let [a, b, c] = self.triangles[t as usize];
            dist2(closest_on_triangle(a, b, c, from), from)
        };
        let mut found = (f64::INFINITY, 0);
        self.tree.nearest(from, distance, |t, d2| {
            found = (d2.sqrt(), t as usize);
            false
        });
        found
    }
}

/// The graph of ridges, with the points of the mesh on it.
struct Ridges {
    /// The ridges at each vertex.
    at: BTreeMap<u32, Vec<u32>>,
    /// The points in the interior of each ridge segment, ordered from its first end.
    on: BTreeMap<u32, Vec<u32>>,
    /// The point of the mesh at each vertex of the domain, if there is one.
    points: BTreeMap<u32, u32>,
}

impl<P: Space> Checker<'_, P> {
    /// Checks parts 3 to 6 of the statement of [`super::check_remeshed`].
    pub(super) fn follows(&mut self, follow: &Follow) {
        self.outside();
        let edges = self.manifold();
        self.ridges(follow.feature_angle, &edges);
        self.deviates(follow.distance);
    }

    fn corners_of(&self, face: usize) -> [u32; 3] {
        let row = self.mesh.faces[face].vertices.as_ref();
        [0, 1, 2].map(|i| row[i])
    }

    /// Checks that every face has one cell and corners on the surface, and that every point on the surface has a face.
    fn outside(&mut self) {
        let mut used = vec![false; self.points.len()];
        for row in 0..self.mesh.faces.len() {
            let face = &self.mesh.faces[row];
            let (feature, inner) = (Feature::Facet(face.facet), !face.cells.contains(&OUTSIDE));
            if inner {
                self.report(MeshDefect::Inner { face: row as u32 });
            }
            for point in self.corners_of(row) {
                used[point as usize] = true;
                let carrier = self.mesh.carriers[point as usize];
                if carrier == Carrier::Volume {
                    self.report(MeshDefect::Carried {
                        what: "face",
                        row: row as u32,
                        feature,
                        point,
                        carrier,
                    });
                }
            }
        }
        for (point, &carrier) in self.mesh.carriers.iter().enumerate() {
            if carrier != Carrier::Volume && !used[point] {
                self.report(MeshDefect::Unused { point: point as u32, what: "face", carrier });
            }
        }
    }

    /// Checks that every edge of the boundary has two faces and that the faces at every vertex form one fan. Returns
    /// the edges, ascending.
    fn manifold(&mut self) -> BTreeSet<[u32; 2]> {
        let mut faces_at: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        let mut around: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
        for row in 0..self.mesh.faces.len() {
            let [a, b, c] = self.corners_of(row);
            for (edge, apex) in [([a, b], c), ([b, c], a), ([c, a], b)] {
                *faces_at.entry(ascending(edge)).or_default() += 1;
                around.entry(apex).or_default().push(edge);
            }
        }
        for (edge, &faces) in faces_at.iter().filter(|(_, faces)| **faces != 2) {
            self.report(MeshDefect::Pinched { vertices: edge.to_vec(), faces });
        }
        for (&vertex, link) in &around {
            let mut ends: Vec<u32> = link.iter().flatten().copied().collect();
            ends.sort_unstable();
            ends.dedup();
            let place = |v: u32| ends.binary_search(&v).unwrap_or_default() as u32;
            let mut fans = Sets::new(ends.len());
            for &[a, b] in link {
                fans.join(place(a), place(b));
            }
            if (1..ends.len() as u32).any(|i| fans.find(i) != fans.find(0)) {
                self.report(MeshDefect::Pinched { vertices: vec![vertex], faces: link.len() });
            }
        }
        faces_at.into_keys().collect()
    }

    /// Checks that the listed edges connect consecutive points along all ridges and are edges of the boundary.
    fn ridges(&mut self, feature_angle: f64, boundary: &BTreeSet<[u32; 2]>) {
        let ridges = self.points_on_ridges(feature_angle);
        let mut expected: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut covered = BTreeSet::new();
        for (&segment, on) in &ridges.on {
            let [a, b] = self.domain.segments[segment as usize].ends();
            let listed = ridges.points.get(&a).into_iter().chain(on).chain(ridges.points.get(&b));
            let listed: Vec<u32> = listed.copied().collect();
            expected.extend(listed.windows(2).map(|w| (ascending([w[0], w[1]]), segment)));
            let (Some(&first), Some(&last)) = (listed.first(), listed.last()) else { continue };
            covered.insert(segment);
            for (end, from) in [(a, first), (b, last)] {
                if let Some(to) = self.beyond(&ridges, segment, end, &mut covered) {
                    expected.insert(ascending([from, to]), segment);
                }
            }
        }
        let listed: BTreeSet<[u32; 2]> = self.mesh.edges.iter().map(|e| ascending(e.vertices)).collect();
        for (edge, &segment) in expected.iter().filter(|(e, _)| !listed.contains(*e)) {
            self.report(MeshDefect::Chain { segment, at: Some(edge[0]) });
        }
        for &segment in ridges.on.keys().filter(|s| !covered.contains(*s)) {
            self.report(MeshDefect::Chain { segment, at: None });
        }
        for (row, edge) in self.mesh.edges.iter().enumerate() {
            let edge = ascending(edge.vertices);
            if !expected.contains_key(&edge) || !boundary.contains(&edge) {
                self.report(MeshDefect::LooseEdge { edge: row as u32 });
            }
        }
    }

    /// Collects the points on ridges. Checks that there is a point wherever ridges meet or end.
    fn points_on_ridges(&mut self, feature_angle: f64) -> Ridges {
        let mut ridges = Ridges { at: BTreeMap::new(), on: BTreeMap::new(), points: BTreeMap::new() };
        for s in self.domain.ridges(feature_angle) {
            let ends = self.domain.segments[s as usize].ends();
            for v in ends {
                ridges.at.entry(v).or_default().push(s);
            }
            ridges.on.insert(s, Vec::new());
        }
        for (point, &carrier) in (0u32..).zip(&self.mesh.carriers) {
            let on = match carrier {
                Carrier::Corner(c) => {
                    ridges.points.insert(self.domain.corners[c as usize], point);
                    continue;
                }
                Carrier::Segment(s) => ridges.on.get_mut(&s),
                _ => continue,
            };
            match on {
                Some(on) => on.push(point),
                None => self.found.defects.push(MeshDefect::Unused { point, what: "ridge", carrier }),
            }
        }
        for (&s, on) in &mut ridges.on {
            let [a, b] = self.domain.segments[s as usize].ends().map(|v| self.domain.points()[v as usize]);
            let along = |v: u32| (self.points[v as usize] - a).dot(b - a);
            on.sort_by(|&v, &w| along(v).total_cmp(&along(w)).then(v.cmp(&w)));
        }
        for v in ridges.at.iter().filter(|(_, ridges)| ridges.len() != 2).map(|(&v, _)| v) {
            if let (Ok(corner), None) = (self.domain.corners.binary_search(&v), ridges.points.get(&v)) {
                self.report(MeshDefect::Corner { corner: corner as u32, count: 0 });
            }
        }
        ridges
    }

    /// Follows the ridges beyond one end of a segment, and returns the next point. Returns `None` if that end has a
    /// point, or if there is no next point.
    fn beyond(&self, ridges: &Ridges, segment: u32, end: u32, covered: &mut BTreeSet<u32>) -> Option<u32> {
        let (mut from, mut v) = (segment, end);
        while !ridges.points.contains_key(&v) {
            let next = ridges.at[&v].iter().copied().find(|&s| s != from)?;
            if next == segment {
                return None;
            }
            covered.insert(next);
            let [a, b] = self.domain.segments[next as usize].ends();
            let on = &ridges.on[&next];
            if let Some(&point) = if v == a { on.first() } else { on.last() } {
                return Some(point);
            }
            (from, v) = (next, if v == a { b } else { a });
        }
        // If the given end has a point, the segment ends there.
        if v == end { None } else { ridges.points.get(&v).copied() }
    }

    /// Checks the distances between boundary and surface.
    fn deviates(&mut self, distance: Option<f64>) {
        let corners = |row| self.corners_of(row).map(|v| self.points[v as usize]);
        let faces = Sheet::new((0..self.mesh.faces.len()).map(corners).collect());
        let size = |row: usize| {
            let sizes = self.corners_of(row).map(|v| self.mesh.sizes[v as usize]);
            distance.unwrap_or(LOOSE * sizes[0].max(sizes[1]).max(sizes[2])) * (1.0 + SLACK)
        };
        let rows = self.domain.triangles();
        let euler =
            [euler((0..self.mesh.faces.len()).map(|row| self.corners_of(row))), euler(rows.iter().copied())];
        let surface = Sheet::new(rows.iter().map(|w| w.map(|v| self.domain.points()[v as usize])).collect());
        let mut found = Deviation { finer: self.finer(), euler, ..Deviation::default() };
        let mut astray = Vec::new();
        for (row, &[a, b, c]) in faces.triangles.iter().enumerate() {
            let thirds = [[a, b], [b, c], [c, a]].map(|[p, q]| [(p * 2.0 + q) / 3.0, (p + q * 2.0) / 3.0]);
            let places = thirds.into_iter().flatten().chain([(a + b + c) / 3.0]);
            let distance = self.unscaled(places.map(|p| surface.nearest(p).0).fold(0.0, f64::max), 1);
            found.of_boundary = found.of_boundary.max(distance);
            if distance > size(row) {
                astray.push(MeshDefect::Astray {
                    what: "face",
                    row: row as u32,
                    distance,
                    allowed: size(row),
                });
            }
        }
        let used: BTreeSet<u32> = rows.into_iter().flatten().collect();
        for v in used.into_iter().filter(|_| !faces.triangles.is_empty()) {
            let (distance, row) = faces.nearest(self.domain.points()[v as usize]);
            let distance = self.unscaled(distance, 1);
            found.of_surface = found.of_surface.max(distance);
            if distance > size(row) {
                astray.push(MeshDefect::Astray { what: "vertex", row: v, distance, allowed: size(row) });
            }
        }
        self.found.defects.extend(astray);
        self.found.deviation = Some(found);
    }

    fn finer(&self) -> u64 {
        let edges: BTreeSet<[u32; 2]> = (0..self.mesh.faces.len())
            .map(|row| self.corners_of(row))
            .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]].map(ascending))
            .collect();
        let is_finer = |e: &&[u32; 2]| {
            let [p, q] = e.map(|v| self.mesh.points[v as usize]);
            let sizes = e.map(|v| self.mesh.sizes[v as usize]);
            4.0 * dist2(p, q) < sizes[0].min(sizes[1]).powi(2)
        };
        edges.iter().filter(is_finer).count() as u64
    }

    /// Checks that every component inside the domain has cells.
    pub(super) fn has_cells(&mut self, sums: &[Sum]) {
        for (component, sum) in sums.iter().enumerate() {
            let of = &self.domain.components[component];
            if of.inside && sum.value() <= 0.0 {
                let [expected, found] = [of.measure, sum.value()].map(|x| self.unscaled(x, P::DIM));
                self.report(MeshDefect::Volume { component: component as u32, expected, found });
            }
        }
    }
}
