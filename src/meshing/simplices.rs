//! The simplicial form of facets and segments.

use crate::bvh::Bounds;
use crate::defect::{At, Element};
use crate::frame::Frame;
use crate::space::Space;

/// A subsegment: part of a segment between two vertices, without vertices in between.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The ends, ascending.
    pub ends: [u32; 2],
    /// The input edges that contain it.
    pub of: Vec<[u32; 2]>,
    /// The marker of the first listed segment that contains it, or 0.
    pub marker: i64,
}

/// The simplices of a domain.
#[derive(Clone, Debug)]
pub struct Simplices<P: Space> {
    /// The points, in the coordinates of the frame.
    pub points: Vec<P>,
    /// The translation and the scaling from the file.
    pub frame: Frame<P>,
    /// For each point, the first point with the same coordinates.
    pub same: Vec<u32>,
    /// The subsegments, ascending by their ends.
    pub parts: Vec<Part>,
    /// Edges in the plane, triangles in space.
    pub walls: Vec<P::Facet>,
    /// The facet (in space) or subsegment (in the plane) of each wall.
    pub owner: Vec<u32>,
}

impl<P: Space> Simplices<P> {
    /// Converts a point to the unit of the file.
    pub fn at(&self, p: P) -> At {
        let p = self.frame.outward(p);
        At((0..P::DIM).map(|i| p.coord(i)).collect())
    }

    /// Returns the coordinates of a vertex, in the unit of the file.
    pub fn place(&self, v: u32) -> At {
        self.at(self.points[v as usize])
    }

    /// Returns the midpoint of an edge, in the unit of the file.
    pub fn middle(&self, [a, b]: [u32; 2]) -> At {
        self.at((self.points[a as usize] + self.points[b as usize]) * 0.5)
    }

    /// Returns the representatives of a list of points, or `None` if one of the points does not exist.
    pub fn represent(&self, list: &[u32]) -> Option<Vec<u32>> {
        list.iter().map(|&v| self.same.get(v as usize).copied()).collect()
    }

    /// Returns the input element of a wall.
    pub fn element(&self, wall: u32) -> Element {
        let owner = self.owner[wall as usize];
        if P::DIM == 2 { Element::Segment(self.parts[owner as usize].of[0]) } else { Element::Facet(owner) }
    }

    /// Returns the bounding box of vertices.
    pub fn bounds(&self, vertices: &[u32]) -> Bounds<P> {
        Bounds::of(vertices.iter().map(|&v| self.points[v as usize]))
    }
}

/// The loops of a facet as representative points, with three corners that span its plane.
#[derive(Clone, Debug)]
pub struct Outline {
    /// The loops.
    pub loops: Vec<Vec<u32>>,
    /// `None` for facets that consist only of segments and points.
    pub plane: Option<[u32; 3]>,
}

impl Outline {
    /// Returns the edges of all loops.
    pub fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.loops.iter().flat_map(|l| {
            let n = if l.len() == 2 { 1 } else { l.len() };
            (0..n).map(|i| [l[i], l[(i + 1) % l.len()]]).filter(|e| e[0] != e[1])
        })
    }
}
