//! What a run of `septet mesh` has to say: one documented, versioned schema.
//!
//! Numbers of features are positions in the domain, their names have the ids of the file. Fields whose names end in
//! `seconds` or `bytes` of memory are measured and do not repeat; everything else does.

use std::path::PathBuf;

use serde::Serialize;

use septet_meshing::conformity::Conformity;
use septet_meshing::domain::{Domain, Feature};
use septet_meshing::facet::Triangulate;
use septet_meshing::input::Kind;
use septet_meshing::mesh::{Mesh, StageLine};
use septet_meshing::quality::ratio::Bounds;
use septet_meshing::quality::{Place, Quality, RadiusEdge, SLIVER_RATIO, SLIVERS, WorstCell};

pub mod histogram;
pub mod tables;

use histogram::HistogramReport;
use septet_core::config::Workers;
use septet_core::mesh::record::{PhaseLine, Record, RunLine};
use septet_core::mesh::view::MeshPicture;
use septet_core::mesh::{Boundary, MeshRequest};

/// Name and version of the schema.
pub const MESH_SCHEMA: &str = "septet-mesh/1";

/// Defects of conformity that are told one by one.
const TOLD: usize = 100;

/// Features that are told one by one.
const FEATURES: usize = 50;

/// What surrounds a run and is not known to it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Surroundings<'a> {
    /// The domain as named.
    pub input: &'a str,
    /// The outputs as named.
    pub outputs: &'a [PathBuf],
    /// The id that the file gave to its first point.
    pub first_id: u64,
    /// Measured times.
    pub seconds: Seconds,
    /// Measured peak memory.
    pub peak_rss_bytes: Option<u64>,
}

/// Measured times.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Seconds {
    /// Reading and checking the domain.
    pub read_seconds: f64,
    /// Making the mesh.
    pub mesh_seconds: f64,
    /// Checking and measuring it.
    pub judge_seconds: f64,
    /// Writing it.
    pub write_seconds: f64,
    /// Everything.
    pub total_seconds: f64,
}

/// The report.
#[derive(Debug, Serialize)]
pub struct MeshReport {
    schema: &'static str,
    version: &'static str,
    pub(super) parameters: ParameterReport,
    domain: DomainReport,
    mesh: CountReport,
    pub(super) stages: Vec<StageReport>,
    pub(super) phases: Vec<PhaseLine>,
    pub(super) runs: Vec<RunLine>,
    radius_edge: Vec<PlaceReport>,
    features: Vec<FeatureReport>,
    quality: QualityReport,
    conformity: ConformityReport,
    deviation: Option<DeviationReport>,
    view: Option<MeshPicture>,
    pub(super) seconds: Seconds,
    peak_rss_bytes: Option<u64>,
}

