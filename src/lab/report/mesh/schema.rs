//! The schema of the report of a mesh, field by field. The page reads back the fields that it shows.

use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize};

use septet_core::mesh::run_log::{RunLine, StagePhase};
use septet_core::mesh::view::MeshPicture;
use septet_core::mesh::{MESH_OPTIONS, MeshSpec};
use septet_core::spec::{Commands, Row, options_of};

use super::super::parameters::Requested;
use super::histogram::HistogramReport;
use super::shapes::SliverReport;

/// A text in the report: borrowed when the report is written, and owned when it is read back.
type Word = Cow<'static, str>;

/// Reads a number that is null if it is not finite.
fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

/// Measured wall-clock seconds.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeshSeconds {
    /// Reading and checking the domain.
    pub read_seconds: f64,
    /// Generating the mesh.
    pub mesh_seconds: f64,
    /// Checking and measuring the mesh.
    pub judge_seconds: f64,
    /// Writing the mesh.
    pub write_seconds: f64,
    /// The whole command.
    pub total_seconds: f64,
}

/// The report of a mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MeshReport {
    /// Name and version of this schema.
    #[cfg_attr(feature = "schema", schemars(extend("const" = super::MESH_SCHEMA)))]
    pub schema: Word,
    /// Version of septet.
    pub version: Word,
    /// The options.
    pub parameters: ParameterReport,
    /// The options that the runs settled, as they used them.
    #[serde(default)]
    pub settled: MeshSettled,
    /// The domain.
    pub domain: DomainReport,
    /// The numbers of points, cells, faces and edges.
    pub mesh: CountReport,
    /// The stages of generation, in order.
    pub stages: Vec<StageReport>,
    /// The phases of the machine in each stage.
    #[serde(default)]
    pub phases: Vec<StagePhase>,
    /// Brent's bound on the steps of all runs with as many processors as points of the mesh.
    #[serde(default)]
    pub brent: u64,
    /// The runs of the machine, in order.
    #[serde(skip_deserializing)]
    pub runs: Vec<RunLine>,
    /// Radius-edge ratios, by the location of the circumcentre of a cell.
    pub radius_edge: Vec<PlaceReport>,
    /// The features with the worst cells.
    #[serde(skip_deserializing)]
    pub features: Vec<FeatureReport>,
    /// The quality of the cells.
    pub quality: QualityReport,
    /// The comparison with the domain.
    pub conformity: ConformityReport,
    /// The distances between the boundary and the surface. `None` unless the surface was remeshed.
    #[serde(skip_deserializing)]
    pub deviation: Option<DeviationReport>,
    /// The picture. `None` if not requested or too large.
    #[serde(default)]
    pub view: Option<MeshPicture>,
    /// Measured wall-clock seconds.
    pub seconds: MeshSeconds,
    /// Measured peak of resident memory.
    #[serde(skip_deserializing)]
    pub peak_rss_bytes: Option<u64>,
}

/// The options of the machine as its runs used them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeshSettled {
    /// Number of workers. `None` for one per leaf.
    pub workers: Option<u32>,
    /// Number of threads.
    pub threads: usize,
}

/// The distances between a remeshed boundary and its surface, in the unit of the file.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeviationReport {
    /// Largest distance from sampled points of the boundary to the surface.
    pub of_boundary: f64,
    /// Largest distance from vertices of the surface to the boundary.
    pub of_surface: f64,
    /// Number of boundary edges shorter than half the size at both ends.
    pub finer_edges: u64,
    /// Euler characteristics of the boundary and of the surface.
    pub euler: [i64; 2],
    /// The requested limit of both distances.
    pub asked: Option<f64>,
}

