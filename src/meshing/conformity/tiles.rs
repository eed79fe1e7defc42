//! The checks that edges tile segments and that faces tile facets.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use septet_geometry::point::Point;
use septet_geometry::predicates::{Sign, orientation};

use super::checker::{Checker, OFF, off};
use super::defect::{MeshDefect, SideComponent};
use crate::domain::Feature;
use crate::mesh::{Carrier, Face, OUTSIDE};
use crate::space::{Space, ascending};
use crate::sum::Sum;

/// Measures of the domain and the mesh, by the components on the two sides, ascending.
type Measures = BTreeMap<[SideComponent; 2], [Sum; 2]>;

/// Returns the length of an edge or the area of a triangle. The normal of an edge has the same length as the edge,
/// and the length of the normal of a triangle is twice the area.
fn extent<P: Point>(corners: &[P]) -> f64 {
    let rel: Vec<P> = corners[1..].iter().map(|&c| c - corners[0]).collect();
    P::hull_normal(&rel).norm2().sqrt() / if P::DIM == 2 { 1.0 } else { 2.0 }
}

fn space<P: Point>(p: P) -> DVec3 {
    DVec3::new(p.coord(0), p.coord(1), p.coord(2))
}

/// Drops one coordinate of a point in space.
fn flat(p: DVec3, axis: usize) -> DVec2 {
    match axis {
        0 => DVec2::new(p.y, p.z),
        1 => DVec2::new(p.z, p.x),
        _ => DVec2::new(p.x, p.y),
    }
}

