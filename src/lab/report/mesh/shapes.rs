//! The shapes of cells in reports: the part of quality that meshes and triangulations of points have in common.

use serde::Serialize;

use septet_meshing::quality::shapes::Shapes;
use septet_meshing::quality::{SLIVER_RATIO, SLIVERS};

use super::histogram::HistogramReport;

/// The shapes of the cells of a triangulation. The fields have the names of those of the quality of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ShapeReport {
    /// Radius-edge ratios: the circumradius divided by the length of the shortest edge.
    pub radius_edge: HistogramReport,
    /// All angles in degrees: dihedral angles in space, interior angles in the plane.
    pub angles: HistogramReport,
    /// The smallest angle of each cell.
    pub least_angles: HistogramReport,
    /// The largest angle of each cell.
    pub largest_angles: HistogramReport,
    /// Slivers by their smallest angle. In the plane, a triangle with such a ratio has no such angle.
    pub slivers: Vec<SliverReport>,
    /// Smallest area or volume of a cell. `None` without cells.
    pub least_volume: Option<f64>,
    /// Largest area or volume of a cell. `None` without cells.
    pub largest_volume: Option<f64>,
}

impl ShapeReport {
    /// Returns the report of shapes.
    pub fn of(shapes: &Shapes) -> Self {
        let sliver =
            |(&angle, &cells): (&f64, &u64)| SliverReport { angle, radius_edge: SLIVER_RATIO, cells };
        let finite = |x: f64| x.is_finite().then_some(x);
        ShapeReport {
            radius_edge: (&shapes.ratios).into(),
            angles: (&shapes.angles).into(),
            least_angles: (&shapes.least_angles).into(),
            largest_angles: (&shapes.largest_angles).into(),
            slivers: SLIVERS.iter().zip(&shapes.slivers).map(sliver).collect(),
            least_volume: finite(shapes.volumes[0]),
            largest_volume: finite(shapes.volumes[1]),
        }
    }
}

/// Number of cells with an angle below `angle` and a radius-edge ratio below `radius_edge`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SliverReport {
    /// The angle in degrees.
    pub angle: f64,
    /// The radius-edge ratio.
    pub radius_edge: f64,
    /// Number of cells.
    pub cells: u64,
}
