//! The description of a domain in a file, before any check.

use septet_geometry::point::Point;

/// The kind of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DomainKind {
    /// A piecewise linear complex (`.poly`, `.smesh`). Internal and dangling elements, isolated points, hole points and
    /// regions are legal. Vertices may lie on segments and in facets.
    Complex,
    /// Closed triangle surfaces (`.stl .off .ply .obj`). Every shell must be a manifold without boundary. The domain is
    /// the set of points that an odd number of shells encloses.
    Surface,
}

/// A segment of the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputSegment {
    /// Its ends, as positions in [`Input::points`].
    pub ends: [u32; 2],
    /// The marker of the file, or 0.
    pub marker: i64,
}

/// A planar facet of the input (space only): the area inside its polygons, without its holes. The area outside the
/// outermost polygons is not part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct InputFacet<P> {
    /// Polygons as closed loops of positions in [`Input::points`]. A loop of two points is a segment in the facet, and
    /// a loop of one point is a point in it.
    pub polygons: Vec<Vec<u32>>,
    /// Points in the holes of the facet.
    pub holes: Vec<P>,
    /// The marker of the file, or 0.
    pub marker: i64,
}

/// A region: the component of the domain around a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<P> {
    /// A point strictly inside it.
    pub at: P,
    /// The attribute of its cells.
    pub attribute: f64,
    /// The target for the volume (in the plane: the area) of its cells, if there is one.
    pub limit: Option<f64>,
}

/// A solid of a surface: a run of its facets, with a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Solid {
    /// The name in the file, or the name of the file.
    pub name: String,
    /// The position after its last facet. Its first facet follows the last one of the solid before.
    pub end: u32,
}

/// The description of a domain, as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Input<P> {
    /// The kind: complex or surface.
    pub kind: DomainKind,
    /// The vertices, in the unit of the file.
    pub points: Vec<P>,
    /// The marker of each point, or an empty list.
    pub markers: Vec<i64>,
    /// The segments listed separately from facets.
    pub segments: Vec<InputSegment>,
    /// Facets (space only).
    pub facets: Vec<InputFacet<P>>,
    /// Points in the holes of the domain.
    pub holes: Vec<P>,
    /// Regions.
    pub regions: Vec<Region<P>>,
    /// The solids of a surface, in the order of their facets. Empty if there is only one.
    pub solids: Vec<Solid>,
}

impl<P: Point> Input<P> {
    /// Creates an input of points only.
    pub fn new(kind: DomainKind, points: Vec<P>) -> Self {
        Input {
            kind,
            points,
            markers: Vec::new(),
            segments: Vec::new(),
            facets: Vec::new(),
            holes: Vec::new(),
            regions: Vec::new(),
            solids: Vec::new(),
        }
    }

    /// Creates a closed surface with the given faces.
    pub fn surface(points: Vec<P>, faces: impl IntoIterator<Item = Vec<u32>>) -> Self {
        let facet = |face| InputFacet { polygons: vec![face], holes: Vec::new(), marker: 0 };
        Input { facets: faces.into_iter().map(facet).collect(), ..Input::new(DomainKind::Surface, points) }
    }
}