impl<P: Space> Checker<'_, P> {
    /// Adds up the outer boundaries of the domain and of the mesh.
    pub(super) fn boundaries(&mut self) {
        let mut sums = [Sum::default(); 2];
        for wall in 0..self.domain.walls().len() as u32 {
            if self.components_at_wall(wall).contains(&None) && self.domain.bounds_inside(wall) {
                sums[0].add(self.wall_extent(wall));
            }
        }
        for face in self.mesh.faces.iter().filter(|f| f.cells.contains(&OUTSIDE)) {
            sums[1].add(extent(&P::corners(&self.points, &face.vertices)));
        }
        self.found.boundary = sums.map(|s| self.unscaled(s.value(), P::DIM - 1));
    }

    /// Checks part 6: corners and carriers. No corner may have two points. If `all` is set, every corner must have a
    /// point.
    pub(super) fn carriers(&mut self, all: bool) {
        let mut at_corner = vec![0; self.domain.corners.len()];
        let largest = self.domain.points().iter().flat_map(|p| (0..P::DIM).map(|i| p.coord(i).abs()));
        let allowed = OFF * largest.fold(0.0, f64::max) + self.step();
        let planes: Vec<[DVec3; 2]> = (0..self.domain.facets.len()).map(|f| self.plane(f)).collect();
        for (i, &carrier) in self.mesh.carriers.iter().enumerate() {
            let (point, p) = (i as u32, self.points[i]);
            let distance = match carrier {
                Carrier::Volume => continue,
                Carrier::Corner(c) => {
                    at_corner[c as usize] += 1;
                    let due = self.domain.points()[self.domain.corners[c as usize] as usize];
                    // Corners must equal the points of the input bit for bit.
                    if p == due { 0.0 } else { (p - due).norm2().sqrt().max(2.0 * allowed) }
                }
                Carrier::Segment(s) => self.off_segment(s, p),
                Carrier::Facet(f) => (space(p) - planes[f as usize][0]).dot(planes[f as usize][1]).abs(),
            };
            if distance > allowed || distance.is_nan() {
                let (distance, feature) = (self.unscaled(distance, 1), carrier.feature());
                if let Some(feature) = feature {
                    self.report(MeshDefect::OffCarrier { point, feature, distance });
                }
            }
        }
        for (corner, count) in at_corner.into_iter().enumerate().filter(|c| c.1 > 1 || all && c.1 == 0) {
            self.report(MeshDefect::Corner { corner: corner as u32, count });
        }
    }

    /// Returns a point and the unit normal of a facet.
    fn plane(&self, facet: usize) -> [DVec3; 2] {
        let walls = self.domain.facets[facet].walls.iter().map(|&w| {
            let c = P::corners(self.domain.points(), &self.domain.walls()[w as usize]);
            let [a, b, c] = [0, 1, 2].map(|i| space(c[i]));
            [a, (b - a).cross(c - a)]
        });
        let larger = |a: [DVec3; 2], b: [DVec3; 2]| if b[1].length() > a[1].length() { b } else { a };
        let [at, normal] = walls.reduce(larger).unwrap_or_default();
        [at, normal / normal.length()]
    }

    fn ends(&self, segment: u32) -> [P; 2] {
        self.domain.segments[segment as usize].ends().map(|v| self.domain.points()[v as usize])
    }

    /// Returns the distance of a point from the closed segment.
    fn off_segment(&self, segment: u32, p: P) -> f64 {
        let [a, b] = self.ends(segment);
        let (along, to) = (b - a, p - a);
        let t = (to.dot(along) / along.norm2()).clamp(0.0, 1.0);
        (to - along * t).norm2().sqrt()
    }

    /// Returns `true` if the carrier is part of the closed segment.
    fn on_segment(&self, segment: u32, carrier: Carrier) -> bool {
        match carrier {
            Carrier::Segment(s) => s == segment,
            Carrier::Corner(c) => {
                self.domain.segments[segment as usize].ends().contains(&self.domain.corners[c as usize])
            }
            _ => false,
        }
    }

    /// Returns `true` if the carrier is part of the closed facet.
    fn on_facet(&self, facet: u32, carrier: Carrier) -> bool {
        let of = &self.domain.facets[facet as usize];
        match carrier {
            Carrier::Facet(f) => f == facet,
            Carrier::Segment(s) => of.boundary.contains(&s) || of.internal.contains(&s),
            Carrier::Corner(c) => of.corners.binary_search(&self.domain.corners[c as usize]).is_ok(),
            Carrier::Volume => false,
        }
    }

    /// Checks part 3. In the plane, faces take the place of edges, and their lengths by component are also compared.
    pub(super) fn segments(&mut self) {
        let mut of: Vec<Vec<[u32; 2]>> = vec![Vec::new(); self.domain.segments.len()];
        let (what, listed): (_, Vec<(u32, [u32; 2], i64)>) = if P::DIM == 2 {
            let ends = |f: &Face<P>| [f.vertices.as_ref()[0], f.vertices.as_ref()[1]];
            ("face", self.mesh.faces.iter().map(|f| (f.facet, ends(f), f.marker)).collect())
        } else {
            ("edge", self.mesh.edges.iter().map(|e| (e.segment, e.vertices, e.marker)).collect())
        };
        for (row, (segment, vertices, found)) in listed.into_iter().enumerate() {
            let row = row as u32;
            of[segment as usize].push(vertices);
            let expected = self.domain.segments[segment as usize].marker;
            if found != expected {
                self.report(MeshDefect::Marker { what, row, expected, found });
            }
            for point in vertices {
                let carrier = self.mesh.carriers[point as usize];
                if !self.on_segment(segment, carrier) {
                    let feature = Feature::Segment(segment);
                    self.report(MeshDefect::Carried { what, row, feature, point, carrier });
                }
            }
        }
        if P::DIM == 3 {
            self.loose_edges();
        }
        let mut chained = vec![false; self.points.len()];
        for (segment, edges) in of.into_iter().enumerate() {
            edges.iter().flatten().for_each(|&v| chained[v as usize] = true);
            if let Err(at) = self.chain(segment as u32, edges) {
                self.report(MeshDefect::Chain { segment: segment as u32, at });
            }
        }
        for (point, &carrier) in self.mesh.carriers.iter().enumerate() {
            if matches!(carrier, Carrier::Segment(_)) && !chained[point] {
                self.report(MeshDefect::Unused { point: point as u32, what, carrier });
            }
        }
        if P::DIM == 2 {
            self.lengths();
        }
    }

    fn loose_edges(&mut self) {
        let all = self.mesh.cell_edges();
        let mut seen = BTreeMap::new();
        for (row, edge) in self.mesh.edges.iter().enumerate() {
            let (key, row) = (ascending(edge.vertices), row as u32);
            if seen.insert(key, row).is_some() {
                self.report(MeshDefect::Twice { what: "edge", row });
            }
            if all.binary_search(&key).is_err() {
                self.report(MeshDefect::LooseEdge { edge: row });
            }
        }
    }

    /// Checks that the edges form a chain between the ends of the segment. The error is the point at which the chain
    /// breaks.
    fn chain(&self, segment: u32, mut edges: Vec<[u32; 2]>) -> Result<(), Option<u32>> {
        let [a, b] = self.ends(segment);
        let along = |v: u32| (self.points[v as usize] - a).dot(b - a);
        for edge in &mut edges {
            if along(edge[0]) > along(edge[1]) {
                edge.swap(0, 1);
            }
        }
        edges.sort_by(|e, f| along(e[0]).total_cmp(&along(f[0])).then(e.cmp(f)));
        let is = |v: u32, end: P| {
            matches!(self.mesh.carriers[v as usize], Carrier::Corner(_)) && self.points[v as usize] == end
        };
        let (Some(first), Some(last)) = (edges.first(), edges.last()) else { return Err(None) };
        for (v, end) in [(first[0], a), (last[1], b)] {
            if !is(v, end) {
                return Err(Some(v));
            }
        }
        let broken = edges.windows(2).find(|w| w[0][1] != w[1][0]).map(|w| w[0][1]);
        let still = edges.iter().find(|e| along(e[0]) >= along(e[1])).map(|e| e[0]);
        broken.or(still).map_or(Ok(()), |v| Err(Some(v)))
    }

    /// Returns the component on each side of a wall, ascending.
    fn components_at_wall(&self, wall: u32) -> [SideComponent; 2] {
        let inside = |c: u32| self.domain.components[c as usize].inside.then_some(c);
        ordered(self.domain.sides.components_at(wall).map(inside))
    }

    fn components_at_face(&self, face: &Face<P>) -> [SideComponent; 2] {
        ordered(face.cells.map(|c| (c != OUTSIDE).then(|| self.mesh.regions[c as usize])))
    }

    pub(super) fn wall_extent(&self, wall: u32) -> f64 {
        extent(&P::corners(self.domain.points(), &self.domain.walls()[wall as usize]))
    }

    /// Returns the sum of the lengths of the edges of a wall.
    fn perimeter(&self, wall: u32) -> f64 {
        let c = P::corners(self.domain.points(), &self.domain.walls()[wall as usize]);
        (0..c.len()).map(|i| (c[i] - c[(i + 1) % c.len()]).norm2().sqrt()).sum()
    }

    /// Checks part 4 for segments in the plane.
    fn lengths(&mut self) {
        let ends = |w: &P::Facet| ascending([w.as_ref()[0], w.as_ref()[1]]);
        let number: BTreeMap<[u32; 2], usize> =
            self.domain.segments.iter().enumerate().map(|(i, s)| (ascending(s.ends()), i)).collect();
        let mut of = vec![Measures::new(); self.domain.segments.len()];
        for (wall, row) in self.domain.walls().iter().enumerate() {
            if let Some(&segment) = number.get(&ends(row)) {
                let wall = wall as u32;
                let sums = of[segment].entry(self.components_at_wall(wall)).or_default();
                sums[0].add(self.wall_extent(wall));
            }
        }
        for face in &self.mesh.faces {
            let sums = of[face.facet as usize].entry(self.components_at_face(face)).or_default();
            sums[1].add(extent(&P::corners(&self.points, &face.vertices)));
        }
        for (segment, measures) in of.into_iter().enumerate() {
            self.compare(Feature::Segment(segment as u32), &measures, 2.0 * self.step());
        }
    }

    /// Compares measures. `slack` is the measure that the step of the grid can change.
    fn compare(&mut self, feature: Feature, measures: &Measures, slack: f64) {
        let whole: f64 = measures.values().map(|s| s[0].value()).sum();
        for (&components, sums) in measures {
            let sums = sums.map(Sum::value);
            let [expected, found] = sums.map(|x| self.unscaled(x, P::DIM - 1));
            if off(sums[0], sums[1], whole, slack) {
                self.report(MeshDefect::Area { feature, components, expected, found });
            }
            if components.contains(&None) {
                self.found.boundary[0] += expected;
                self.found.boundary[1] += found;
            }
        }
    }

    /// Checks part 4 for facets in space.
    pub(super) fn facets(&mut self) {
        if P::DIM == 2 {
            return;
        }
        let mut of: Vec<Vec<u32>> = vec![Vec::new(); self.domain.facets.len()];
        let mut tiled = vec![false; self.points.len()];
        for (row, face) in self.mesh.faces.iter().enumerate() {
            let (row, facet) = (row as u32, face.facet);
            of[facet as usize].push(row);
            let expected = self.domain.facets[facet as usize].marker;
            if face.marker != expected {
                self.report(MeshDefect::Marker { what: "face", row, expected, found: face.marker });
            }
            for &point in face.vertices.as_ref() {
                tiled[point as usize] = true;
                let carrier = self.mesh.carriers[point as usize];
                if !self.on_facet(facet, carrier) {
                    let feature = Feature::Facet(facet);
                    self.report(MeshDefect::Carried { what: "face", row, feature, point, carrier });
                }
            }
        }
        for (point, &carrier) in self.mesh.carriers.iter().enumerate() {
            if matches!(carrier, Carrier::Facet(_)) && !tiled[point] {
                self.report(MeshDefect::Unused { point: point as u32, what: "face", carrier });
            }
        }
        let mut subsegments: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
        for edge in &self.mesh.edges {
            subsegments.entry(edge.segment).or_default().push(ascending(edge.vertices));
        }
        for (facet, faces) in of.into_iter().enumerate() {
            self.sides_of_edges(facet as u32, &faces, &subsegments);
            self.areas(facet as u32, &faces);
        }
    }

    fn sides_of_edges(&mut self, facet: u32, faces: &[u32], subsegments: &BTreeMap<u32, Vec<[u32; 2]>>) {
        let normal = self.plane(facet as usize)[1].abs().to_array();
        let axis = (1..3).fold(0, |k, i| if normal[i] > normal[k] { i } else { k });
        let mut sides: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
        for &face in faces {
            let mut v = [0, 1, 2].map(|i| self.mesh.faces[face as usize].vertices.as_ref()[i]);
            match orientation(&v.map(|i| flat(space(self.points[i as usize]), axis))) {
                Sign::Zero => self.report(MeshDefect::FlatFace { face, facet }),
                Sign::Negative => v.swap(1, 2),
                Sign::Positive => {}
            }
            for [a, b] in [[v[0], v[1]], [v[1], v[2]], [v[2], v[0]]] {
                sides.entry(ascending([a, b])).or_default()[usize::from(a > b)] += 1;
            }
        }
        let of = &self.domain.facets[facet as usize];
        let on = |list: &[u32]| {
            list.iter().filter_map(|s| subsegments.get(s)).flatten().copied().collect::<Vec<_>>()
        };
        let (mut boundary, internal) = (on(&of.boundary), on(&of.internal));
        boundary.sort_unstable();
        // Subsegments without a face must be included.
        boundary.iter().chain(&internal).for_each(|&edge| {
            sides.entry(edge).or_default();
        });
        for (edge, sides) in sides {
            let once = boundary.binary_search(&edge).is_ok();
            if if once { sides[0] + sides[1] != 1 } else { sides != [1, 1] } {
                self.report(MeshDefect::FacetEdge { facet, edge, sides, required: if once { 1 } else { 2 } });
            }
        }
    }

    fn areas(&mut self, facet: u32, faces: &[u32]) {
        let mut measures = Measures::new();
        for &wall in &self.domain.facets[facet as usize].walls {
            measures.entry(self.components_at_wall(wall)).or_default()[0].add(self.wall_extent(wall));
        }
        for &face in faces {
            let face = &self.mesh.faces[face as usize];
            let area = extent(&P::corners(&self.points, &face.vertices));
            measures.entry(self.components_at_face(face)).or_default()[1].add(area);
        }
        let around = self.domain.facets[facet as usize].walls.iter().map(|&w| self.perimeter(w)).sum::<f64>();
        self.compare(Feature::Facet(facet), &measures, around * self.step());
    }
}

fn ordered(mut pair: [SideComponent; 2]) -> [SideComponent; 2] {
    pair.sort_unstable();
    pair
}
