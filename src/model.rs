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
