//! The report of `septet mesh`: a documented, versioned schema.
//!
//! The number of a feature is its position in the domain. The name of a feature contains its ids in the file. Times
//! (fields whose names end in `seconds`) and memory sizes are measured and do not repeat. All other fields repeat
//! exactly.

use std::path::PathBuf;

use septet_meshing::conformity::Conformity;
use septet_meshing::domain::{Domain, Feature};
use septet_meshing::facet::Triangulate;
use septet_meshing::input::DomainKind;
use septet_meshing::mesh::{Mesh, StageLine};
use septet_meshing::quality::ratio::Bracket;
use septet_meshing::quality::reasons::{Reason, reasons};
use septet_meshing::quality::{CentrePlace, Quality, RadiusEdge, WorstCell};

pub mod histogram;
mod schema;
mod shapes;
pub mod tables;

pub use schema::{
    CellReport, ConformityReport, CountReport, DeviationReport, DomainReport, FeatureReport, MeshReport,
    MeshSeconds, MeshSettled, ParameterReport, PlaceReport, QualityReport, RatioRange, StageReport,
};

pub use shapes::{ShapeReport, SliverReport};

use super::parameters::Requested;
use histogram::HistogramReport;
use septet_core::mesh::run_log::RunLog;
use septet_core::mesh::view::MeshPicture;
use septet_core::mesh::{Boundary, MeshSpec};
use septet_core::spec::{Words, Workers};

/// Name and version of the schema.
pub const MESH_SCHEMA: &str = "septet-mesh/2";

/// Maximum number of conformity defects that are listed.
const LISTED_DEFECTS: usize = 100;

/// Maximum number of features that are listed.
const LISTED_FEATURES: usize = 50;

/// The context of a mesh: the data of its report that meshing itself does not provide.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshContext<'a> {
    /// The domain as given on the command line.
    pub input: &'a str,
    /// The outputs as given on the command line.
    pub outputs: &'a [PathBuf],
    /// The id of the first point in the file.
    pub first_id: u64,
    /// Measured times.
    pub seconds: MeshSeconds,
    /// Measured peak of resident memory, in bytes.
    pub peak_rss_bytes: Option<u64>,
}

/// A mesh with its checks and measurements.
pub struct CheckedMesh<'a, P: Triangulate> {
    /// The domain.
    pub domain: &'a Domain<P>,
    /// The request.
    pub request: &'a MeshSpec,
    /// The mesh.
    pub mesh: &'a Mesh<P>,
    /// The stages of generation.
    pub stages: &'a [StageLine],
    /// The quality of the mesh.
    pub quality: &'a Quality<P>,
    /// The conformity of the mesh to its domain.
    pub conformity: &'a Conformity,
    /// The runs of the machine.
    pub run_log: &'a RunLog,
    /// The picture of the mesh, if there is one.
    pub picture: Option<&'a MeshPicture>,
}

impl MeshReport {
    /// Returns the report of a mesh.
    pub fn of<P: Triangulate>(checked: &CheckedMesh<'_, P>, context: &MeshContext<'_>) -> Self {
        let CheckedMesh { domain, request, mesh, stages, quality, conformity, run_log, picture } = *checked;
        let id = context.first_id;
        let places = ["free", "near", "above", "outside"].into_iter().zip(&quality.places);
        let features = quality.features.iter().take(LISTED_FEATURES).map(|f| FeatureReport {
            feature: feature_name(domain, f.feature, id),
            cells: f.cells,
            over: f.over,
            radius_edge: between(f.most),
            worst_cell: f.worst,
            least_angle: f.least_angle,
        });
        MeshReport {
            schema: MESH_SCHEMA.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            parameters: parameters(domain, request, context),
            settled: settled(request),
            domain: domain_report(domain),
            mesh: counts(mesh),
            stages: stages.iter().map(stage).collect(),
            phases: run_log.phases.clone(),
            brent: run_log.brent(mesh.points.len() as u64),
            runs: run_log.runs.clone(),
            radius_edge: places.map(|(name, p)| place(domain, name, p, id)).collect(),
            features: features.collect(),
            quality: quality_report(
                domain,
                quality,
                id,
                request.remeshes(domain).then_some(request.feature_angle),
            ),
            conformity: conformity_report(conformity),
            deviation: conformity.deviation.map(|d| DeviationReport {
                of_boundary: d.of_boundary,
                of_surface: d.of_surface,
                finer_edges: d.finer,
                euler: d.euler,
                asked: request.max_distance,
            }),
            view: picture.cloned(),
            seconds: context.seconds,
            peak_rss_bytes: context.peak_rss_bytes,
        }
    }