/// The options of a mesh as requested, except `boundary`. Lengths are in the unit of the file.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ParameterReport {
    /// The domain as given on the command line.
    pub input: String,
    /// The outputs as given on the command line.
    #[serde(skip_deserializing)]
    pub outputs: Vec<String>,
    /// `exact` or `remesh`, as the mesh used it.
    pub boundary: Word,
    /// The Lipschitz constant of the size function.
    pub lipschitz: f64,
    /// Largest radius-edge ratio away from the boundary.
    pub radius_edge: f64,
    /// Seed of every random draw.
    pub seed: u64,
    /// Number of points in the size field.
    #[serde(skip_deserializing)]
    pub size_field_points: usize,
    /// Largest number of points in a leaf of the partition trees.
    #[serde(skip_deserializing)]
    pub leaf: Option<u64>,
    /// Number of threads that run the workers.
    #[serde(skip_deserializing)]
    pub threads: usize,
    /// The other options.
    #[serde(flatten, skip_deserializing)]
    #[cfg_attr(feature = "schema", schemars(schema_with = "other_options"))]
    pub options: Requested,
}

/// The options that are fields of [`ParameterReport`].
const FIELDS: [&str; 6] = ["boundary", "lipschitz", "radius_edge", "seed", "leaf", "threads"];

impl ParameterReport {
    /// Returns the rows of the other options of a mesh.
    pub(super) fn mesh_rows() -> impl Iterator<Item = &'static Row<MeshSpec>> {
        MESH_OPTIONS.iter().filter(|row| !FIELDS.contains(&row.key))
    }

    /// Returns the rows of the other options of its runs.
    pub(super) fn run_rows() -> impl Iterator<Item = &'static Row> {
        options_of(Commands::MESH).filter(|row| !FIELDS.contains(&row.key))
    }
}

#[cfg(feature = "schema")]
fn other_options(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let fields = crate::option_schema::Fields::default();
    fields.and(ParameterReport::mesh_rows()).and(ParameterReport::run_rows()).object()
}

/// The domain.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DomainReport {
    /// Number of coordinates: 2 or 3.
    pub dimension: usize,
    /// `complex` or `surface`.
    #[serde(skip_deserializing)]
    pub kind: Word,
    /// Number of points.
    #[serde(skip_deserializing)]
    pub points: u64,
    /// Number of corners.
    #[serde(skip_deserializing)]
    pub corners: u64,
    /// Number of segments.
    pub segments: u64,
    /// Number of facets.
    pub facets: u64,
    /// Number of components inside the domain.
    pub components: u64,
    /// Number of components with a region in the input.
    #[serde(skip_deserializing)]
    pub regions: u64,
    /// Area or volume in the unit of the file.
    #[serde(skip_deserializing)]
    pub measure: f64,
}

/// The numbers of points, cells, faces and edges of a mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CountReport {
    /// Number of points.
    pub points: u64,
    /// Number of points on corners.
    pub corner_points: u64,
    /// Number of points on segments.
    pub segment_points: u64,
    /// Number of points on facets.
    pub facet_points: u64,
    /// Number of points in the interior of the domain.
    pub volume_points: u64,
    /// Number of cells.
    pub cells: u64,
    /// Number of faces on facets.
    pub faces: u64,
    /// Number of edges on segments.
    #[serde(skip_deserializing)]
    pub edges: u64,
    /// Number of flat cells that were dropped.
    #[serde(skip_deserializing)]
    pub dropped: u64,
}

/// A stage of generation.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StageReport {
    /// The name.
    pub name: String,
    /// Number of candidates.
    pub candidates: u64,
    /// Number of points that were inserted.
    pub points: u64,
    /// Number of completion rounds.
    pub completion_rounds: u64,
    /// Number of rounds of the independent sets.
    pub set_rounds: u64,
    /// Number of rounds of the machine.
    pub rounds: u64,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
    /// Number of operations.
    pub work: u64,
    /// Steps on the longest chain.
    pub depth: u64,
    /// Measured seconds.
    pub seconds: f64,
}

/// An interval that contains a ratio. The upper bound is null if rounding prevents a finite one.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RatioRange {
    /// The lower bound.
    #[serde(skip_deserializing)]
    pub lower: f64,
    /// The upper bound; infinite, and null in JSON, if rounding prevents a finite one.
    #[serde(deserialize_with = "number")]
    pub upper: f64,
}

