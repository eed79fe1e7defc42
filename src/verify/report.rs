//! What the verifier found: levels, and typed faults that name cells and points.

use std::fmt;

use serde::Serialize;

/// How many faults of a level are kept.
pub const KEPT: usize = 10;

/// One fault. Cells are rows of the file, points and vertices input indices, both zero-based.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "fault", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Fault {
    /// The arrays do not describe a mesh at all.
    Shape {
        /// What is wrong with them.
        reason: &'static str,
    },
    /// A coordinate is infinite or not a number.
    NotFinite {
        /// The point.
        point: u64,
    },
    /// A vertex index is no point.
    OutOfRange {
        /// The cell.
        cell: u64,
        /// The index.
        index: u64,
    },
    /// A cell names a vertex twice.
    RepeatedVertex {
        /// The cell.
        cell: u64,
        /// The vertex.
        vertex: u64,
    },
    /// Two cells have the same vertices.
    CellTwice {
        /// The two cells.
        cells: [u64; 2],
    },
    /// A point is no vertex, and coincides with none.
    Unused {
        /// The point.
        point: u64,
    },
    /// Coincident points are both vertices.
    CoincidentVertices {
        /// The two points.
        points: [u64; 2],
    },
    /// A vertex is not the smallest index of its coincident points (septet's convention).
    NotRepresentative {
        /// The vertex.
        vertex: u64,
        /// The smallest index of a point that coincides with it.
        smallest: u64,
    },
    /// There are no cells, though the points span the space.
    NoCells,
    /// A cell of volume exactly zero.
    Flat {
        /// The cell.
        cell: u64,
    },
    /// A negatively oriented cell, where the order of a row was asked to matter.
    Negative {
        /// The cell.
        cell: u64,
    },
    /// A facet of more than two cells.
    FacetOvershared {
        /// Its vertices.
        facet: Vec<u64>,
        /// The first of its cells.
        cells: Vec<u64>,
        /// How many cells it has.
        count: u64,
    },
    /// The two cells of a facet lie on the same side of it.
    SameSide {
        /// Its vertices.
        facet: Vec<u64>,
        /// The two cells.
        cells: [u64; 2],
    },
    /// The cells at a vertex are not connected through facets at it.
    PinchedVertex {
        /// The vertex.
        vertex: u64,
        /// One cell of each of two parts.
        cells: [u64; 2],
    },
    /// The link of a vertex is neither a disc nor a sphere.
    LinkNotADisc {
        /// The vertex.
        vertex: u64,
        /// The link's Euler characteristic.
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
    /// Two boundary facets are folded onto each other in one plane (or line).
    Folded {
        /// The ridge between them.
        ridge: Vec<u64>,
        /// Their cells.
        cells: [u64; 2],
    },
    /// The far vertex of a neighbour lies strictly inside the circumsphere of a cell.
    NotEmpty {
        /// The two cells.
        cells: [u64; 2],
        /// The vertex of the second, inside the sphere of the first.
        vertex: u64,
    },
    /// Cospherical cells are not those of the lexicographic perturbation.
    TieBrokenOtherwise {
        /// The two cells.
        cells: [u64; 2],
        /// The vertex of the second, inside the perturbed sphere of the first.
        vertex: u64,
    },
    /// The interior point of one cell lies in another, too.
    CoveredTwice {
        /// The cell whose interior point was taken.
        cell: u64,
        /// The other cell.
        other: u64,
    },
    /// A cell has a part on the outer side of a boundary facet.
    BeyondBoundary {
        /// The cell.
        cell: u64,
        /// The cell of the boundary facet.
        other: u64,
        /// The facet's vertices.
        facet: Vec<u64>,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Shape { reason } => f.write_str(reason),
            Fault::NotFinite { point } => write!(f, "point {point} is not finite"),
            Fault::OutOfRange { cell, index } => {
                write!(f, "cell {cell} names point {index}, which does not exist")
            }
            Fault::RepeatedVertex { cell, vertex } => {
                write!(f, "cell {cell} names point {vertex} twice")
            }
            Fault::CellTwice { cells: [a, b] } => {
                write!(f, "cells {a} and {b} have the same vertices")
            }
            Fault::Unused { point } => {
                write!(f, "point {point} is no vertex and coincides with none")
            }
            Fault::CoincidentVertices { points: [a, b] } => {
                write!(f, "points {a} and {b} coincide, and both are vertices")
            }
            Fault::NotRepresentative { vertex, smallest } => {
                write!(f, "vertex {vertex} coincides with point {smallest}, which should stand for it")
            }
            Fault::NoCells => f.write_str("there are no cells, though the points span the space"),
            geometric => geometric.fmt_geometric(f),
        }
    }
}

