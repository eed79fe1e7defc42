//! Typed faults of triangulations, with their cells and points.

use std::fmt;

use serde::Serialize;

/// A fault. Cells are rows of the file, points and vertices are input indices. Both are zero-based.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "fault", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Fault {
    /// The arrays do not describe a mesh.
    Shape {
        /// The contradiction.
        reason: &'static str,
    },
    /// A coordinate is infinite or NaN.
    NotFinite {
        /// The point.
        point: u64,
    },
    /// A weight is infinite or NaN.
    WeightNotFinite {
        /// The point.
        point: u64,
    },
    /// A vertex index is not the index of a point.
    OutOfRange {
        /// The cell.
        cell: u64,
        /// The index.
        index: u64,
    },
    /// A cell names a vertex twice. In a periodic box, with the same offset.
    RepeatedVertex {
        /// The cell.
        cell: u64,
        /// The vertex.
        vertex: u64,
    },
    /// An offset of a cell is larger than 2^26, or along an axis that is not periodic.
    OffsetNotAdmitted {
        /// The cell.
        cell: u64,
    },
    /// A point is more than 2^26 lengths away from the periodic box at 0.
    TooFar {
        /// The point.
        point: u64,
    },
    /// Two cells have the same vertices. In a periodic box, one may be a translation of the other.
    CellTwice {
        /// The two cells.
        cells: [u64; 2],
    },
    /// A point is not a vertex and does not coincide with one.
    Unused {
        /// The point.
        point: u64,
    },
    /// Two coincident points are both vertices.
    CoincidentVertices {
        /// The two points.
        points: [u64; 2],
    },
    /// A vertex coincides with a point of larger weight.
    Lighter {
        /// The vertex.
        vertex: u64,
        /// The smallest index of a heaviest point that coincides with it.
        heavier: u64,
    },
    /// A vertex coincides with a point of smaller index, which must be the vertex in the canonical triangulation.
    NotRepresentative {
        /// The vertex.
        vertex: u64,
        /// The smallest index of a point that coincides with it, and has the same weight.
        smallest: u64,
    },
    /// There are no cells, although the points span the space.
    NoCells,
    /// The volume of a cell is exactly zero.
    Flat {
        /// The cell.
        cell: u64,
    },
    /// A cell is negatively oriented, although positive orientation is required.
    Negative {
        /// The cell.
        cell: u64,
    },
    /// A facet has one cell, although the box is periodic along all axes.
    OpenFacet {
        /// Its vertices.
        facet: Vec<u64>,
        /// Its cell.
        cell: u64,
    },
    /// A facet has more than two cells.
    FacetOvershared {
        /// Its vertices.
        facet: Vec<u64>,
        /// The first of its cells.
        cells: Vec<u64>,
        /// The number of its cells.
        count: u64,
    },
    /// The two cells of a facet lie on the same side of it.
    SameSide {
        /// Its vertices.
        facet: Vec<u64>,
        /// The two cells.
        cells: [u64; 2],
    },
    /// The cells at a vertex are not connected through facets at that vertex.
    PinchedVertex {
        /// The vertex.
        vertex: u64,
        /// One cell of each of two connected parts.
        cells: [u64; 2],
    },
    /// The link of a vertex is neither a disc nor a sphere.
    LinkNotADisc {
        /// The vertex.
        vertex: u64,
        /// The Euler characteristic of the link.
        euler: i64,
        /// The number of boundary facets at the vertex.
        boundary: u64,
    },
    /// A ridge of the boundary does not lie in exactly two boundary facets.
    OpenRidge {
        /// Its vertices.
        ridge: Vec<u64>,
        /// The number of boundary facets at it.
        count: u64,
    },
    /// The boundary is not locally convex at a ridge.
    Reflex {
        /// Its vertices.
        ridge: Vec<u64>,
        /// The cells of its two boundary facets.
        cells: [u64; 2],
    },
    /// Two boundary facets are folded onto each other, in one plane or line.
    Folded {
        /// The ridge between them.
        ridge: Vec<u64>,
        /// The cells of the two facets.
        cells: [u64; 2],
    },
    /// The far vertex of a neighbour lies strictly inside the circumsphere of a cell. With weights, its lift is strictly below
    /// the hyperplane through the lifts of the cell.
    NotEmpty {
        /// The two cells.
        cells: [u64; 2],
        /// The vertex of the second cell that is inside the circumsphere of the first.
        vertex: u64,
    },
    /// Two cospherical cells are not those that the lexicographic perturbation determines. With weights, their lifts have one
    /// hyperplane.
    TieBrokenOtherwise {
        /// The two cells.
        cells: [u64; 2],
        /// The vertex of the second cell that is inside the perturbed circumsphere of the first.
        vertex: u64,
    },
    /// The interior point of a cell also lies in another cell.
    CoveredTwice {
        /// The cell of the interior point.
        cell: u64,
        /// The other cell.
        other: u64,
    },
    /// An edge of a cell is longer than the periodic box along an axis.
    LongerThanBox {
        /// The cell.
        cell: u64,
        /// The axis, from 0.
        axis: u64,
    },
    /// The hyperplane of a boundary facet is not parallel to an axis of the periodic box.
    Slanted {
        /// The cell of the facet.
        cell: u64,
        /// The vertices of the facet.
        facet: Vec<u64>,
        /// The axis, from 0.
        axis: u64,
    },
    /// A part of a cell is on the outer side of a boundary facet.
    BeyondBoundary {
        /// The cell.
        cell: u64,
        /// The cell of the boundary facet.
        other: u64,
        /// The vertices of the facet.
        facet: Vec<u64>,
    },
    /// A point with a weight is not a vertex, but it is not hidden: its lift is not strictly above the cell around it.
    NotHidden {
        /// The point.
        point: u64,
        /// A closed cell that contains the point.
        cell: u64,
    },
    /// A point with a weight is outside all cells.
    Outside {
        /// The point.
        point: u64,
        /// The cell of a boundary facet between the cells and the point.
        cell: u64,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Shape { reason } => f.write_str(reason),
            Fault::NotFinite { point } => write!(f, "point {point} is not finite"),
            Fault::WeightNotFinite { point } => write!(f, "the weight of point {point} is not finite"),
            Fault::OutOfRange { cell, index } => {
                write!(f, "cell {cell} names point {index}, which does not exist")
            }
            Fault::RepeatedVertex { cell, vertex } => {
                write!(f, "cell {cell} names point {vertex} twice")
            }
            Fault::OffsetNotAdmitted { cell } => write!(
                f,
                "an offset of cell {cell} is larger than 67108864, or along an axis that is not periodic"
            ),
            Fault::TooFar { point } => {
                write!(f, "point {point} is more than 67108864 lengths of the box away from 0")
            }
            Fault::CellTwice { cells: [a, b] } => {
                write!(f, "cells {a} and {b} have the same vertices")
            }
            Fault::Unused { point } => {
                write!(f, "point {point} is not a vertex and coincides with none")
            }
            Fault::CoincidentVertices { points: [a, b] } => {
                write!(f, "points {a} and {b} coincide, and both are vertices")
            }
            Fault::Lighter { vertex, heavier } => {
                write!(f, "vertex {vertex} coincides with point {heavier}, which has a larger weight")
            }
            Fault::NotRepresentative { vertex, smallest } => {
                write!(f, "vertex {vertex} coincides with point {smallest}, which should represent it")
            }
            Fault::NoCells => f.write_str("there are no cells, although the points span the space"),
            geometric => geometric.fmt_geometric(f),
        }
    }
}