    /// Returns the report as JSON.
    ///
    /// # Errors
    /// Fails if a number has no JSON form. A report has no such number.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        crate::report::json::rows(self)
    }
}

/// Returns the name of a feature, with its ids in the file.
pub fn feature_name<P: Triangulate>(domain: &Domain<P>, feature: Feature, first_id: u64) -> String {
    let id = |v: u32| u64::from(v) + first_id;
    match feature {
        Feature::Corner(c) => format!("point {}", id(domain.corners[c as usize])),
        Feature::Segment(s) => {
            let [a, b] = domain.segments[s as usize].ends();
            format!("segment {}-{}", id(a), id(b))
        }
        Feature::Facet(f) => format!("facet {}", id(domain.facets[f as usize].of[0])),
    }
}

fn parameters<P: Triangulate>(
    domain: &Domain<P>,
    request: &MeshSpec,
    context: &MeshContext<'_>,
) -> ParameterReport {
    let machine = &request.run.machine;
    let boundary = if request.remeshes(domain) { Boundary::Remesh } else { Boundary::Exact };
    ParameterReport {
        input: context.input.to_owned(),
        outputs: context.outputs.iter().map(|o| o.display().to_string()).collect(),
        boundary: boundary.name().into(),
        lipschitz: request.sizes.lipschitz,
        radius_edge: request.radius_edge(),
        seed: machine.seed,
        size_field_points: request.sizes.field.as_ref().map_or(0, |f| f.rows.len()),
        leaf: request.run.tree.leaf,
        threads: machine.thread_count(),
        options: Requested::of(ParameterReport::mesh_rows(), request)
            .and(Requested::of(ParameterReport::run_rows(), &request.run)),
    }
}

fn settled(request: &MeshSpec) -> MeshSettled {
    let machine = &request.run.machine;
    let workers = match machine.workers {
        Workers::Auto => Some(machine.thread_count() as u32),
        Workers::Count(workers) => Some(workers),
        Workers::Leaves => None,
    };
    MeshSettled { workers, threads: machine.thread_count() }
}

fn domain_report<P: Triangulate>(domain: &Domain<P>) -> DomainReport {
    DomainReport {
        dimension: P::DIM,
        kind: match domain.kind {
            DomainKind::Complex => "complex",
            DomainKind::Surface => "surface",
        }
        .into(),
        points: domain.points().len() as u64,
        corners: domain.corners.len() as u64,
        segments: domain.segments.len() as u64,
        facets: domain.facets.len() as u64,
        components: domain.components.iter().filter(|c| c.inside).count() as u64,
        regions: domain.components.iter().filter(|c| c.region.is_some()).count() as u64,
        measure: unscaled_measure(domain),
    }
}

/// Returns the area or volume of a domain in the unit of the file.
pub fn unscaled_measure<P: Triangulate>(domain: &Domain<P>) -> f64 {
    // Scaling once per dimension keeps the factor, a power of two, in range.
    let mut measure = P::splat(domain.measure());
    for _ in 0..P::DIM {
        measure = septet_geometry::range::scale(measure, -domain.simplices.frame.exponent);
    }
    measure.coord(0)
}

fn counts<P: Triangulate>(mesh: &Mesh<P>) -> CountReport {
    let carried = |d: usize| {
        let carriers = mesh.carriers.iter();
        carriers.filter(|c| c.feature().map_or(3, |_| c.dimension(P::DIM)) == d).count() as u64
    };
    CountReport {
        points: mesh.points.len() as u64,
        corner_points: carried(0),
        segment_points: carried(1),
        facet_points: carried(2),
        volume_points: carried(3),
        cells: mesh.cells.len() as u64,
        faces: mesh.faces.len() as u64,
        edges: mesh.edges.len() as u64,
        dropped: mesh.dropped,
    }
}

