//! Is a mesh a mesh of its domain?
//!
//! **Statement.** [`check`] finds nothing only if
//! 1. every cell is positive (exact sign), each facet of cells is in at most two, in two on opposite sides;
//! 2. a facet of cells in one cell only, or between two components, is a listed face, and a listed face is in
//!    exactly the cells that it names;
//! 3. on each segment the listed edges are a chain from corner to corner;
//! 4. on each facet the faces, all turned one way in a projection along an axis (exact signs), have each edge once in
//!    each direction, but for the pieces of its boundary segments, which they have once; and for each pair of components (or the
//!    outside) their areas add up to those of the domain's walls between these, to 1e-9 of the facet;
//! 5. the cells of each component add up to its measure, to 1e-9 of it;
//! 6. corners are where the domain has them, points are on their carriers to 1e-12 of the largest coordinate, cells use every
//!    point, rows are in canonical order, markers are the domain's.
//!
//! *Then, up to the tolerances, the cells tile the domain and the faces its facets, each once.* By 4 the faces of a facet are
//! a chain whose boundary is the facet's, so they cover it with a constant degree, and by its area with degree one. By 1 and 2
//! the cells of a component are a chain whose boundary lies in faces on the walls; they cover with
//! degrees that are constant between walls and, all being positive, nowhere negative; by 4 the boundary is that of the
//! component, so the degree is one in it and zero elsewhere; 5 says so once more, by other numbers.
//!
//! It shares no code with generation: of the domain it reads features, walls and components, of geometry the
//! predicates.
//!
//! **Work and depth.** `O(m log m)`, sequential.

mod adjacency;
mod follow;
mod shape;
mod tiles;

use septet_geometry::point::Point;
use septet_geometry::predicates::{Sign, orientation};
use septet_geometry::range::{scale, scale_exponent};

use crate::domain::{Domain, Feature};
use crate::mesh::{Carrier, Mesh};
use crate::quality::angles::measure;
use crate::space::Space;

/// How far sums of areas and volumes may be off, relative to the whole.
pub const SUMS: f64 = 1e-9;

/// How far a point may be off its carrier, relative to the largest coordinate.
pub const OFF: f64 = 1e-12;

pub use follow::{Deviation, LOOSE};

/// A component of the domain, or nothing of it.
pub type Beside = Option<u32>;

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
    #[error("{feature:?} between {beside:?}: faces add up to {found}, the domain has {expected}")]
    Area {
        /// The facet; in the plane the segment.
        feature: Feature,
        /// The components; none is the outside.
        beside: [Beside; 2],
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

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conformity {
    /// What is wrong: by features from corners to facets within each kind of check.
    pub defects: Vec<MeshDefect>,
    /// Area or volume of the domain and of the mesh, in the unit of the file.
    pub measure: [f64; 2],
    /// Length or area of the domain's boundary towards the outside and of the mesh's, in the unit of the file.
    pub boundary: [f64; 2],
    /// Of a boundary that follows a surface, how far they are from each other.
    pub deviation: Option<Deviation>,
}

impl Conformity {
    /// Do the arrays not even fit together, so that nothing else could be looked at?
    pub fn is_shapeless(&self) -> bool {
        self.measure == [0.0; 2] && !self.is_clean()
    }

    /// Is nothing wrong?
    pub fn is_clean(&self) -> bool {
        self.defects.is_empty()
    }
}

/// A sum with its rounding carried along (Neumaier).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    pub(crate) fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        self.lost += if self.sum.abs() >= x.abs() { (self.sum - sum) + x } else { (x - sum) + self.sum };
        self.sum = sum;
    }

    pub(crate) fn value(self) -> f64 {
        self.sum + self.lost
    }
}

/// What all parts of the check look at.
struct Checker<'a, P: Space> {
    domain: &'a Domain<P>,
    mesh: &'a Mesh<P>,
    /// The points of the mesh in the domain's scaled coordinates.
    points: Vec<P>,
    found: Conformity,
}

/// Compares a mesh with its domain.
pub fn check<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) -> Conformity {
    compare(domain, mesh, None)
}

/// What is asked of a boundary that follows a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follow {
    /// Edges of the surface that turn by more than this, in degrees, are kept.
    pub feature_angle: f64,
    /// The largest [`Deviation`], in the unit of the file; [`LOOSE`] times the size at a face if not said.
    pub distance: Option<f64>,
}