impl Fault {
    /// The faults of the levels `orientation` and `manifold`.
    fn fmt_geometric(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Flat { cell } => write!(f, "cell {cell} is flat"),
            Fault::Negative { cell } => write!(f, "cell {cell} is negatively oriented"),
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

    /// The faults of the levels after `manifold`.
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
                write!(f, "vertex {vertex} of cell {b} lies inside the sphere of cell {a}")
            }
            Fault::TieBrokenOtherwise { cells: [a, b], vertex } => write!(
                f,
                "cells {a} and {b} are cospherical and not those of the perturbation (vertex {vertex})"
            ),
            Fault::CoveredTwice { cell, other } => {
                write!(f, "an interior point of cell {cell} lies in cell {other}, too")
            }
            Fault::BeyondBoundary { cell, other, facet } => {
                write!(f, "cell {cell} reaches beyond the boundary facet {facet:?} of cell {other}")
            }
            other => write!(f, "{other:?}"),
        }
    }
}

/// One level of the verification.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LevelReport {
    /// `structure`, `orientation`, `manifold`, `hull`, `empty spheres` or `single cover`.
    pub name: &'static str,
    /// The level ran and found no fault.
    pub passed: bool,
    /// How many items were checked: points and cells; cells; facets and vertices; boundary ridges;
    /// interior facets; cells and boundary facets.
    pub checked: u64,
    /// The first faults, at most [`KEPT`].
    pub faults: Vec<Fault>,
    /// How many faults there are.
    pub fault_count: u64,
    /// The earlier level whose failure kept this one from running.
    pub stopped_by: Option<&'static str>,
}

/// The outcome of [`super::verify`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Report {
    /// The levels, in order.
    pub levels: Vec<LevelReport>,
    /// 2 or 3.
    pub dimension: usize,
    /// Was the lexicographic perturbation required?
    pub perturbed: bool,
    /// Number of points.
    pub points: u64,
    /// Number of cells.
    pub cells: u64,
    /// Number of facets with one cell.
    pub hull_facets: u64,
    /// Number of facets with two cells.
    pub interior_facets: u64,
    /// Number of interior facets whose two cells are exactly cospherical.
    pub ties: u64,
    /// Number of points that are vertices.
    pub vertices_used: u64,
    /// Number of points that coincide with a point of smaller index.
    pub duplicates: u64,
    /// The dimension of the points' affine hull, -1 for no points.
    pub dimension_of_points: i32,
}

impl Report {
    /// Did every level run, without a fault?
    pub fn passed(&self) -> bool {
        self.levels.iter().all(|level| level.passed)
    }

    /// The level of that name.
    pub fn level(&self, name: &str) -> Option<&LevelReport> {
        self.levels.iter().find(|level| level.name == name)
    }
}

/// Faults as they are found: the first few and how many.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// The first faults.
    pub faults: Vec<Fault>,
    /// How many faults.
    pub count: u64,
    /// How many items were checked.
    pub checked: u64,
    /// How many of them were ties.
    pub ties: u64,
}

impl Tally {
    /// Notes one fault.
    pub fn fault(&mut self, fault: Fault) {
        self.count += 1;
        if self.faults.len() < KEPT {
            self.faults.push(fault);
        }
    }

    /// Appends what was found in later items.
    pub fn append(&mut self, later: Tally) {
        self.count += later.count;
        self.checked += later.checked;
        self.ties += later.ties;
        let room = KEPT - self.faults.len();
        self.faults.extend(later.faults.into_iter().take(room));
    }

    /// The level's report.
    pub fn level(self, name: &'static str) -> LevelReport {
        LevelReport {
            name,
            passed: self.count == 0,
            checked: self.checked,
            faults: self.faults,
            fault_count: self.count,
            stopped_by: None,
        }
    }
}
