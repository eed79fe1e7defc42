//! The numbers of a triangulation in reports.

use serde::Serialize;

use septet_core::Stats;

use super::mesh::ShapeReport;
use super::mesh::histogram::HistogramReport;

/// The numbers of a triangulation, for `--stats`. Lengths, areas and volumes have the unit of the coordinates. They are null if
/// they exceed the range of numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StatsReport {
    /// Number of vertices.
    pub points: u64,
    /// Number of points that coincide with a point of smaller index.
    pub duplicates: u64,
    /// Number of edges.
    pub edges: u64,
    /// Number of facets: edges in the plane, triangles in space.
    pub facets: u64,
    /// Number of triangles or tetrahedra.
    pub cells: u64,
    /// Number of connected parts: 1, or 0 without cells.
    pub components: u64,
    /// The convex hull.
    pub hull: HullReport,
    /// The least and the largest coordinate on each axis. Empty if there are no points.
    pub extent: Vec<[f64; 2]>,
    /// The number of edges at each vertex.
    pub degrees: HistogramReport,
    /// The shapes of the cells.
    pub quality: ShapeReport,
}

/// The convex hull.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HullReport {
    /// Number of facets: edges in the plane, triangles in space.
    pub facets: u64,
    /// Number of edges.
    pub edges: u64,
    /// Number of vertices, including those inside faces of the hull.
    pub vertices: u64,
    /// Area in the plane, volume in space: the sum over all cells.
    pub volume: Option<f64>,
    /// Length of the boundary in the plane, its area in space.
    pub surface: Option<f64>,
}

impl StatsReport {
    /// Returns the report of the numbers.
    pub(super) fn of(stats: &Stats) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        StatsReport {
            points: stats.points,
            duplicates: stats.duplicates,
            edges: stats.edges,
            facets: stats.facets,
            cells: stats.cells,
            components: stats.components,
            hull: HullReport {
                facets: stats.hull_facets,
                edges: stats.hull_edges,
                vertices: stats.hull_vertices,
                volume: finite(stats.volume),
                surface: finite(stats.surface),
            },
            extent: stats.extent.clone(),
            degrees: (&stats.degrees).into(),
            quality: ShapeReport::of(&stats.shapes),
        }
    }
}