/// The radius-edge ratios of the cells whose circumcentres have one kind of location.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlaceReport {
    /// `free`, `near`, `above` or `outside`.
    pub place: Word,
    /// Number of cells.
    pub cells: u64,
    /// The largest ratio.
    pub most: RatioRange,
    /// The proved bound. `None` if no bound is proved.
    pub promised: Option<f64>,
    /// Number of cells above the bound.
    pub over: u64,
    /// The worst cells.
    #[serde(skip_deserializing)]
    pub worst: Vec<CellReport>,
}

/// A cell.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CellReport {
    /// Index of the cell.
    pub cell: u32,
    /// The radius-edge ratio.
    pub radius_edge: RatioRange,
    /// Smallest angle in degrees.
    pub least_angle: f64,
    /// Largest angle in degrees.
    pub largest_angle: f64,
    /// The feature near the circumcentre, or nearest to a circumcentre outside the domain. `None` for a free
    /// circumcentre, and for a flat cell.
    pub feature: Option<String>,
    /// The mean of the vertices of the cell.
    pub at: Vec<f64>,
    /// The vertices: index, and the feature that each lies on.
    pub vertices: Vec<(u32, String)>,
    /// The reason for the smallest angle. `None` in lists by radius-edge ratio.
    pub reason: Option<String>,
}

/// A feature with the cells whose circumcentres lie near it, or outside the domain with this feature as the nearest
/// one.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FeatureReport {
    /// The name of the feature.
    pub feature: String,
    /// Number of cells.
    pub cells: u64,
    /// Number of cells above the bound.
    pub over: u64,
    /// The largest radius-edge ratio.
    pub radius_edge: RatioRange,
    /// Index of the cell with the largest ratio.
    pub worst_cell: u32,
    /// Smallest angle in degrees.
    pub least_angle: f64,
}

/// The quality of the cells of a mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct QualityReport {
    /// Radius-edge ratios.
    pub radius_edge: HistogramReport,
    /// All angles in degrees: dihedral angles in space, interior angles in the plane.
    pub angles: HistogramReport,
    /// The smallest angle of each cell.
    pub least_angles: HistogramReport,
    /// The largest angle of each cell.
    pub largest_angles: HistogramReport,
    /// Edge lengths over sizes.
    pub length_over_size: HistogramReport,
    /// Sizes over local feature sizes. `None` if these are unknown.
    pub size_over_local_size: Option<HistogramReport>,
    /// Slivers by their smallest angle.
    #[serde(skip_deserializing)]
    pub slivers: Vec<SliverReport>,
    /// Smallest area or volume of a cell.
    #[serde(skip_deserializing)]
    pub least_volume: f64,
    /// Largest area or volume of a cell.
    #[serde(skip_deserializing)]
    pub largest_volume: f64,
    /// Area or volume of all cells.
    #[serde(skip_deserializing)]
    pub volume: f64,
    /// The integral of `f^-d`.
    #[serde(skip_deserializing)]
    pub integral: f64,
    /// Number of points over the integral.
    #[serde(skip_deserializing)]
    pub points_over_integral: f64,
    /// Largest slope of the sizes along an edge.
    #[serde(deserialize_with = "number")]
    pub lipschitz: f64,
    /// The vertices of the edge with this slope.
    #[serde(skip_deserializing)]
    pub steepest_edge: [u32; 2],
    /// The cells with the smallest angles.
    #[serde(skip_deserializing)]
    pub thinnest: Vec<CellReport>,
}

/// The comparison of a mesh with its domain.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ConformityReport {
    /// Whether the mesh conforms to the domain.
    pub passed: bool,
    /// Area or volume of the domain.
    pub domain_measure: f64,
    /// Area or volume of the mesh.
    pub mesh_measure: f64,
    /// Length or area of the boundary of the domain.
    #[serde(skip_deserializing)]
    pub domain_boundary: f64,
    /// Length or area of the boundary of the mesh.
    #[serde(skip_deserializing)]
    pub mesh_boundary: f64,
    /// Number of defects.
    pub defects: u64,
    /// The first defects.
    #[serde(skip_deserializing)]
    pub first: Vec<String>,
}
