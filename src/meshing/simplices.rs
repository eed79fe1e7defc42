//! The simplicial form of a domain's facets and segments.

use septet_geometry::range::scale;

use crate::bvh::Bounds;
use crate::defect::{At, Element};
use crate::space::Space;

/// A piece of a segment between two vertices, with nothing on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The ends, ascending.
    pub ends: [u32; 2],
    /// The edges of the input that it is part of.
    pub of: Vec<[u32; 2]>,
    /// The marker of the first listed segment it is part of, else 0.
    pub marker: i64,
}

/// The simplices of a domain.
#[derive(Clone, Debug)]
pub struct Simplices<P: Space> {
    /// The points times `2^exponent`.
    pub points: Vec<P>,
    /// The power of two that brings the coordinates into the exact range.
    pub exponent: i32,
    /// For each point the smallest one at the same place.
    pub same: Vec<u32>,
    /// The segments in pieces, ascending by their ends.
    pub parts: Vec<Part>,
    /// Edges of the plane, triangles of space.
    pub walls: Vec<P::Facet>,
    /// For each wall the facet (in space) or the part (in the plane) that it belongs to.
    pub owner: Vec<u32>,
}

impl<P: Space> Simplices<P> {
    /// A point as the file has it.
    pub fn at(&self, p: P) -> At {
        let p = scale(p, -self.exponent);
        At((0..P::DIM).map(|i| p.coord(i)).collect())
    }

    /// The place of a vertex.
    pub fn place(&self, v: u32) -> At {
        self.at(self.points[v as usize])
    }

    /// The middle of an edge.
    pub fn middle(&self, [a, b]: [u32; 2]) -> At {
        self.at((self.points[a as usize] + self.points[b as usize]) * 0.5)
    }

    /// The representatives of a list of points, if all are there.
    pub fn represent(&self, list: &[u32]) -> Option<Vec<u32>> {
        list.iter().map(|&v| self.same.get(v as usize).copied()).collect()
    }

    /// What a wall belongs to, as a piece of the input.
    pub fn element(&self, wall: u32) -> Element {
        let owner = self.owner[wall as usize];
        if P::DIM == 2 { Element::Segment(self.parts[owner as usize].of[0]) } else { Element::Facet(owner) }
    }

    /// The box of vertices.
    pub fn bounds(&self, vertices: &[u32]) -> Bounds<P> {
        Bounds::of(vertices.iter().map(|&v| self.points[v as usize]))
    }
}

/// A facet that has a plane: its loops by representative points, and three corners that span the plane.
#[derive(Clone, Debug)]
pub struct Outline {
    /// The loops.
    pub loops: Vec<Vec<u32>>,
    /// `None`: segments and points alone.
    pub plane: Option<[u32; 3]>,
}

impl Outline {
    /// The edges of all loops.
    pub fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.loops.iter().flat_map(|l| {
            let n = if l.len() == 2 { 1 } else { l.len() };
            (0..n).map(|i| [l[i], l[(i + 1) % l.len()]]).filter(|e| e[0] != e[1])
        })
    }
}
