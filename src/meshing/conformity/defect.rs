//! What may be wrong with a mesh of a domain.

use septet_geometry::predicates::Sign;

use crate::domain::Feature;
use crate::mesh::Carrier;

/// A component of the domain, or nothing of it.
pub type SideComponent = Option<u32>;

/// What is wrong with a mesh. Cells, faces, edges and points are positions in the mesh, all else in the domain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshDefect {
    /// Arrays do not fit together.
    #[error("{found} {what} where {expected} are due")]
    Length {
        /// Of what.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A number names nothing.
    #[error("{what} {row} names {value}, which does not exist")]
    Index {
        /// What names it.
        what: &'static str,
        /// Its row.
        row: u32,
        /// The number.
        value: u32,
    },
    /// A row names a point twice.
    #[error("{what} {row} has a point twice")]
    Repeated {
        /// What does.
        what: &'static str,
        /// Its row.
        row: u32,
    },
    /// Coordinates are not finite or need more digits than exact signs have.
    #[error("the coordinates: {0}")]
    Range(String),
    /// The size at a point is no positive number.
    #[error("point {point}: the size is {size}")]
    Size {
        /// The point.
        point: u32,
        /// As given.
        size: f64,
    },
    /// A cell is inverted or flat.
    #[error("cell {cell} is {}", if *.sign == Sign::Zero { "flat" } else { "inverted" })]
    Orientation {
        /// The cell.
        cell: u32,
        /// Its sign.
        sign: Sign,
    },
    /// A row is not in canonical order, or not behind the one before.
    #[error("cell {cell} is out of order")]
    Order {
        /// The cell.
        cell: u32,
    },
    /// A cell is said to lie in what is not part of the domain.
    #[error("cell {cell} lies in component {component}, which is not part of the domain")]
    Region {
        /// The cell.
        cell: u32,
        /// The component.
        component: u32,
    },
    /// More than two cells have a facet.
    #[error("{count} cells have the facet {vertices:?}")]
    Crowded {
        /// Its points, ascending.
        vertices: Vec<u32>,
        /// How many.
        count: usize,
    },
    /// Two cells lie on the same side of their common facet.
    #[error("cells {} and {} lie on the same side of their common facet", .cells[0], .cells[1])]
    SameSide {
        /// The cells.
        cells: [u32; 2],
    },
    /// A facet of one cell only is no face.
    #[error("the facet {vertices:?} of cell {cell} has no other cell and is no face")]
    Open {
        /// The cell.
        cell: u32,
        /// The points of the facet, ascending.
        vertices: Vec<u32>,
    },
    /// The facet between two components is no face.
    #[error("cells {} and {} lie in different components and have no face between them", .cells[0], .cells[1])]
    Unmarked {
        /// The cells.
        cells: [u32; 2],
    },
    /// A face is not in the cells that it names, and in these only.
    #[error("face {face} names cells {named:?} and is in {found:?}")]
    FaceCells {
        /// The face.
        face: u32,
        /// The cells named.
        named: Vec<u32>,
        /// The cells that have it.
        found: Vec<u32>,
    },
    /// A face or an edge is listed twice.
    #[error("{what} {row} is listed twice")]
    Twice {
        /// Face or edge.
        what: &'static str,
        /// The second of them.
        row: u32,
    },
    /// A face or an edge has another marker than the domain.
    #[error("{what} {row} has marker {found}, the domain has {expected}")]
    Marker {
        /// Face or edge.
        what: &'static str,
        /// Its row.
        row: u32,
        /// The domain's.
        expected: i64,
        /// The mesh's.
        found: i64,
    },
    /// A point of a face or an edge is carried by something that is not part of its facet or segment.
    #[error("{what} {row} on {feature:?} has point {point}, carried by {carrier:?}")]
    Carried {
        /// Face or edge.
        what: &'static str,
        /// Its row.
        row: u32,
        /// Its facet or segment.
        feature: Feature,
        /// The point.
        point: u32,
        /// The point's carrier.
        carrier: Carrier,
    },
    /// A point is off its carrier.
    #[error("point {point} is {distance} off {feature:?}")]
    OffCarrier {
        /// The point.
        point: u32,
        /// Its carrier.
        feature: Feature,
        /// How far, in the unit of the file.
        distance: f64,
    },
    /// A corner is no point of the mesh, or more than one.
    #[error("corner {corner} is {count} points of the mesh")]
    Corner {
        /// The corner.
        corner: u32,
        /// How many points say they are it.
        count: usize,
    },
    /// A point is in no cell, or in no face or edge of its carrier.
    #[error("point {point} is in no {what} of {carrier:?}")]
    Unused {
        /// The point.
        point: u32,
        /// Cell, face or edge.
        what: &'static str,
        /// Its carrier.
        carrier: Carrier,
    },
    /// The edges on a segment are not a chain between its corners.
    #[error("segment {segment} is not tiled: the chain breaks at point {at:?}")]
    Chain {
        /// The segment.
        segment: u32,
        /// The point where it breaks; none if the segment has no edges.
        at: Option<u32>,
    },
    /// An edge on a segment is no edge of any cell.
    #[error("edge {edge} is no edge of a cell")]
    LooseEdge {
        /// The edge.
        edge: u32,
    },
    /// A face has no area in the plane of its facet.
    #[error("face {face} is flat in the plane of facet {facet}")]
    FlatFace {
        /// The face.
        face: u32,
        /// The facet.
        facet: u32,
    },
    /// An edge does not divide the faces of a facet as it should.
    #[error("facet {facet}: its edge {edge:?} has faces on {} and {} sides, where {due} are due in all", .sides[0], .sides[1])]
    FacetEdge {
        /// The facet.
        facet: u32,
        /// The ends, ascending.
        edge: [u32; 2],
        /// Faces on its left and on its right.
        sides: [u32; 2],
        /// How many are due: one on boundary segments, else one on each side.
        due: u32,
    },
    /// The faces of a facet (in the plane: of a segment) between two components do not add up.
    #[error("{feature:?} between {components:?}: faces add up to {found}, the domain has {expected}")]
    Area {
        /// The facet; in the plane the segment.
        feature: Feature,
        /// The components; none is the outside.
        components: [SideComponent; 2],
        /// Of the domain, in the unit of the file.
        expected: f64,
        /// Of the mesh.
        found: f64,
    },
    /// A face of a boundary that follows a surface has cells on both sides.
    #[error("face {face} has cells on both sides")]
    Inner {
        /// The face.
        face: u32,
    },
    /// An edge of the boundary has other than two faces, or the faces at a vertex are more than one fan.
    #[error("the boundary is no manifold at points {vertices:?}, with {faces} faces")]
    Pinched {
        /// The edge, ascending, or the vertex.
        vertices: Vec<u32>,
        /// How many faces are there.
        faces: usize,
    },
    /// The boundary and the surface that it follows are too far from each other.
    #[error("{what} {row} is {distance} from the {}, {allowed} is allowed", if *.what == "face" { "surface" } else { "boundary" })]
    Astray {
        /// A face of the mesh, or a vertex of the surface.
        what: &'static str,
        /// Which.
        row: u32,
        /// How far, in the unit of the file.
        distance: f64,
        /// How far it may be.
        allowed: f64,
    },
    /// The cells of a component do not add up.
    #[error("component {component}: cells add up to {found}, the domain has {expected}")]
    Volume {
        /// The component.
        component: u32,
        /// Of the domain, in the unit of the file.
        expected: f64,
        /// Of the mesh.
        found: f64,
    },
}

impl MeshDefect {
    /// The input feature that it concerns, if one is named.
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
