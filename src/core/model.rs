//! The input and output of the library: point sets and triangulations, independent of files and machines.

use glam::{DVec2, DVec3};
use septet_geometry::coordinates::{HigherSlice, PointSlice};
use septet_geometry::higher::VecN;
use septet_geometry::point::Position;
use septet_geometry::site::Weighted;

use crate::result::outcome::Outcome;

/// A point set of any dimension, as read or generated: in input order, duplicates included.
#[derive(Clone, Debug, PartialEq)]
pub enum Points {
    /// Points of the plane.
    Plane(Vec<DVec2>),
    /// Points of space.
    Space(Vec<DVec3>),
    /// Points of a higher dimension.
    Higher(HigherPoints),
}

/// A point set of dimension 4, 5 or 6.
#[derive(Clone, Debug, PartialEq)]
pub enum HigherPoints {
    /// Points of dimension 4.
    Four(Vec<VecN<4>>),
    /// Points of dimension 5.
    Five(Vec<VecN<5>>),
    /// Points of dimension 6.
    Six(Vec<VecN<6>>),
}

impl HigherPoints {
    /// Creates the points with these coordinates, `dimension` for each. Returns `None` for another dimension than 4, 5 and 6.
    pub fn of(dimension: usize, coordinates: &[f64]) -> Option<Self> {
        Some(match dimension {
            4 => HigherPoints::Four(coordinates.as_chunks().0.iter().copied().map(VecN).collect()),
            5 => HigherPoints::Five(coordinates.as_chunks().0.iter().copied().map(VecN).collect()),
            6 => HigherPoints::Six(coordinates.as_chunks().0.iter().copied().map(VecN).collect()),
            _ => return None,
        })
    }

    /// Returns the points.
    pub fn slice(&self) -> HigherSlice<'_> {
        match self {
            HigherPoints::Four(p) => HigherSlice::Four(p),
            HigherPoints::Five(p) => HigherSlice::Five(p),
            HigherPoints::Six(p) => HigherSlice::Six(p),
        }
    }

    /// Returns the coordinates as one flat array, `dimension` per point.
    pub fn coordinates(&self) -> &[f64] {
        match self {
            HigherPoints::Four(p) => bytemuck::cast_slice(p),
            HigherPoints::Five(p) => bytemuck::cast_slice(p),
            HigherPoints::Six(p) => bytemuck::cast_slice(p),
        }
    }
}

impl Points {
    /// Creates the points with these coordinates, `dimension` for each: 2 to 6. Others are those of space.
    pub fn of(dimension: usize, coordinates: &[f64]) -> Self {
        match HigherPoints::of(dimension, coordinates) {
            Some(points) => Points::Higher(points),
            None if dimension == 2 => {
                Points::Plane(coordinates.as_chunks().0.iter().copied().map(DVec2::from_array).collect())
            }
            None => Points::Space(coordinates.as_chunks().0.iter().copied().map(DVec3::from_array).collect()),
        }
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        match self {
            Points::Plane(p) => p.len(),
            Points::Space(p) => p.len(),
            Points::Higher(p) => p.slice().len(),
        }
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of coordinates: 2 to 6.
    pub fn dimension(&self) -> usize {
        match self {
            Points::Plane(_) => 2,
            Points::Space(_) => 3,
            Points::Higher(p) => p.slice().dimension(),
        }
    }

    /// Returns the points.
    pub fn slice(&self) -> PointSlice<'_> {
        match self {
            Points::Plane(p) => PointSlice::Plane(p),
            Points::Space(p) => PointSlice::Space(p),
            Points::Higher(p) => PointSlice::Higher(p.slice()),
        }
    }

    /// Returns the coordinates as one flat array, `dimension` per point.
    pub fn coordinates(&self) -> &[f64] {
        match self {
            Points::Plane(p) => bytemuck::cast_slice(p),
            Points::Space(p) => bytemuck::cast_slice(p),
            Points::Higher(p) => p.coordinates(),
        }
    }
}

/// A set of points with weights, which are squared lengths.
#[derive(Clone, Debug, PartialEq)]
pub enum WeightedPoints {
    /// Sites of the plane.
    Plane(Vec<Weighted<DVec2>>),
    /// Sites of space.
    Space(Vec<Weighted<DVec3>>),
}

impl WeightedPoints {
    /// Joins points and their weights. Returns `None` if their numbers differ, and in dimensions 4 to 6.
    pub fn join(points: &Points, weights: &[f64]) -> Option<Self> {
        if points.len() != weights.len() {
            return None;
        }
        match points {
            Points::Plane(points) => Some(WeightedPoints::Plane(joined(points, weights))),
            Points::Space(points) => Some(WeightedPoints::Space(joined(points, weights))),
            Points::Higher(_) => None,
        }
    }