impl Fault {
    /// Returns the cells of the fault.
    pub fn cells(&self) -> Vec<u64> {
        match self {
            Fault::OutOfRange { cell, .. }
            | Fault::RepeatedVertex { cell, .. }
            | Fault::OffsetNotAdmitted { cell }
            | Fault::OpenFacet { cell, .. }
            | Fault::LongerThanBox { cell, .. }
            | Fault::Slanted { cell, .. }
            | Fault::Flat { cell }
            | Fault::Negative { cell }
            | Fault::NotHidden { cell, .. }
            | Fault::Outside { cell, .. } => vec![*cell],
            Fault::CellTwice { cells }
            | Fault::SameSide { cells, .. }
            | Fault::PinchedVertex { cells, .. }
            | Fault::Reflex { cells, .. }
            | Fault::Folded { cells, .. }
            | Fault::NotEmpty { cells, .. }
            | Fault::TieBrokenOtherwise { cells, .. } => cells.to_vec(),
            Fault::FacetOvershared { cells, .. } => cells.clone(),
            Fault::CoveredTwice { cell, other } | Fault::BeyondBoundary { cell, other, .. } => {
                vec![*cell, *other]
            }
            Fault::Shape { .. }
            | Fault::NotFinite { .. }
            | Fault::WeightNotFinite { .. }
            | Fault::TooFar { .. }
            | Fault::Unused { .. }
            | Fault::CoincidentVertices { .. }
            | Fault::Lighter { .. }
            | Fault::NotRepresentative { .. }
            | Fault::NoCells
            | Fault::LinkNotADisc { .. }
            | Fault::OpenRidge { .. } => Vec::new(),
        }
    }

