//! A domain as a file states it, before anything has been checked.

use septet_geometry::point::Point;

/// What the pieces of an input are meant to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A piecewise linear complex (`.poly`, `.smesh`): internal and dangling pieces, isolated points,
    /// hole points and regions are legal; vertices may lie on segments and in facets.
    Complex,
    /// Closed triangle surfaces (`.stl .off .ply .obj`): every shell must be a manifold without boundary;
    /// the domain is what an odd number of shells surrounds.
    Surface,
}

/// A segment of the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputSegment {
    /// Its ends, as positions in [`Input::points`].
    pub ends: [u32; 2],
    /// The marker of the file, 0 if there is none.
    pub marker: i64,
}

/// A planar facet of the input (space only): what its polygons surround, without its holes. The outside of
/// the outermost polygons is not part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct InputFacet<P> {
    /// Polygons as closed loops of positions in [`Input::points`]; a loop of two is a segment in the facet,
    /// a loop of one a point in it.
    pub polygons: Vec<Vec<u32>>,
    /// Points in the holes of the facet.
    pub holes: Vec<P>,
    /// The marker of the file, 0 if there is none.
    pub marker: i64,
}

/// A region: the component of the domain around a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<P> {
    /// A point strictly inside of it.
    pub at: P,
    /// The attribute that its cells get.
    pub attribute: f64,
    /// The largest volume (area in the plane) that its cells may have, if limited.
    pub limit: Option<f64>,
}

/// A domain as read.
#[derive(Clone, Debug, PartialEq)]
pub struct Input<P> {
    /// Complex or surface.
    pub kind: Kind,
    /// The vertices. Coordinates in the file's unit.
    pub points: Vec<P>,
    /// A marker for each point, or none at all.
    pub markers: Vec<i64>,
    /// Segments that are listed for themselves.
    pub segments: Vec<InputSegment>,
    /// Facets (space only).
    pub facets: Vec<InputFacet<P>>,
    /// Points in the holes of the domain.
    pub holes: Vec<P>,
    /// Regions.
    pub regions: Vec<Region<P>>,
}

impl<P: Point> Input<P> {
    /// An input of these points and nothing else.
    pub fn new(kind: Kind, points: Vec<P>) -> Self {
        Input {
            kind,
            points,
            markers: Vec::new(),
            segments: Vec::new(),
            facets: Vec::new(),
            holes: Vec::new(),
            regions: Vec::new(),
        }
    }

    /// A closed surface of these faces.
    pub fn surface(points: Vec<P>, faces: impl IntoIterator<Item = Vec<u32>>) -> Self {
        let facet = |face| InputFacet { polygons: vec![face], holes: Vec::new(), marker: 0 };
        Input { facets: faces.into_iter().map(facet).collect(), ..Input::new(Kind::Surface, points) }
    }
}