    /// Returns the sites.
    pub fn slice(&self) -> PointSlice<'_> {
        match self {
            WeightedPoints::Plane(sites) => PointSlice::WeightedPlane(sites),
            WeightedPoints::Space(sites) => PointSlice::WeightedSpace(sites),
        }
    }
}

fn joined<P: Position>(points: &[P], weights: &[f64]) -> Vec<Weighted<P>> {
    points.iter().zip(weights).map(|(&point, &weight)| Weighted::new(point, weight)).collect()
}

/// A triangulation in the form that writers take.
///
/// Cells are rows of `dimension + 1` zero-based indices of the input points, in canonical order. In space, the smallest
/// index is first and the second smallest is second; the orientation decides the order of the other two. In the plane,
/// the smallest index is first, and the order is counter-clockwise. In higher dimensions, all but the last two are sorted, and
/// the orientation decides their order. Rows are sorted.
#[derive(Clone, Copy, Debug)]
pub struct MeshView<'a> {
    /// 2 to 6.
    pub dimension: usize,
    /// All input points, `dimension` coordinates each.
    pub coordinates: &'a [f64],
    /// The height of each point, if the mesh is a terrain: a triangulation in the plane whose points have a third
    /// coordinate. Formats with three coordinates hold the heights as z.
    pub heights: Option<&'a [f64]>,
    /// `dimension + 1` point indices per cell.
    pub cells: &'a [u64],
    /// The worker that owns each cell, if requested.
    pub owner: Option<&'a [u32]>,
    /// The leaf of the partition tree that owns the smallest vertex of each cell, if requested.
    pub owning_leaf: Option<&'a [u64]>,
    /// The run whose triangulation this is, if it was a run by one process. A `.pvtu` file has a piece for each worker.
    pub run: Option<&'a Outcome>,
    /// Labels of cells, faces, edges and points, if the triangulation is a mesh of a domain.
    pub labels: Option<&'a Labels>,
}

/// Edges or triangles of a mesh that lie on features of its domain.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Patches {
    /// Point indices: two per row for edges, three for triangles.
    pub vertices: Vec<u64>,
    /// The feature of the domain on which each row lies.
    pub of: Vec<u32>,
    /// The marker of each row.
    pub markers: Vec<i64>,
}

impl Patches {
    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.of.len()
    }

    /// Returns `true` if there are no rows.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }
}

/// The labels of a mesh of a domain. A file format holds some or all of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Labels {
    /// The component of the domain of each cell, from 1.
    pub regions: Vec<u32>,
    /// The attribute of the region of each cell, from the input if it has one.
    pub attributes: Vec<f64>,
    /// Triangles on facets (in the plane: edges on segments), oriented outward from their first cell.
    pub faces: Patches,
    /// For each face, the component of its first cell, then the component on the other side; 0 is the outside.
    pub sides: Vec<[u32; 2]>,
    /// Edges on segments; empty in the plane.
    pub edges: Patches,
    /// The marker of the feature that each point lies on.
    pub point_markers: Vec<i64>,
    /// The size function at each point.
    pub sizes: Vec<f64>,
    /// The dimension and the index of the feature that each point lies on; index -1 for the interior of a region.
    pub carriers: Vec<[i32; 2]>,
}

impl Outcome {
    /// Returns the triangulation of one process in the form that writers take, with the coordinates of the input.
    pub fn view<'a>(&'a self, coordinates: &'a [f64]) -> MeshView<'a> {
        MeshView {
            dimension: self.space,
            coordinates,
            heights: None,
            cells: self.cells(),
            owner: self.owner(),
            owning_leaf: self.owning_leaf(),
            run: Some(self),
            labels: None,
        }
    }
}

impl MeshView<'_> {
    /// Returns the number of points.
    pub fn point_count(&self) -> usize {
        self.coordinates.len() / self.dimension
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / (self.dimension + 1)
    }

    /// Returns the place of a point in space. A point in the plane has its height as z, or 0 if it has none.
    pub fn place(&self, point: usize) -> [f64; 3] {
        let own = &self.coordinates[point * self.dimension..(point + 1) * self.dimension];
        let z = || self.heights.map_or(0.0, |heights| heights[point]);
        [own[0], own[1], own.get(2).copied().unwrap_or_else(z)]
    }
}
