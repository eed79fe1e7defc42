//! The picture of a mesh: its points and cells, and the values that colour its cells.
//!
//! A picture always shows the whole mesh. A mesh with too many cells has no picture, because a subset of the cells
//! would show gaps that the mesh does not have. Coordinates are rounded to 1e-7 of the extent of the mesh, and other
//! numbers to six digits.

use serde::{Deserialize, Serialize};

use septet_geometry::point::{Point, Simplex};
use septet_geometry::range::scale;
use septet_meshing::domain::Domain;
use septet_meshing::facet::Triangulate;
use septet_meshing::mesh::{Mesh, region_names};
use septet_meshing::quality::angles::angles;
use septet_meshing::quality::ratio::ratio;
use septet_meshing::size::SizeFunction;

use crate::result::view::Digits;

/// The largest number of cells that a picture may have: about 12 MB of JSON.
pub const MOST_CELLS: u32 = 200_000;

/// The default limit on the number of cells: about 1 MB of JSON.
pub const DEFAULT_CELLS: u32 = 20_000;

/// A mesh for drawing. Every list about cells has one entry per cell, in the order of the mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeshPicture {
    /// Number of points.
    pub points: u64,
    /// Number of cells.
    pub cells: u64,
    /// Smallest coordinates.
    pub low: Vec<f64>,
    /// Largest coordinates.
    pub high: Vec<f64>,
    /// The coordinates of all points, in the unit of the file.
    pub positions: Vec<f64>,
    /// The points of all cells, as zero-based positions.
    pub corners: Vec<u32>,
    /// Radius-edge ratios. Null if rounding makes the ratio infinite.
    pub radius_edge: Vec<Option<f64>>,
    /// Smallest angles in degrees: dihedral angles in space, angles at corners in the plane.
    pub least_angle: Vec<f64>,
    /// The size function at the mean of the points, in the unit of the file.
    pub size: Vec<f64>,
    /// The region of each cell, as a position in `regions`.
    pub region: Vec<u32>,
    /// The names of the regions, as in files.
    pub regions: Vec<f64>,
    /// The worker that owned each cell. Null if unknown.
    pub owner: Option<Vec<u32>>,
}

impl MeshPicture {
    /// Draws a mesh of this domain and size function.
    pub fn of<P: Triangulate>(
        domain: &Domain<P>,
        mesh: &Mesh<P>,
        size: &SizeFunction<P>,
        owner: Option<Vec<u32>>,
    ) -> Self {
        let exponent = domain.simplices.frame.exponent;
        let [low, high] = corners(&mesh.points);
        let extent = (0..P::DIM).map(|i| high.coord(i) - low.coord(i)).fold(0.0, f64::max);
        let digits = Digits::of(extent, 7);
        let shown = |p: P| (0..P::DIM).map(move |i| digits.round(p.coord(i)));
        let mut picture = MeshPicture {
            points: mesh.points.len() as u64,
            cells: mesh.cells.len() as u64,
            low: shown(low).collect(),
            high: shown(high).collect(),
            positions: mesh.points.iter().flat_map(|&p| shown(p)).collect(),
            corners: mesh.cells.iter().flat_map(AsRef::as_ref).copied().collect(),
            owner,
            ..MeshPicture::default()
        };
        picture.name_regions(domain, mesh);
        for cell in 0..mesh.cells.len() as u32 {
            let corners = mesh.corners(cell).map(|p| domain.simplices.frame.inward(p));
            let corners = &corners[..=P::DIM];
            let least = angles(corners).into_iter().fold(f64::INFINITY, f64::min);
            let middle = corners.iter().fold(P::splat(0.0), |sum, &p| sum + p / corners.len() as f64);
            let ratio = ratio(corners).upper;
            picture.radius_edge.push(ratio.is_finite().then(|| six_digits(ratio)));
            picture.least_angle.push(six_digits(least));
            picture.size.push(six_digits(scale(P::splat(size.at(middle)), -exponent).coord(0)));
        }
        picture
    }

    fn name_regions<P: Triangulate>(&mut self, domain: &Domain<P>, mesh: &Mesh<P>) {
        let mut present = mesh.regions.clone();
        present.sort_unstable();
        present.dedup();
        let names = region_names(domain);
        self.regions = present.iter().map(|&c| names[c as usize]).collect();
        let place = |c: &u32| present.binary_search(c).unwrap_or(0) as u32;
        self.region = mesh.regions.iter().map(place).collect();
    }
}

/// Returns the smallest and the largest coordinates.
fn corners<P: Point>(points: &[P]) -> [P; 2] {
    let first = points.first().copied().unwrap_or_default();
    points.iter().fold([first; 2], |[mut low, mut high], p| {
        for i in 0..P::DIM {
            low.set_coord(i, low.coord(i).min(p.coord(i)));
            high.set_coord(i, high.coord(i).max(p.coord(i)));
        }
        [low, high]
    })
}

fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// Returns the owners of the cells of a mesh, given the owners in the triangulation that contains them. Returns `None`
/// if a cell is missing there.
pub(super) fn owned<P: Point>(cells: &[P::Cell], owners: &[u32], mesh: &Mesh<P>) -> Option<Vec<u32>> {
    let sorted = |cell: &P::Cell| {
        let mut cell = *cell;
        cell.as_mut().sort_unstable();
        cell
    };
    let mut known: Vec<(P::Cell, u32)> = cells.iter().map(sorted).zip(owners.iter().copied()).collect();
    known.sort_unstable();
    let owner = |cell: &P::Cell| {
        let at = known.binary_search_by_key(&sorted(cell), |&(known, _)| known);
        at.ok().map(|i| known[i].1)
    };
    debug_assert_eq!(P::Cell::LEN, P::DIM + 1);
    mesh.cells.iter().map(owner).collect()
}
