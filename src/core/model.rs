//! What enters and leaves the library: point sets and triangulations, free of files and machines.

use glam::{DVec2, DVec3};

/// A point set of either dimension, as read or generated: in input order, duplicates included.
#[derive(Clone, Debug, PartialEq)]
pub enum Points {
    /// Points of the plane.
    Plane(Vec<DVec2>),
    /// Points of space.
    Space(Vec<DVec3>),
}

impl Points {
    /// Number of points.
    pub fn len(&self) -> usize {
        match self {
            Points::Plane(p) => p.len(),
            Points::Space(p) => p.len(),
        }
    }

    /// Are there no points?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        match self {
            Points::Plane(_) => 2,
            Points::Space(_) => 3,
        }
    }

    /// The coordinates as one flat array, `dimension` per point.
    pub fn coordinates(&self) -> &[f64] {
        match self {
            Points::Plane(p) => bytemuck::cast_slice(p),
            Points::Space(p) => bytemuck::cast_slice(p),
        }
    }
}

/// A triangulation as files see it. Cells are rows of `dimension + 1` zero-based indices of the
/// input points, in canonical order: smallest index first, then the second smallest, the last two by
/// positive orientation (in the plane: smallest first, counter-clockwise); rows sorted.
#[derive(Clone, Copy, Debug)]
pub struct MeshView<'a> {
    /// 2 or 3.
    pub dimension: usize,
    /// All input points, `dimension` coordinates each.
    pub coordinates: &'a [f64],
    /// `dimension + 1` point indices per cell.
    pub cells: &'a [u64],
    /// The worker that owned each cell, one entry per cell, where asked for.
    pub owner: Option<&'a [u32]>,
    /// The leaf of the partition tree that was home to each cell's smallest vertex, where asked for.
    pub home_leaf: Option<&'a [u64]>,
    /// What a mesh of a domain says about its cells, faces, edges and points, where it is one.
    pub labels: Option<&'a Labels>,
}

/// Rows of point indices that belong to pieces of a domain.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Patches {
    /// Points, two a row for edges, three for triangles.
    pub vertices: Vec<u64>,
    /// The piece of the domain that each row is part of.
    pub of: Vec<u32>,
    /// The marker of each row.
    pub markers: Vec<i64>,
}

impl Patches {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.of.len()
    }

    /// Are there no rows?
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }
}

/// What a mesh of a domain knows beyond its cells. Formats write what they can hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Labels {
    /// The component of the domain of each cell, from 1.
    pub regions: Vec<u32>,
    /// The number that names the region of each cell: its attribute in the input, if it has one.
    pub attributes: Vec<f64>,
    /// Triangles on facets (in the plane: edges on segments), outward from the first cell they have.
    pub faces: Patches,
    /// The components on the two sides of each face, that of its first cell first; 0 is the outside.
    pub sides: Vec<[u32; 2]>,
    /// Edges on segments; none in the plane.
    pub edges: Patches,
    /// The marker of what each point lies on.
    pub point_markers: Vec<i64>,
    /// The size function at each point.
    pub sizes: Vec<f64>,
    /// What each point lies on: the dimension of it, and its number (-1 for the inside of a region).
    pub carriers: Vec<[i32; 2]>,
}

impl MeshView<'_> {
    /// Number of points.
    pub fn point_count(&self) -> usize {
        self.coordinates.len() / self.dimension
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / (self.dimension + 1)
    }
}