    /// Returns the points that the fault names.
    pub fn points(&self) -> Vec<u64> {
        match self {
            Fault::NotFinite { point }
            | Fault::WeightNotFinite { point }
            | Fault::TooFar { point }
            | Fault::Unused { point }
            | Fault::NotHidden { point, .. }
            | Fault::Outside { point, .. } => vec![*point],
            Fault::Lighter { vertex, heavier } => vec![*vertex, *heavier],
            Fault::CoincidentVertices { points } => points.to_vec(),
            Fault::NotRepresentative { vertex, smallest } => vec![*vertex, *smallest],
            Fault::RepeatedVertex { vertex, .. }
            | Fault::PinchedVertex { vertex, .. }
            | Fault::LinkNotADisc { vertex, .. }
            | Fault::NotEmpty { vertex, .. }
            | Fault::TieBrokenOtherwise { vertex, .. } => vec![*vertex],
            Fault::OpenRidge { ridge, .. } | Fault::Reflex { ridge, .. } | Fault::Folded { ridge, .. } => {
                ridge.clone()
            }
            Fault::FacetOvershared { facet, .. }
            | Fault::OpenFacet { facet, .. }
            | Fault::Slanted { facet, .. }
            | Fault::SameSide { facet, .. }
            | Fault::BeyondBoundary { facet, .. } => facet.clone(),
            Fault::Shape { .. }
            | Fault::OutOfRange { .. }
            | Fault::OffsetNotAdmitted { .. }
            | Fault::LongerThanBox { .. }
            | Fault::CellTwice { .. }
            | Fault::NoCells
            | Fault::Flat { .. }
            | Fault::Negative { .. }
            | Fault::CoveredTwice { .. } => Vec::new(),
        }
    }

    /// Formats the faults of the levels `orientation` and `manifold`.
    fn fmt_geometric(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Flat { cell } => write!(f, "cell {cell} is flat"),
            Fault::Negative { cell } => write!(f, "cell {cell} is negatively oriented"),
            Fault::OpenFacet { facet, cell } => {
                write!(f, "facet {facet:?} has one cell, {cell}, although all axes of the box are periodic")
            }
            Fault::FacetOvershared { facet, cells, count } => {
                write!(f, "facet {facet:?} lies in {count} cells, among them {cells:?}")
            }
            Fault::SameSide { facet, cells: [a, b] } => {
                write!(f, "cells {a} and {b} lie on the same side of their facet {facet:?}")
            }
            Fault::PinchedVertex { vertex, cells: [a, b] } => write!(
                f,
                "vertex {vertex} is pinched: cells {a} and {b} at it are not connected through facets at it"
            ),
            Fault::LinkNotADisc { vertex, euler, boundary } => write!(
                f,
                "the link of vertex {vertex} is neither disc nor sphere (Euler characteristic {euler}, {boundary} boundary facets)"
            ),
            global => global.fmt_global(f),
        }
    }

    /// Formats the faults of the levels after `manifold`.
    fn fmt_global(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::OpenRidge { ridge, count } => {
                write!(f, "boundary ridge {ridge:?} lies in {count} boundary facets, not in two")
            }
            Fault::Reflex { ridge, cells: [a, b] } => {
                write!(f, "the boundary is not convex at {ridge:?}, between cells {a} and {b}")
            }
            Fault::Folded { ridge, cells: [a, b] } => {
                write!(f, "the boundary is folded at {ridge:?}, between cells {a} and {b}")
            }
            Fault::NotEmpty { cells: [a, b], vertex } => {
                write!(f, "vertex {vertex} of cell {b} lies inside the circumsphere of cell {a}")
            }
            Fault::TieBrokenOtherwise { cells: [a, b], vertex } => write!(
                f,
                "cells {a} and {b} are cospherical and not those of the perturbation (vertex {vertex})"
            ),
            Fault::CoveredTwice { cell, other } => {
                write!(f, "an interior point of cell {cell} also lies in cell {other}")
            }
            Fault::LongerThanBox { cell, axis } => {
                write!(f, "an edge of cell {cell} is longer than the box along axis {axis}")
            }
            Fault::Slanted { cell, facet, axis } => {
                write!(
                    f,
                    "the boundary facet {facet:?} of cell {cell} is not parallel to axis {axis} of the box"
                )
            }
            Fault::BeyondBoundary { cell, other, facet } => {
                write!(f, "cell {cell} crosses the boundary facet {facet:?} of cell {other}")
            }
            Fault::NotHidden { point, cell } => {
                write!(f, "point {point} is not a vertex, but its lift is not above that of cell {cell}")
            }
            Fault::Outside { point, cell } => {
                write!(f, "point {point} is outside all cells, next to cell {cell}")
            }
            other => write!(f, "{other:?}"),
        }
    }
}
