//! Meshes of domains: the result of generation.
//!
//! **Statement.** Points lie on *carriers*, the features of lowest dimension that contain them. Cells tile the
//! components of the domain. Faces tile its facets (in the plane: its segments). In space, edges tile its segments.
//! [`crate::conformity::check`] verifies this.

use septet_geometry::point::{Point, Simplex};

use crate::domain::{Domain, Feature};
use crate::space::Space;

/// The index for the outside of the domain, including holes.
pub const OUTSIDE: u32 = u32::MAX;

/// The feature of lowest dimension on which a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Carrier {
    /// Position in [`Domain::corners`].
    Corner(u32),
    /// Position in [`Domain::segments`].
    Segment(u32),
    /// Position in [`Domain::facets`].
    Facet(u32),
    /// The interior of the domain.
    Volume,
}

impl Carrier {
    /// Returns 0 for corners, 1 for segments, 2 for facets, and the dimension of the space for the interior.
    pub fn dimension(self, space: usize) -> usize {
        match self {
            Carrier::Corner(_) => 0,
            Carrier::Segment(_) => 1,
            Carrier::Facet(_) => 2,
            Carrier::Volume => space,
        }
    }

    /// Returns the feature, or `None` for the interior.
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

/// A facet of cells that lies on a facet of the domain. In the plane, it is an edge on a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face<P: Point> {
    /// Its points, in any order.
    pub vertices: P::Facet,
    /// Position in [`Domain::facets`]. In the plane, position in [`Domain::segments`].
    pub facet: u32,
    /// The marker of that facet or segment.
    pub marker: i64,
    /// The adjacent cells, in any order. [`OUTSIDE`] if there is none.
    pub cells: [u32; 2],
}

/// In space, an edge of cells that lies on a segment. In the plane, faces take this role.
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
    /// The carrier of each point.
    pub carriers: Vec<Carrier>,
    /// Positively oriented rows in canonical order, sorted. In space, a row starts with the smallest point, then the
    /// second smallest, and the orientation determines the last two. In the plane, it starts with the smallest point.
    pub cells: Vec<P::Cell>,
    /// Position of each cell's component in [`Domain::components`].
    pub regions: Vec<u32>,
    /// The faces on facets.
    pub faces: Vec<Face<P>>,
    /// The edges on segments. Empty in the plane.
    pub edges: Vec<Edge>,
    /// The number of cells that were dropped because all their vertices lie on one facet.
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
    /// Returns the points of a cell: the first `DIM + 1` entries of four.
    pub fn corners(&self, cell: u32) -> [P; 4] {
        let mut corners = [P::default(); 4];
        for (corner, &v) in corners.iter_mut().zip(self.cells[cell as usize].as_ref()) {
            *corner = self.points[v as usize];
        }
        corners
    }

    /// Returns every edge of the cells once, in sorted order and with ascending ends.
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

/// Returns the number that represents each component in files: the attribute of its region. Components without a
/// region receive whole numbers above all attributes, or consecutive numbers if there are no regions. Components
/// outside the domain receive 0.
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

/// Returns the marker of each point, which is the marker of its carrier. The marker of a corner is the first nonzero
/// marker among the segments, and then among the facets, that contain it.
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

/// The counts of one stage of generation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageLine {
    /// The name, such as `segments`.
    pub name: String,
    /// The number of candidates.
    pub candidates: u64,
    /// The number of points placed.
    pub points: u64,
    /// The number of completion rounds.
    pub completion_rounds: u64,
    /// The number of rounds of independent sets.
    pub set_rounds: u64,
    /// The number of rounds of the machine.
    pub rounds: u64,
    /// The number of messages.
    pub messages: u64,
    /// The bytes of the messages.
    pub bytes: u64,
    /// The number of operations.
    pub work: u64,
    /// The number of steps on the longest chain.
    pub depth: u64,
    /// Seconds, as measured by the caller.
    pub seconds: f64,
}
