//! Meshes of domains: what generation makes and everything behind it takes.
//!
//! **Statement.** Points lie on *carriers*, the lowest-dimensional pieces of the domain that hold them; cells tile
//! the components of the domain, faces tile its facets (in the plane: its segments), edges its segments in space.
//! [`crate::conformity::check`] says whether all this is so.

use septet_geometry::point::{Point, Simplex};

use crate::domain::{Domain, Feature};
use crate::space::Space;

/// No cell: the outside of the domain, holes included.
pub const OUTSIDE: u32 = u32::MAX;

/// The lowest-dimensional piece of the domain that a point lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Carrier {
    /// Position in [`Domain::corners`].
    Corner(u32),
    /// Position in [`Domain::segments`].
    Segment(u32),
    /// Position in [`Domain::facets`].
    Facet(u32),
    /// Nothing but the inside.
    Volume,
}

impl Carrier {
    /// 0 for corners, 1 for segments, 2 for facets; what is on none of them has the dimension of the space.
    pub fn dimension(self, space: usize) -> usize {
        match self {
            Carrier::Corner(_) => 0,
            Carrier::Segment(_) => 1,
            Carrier::Facet(_) => 2,
            Carrier::Volume => space,
        }
    }

    /// The feature, if it is one.
    pub fn feature(self) -> Option<Feature> {
        match self {
            Carrier::Corner(i) => Some(Feature::Corner(i)),
            Carrier::Segment(i) => Some(Feature::Segment(i)),
            Carrier::Facet(i) => Some(Feature::Facet(i)),
            Carrier::Volume => None,
        }
    }
}

impl From<Feature> for Carrier {
    fn from(feature: Feature) -> Self {
        match feature {
            Feature::Corner(i) => Carrier::Corner(i),
            Feature::Segment(i) => Carrier::Segment(i),
            Feature::Facet(i) => Carrier::Facet(i),
        }
    }
}

/// A facet of cells that lies on the domain's own (in the plane: an edge on a segment).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face<P: Point> {
    /// Its points, in any order.
    pub vertices: P::Facet,
    /// Position in [`Domain::facets`], in the plane in [`Domain::segments`].
    pub facet: u32,
    /// The marker of that piece.
    pub marker: i64,
    /// The cells that have it, in any order; [`OUTSIDE`] where there is none.
    pub cells: [u32; 2],
}

/// An edge of cells that lies on a segment. In the plane faces say this.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Its points, in any order.
    pub vertices: [u32; 2],
    /// Position in [`Domain::segments`].
    pub segment: u32,
    /// The marker of the segment.
    pub marker: i64,
}

/// A mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh<P: Point> {
    /// Coordinates in the unit of the file.
    pub points: Vec<P>,
    /// The size function at each point, in the unit of the file.
    pub sizes: Vec<f64>,
    /// What each point lies on.
    pub carriers: Vec<Carrier>,
    /// Positively oriented rows in canonical order: smallest point first, then the second smallest, the last two
    /// by orientation (in the plane: smallest first); rows ascending.
    pub cells: Vec<P::Cell>,
    /// Position of each cell's component in [`Domain::components`].
    pub regions: Vec<u32>,
    /// The faces on facets.
    pub faces: Vec<Face<P>>,
    /// The edges on segments; none in the plane.
    pub edges: Vec<Edge>,
    /// Cells with all vertices on one facet that were left out.
    pub dropped: u64,
}

impl<P: Point> Default for Mesh<P> {
    fn default() -> Self {
        Mesh {
            points: Vec::new(),
            sizes: Vec::new(),
            carriers: Vec::new(),
            cells: Vec::new(),
            regions: Vec::new(),
            faces: Vec::new(),
            edges: Vec::new(),
            dropped: 0,
        }
    }
}

impl<P: Point> Mesh<P> {
    /// The points of a cell, the first `DIM + 1` of four.
    pub fn corners(&self, cell: u32) -> [P; 4] {
        let mut corners = [P::default(); 4];
        for (corner, &v) in corners.iter_mut().zip(self.cells[cell as usize].as_ref()) {
            *corner = self.points[v as usize];
        }
        corners
    }

    /// Every edge of the cells once, ends ascending, sorted.
    pub fn cell_edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.cells.len() * P::Cell::LEN * (P::Cell::LEN - 1) / 2);
        for cell in &self.cells {
            let cell = cell.as_ref();
            for (i, &a) in cell.iter().enumerate() {
                edges.extend(cell[i + 1..].iter().map(|&b| [a.min(b), a.max(b)]));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        edges
    }
}

/// The number that names each component in files: the attribute of its region; components without a region get
/// whole numbers above all attributes, or their own number if there are no regions at all. What is not inside is 0.
pub fn region_names<P: Space>(domain: &Domain<P>) -> Vec<f64> {
    let attributes = domain.regions.iter().map(|r| r.attribute);
    let mut next = attributes.fold(0.0f64, f64::max).floor();
    let mut name = |c: &crate::domain::Component| match c.region {
        _ if !c.inside => 0.0,
        Some(region) => domain.regions[region as usize].attribute,
        None => {
            next += 1.0;
            next
        }
    };
    domain.components.iter().map(&mut name).collect()
}

/// The marker of each point: that of its carrier; of a corner, the first that is not 0 of the segments and then the
/// facets that have it.
pub fn point_markers<P: Space>(domain: &Domain<P>, mesh: &Mesh<P>) -> Vec<i64> {
    let position = |v: u32| domain.corners.binary_search(&v).ok();
    let mut of_corner = vec![0; domain.corners.len()];
    let mut set = |c: Option<usize>, marker: i64| match c {
        Some(c) if of_corner[c] == 0 => of_corner[c] = marker,
        _ => {}
    };
    for segment in &domain.segments {
        segment.ends().into_iter().for_each(|v| set(position(v), segment.marker));
    }
    for facet in &domain.facets {
        facet.corners.iter().for_each(|&v| set(position(v), facet.marker));
    }
    let marker = |carrier: &Carrier| match *carrier {
        Carrier::Corner(c) => of_corner[c as usize],
        Carrier::Segment(s) => domain.segments[s as usize].marker,
        Carrier::Facet(f) => domain.facets[f as usize].marker,
        Carrier::Volume => 0,
    };
    mesh.carriers.iter().map(marker).collect()
}

/// What one stage of generation did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageLine {
    /// Its name, such as `segments`.
    pub name: String,
    /// Candidates made.
    pub candidates: u64,
    /// Points kept.
    pub points: u64,
    /// Rounds of completion.
    pub completion_rounds: u64,
    /// Rounds of independent sets.
    pub set_rounds: u64,
    /// Rounds of the machine.
    pub rounds: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes of them.
    pub bytes: u64,
    /// Operations counted.
    pub work: u64,
    /// Steps of the longest chain.
    pub depth: u64,
    /// Seconds, as measured by the caller.
    pub seconds: f64,
}
