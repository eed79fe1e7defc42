//! Contacts between elements of an input.
//!
//! **Statement.** The simplices are a complex iff
//! 1. no edge of a wall or segment meets a wall beyond a common face,
//! 2. no segment meets another segment beyond a common face, and
//! 3. no two walls coincide.
//!
//! [`crate::space`] gives the argument. All pairs whose boxes meet are tested.
//!
//! **Work and depth.** `O(m log m + pairs)`, sequential. The tests of different edges are independent.

use std::collections::{BTreeMap, BTreeSet};

use crate::bvh::{Bounds, Bvh};
use crate::defect::{Defect, Element};
use crate::facet::wall_edges;
use crate::resolve::{Part, Simplices};
use crate::space::{Space, edges_overlap};

/// Returns all forbidden contacts, each pair of elements once.
pub fn contacts<P: Space>(simplices: &Simplices<P>) -> Vec<Defect> {
    let mut search = Search { simplices, edges: wall_edges::<P>(&simplices.walls), found: BTreeMap::new() };
    for part in &simplices.parts {
        search.edges.entry(part.ends).or_default();
    }
    search.edges_and_walls();
    if P::DIM == 3 {
        search.parts_and_parts();
    }
    let mut defects = doubled(simplices);
    defects.extend(search.found.into_iter().map(|(elements, b)| {
        let at = simplices.at((b.low + b.high) * 0.5);
        Defect::Intersect { elements, at }
    }));
    defects
}

struct Search<'a, P: Space> {
    simplices: &'a Simplices<P>,
    /// All edges with their walls.
    edges: BTreeMap<[u32; 2], Vec<u32>>,
    found: BTreeMap<[Element; 2], Bounds<P>>,
}

impl<P: Space> Search<'_, P> {
    fn p(&self, v: u32) -> P {
        self.simplices.points[v as usize]
    }

    fn edges_and_walls(&mut self) {
        let boxes = self.simplices.walls.iter().map(|w| self.simplices.bounds(w.as_ref())).collect();
        let tree = Bvh::new(boxes);
        let mut hits = Vec::new();
        for (&edge, owners) in &self.edges {
            let bounds = self.simplices.bounds(&edge);
            for wall in tree.meeting(&bounds) {
                if self.beyond(edge, wall) {
                    hits.push((edge, owners.clone(), wall));
                }
            }
        }
        for (edge, owners, wall) in hits {
            let bounds = overlap(
                &self.simplices.bounds(&edge),
                &self.simplices.bounds(self.simplices.walls[wall as usize].as_ref()),
            );
            let other = self.simplices.element(wall);
            let mut elements: Vec<Element> = owners.iter().map(|&w| self.simplices.element(w)).collect();
            if owners.is_empty() {
                elements.extend(self.segment(edge));
            }
            for element in elements {
                self.add(element, other, bounds);
            }
        }
    }

    /// Returns the input segment that contains an edge.
    fn segment(&self, edge: [u32; 2]) -> Option<Element> {
        let i = self.simplices.parts.binary_search_by_key(&edge, |p| p.ends).ok()?;
        self.simplices.parts[i].of.first().map(|&of| Element::Segment(of))
    }

    fn add(&mut self, a: Element, b: Element, bounds: Bounds<P>) {
        self.found.entry([a.min(b), a.max(b)]).or_insert(bounds);
    }

    /// Returns `true` if an edge and a wall meet beyond their common face.
    fn beyond(&self, edge: [u32; 2], wall: u32) -> bool {
        let wall = self.simplices.walls[wall as usize];
        let corners = wall.as_ref();
        let common: Vec<usize> = (0..corners.len()).filter(|&i| edge.contains(&corners[i])).collect();
        let at: Vec<P> = corners.iter().map(|&v| self.p(v)).collect();
        match common[..] {
            [] => P::edge_meets_wall(edge.map(|v| self.p(v)), &at),
            [i] => {
                let other = if edge[0] == corners[i] { edge[1] } else { edge[0] };
                let mut at = at;
                at.rotate_left(i);
                P::edge_enters_wall(&at, self.p(other))
            }
            _ => false,
        }
    }

    /// In space, tests the segments that are not edges of walls against each other.
    fn parts_and_parts(&mut self) {
        let free = |p: &&Part| self.edges.get(&p.ends).is_none_or(Vec::is_empty);
        let parts: Vec<&Part> = self.simplices.parts.iter().filter(free).collect();
        let tree = Bvh::new(parts.iter().map(|p| self.simplices.bounds(&p.ends)).collect());
        let mut hits = Vec::new();
        for (i, part) in parts.iter().enumerate() {
            let bounds = self.simplices.bounds(&part.ends);
            for j in tree.meeting(&bounds).into_iter().filter(|&j| j as usize > i) {
                let other = parts[j as usize];
                if self.parts_beyond(part.ends, other.ends) {
                    hits.push((
                        part.of[0],
                        other.of[0],
                        overlap(&bounds, &self.simplices.bounds(&other.ends)),
                    ));
                }
            }
        }
        for (a, b, bounds) in hits {
            self.add(Element::Segment(a), Element::Segment(b), bounds);
        }
    }

    fn parts_beyond(&self, e: [u32; 2], f: [u32; 2]) -> bool {
        let common: BTreeSet<u32> = e.iter().filter(|v| f.contains(v)).copied().collect();
        match common.first() {
            None => P::edges_meet(e.map(|v| self.p(v)), f.map(|v| self.p(v))),
            Some(&c) => {
                let far = |e: [u32; 2]| self.p(if e[0] == c { e[1] } else { e[0] });
                edges_overlap(self.p(c), far(e), far(f))
            }
        }
    }
}

/// Returns the intersection of two boxes that meet.
fn overlap<P: Space>(a: &Bounds<P>, b: &Bounds<P>) -> Bounds<P> {
    let mut both = *a;
    for i in 0..P::DIM {
        both.low.set_coord(i, a.low.coord(i).max(b.low.coord(i)));
        both.high.set_coord(i, a.high.coord(i).min(b.high.coord(i)));
    }
    both
}

/// Reports walls with the same vertices.
fn doubled<P: Space>(simplices: &Simplices<P>) -> Vec<Defect> {
    let mut by_vertices: BTreeMap<Vec<u32>, Vec<u32>> = BTreeMap::new();
    for (i, wall) in simplices.walls.iter().enumerate() {
        let mut key = wall.as_ref().to_vec();
        key.sort_unstable();
        by_vertices.entry(key).or_default().push(i as u32);
    }
    let mut found = BTreeMap::new();
    for (vertices, walls) in &by_vertices {
        for pair in walls.windows(2) {
            let elements = [simplices.element(pair[0]), simplices.element(pair[1])];
            found.entry(elements).or_insert_with(|| simplices.place(vertices[0]));
        }
    }
    found.into_iter().map(|(elements, at)| Defect::Doubled { elements, at }).collect()
}