/// Compares a mesh whose boundary follows a closed surface of space without being it. Finds nothing only if
/// 1. and 2. hold as in [`check`];
/// 3. every face is in one cell and its corners lie on the surface; every edge of faces is in two of them, the faces at
///    every vertex are one fan: the boundary is a closed 2-manifold;
/// 4. where other than two ridges meet there is a point of the mesh, and the listed edges join each point on a ridge to the
///    next, all along the ridges, and are edges of faces;
/// 5. boundary and surface are no farther from each other than is asked, both ways, in the places that [`Deviation`] looks at;
/// 6. every component has cells, points are on their carriers to 1e-12 of the largest coordinate, cells use every point, rows
///    are in canonical order.
///
/// *Then the boundary does not cross itself:* cells of a component that have all their facets in common, on opposite sides, but for
/// those on the boundary, cover space with a degree that changes at the boundary alone, by one, and is nowhere negative.
/// Measures and boundaries are added up, and nothing else is asked of them.
pub fn check_remeshed<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>, follow: &Follow) -> Conformity {
    compare(domain, mesh, Some(follow))
}

fn compare<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>, follow: Option<&Follow>) -> Conformity {
    let mut checker = Checker { domain, mesh, points: Vec::new(), found: Conformity::default() };
    checker.found.defects = shape::shape(domain, mesh);
    if !checker.found.is_clean() {
        return checker.found;
    }
    checker.points = mesh.points.iter().map(|&p| scale(p, domain.simplices.exponent)).collect();
    if let Some(range) = out_of_range(&checker.points) {
        checker.found.defects.push(MeshDefect::Range(range));
        return checker.found;
    }
    checker.cells();
    checker.faces();
    checker.used();
    checker.carriers(follow.is_none());
    if let Some(follow) = follow {
        checker.boundaries();
        checker.follows(follow);
    } else {
        checker.segments();
        checker.facets();
    }
    checker.volumes(follow.is_none());
    checker.found
}

fn out_of_range<P: Point>(points: &[P]) -> Option<String> {
    match scale_exponent(points) {
        Ok(0) => None,
        Ok(e) => Some(format!("in the domain's scale they lie outside the exact range (by 2^{e})")),
        Err(error) => Some(error.to_string()),
    }
}

impl<P: Space> Checker<'_, P> {
    fn report(&mut self, defect: MeshDefect) {
        self.found.defects.push(defect);
    }

    fn corners(&self, cell: &P::Cell) -> [P; 4] {
        let mut corners = [P::default(); 4];
        for (corner, &v) in corners.iter_mut().zip(cell.as_ref()) {
            *corner = self.points[v as usize];
        }
        corners
    }

    /// A measure of dimension `d` in the unit of the file.
    fn unscaled(&self, mut x: f64, d: usize) -> f64 {
        for _ in 0..d {
            x = scale(P::splat(x), -self.domain.simplices.exponent).coord(0);
        }
        x
    }

    fn cells(&mut self) {
        for (i, cell) in self.mesh.cells.iter().enumerate() {
            let sign = orientation(&self.corners(cell)[..=P::DIM]);
            let row = cell.as_ref();
            let ordered = (0..P::DIM - 1).all(|k| row[k + 1..].iter().all(|&v| row[k] < v));
            let behind = i == 0 || self.mesh.cells[i - 1] < *cell;
            let cell = i as u32;
            if sign != Sign::Positive {
                self.report(MeshDefect::Orientation { cell, sign });
            }
            if !ordered || !behind {
                self.report(MeshDefect::Order { cell });
            }
        }
    }

    fn used(&mut self) {
        let mut used = vec![false; self.points.len()];
        for cell in &self.mesh.cells {
            cell.as_ref().iter().for_each(|&v| used[v as usize] = true);
        }
        for (i, &carrier) in self.mesh.carriers.iter().enumerate() {
            if !used[i] {
                self.report(MeshDefect::Unused { point: i as u32, what: "cell", carrier });
            }
        }
    }

    fn volumes(&mut self, exact: bool) {
        let mut sums = vec![Sum::default(); self.domain.components.len()];
        for (cell, &region) in self.mesh.cells.iter().zip(&self.mesh.regions) {
            sums[region as usize].add(measure(&self.corners(cell)));
        }
        if !exact {
            self.has_cells(&sums);
        }
        let mut totals = [Sum::default(); 2];
        for (component, (sum, of)) in sums.into_iter().zip(&self.domain.components).enumerate() {
            if !of.inside {
                continue;
            }
            totals[0].add(of.measure);
            totals[1].add(sum.value());
            if exact && off(of.measure, sum.value(), of.measure) {
                let [expected, found] = [of.measure, sum.value()].map(|x| self.unscaled(x, P::DIM));
                self.report(MeshDefect::Volume { component: component as u32, expected, found });
            }
        }
        self.found.measure = totals.map(|t| self.unscaled(t.value(), P::DIM));
    }
}

/// Are two sums further apart than they may be?
fn off(expected: f64, found: f64, whole: f64) -> bool {
    let difference = (expected - found).abs();
    difference > SUMS * whole.abs() || difference.is_nan()
}