/// The distance between the boundary of a remeshed surface and the surface, in the unit of the file: of sampled places of the
/// one from the other, of vertices of the other from the one; edges of the boundary below half the size; the Euler
/// characteristics of boundary and surface; and what was asked for.
#[derive(Debug, Serialize)]
struct DeviationReport {
    of_boundary: f64,
    of_surface: f64,
    finer_edges: u64,
    euler: [i64; 2],
    asked: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct ParameterReport {
    pub(super) input: String,
    outputs: Vec<String>,
    boundary: &'static str,
    lipschitz: f64,
    radius_edge: f64,
    size: Option<f64>,
    min_size: Option<f64>,
    size_field_points: usize,
    singularity: Option<&'static str>,
    feature_angle: f64,
    improve: bool,
    leaf: Option<u64>,
    workers: Option<u32>,
    threads: usize,
    transport: &'static str,
    delivery_seed: Option<u64>,
    seed: u64,
}

#[derive(Debug, Serialize)]
struct DomainReport {
    dimension: usize,
    kind: &'static str,
    points: usize,
    corners: usize,
    segments: usize,
    facets: usize,
    components: usize,
    regions: usize,
    measure: f64,
}

#[derive(Debug, Serialize)]
struct CountReport {
    points: usize,
    corner_points: usize,
    segment_points: usize,
    facet_points: usize,
    volume_points: usize,
    cells: usize,
    faces: usize,
    edges: usize,
    dropped: u64,
}

#[derive(Debug, Serialize)]
pub(super) struct StageReport {
    pub(super) name: String,
    pub(super) candidates: u64,
    pub(super) points: u64,
    pub(super) completion_rounds: u64,
    pub(super) set_rounds: u64,
    pub(super) rounds: u64,
    pub(super) messages: u64,
    pub(super) bytes: u64,
    pub(super) work: u64,
    pub(super) depth: u64,
    pub(super) seconds: f64,
}

/// A number of which it is known that it lies between two; the upper one is null where rounding leaves it open.
#[derive(Debug, Serialize)]
struct Between {
    lower: f64,
    upper: f64,
}

/// The radius-edge ratios of cells whose circumcentres lie in one kind of place.
#[derive(Debug, Serialize)]
struct PlaceReport {
    place: &'static str,
    cells: u64,
    most: Between,
    promised: Option<f64>,
    over: u64,
    worst: Vec<CellReport>,
}

#[derive(Debug, Serialize)]
struct CellReport {
    cell: u32,
    radius_edge: Between,
    least_angle: f64,
    largest_angle: f64,
    feature: Option<String>,
    at: Vec<f64>,
    vertices: Vec<(u32, String)>,
}

#[derive(Debug, Serialize)]
struct FeatureReport {
    feature: String,
    cells: u64,
    over: u64,
    radius_edge: Between,
    worst_cell: u32,
    least_angle: f64,
}

#[derive(Debug, Serialize)]
struct QualityReport {
    radius_edge: HistogramReport,
    angles: HistogramReport,
    least_angles: HistogramReport,
    largest_angles: HistogramReport,
    length_over_size: HistogramReport,
    size_over_local_size: Option<HistogramReport>,
    slivers: Vec<SliverReport>,
    least_volume: f64,
    largest_volume: f64,
    volume: f64,
    integral: f64,
    points_over_integral: f64,
    lipschitz: f64,
    steepest_edge: [u32; 2],
    thinnest: Vec<CellReport>,
}

/// Cells with an angle below this, and a radius-edge ratio below that.
#[derive(Debug, Serialize)]
struct SliverReport {
    angle: f64,
    radius_edge: f64,
    cells: u64,
}

#[derive(Debug, Serialize)]
struct ConformityReport {
    passed: bool,
    domain_measure: f64,
    mesh_measure: f64,
    domain_boundary: f64,
    mesh_boundary: f64,
    defects: usize,
    first: Vec<String>,
}

/// A mesh and everything that was found out about it.
pub struct Judged<'a, P: Triangulate> {
    /// The domain.
    pub domain: &'a Domain<P>,
    /// What was asked for.
    pub request: &'a MeshRequest,
    /// The mesh.
    pub mesh: &'a Mesh<P>,
    /// The stages of generation.
    pub stages: &'a [StageLine],
    /// Its quality.
    pub quality: &'a Quality<P>,
    /// Its conformity.
    pub conformity: &'a Conformity,
    /// The runs of the machine.
    pub record: &'a Record,
    /// Its picture, if there is one.
    pub picture: Option<&'a MeshPicture>,
}

impl MeshReport {
    /// The report of a mesh.
    pub fn of<P: Triangulate>(judged: &Judged<'_, P>, around: &Surroundings<'_>) -> Self {
        let Judged { domain, request, mesh, stages, quality, conformity, record, picture } = *judged;
        let id = around.first_id;
        let places = ["free", "near", "above", "outside"].into_iter().zip(&quality.places);
        let features = quality.features.iter().take(FEATURES).map(|f| FeatureReport {
            feature: feature_name(domain, f.feature, id),
            cells: f.cells,
            over: f.over,
            radius_edge: between(f.most),
            worst_cell: f.worst,
            least_angle: f.least_angle,
        });
        MeshReport {
            schema: MESH_SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            parameters: parameters(domain.kind, request, around),
            domain: domain_report(domain),
            mesh: counts(mesh),
            stages: stages.iter().map(stage).collect(),
            phases: record.phases.clone(),
            runs: record.runs.clone(),
            radius_edge: places.map(|(name, p)| place(domain, name, p, id)).collect(),
            features: features.collect(),
            quality: quality_report(domain, quality, id),
            conformity: conformity_report(conformity),
            deviation: conformity.deviation.map(|d| DeviationReport {
                of_boundary: d.of_boundary,
                of_surface: d.of_surface,
                finer_edges: d.finer,
                euler: d.euler,
                asked: request.max_distance,
            }),
            view: picture.cloned(),
            seconds: around.seconds,
            peak_rss_bytes: around.peak_rss_bytes,
        }
    }

    /// The report as JSON.
    ///
    /// # Errors
    /// None that numbers or names can cause.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        crate::report::json::rows(self)
    }
}

/// A feature by the ids of the file.
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

