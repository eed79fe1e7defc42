//! Domains: corners, segments and facets with their incidences.
//!
//! **Statement.** A *feature* is a corner, a segment (closed) or a facet (closed). The features of a complex are the
//! elements of the file, with segments divided at every vertex on them. In a surface, coplanar triangles that share an
//! edge are joined into one facet (exact test). Every other edge is part of a segment. Consecutive collinear edges
//! between the same facets form one segment. Vertices in the interior of such a facet or segment are not corners.
//!
//! *Two features share a point iff they share a corner.* Two features of a simplicial complex that share a point share
//! a face, and therefore a vertex. A vertex that is not a corner lies in one facet, or in one segment and the facets
//! around it. All of these contain the ends of that segment.
//!
//! Facets and segments that lie in one plane or on one line up to the digits of the file are joined for the sizes
//! only ([`Domain::flats`]). They remain separate features, which the mesh contains.
//!
//! Elements that have no part of the domain on either side are not features. They are listed in [`Domain::left_out`].
//!
//! **Work and depth.** `O(m log m)`.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::cost::Sweep;
use septet_geometry::predicates::{Sign, orientation};

use crate::defect::Element;
use crate::facet::wall_edges;
use crate::flats::Flats;
use crate::input::{DomainKind, Input, Region};
use crate::resolve::Simplices;
use crate::sides::{Location, Sets, Sides};
use crate::space::{Space, on_segment};

/// A part of the domain's boundary from which points must keep a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Feature {
    /// Position in [`Domain::corners`].
    Corner(u32),
    /// Position in [`Domain::segments`].
    Segment(u32),
    /// Position in [`Domain::facets`].
    Facet(u32),
}

/// A straight segment between two corners.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// The vertices on the segment, in order. The first and the last are its corners.
    pub chain: Vec<u32>,
    /// The facets that contain it, ascending.
    pub facets: Vec<u32>,
    /// The marker of the input, or 0.
    pub marker: i64,
}

impl Segment {
    /// Returns the vertices at the ends of the segment.
    pub fn ends(&self) -> [u32; 2] {
        [self.chain[0], self.chain[self.chain.len() - 1]]
    }
}

/// A planar facet in space.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Facet {
    /// Its triangles, as ascending positions in [`Domain::walls`].
    pub walls: Vec<u32>,
    /// The vertices that are corners, on its boundary and inside it, ascending.
    pub corners: Vec<u32>,
    /// The segments on its boundary. The facet lies on one side of each.
    pub boundary: Vec<u32>,
    /// The segments inside it.
    pub internal: Vec<u32>,
    /// The input facets that it consists of, ascending.
    pub of: Vec<u32>,
    /// The marker of the input, or 0.
    pub marker: i64,
}

/// A component of the complement of the walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Whether it is part of the domain.
    pub inside: bool,
    /// Its region in the input.
    pub region: Option<u32>,
    /// Its area or volume in scaled coordinates, rounded; 0 for the unbounded component.
    pub measure: f64,
}

/// A domain without defects.
#[derive(Clone, Debug)]
pub struct Domain<P: Space> {
    /// The kind of the input.
    pub kind: DomainKind,
    /// The simplices that the features are made of.
    pub simplices: Simplices<P>,
    /// The components on the sides of the walls.
    pub sides: Sides<P>,
    /// The components. Component 0 is unbounded.
    pub components: Vec<Component>,
    /// Vertices that are corners, ascending.
    pub corners: Vec<u32>,
    /// The segments, ascending by their chains.
    pub segments: Vec<Segment>,
    /// The facets, ascending by their walls. Empty in the plane.
    pub facets: Vec<Facet>,
    /// The facets and segments that are joined for the sizes.
    pub flats: Flats,
    /// The regions of the input.
    pub regions: Vec<Region<P>>,
    /// Input elements that lie outside the domain or in its holes.
    pub left_out: Vec<Element>,
    /// Whether it is a surface whose edges have two triangles each, and whose vertices have one fan each.
    pub manifold: bool,
}