fn stage(line: &StageLine) -> StageReport {
    StageReport {
        name: line.name.clone(),
        candidates: line.candidates,
        points: line.points,
        completion_rounds: line.completion_rounds,
        set_rounds: line.set_rounds,
        rounds: line.rounds,
        messages: line.messages,
        bytes: line.bytes,
        work: line.work,
        depth: line.depth,
        seconds: line.seconds,
    }
}

fn between(bounds: Bracket) -> RatioRange {
    RatioRange { lower: bounds.lower, upper: bounds.upper }
}

fn place<P: Triangulate>(
    domain: &Domain<P>,
    place: &'static str,
    kind: &RadiusEdge<P>,
    first_id: u64,
) -> PlaceReport {
    PlaceReport {
        place: place.into(),
        cells: kind.cells,
        most: between(kind.most),
        promised: kind.promised,
        over: kind.over,
        worst: kind.worst.iter().map(|c| cell(domain, c, first_id)).collect(),
    }
}

fn cell<P: Triangulate>(domain: &Domain<P>, worst: &WorstCell<P>, first_id: u64) -> CellReport {
    let name = |feature| feature_name(domain, feature, first_id);
    let carried = |c: septet_meshing::mesh::Carrier| c.feature().map_or_else(|| "volume".to_owned(), name);
    CellReport {
        cell: worst.cell,
        radius_edge: between(worst.ratio),
        least_angle: worst.angles[0],
        largest_angle: worst.angles[1],
        feature: CentrePlace::feature(worst.place).map(name),
        at: (0..P::DIM).map(|i| worst.at.coord(i)).collect(),
        vertices: worst.vertices.iter().map(|&(v, c)| (v, carried(c))).collect(),
        reason: None,
    }
}

/// Returns the reason for the angles of a cell as a clause about the cell.
pub fn reason_text<P: Triangulate>(domain: &Domain<P>, reason: &Reason, first_id: u64) -> String {
    match reason {
        Reason::InputAngle(angle) => {
            let [a, b] = angle.features.map(|feature| feature_name(domain, feature, first_id));
            format!("it touches the input angle of {:.2} degrees between {a} and {b}", angle.degrees())
        }
        Reason::Boundary => "all its vertices are on the boundary".to_owned(),
        Reason::Surroundings => "the cells around it leave no room".to_owned(),
    }
}

/// Describes the cells with the smallest angles, with their reasons.
fn thinnest<P: Triangulate>(
    domain: &Domain<P>,
    q: &Quality<P>,
    first_id: u64,
    feature_angle: Option<f64>,
) -> Vec<CellReport> {
    let reasons = reasons(domain, &q.thinnest, feature_angle);
    let of = |(worst, reason): (&WorstCell<P>, &Reason)| CellReport {
        reason: Some(reason_text(domain, reason, first_id)),
        ..cell(domain, worst, first_id)
    };
    q.thinnest.iter().zip(&reasons).map(of).collect()
}

fn quality_report<P: Triangulate>(
    domain: &Domain<P>,
    q: &Quality<P>,
    first_id: u64,
    feature_angle: Option<f64>,
) -> QualityReport {
    let ShapeReport { radius_edge, angles, least_angles, largest_angles, slivers, .. } =
        ShapeReport::of(&q.shapes);
    QualityReport {
        radius_edge,
        angles,
        least_angles,
        largest_angles,
        length_over_size: (&q.lengths).into(),
        size_over_local_size: q.grading.as_ref().map(HistogramReport::from),
        slivers,
        least_volume: q.volumes[0],
        largest_volume: q.volumes[1],
        volume: q.volume,
        integral: q.integral,
        points_over_integral: q.points as f64 / q.integral,
        lipschitz: q.steepest.slope,
        steepest_edge: q.steepest.edge,
        thinnest: thinnest(domain, q, first_id, feature_angle),
    }
}

fn conformity_report(found: &Conformity) -> ConformityReport {
    ConformityReport {
        passed: found.is_clean(),
        domain_measure: found.measure[0],
        mesh_measure: found.measure[1],
        domain_boundary: found.boundary[0],
        mesh_boundary: found.boundary[1],
        defects: found.defects.len() as u64,
        first: found.defects.iter().take(LISTED_DEFECTS).map(ToString::to_string).collect(),
    }
}