fn parameters(kind: Kind, request: &MeshRequest, around: &Surroundings<'_>) -> ParameterReport {
    let machine = &request.machine;
    ParameterReport {
        input: around.input.to_owned(),
        outputs: around.outputs.iter().map(|o| o.display().to_string()).collect(),
        boundary: match request.boundary_of(kind) {
            Boundary::Exact => "exact",
            Boundary::Remesh => "remesh",
        },
        lipschitz: request.lipschitz,
        radius_edge: request.radius_edge(),
        size: request.size,
        min_size: request.min_size,
        size_field_points: request.field.as_ref().map_or(0, |f| f.rows.len()),
        singularity: request.singularity.as_ref().map(|s| match s.shape {
            septet_core::mesh::Shape::Point => "point",
            septet_core::mesh::Shape::Line => "line",
        }),
        feature_angle: request.feature_angle,
        improve: request.improve,
        leaf: machine.leaf,
        workers: match machine.workers {
            Workers::Count(n) => Some(n),
            Workers::Leaves => None,
        },
        threads: machine.threads,
        transport: machine.transport.name(),
        delivery_seed: machine.transport.delivery_seed(),
        seed: machine.seed,
    }
}

fn domain_report<P: Triangulate>(domain: &Domain<P>) -> DomainReport {
    DomainReport {
        dimension: P::DIM,
        kind: match domain.kind {
            Kind::Complex => "complex",
            Kind::Surface => "surface",
        },
        points: domain.points().len(),
        corners: domain.corners.len(),
        segments: domain.segments.len(),
        facets: domain.facets.len(),
        components: domain.components.iter().filter(|c| c.inside).count(),
        regions: domain.components.iter().filter(|c| c.region.is_some()).count(),
        measure: unscaled_measure(domain),
    }
}

/// Area or volume of a domain in the unit of the file.
pub fn unscaled_measure<P: Triangulate>(domain: &Domain<P>) -> f64 {
    // Scaled once for each dimension, so that the factor stays a power of two in range.
    let mut measure = P::splat(domain.measure());
    for _ in 0..P::DIM {
        measure = septet_geometry::range::scale(measure, -domain.simplices.exponent);
    }
    measure.coord(0)
}

fn counts<P: Triangulate>(mesh: &Mesh<P>) -> CountReport {
    let carried = |d: usize| {
        mesh.carriers.iter().filter(|c| c.feature().map_or(3, |_| c.dimension(P::DIM)) == d).count()
    };
    CountReport {
        points: mesh.points.len(),
        corner_points: carried(0),
        segment_points: carried(1),
        facet_points: carried(2),
        volume_points: carried(3),
        cells: mesh.cells.len(),
        faces: mesh.faces.len(),
        edges: mesh.edges.len(),
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

fn between(bounds: Bounds) -> Between {
    Between { lower: bounds.lower, upper: bounds.upper }
}

fn place<P: Triangulate>(
    domain: &Domain<P>,
    place: &'static str,
    kind: &RadiusEdge<P>,
    first_id: u64,
) -> PlaceReport {
    PlaceReport {
        place,
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
        feature: Place::feature(worst.place).map(name),
        at: (0..P::DIM).map(|i| worst.at.coord(i)).collect(),
        vertices: worst.vertices.iter().map(|&(v, c)| (v, carried(c))).collect(),
    }
}

fn quality_report<P: Triangulate>(domain: &Domain<P>, q: &Quality<P>, first_id: u64) -> QualityReport {
    let sliver = |(&angle, &cells): (&f64, &u64)| SliverReport { angle, radius_edge: SLIVER_RATIO, cells };
    QualityReport {
        radius_edge: (&q.ratios).into(),
        angles: (&q.angles).into(),
        least_angles: (&q.least_angles).into(),
        largest_angles: (&q.largest_angles).into(),
        length_over_size: (&q.lengths).into(),
        size_over_local_size: q.grading.as_ref().map(HistogramReport::from),
        slivers: SLIVERS.iter().zip(&q.slivers).map(sliver).collect(),
        least_volume: q.volumes[0],
        largest_volume: q.volumes[1],
        volume: q.volume,
        integral: q.integral,
        points_over_integral: q.points as f64 / q.integral,
        lipschitz: q.steepest.slope,
        steepest_edge: q.steepest.edge,
        thinnest: q.thinnest.iter().map(|c| cell(domain, c, first_id)).collect(),
    }
}

fn conformity_report(found: &Conformity) -> ConformityReport {
    ConformityReport {
        passed: found.is_clean(),
        domain_measure: found.measure[0],
        mesh_measure: found.measure[1],
        domain_boundary: found.boundary[0],
        mesh_boundary: found.boundary[1],
        defects: found.defects.len(),
        first: found.defects.iter().take(TOLD).map(ToString::to_string).collect(),
    }
}