impl<P: Space> Domain<P> {
    /// Builds features from the simplices of a complex.
    pub(crate) fn new(
        input: &Input<P>,
        simplices: Simplices<P>,
        sides: Sides<P>,
        components: Vec<Component>,
    ) -> Self {
        let regions = input.regions.clone();
        let (corners, segments, facets, left_out) = (vec![], vec![], vec![], vec![]);
        let kind = input.kind;
        let manifold = kind == DomainKind::Surface;
        let flats = Flats::default();
        let mut domain = Domain {
            kind,
            simplices,
            sides,
            components,
            corners,
            segments,
            facets,
            flats,
            regions,
            left_out,
            manifold,
        };
        let live: Vec<bool> = (0..domain.walls().len() as u32).map(|w| domain.bounds_inside(w)).collect();
        let edges = wall_edges::<P>(domain.walls());
        let groups = domain.groups(&edges, &live, input);
        let segment_edges = domain.segment_edges(&edges, &groups, &live);
        domain.make_segments(&segment_edges);
        domain.make_corners(&live);
        domain.make_facets(input, &edges, &groups, &live);
        domain.note_left_out(&live);
        let (corners, segments, facets) = (&domain.corners, &domain.segments, &domain.facets);
        domain.flats = Flats::separate(corners.len(), segments.len(), facets.len());
        domain
    }

    /// Returns all points, scaled by the power of two of [`Simplices::frame`].
    pub fn points(&self) -> &[P] {
        &self.simplices.points
    }

    /// Returns the simplices of codimension one: triangles of facets, or subsegments in the plane.
    pub fn walls(&self) -> &[P::Facet] {
        &self.simplices.walls
    }

