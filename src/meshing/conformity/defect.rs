//! Defects of a mesh of a domain.

use septet_geometry::predicates::Sign;

use crate::domain::Feature;
use crate::mesh::Carrier;

/// A component of the domain, or `None` for the outside.
pub type SideComponent = Option<u32>;

/// A defect of a mesh. Indices of cells, faces, edges and points refer to the mesh, and all other indices to the
/// domain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshDefect {
    /// The length of an array is wrong.
    #[error("array {what} has {found} entries instead of {expected}")]
    Length {
        /// The array.
        what: &'static str,
        /// The required length.
        expected: usize,
        /// The actual length.
        found: usize,
    },
    /// An index is out of range.
    #[error("{what} {row} refers to {value}, which does not exist")]
    Index {
        /// The kind of the row.
        what: &'static str,
        /// The row.
        row: u32,
        /// The index.
        value: u32,
    },
    /// A row contains a point twice.
    #[error("{what} {row} contains a point twice")]
    Repeated {
        /// The kind of the row.
        what: &'static str,
        /// The row.
        row: u32,
    },
    /// Coordinates are not finite, or they exceed the range of the exact predicates.
    #[error("invalid coordinates: {0}")]
    Range(String),
    /// The size at a point is not a positive number.
    #[error("point {point} has size {size}, which is not positive and finite")]
    Size {
        /// The point.
        point: u32,
        /// The size.
        size: f64,
    },
    /// A cell is inverted or flat.
    #[error("cell {cell} is {}", if *.sign == Sign::Zero { "flat" } else { "inverted" })]
    Orientation {
        /// The cell.
        cell: u32,
        /// The sign of its orientation.
        sign: Sign,
    },
    /// A cell is not in canonical order, or it does not follow the previous one.
    #[error("cell {cell} is out of order")]
    Order {
        /// The cell.
        cell: u32,
    },
    /// A cell is assigned to a component outside the domain.
    #[error("cell {cell} lies in component {component}, which is not part of the domain")]
    Region {
        /// The cell.
        cell: u32,
        /// The component.
        component: u32,
    },
    /// More than two cells share a facet.
    #[error("{count} cells share the facet {vertices:?}")]
    Crowded {
        /// The points of the facet, ascending.
        vertices: Vec<u32>,
        /// The number of cells.
        count: usize,
    },
    /// Two cells lie on the same side of their common facet.
    #[error("cells {} and {} lie on the same side of their common facet", .cells[0], .cells[1])]
    SameSide {
        /// The cells.
        cells: [u32; 2],
    },
    /// A facet of only one cell is not a listed face.
    #[error("the facet {vertices:?} of cell {cell} has no other cell and is not a listed face")]
    Open {
        /// The cell.
        cell: u32,
        /// The points of the facet, ascending.
        vertices: Vec<u32>,
    },
    /// A facet between two components is not a listed face.
    #[error("cells {} and {} lie in different components, but no listed face separates them", .cells[0], .cells[1])]
    Unmarked {
        /// The cells.
        cells: [u32; 2],
    },
    /// The cells that a face lists are not exactly the cells that have the face.
    #[error("face {face} lists cells {listed:?} but belongs to cells {found:?}")]
    FaceCells {
        /// The face.
        face: u32,
        /// The cells that it lists.
        listed: Vec<u32>,
        /// The cells that have the face.
        found: Vec<u32>,
    },
    /// A face or an edge is listed twice.
    #[error("{what} {row} is listed twice")]
    Twice {
        /// The kind: face or edge.
        what: &'static str,
        /// The second row.
        row: u32,
    },
    /// The marker of a face or an edge differs from the marker of its facet or segment.
    #[error("{what} {row} has marker {found} instead of {expected}")]
    Marker {
        /// The kind: face or edge.
        what: &'static str,
        /// The row.
        row: u32,
        /// The marker in the domain.
        expected: i64,
        /// The marker in the mesh.
        found: i64,
    },
    /// The carrier of a point of a face or an edge is not part of the facet or segment.
    #[error("{what} {row} on {feature:?} contains point {point}, whose carrier is {carrier:?}")]
    Carried {
        /// The kind: face or edge.
        what: &'static str,
        /// The row.
        row: u32,
        /// The facet or segment.
        feature: Feature,
        /// The point.
        point: u32,
        /// The carrier of the point.
        carrier: Carrier,
    },
    /// A point does not lie on its carrier.
    #[error("point {point} is at distance {distance} from its carrier {feature:?}")]
    OffCarrier {
        /// The point.
        point: u32,
        /// The carrier.
        feature: Feature,
        /// The distance from the carrier, in the unit of the file.
        distance: f64,
    },
    /// A corner has no point of the mesh, or more than one.
    #[error("corner {corner} has {count} points of the mesh instead of one")]
    Corner {
        /// The corner.
        corner: u32,
        /// The number of points that have this corner as carrier.
        count: usize,
    },
    /// A point is in no cell, or in no face or edge of its carrier.
    #[error("no {what} contains point {point} on {carrier:?}")]
    Unused {
        /// The point.
        point: u32,
        /// The kind: cell, face, edge or ridge.
        what: &'static str,
        /// The carrier.
        carrier: Carrier,
    },
    /// The edges on a segment do not form a chain between its corners.
    #[error("segment {segment} is not tiled: the chain of edges breaks at point {at:?}")]
    Chain {
        /// The segment.
        segment: u32,
        /// The point at which the chain breaks. `None` if the segment has no edges.
        at: Option<u32>,
    },
    /// An edge on a segment is not an edge of any cell.
    #[error("edge {edge} is not an edge of any cell")]
    LooseEdge {
        /// The edge.
        edge: u32,
    },
    /// A face has no area when projected to the plane of its facet.
    #[error("face {face} has no area in the plane of facet {facet}")]
    FlatFace {
        /// The face.
        face: u32,
        /// The facet.
        facet: u32,
    },
    /// The faces of a facet do not meet correctly at an edge.
    #[error("edge {edge:?} of facet {facet} has {} faces on its left and {} on its right, but the total must be {required}", .sides[0], .sides[1])]
    FacetEdge {
        /// The facet.
        facet: u32,
        /// The ends, ascending.
        edge: [u32; 2],
        /// The numbers of faces on its left and on its right.
        sides: [u32; 2],
        /// The required total: 1 on boundary segments, otherwise 2, one on each side.
        required: u32,
    },
    /// The faces on a facet that separate two components have the wrong total area. In the plane, this is the total
    /// length of the edges on a segment.
    #[error(
        "the faces on {feature:?} between components {components:?} have measure {found} instead of {expected}"
    )]
    Area {
        /// The facet. In the plane, the segment.
        feature: Feature,
        /// The components on the two sides. `None` is the outside.
        components: [SideComponent; 2],
        /// The total in the domain, in the unit of the file.
        expected: f64,
        /// The total in the mesh.
        found: f64,
    },
    /// A face of a remeshed boundary has cells on both sides.
    #[error("face {face} has cells on both sides")]
    Inner {
        /// The face.
        face: u32,
    },
    /// An edge of the boundary does not have two faces, or the faces at a vertex form several fans.
    #[error("the boundary is not a manifold at points {vertices:?}, where {faces} faces meet")]
    Pinched {
        /// The edge, ascending, or the vertex.
        vertices: Vec<u32>,
        /// The number of faces there.
        faces: usize,
    },
    /// The remeshed boundary and the surface are too far from each other.
    #[error("{what} {row} is at distance {distance} from the {}, above the limit of {allowed}", if *.what == "face" { "surface" } else { "boundary" })]
    Astray {
        /// The kind: a face of the mesh, or a vertex of the surface.
        what: &'static str,
        /// Its index.
        row: u32,
        /// The distance, in the unit of the file.
        distance: f64,
        /// The largest allowed distance.
        allowed: f64,
    },
    /// The total measure of the cells of a component is wrong.
    #[error("the cells of component {component} have measure {found} instead of {expected}")]
    Volume {
        /// The component.
        component: u32,
        /// The measure in the domain, in the unit of the file.
        expected: f64,
        /// The measure in the mesh.
        found: f64,
    },
}

impl MeshDefect {
    /// Returns the input feature of the defect, if there is one.
    pub fn feature(&self) -> Option<Feature> {
        match *self {
            Self::Carried { feature, .. } | Self::OffCarrier { feature, .. } | Self::Area { feature, .. } => {
                Some(feature)
            }
            Self::Corner { corner, .. } => Some(Feature::Corner(corner)),
            Self::Chain { segment, .. } => Some(Feature::Segment(segment)),
            Self::FlatFace { facet, .. } | Self::FacetEdge { facet, .. } => Some(Feature::Facet(facet)),
            Self::Unused { carrier, .. } => carrier.feature(),
            _ => None,
        }
    }
}