    /// Returns the vertices of the walls of all facets, in the order of the facets. Use it only in space, where walls
    /// are triangles.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let walls = self.facets.iter().flat_map(|f| &f.walls);
        let corners = |&w: &u32| {
            let wall = self.walls()[w as usize];
            [0, 1, 2].map(|i| wall.as_ref()[i])
        };
        walls.map(corners).collect()
    }

    /// Returns `true` if the domain lies on at least one side of the wall.
    pub fn bounds_inside(&self, wall: u32) -> bool {
        self.sides.components_at(wall).iter().any(|&c| self.components[c as usize].inside)
    }

    /// Returns the facet group of every wall. Coplanar adjacent walls of a surface are joined.
    fn groups(&self, edges: &BTreeMap<[u32; 2], Vec<u32>>, live: &[bool], input: &Input<P>) -> Vec<u32> {
        let mut sets = Sets::new(self.walls().len());
        if P::DIM == 2 {
            return (0..self.walls().len() as u32).collect();
        }
        let mut first: BTreeMap<u32, u32> = BTreeMap::new();
        for (wall, &owner) in self.simplices.owner.iter().enumerate().filter(|(w, _)| live[*w]) {
            let leader = *first.entry(owner).or_insert(wall as u32);
            sets.join(leader, wall as u32);
        }
        if input.kind == DomainKind::Surface {
            for (edge, walls) in edges {
                if let [a, b] = walls[..] {
                    let apex = |w: u32| self.walls()[w as usize].as_ref().iter().find(|v| !edge.contains(v));
                    let ids = edge.iter().chain(apex(a)).chain(apex(b));
                    let at: Vec<P> = ids.map(|&v| self.points()[v as usize]).collect();
                    if at.len() == P::DIM + 1 && orientation(&at) == Sign::Zero {
                        sets.join(a, b);
                    }
                }
            }
        }
        (0..self.walls().len() as u32).map(|w| sets.find(w)).collect()
    }

    /// Returns the edges that belong to segments, with the groups around them and their markers.
    fn segment_edges(
        &self,
        edges: &BTreeMap<[u32; 2], Vec<u32>>,
        groups: &[u32],
        live: &[bool],
    ) -> BTreeMap<[u32; 2], (BTreeSet<u32>, i64)> {
        let mut found = BTreeMap::new();
        for part in &self.simplices.parts {
            let walls = edges.get(&part.ends).map_or(&[][..], Vec::as_slice);
            let around: BTreeSet<u32> =
                walls.iter().filter(|&&w| live[w as usize]).map(|&w| groups[w as usize]).collect();
            let flat = self.kind == DomainKind::Surface && around.len() == 1 && walls.len() == 2;
            let alive = if walls.is_empty() { self.holds(part.ends) } else { !around.is_empty() };
            if alive && !flat {
                found.insert(part.ends, (around, part.marker));
            }
        }
        found
    }

    /// Returns `true` if the domain contains the middle of an edge that is not part of a wall.
    fn holds(&self, [a, b]: [u32; 2]) -> bool {
        let (p, q) = (self.points()[a as usize], self.points()[b as usize]);
        [0.5, 0.25, 0.75].into_iter().any(|t| self.is_inside(p + (q - p) * t))
    }

    /// Returns `true` if the point lies strictly inside the domain.
    pub fn is_inside(&self, q: P) -> bool {
        self.is_inside_counted(q, &mut Sweep::default())
    }

    /// Returns [`Domain::is_inside`], and counts the visits of the tree of walls.
    pub(crate) fn is_inside_counted(&self, q: P, visits: &mut Sweep) -> bool {
        match self.sides.locate_counted(self.points(), q, visits) {
            Some(Location::Component(c)) => self.components[c as usize].inside,
            _ => false,
        }
    }

    /// Returns `true` if a point lies strictly inside the domain. No other wall may lie between the point and the
    /// given wall, and the point must not lie in the plane of that wall.
    pub fn is_inside_by(&self, wall: u32, q: P) -> bool {
        self.components[self.sides.towards(self.points(), wall, q) as usize].inside
    }

    /// Joins consecutive edges into segments.
    fn make_segments(&mut self, edges: &BTreeMap<[u32; 2], (BTreeSet<u32>, i64)>) {
        let mut at: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
        for edge in edges.keys() {
            for v in edge {
                at.entry(*v).or_default().push(*edge);
            }
        }
        let other = |e: [u32; 2], v: u32| if e[0] == v { e[1] } else { e[0] };
        let straight = |v: u32| match at.get(&v).map(Vec::as_slice) {
            Some(&[e, f]) if self.kind == DomainKind::Surface => {
                let [a, b, c] = [other(e, v), v, other(f, v)].map(|i| self.points()[i as usize]);
                edges[&e].0 == edges[&f].0 && on_segment(a, c, b)
            }
            _ => false,
        };
        let mut segments = Vec::new();
        for (&start, around) in at.iter().filter(|(v, _)| !straight(**v)) {
            for &edge in around {
                let mut chain = vec![start, other(edge, start)];
                let mut last = edge;
                while let Some(&v) = chain.last().filter(|&&v| straight(v)) {
                    last = if at[&v][0] == last { at[&v][1] } else { at[&v][0] };
                    chain.push(other(last, v));
                }
                if chain[0] < chain[chain.len() - 1] {
                    let (groups, marker) = &edges[&edge];
                    let facets = groups.iter().copied().collect();
                    segments.push(Segment { chain, facets, marker: *marker });
                }
            }
        }
        segments.sort_by(|a, b| a.chain.cmp(&b.chain));
        self.segments = segments;
    }

    fn make_corners(&mut self, live: &[bool]) {
        let mut corners: BTreeSet<u32> = self.segments.iter().flat_map(Segment::ends).collect();
        if self.kind == DomainKind::Complex {
            let mut met: BTreeSet<u32> = self.simplices.parts.iter().flat_map(|p| p.ends).collect();
            for (i, wall) in self.walls().iter().enumerate() {
                met.extend(wall.as_ref());
                if live[i] {
                    corners.extend(wall.as_ref());
                }
            }
            let is_first = |&v: &u32| self.simplices.same[v as usize] == v;
            let alone = (0..self.points().len() as u32).filter(|v| !met.contains(v)).filter(is_first);
            corners.extend(alone.filter(|&v| self.is_inside(self.points()[v as usize])));
        }
        self.corners = corners.into_iter().collect();
    }

    fn make_facets(
        &mut self,
        input: &Input<P>,
        edges: &BTreeMap<[u32; 2], Vec<u32>>,
        groups: &[u32],
        live: &[bool],
    ) {
        if P::DIM == 2 {
            for segment in &mut self.segments {
                segment.facets.clear();
            }
            return;
        }
        let mut of_group: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (wall, group) in groups.iter().enumerate().filter(|(w, _)| live[*w]) {
            of_group.entry(*group).or_default().push(wall as u32);
        }
        let number: BTreeMap<u32, u32> = of_group.keys().enumerate().map(|(i, &g)| (g, i as u32)).collect();
        for segment in &mut self.segments {
            segment.facets = segment.facets.iter().map(|g| number[g]).collect();
        }
        for walls in of_group.into_values() {
            let of: BTreeSet<u32> = walls.iter().map(|&w| self.simplices.owner[w as usize]).collect();
            let vertices: BTreeSet<u32> =
                walls.iter().flat_map(|&w| self.simplices.walls[w as usize].as_ref().to_vec()).collect();
            let corners = vertices.into_iter().filter(|v| self.corners.binary_search(v).is_ok()).collect();
            let marker = of.iter().map(|&f| input.facets[f as usize].marker).find(|&m| m != 0).unwrap_or(0);
            let (boundary, internal) = (Vec::new(), Vec::new());
            let of = of.into_iter().collect();
            self.facets.push(Facet { walls, corners, boundary, internal, of, marker });
        }
        let facet_of: Vec<Option<u32>> = groups.iter().map(|g| number.get(g).copied()).collect();
        for (s, segment) in self.segments.iter().enumerate() {
            let edge = crate::space::ascending([segment.chain[0], segment.chain[1]]);
            for &facet in &segment.facets {
                let walls = edges[&edge].iter().filter(|&&w| facet_of[w as usize] == Some(facet)).count();
                let facet = &mut self.facets[facet as usize];
                let list = if walls == 1 { &mut facet.boundary } else { &mut facet.internal };
                list.push(s as u32);
            }
        }
    }

    fn note_left_out(&mut self, live: &[bool]) {
        let mut out = BTreeSet::new();
        for wall in (0..live.len() as u32).filter(|&w| !live[w as usize]) {
            out.insert(self.simplices.element(wall));
        }
        if P::DIM == 3 {
            let edges = wall_edges::<P>(self.walls());
            let kept: BTreeSet<[u32; 2]> = self.segments.iter().map(Segment::ends).collect();
            for part in self.simplices.parts.iter().filter(|p| !edges.contains_key(&p.ends)) {
                if !kept.contains(&part.ends) {
                    out.insert(Element::Segment(part.of[0]));
                }
            }
        }
        self.left_out = out.into_iter().collect();
    }

    /// Returns all features: first corners, then segments, then facets.
    pub fn features(&self) -> impl Iterator<Item = Feature> + use<P> {
        let corners = (0..self.corners.len() as u32).map(Feature::Corner);
        let segments = (0..self.segments.len() as u32).map(Feature::Segment);
        corners.chain(segments).chain((0..self.facets.len() as u32).map(Feature::Facet))
    }

    /// Returns the vertices of a feature that are corners, ascending.
    pub fn corners_of(&self, feature: Feature) -> Vec<u32> {
        match feature {
            Feature::Corner(c) => vec![self.corners[c as usize]],
            Feature::Segment(s) => {
                let mut ends = self.segments[s as usize].ends().to_vec();
                ends.sort_unstable();
                ends
            }
            Feature::Facet(f) => self.facets[f as usize].corners.clone(),
        }
    }

    /// Returns `true` if the features have no common point.
    pub fn are_disjoint(&self, a: Feature, b: Feature) -> bool {
        let (mut few, mut many) = (self.corners_of(a), self.corners_of(b));
        if few.len() > many.len() {
            std::mem::swap(&mut few, &mut many);
        }
        few.iter().all(|v| many.binary_search(v).is_err())
    }

    /// Returns the segments at every corner, by the vertex of the corner.
    pub fn segments_at(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut at: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (i, segment) in self.segments.iter().enumerate() {
            for v in segment.ends() {
                at.entry(v).or_default().push(i as u32);
            }
        }
        at
    }

    /// Returns the area or volume of the domain in scaled coordinates, rounded.
    pub fn measure(&self) -> f64 {
        self.components.iter().filter(|c| c.inside).map(|c| c.measure).sum()
    }
}
