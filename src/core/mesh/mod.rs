//! Meshes of domains: the request, the mesh as arrays for files, and its quality.
//!
//! `generate` generates a mesh. [`labelled::Labelled`] holds the arrays for the writers. [`run_log`] records the runs
//! of the machine, and [`view`] is the picture in the report.

mod error;
pub mod field;
pub mod labelled;
pub mod machine;
mod options;
pub mod pipeline;
mod request;
pub mod run_log;
pub mod view;

#[cfg(test)]
mod tests;

use std::time::Instant;

use septet_meshing::conformity::{self, Conformity, Follow};
use septet_meshing::constrain::{Constrain, Counted};
use septet_meshing::distance::Features;
use septet_meshing::domain::Domain;
use septet_meshing::facet::Triangulate;
use septet_meshing::generate::remesh::{DEFAULT_PARTS, Options, SurfaceFeatures, remesh};
use septet_meshing::generate::{self, Coarse, GenerationError, Missing, Rules};
use septet_meshing::improve::{Target, improve};
use septet_meshing::mesh::{Mesh, StageLine};
use septet_meshing::quality::balls::BoundaryBalls;
pub use septet_meshing::quality::promise::Promise;
use septet_meshing::quality::zones::Zones;
use septet_meshing::quality::{CentrePlace, Measure, Quality, quality_on};
use septet_meshing::size::SizeFunction;
use septet_workers::profile::stage_span;

use crate::run::memory;
use crate::spec::{Machine, Spec};
pub use error::MeshError;
use machine::{AllCores, CountedMachine};
pub use options::MESH_OPTIONS;
pub use pipeline::{Dimension, Made, MakeError, MeshKeep, accept, check, make, make_of, remedy};
pub use request::{
    Boundary, DEFAULT_FEATURE_ANGLE, DEFAULT_LIPSCHITZ, MeshSpec, SingularityRequest, SingularityShape, Sizes,
};
use run_log::RunLog;

/// Compares a mesh with its domain. The request selects whether the boundary is exact or remeshed.
pub fn conform<P: Triangulate>(domain: &Domain<P>, mesh: &Mesh<P>, request: &MeshSpec) -> Conformity {
    let _span = stage_span(request.run.machine.name(), "conformity");
    if request.remeshes(domain) {
        conformity::check_on(domain, mesh, Some(&follow(request)), &AllCores)
    } else {
        conformity::check_on(domain, mesh, None, &AllCores)
    }
}

/// Returns the requirements for a remeshed boundary.
fn follow(request: &MeshSpec) -> Follow {
    Follow { feature_angle: request.feature_angle, distance: request.max_distance }
}

/// Builds the size function of a request.
///
/// # Errors
/// Fails if sizes are out of range or too fine.
pub fn sizes<P: Triangulate>(domain: &Domain<P>, request: &MeshSpec) -> Result<SizeFunction<P>, MeshError> {
    sizes_on(domain, request, &machine(request))
}

/// Builds the size function of a request on a machine.
fn sizes_on<P: Triangulate>(
    domain: &Domain<P>,
    request: &MeshSpec,
    machine: &CountedMachine,
) -> Result<SizeFunction<P>, MeshError> {
    let mut options = request.size_options(domain)?;
    if request.is_free(domain) {
        // No part of the boundary limits the size, and no good cell is larger than this.
        let none = Features::of_chains(domain, Vec::new());
        options.constraints.most.get_or_insert(4.0 * diagonal_of(domain));
        return Ok(SizeFunction::of_features(domain, &none, &options, machine)??);
    }
    if !request.remeshes(domain) {
        let features = Features::new(domain);
        if let Some(Coarse { feature, size, step }) = Coarse::of(domain, &features) {
            return Err(MeshError::Coarse { feature, size, step });
        }
        return Ok(SizeFunction::of_features(domain, &features, &options, machine)??);
    }
    let constraints = &mut options.constraints;
    if constraints.most.is_none() && constraints.field.is_empty() && constraints.singularities.is_empty() {
        constraints.most = Some(diagonal_of(domain) / DEFAULT_PARTS);
    }
    let surface = SurfaceFeatures::new(domain, request.feature_angle);
    Ok(SizeFunction::of_features(domain, &surface.distance_features(domain), &options, machine)??)
}

/// Returns the diagonal of the bounding box of the corners, in the unit of the file.
fn diagonal_of<P: Triangulate>(domain: &Domain<P>) -> f64 {
    let live = domain.corners.iter().map(|&v| domain.points()[v as usize]);
    let extent = septet_meshing::bvh::Bounds::of(live).extent();
    septet_geometry::range::scale(extent, -domain.simplices.frame.exponent).norm2().sqrt()
}

/// Measures the quality of a mesh of this request. For a constrained triangulation, no radius-edge ratio is promised. Neither is one
/// for a remeshed surface, of which only
/// its corners and ridges define the local feature size.
pub fn assess<P: Triangulate>(
    domain: &Domain<P>,
    mesh: &Mesh<P>,
    size: &SizeFunction<P>,
    request: &MeshSpec,
    worst: usize,
) -> Quality<P> {
    let _span = stage_span(request.run.machine.name(), "quality");
    if request.is_free(domain) {
        return measure_freely(domain, mesh, worst);
    }
    if !request.remeshes(domain) {
        return measure(domain, mesh, size, worst);
    }
    let features = Features::new(domain);
    let kept = SurfaceFeatures::new(domain, request.feature_angle).distance_features(domain);
    let zone = 1.0 / (1.0 - size.lipschitz());
    let zones = Zones { domain, features: &features, size: &|x| size.at(x), zone };
    let measure = Measure {
        place: &|centre, radius| zones.place(centre, radius),
        local_size: Some(&|x| kept.local_size(x).radius),
        promised: [None; 3],
        worst,
    };
    quality_on(domain, mesh, &measure, &AllCores)
}

/// Measures the quality of a constrained triangulation, for which no radius-edge ratio is promised.
fn measure_freely<P: Triangulate>(domain: &Domain<P>, mesh: &Mesh<P>, worst: usize) -> Quality<P> {
    let place = |centre, _| {
        if domain.is_inside(centre) { CentrePlace::Free } else { CentrePlace::Outside(None) }
    };
    let measure = Measure { place: &place, local_size: None, promised: [None; 3], worst };
    quality_on(domain, mesh, &measure, &AllCores)
}

/// Measures the quality of a mesh against its size function and the promised ratios.
pub fn measure<P: Triangulate>(
    domain: &Domain<P>,
    mesh: &Mesh<P>,
    size: &SizeFunction<P>,
    worst: usize,
) -> Quality<P> {
    let features = Features::new(domain);
    let at = |x| size.at(x);
    let balls = BoundaryBalls::new(domain, &features, mesh, &at, size.lipschitz());
    let measure = Measure {
        place: &|centre, radius| balls.place(centre, radius),
        local_size: Some(&|x| features.local_size(x).radius),
        promised: balls.promise(size.lipschitz()).all(),
        worst,
    };
    quality_on(domain, mesh, &measure, &AllCores)
}

/// A mesh before it is checked, with its stages and runs.
struct Built<P: Triangulate> {
    mesh: Mesh<P>,
    stages: Vec<StageLine>,
    run_log: RunLog,
    /// The worker that owned each cell, if requested.
    owners: Option<Vec<u32>>,
}

/// Generates a mesh of a domain without checking it. [`make`] also compares it with the domain.
///
/// The counts of the stage `improve` have a special meaning: candidates are bad cells, points are changes, and rounds of
/// completion are rounds of changes. The result is the same for every number of workers and threads and for every transport.
///
/// # Errors
/// Returns [`MeshError`].
pub fn generate<P: Constrain>(
    domain: &Domain<P>,
    size: &SizeFunction<P>,
    request: &MeshSpec,
) -> Result<(Mesh<P>, Vec<StageLine>), MeshError> {
    build(domain, size, request, (machine(request), 0)).map(|made| (made.mesh, made.stages))
}

/// Generates a mesh on a machine, with the log of its runs. Keeps the owners of cells if the mesh has at most `owned` cells.
///
/// # Errors
/// Returns [`MeshError`].
fn build<P: Constrain>(
    domain: &Domain<P>,
    size: &SizeFunction<P>,
    request: &MeshSpec,
    (mut machine, owned): (CountedMachine, usize),
) -> Result<Built<P>, MeshError> {
    let mut rules =
        Rules { size, lipschitz: size.lipschitz(), seed: request.run.machine.seed, most: MOST_POINTS };
    if let Some(limit) = request.run.machine.max_memory.or_else(memory::available) {
        rules.most = MOST_POINTS.min(limit / BYTES_PER_POINT);
    }
    if let Some(limit) = request.run.machine.max_memory {
        let points = if request.as_it_is {
            domain.corners.len() as u64
        } else {
            generate::expected_points(domain, rules, &AllCores)
        };
        let forecast = points.saturating_mul(BYTES_PER_POINT).saturating_add(64 << 20);
        if forecast > limit {
            return Err(MeshError::Memory { forecast, limit, points });
        }
    }
    let (made, sequential) = generated(domain, rules, request, &mut machine).map_err(failure)?;
    let inside = (0..made.delaunay.cells.len() as u32).filter(|&c| made.labels.is_inside(c)).count();
    // The cells of a constrained triangulation are not those of a run.
    let known = machine.owners(P::DIM, made.delaunay.cells.len());
    let known = known.filter(|_| inside <= owned && !request.is_free(domain));
    let known = known.map(|owners| (made.delaunay.cells.clone(), owners.to_vec()));
    let (mut stages, run_log) = machine.finish(&made.stages);
    if let Some(last) = stages.last_mut() {
        last.work += sequential;
        last.depth += sequential;
    }
    let (mut mesh, mut changes) = (made.into_mesh(domain), 0);
    if request.improve && !request.as_it_is {
        let _span = stage_span(request.run.machine.name(), "improve");
        let start = Instant::now();
        let follow = request.remeshes(domain).then(|| follow(request));
        let fixed = request.keep_surface;
        // No ratio is promised for a refined triangulation.
        let ratio = if request.is_free(domain) { f64::INFINITY } else { request.radius_edge() };
        let target = Target { ratio, fixed, follow, ..Target::default() };
        let done = improve(domain, &mut mesh, &target, &AllCores);
        changes = done.changes();
        stages.push(StageLine {
            name: "improve".to_string(),
            candidates: done.bad[0],
            points: changes,
            completion_rounds: u64::from(done.sweeps),
            seconds: start.elapsed().as_secs_f64(),
            ..StageLine::default()
        });
    }
    // No worker owned the cells of a changed mesh.
    let owners =
        known.filter(|_| changes == 0).and_then(|(cells, owners)| view::owned(&cells, &owners, &mesh));
    Ok(Built { mesh, stages, run_log, owners })
}

/// Generates a mesh as the request chooses. Also returns the operations that the machine does not count.
fn generated<P: Constrain>(
    domain: &Domain<P>,
    rules: Rules<'_, P>,
    request: &MeshSpec,
    machine: &mut CountedMachine,
) -> Counted<P, crate::Error> {
    if request.as_it_is {
        P::as_it_is(domain, rules, machine)
    } else if request.is_refined(domain) {
        P::refined(domain, rules, request.wish(), machine)
    } else if request.remeshes(domain) {
        let options = Options { distance: request.max_distance };
        remesh(domain, rules, request.feature_angle, options, machine).map(|made| (made, 0))
    } else {
        generate::generate(domain, rules, machine).map(|made| (made, 0))
    }
}

/// Converts an error of the generator.
fn failure(failure: GenerationError<crate::Error>) -> MeshError {
    match failure {
        GenerationError::Machine(error) => MeshError::Run(error),
        GenerationError::Missing(Missing { features, reason }) => MeshError::Missing { features, reason },
        GenerationError::TooMany(most) => MeshError::TooMany { most },
        GenerationError::Unsupported(what) => MeshError::Unsupported(what),
    }
}

/// Returns the machine of the runs. The memory limit applies to the mesh as a whole, not to each run.
fn machine(request: &MeshSpec) -> CountedMachine {
    CountedMachine::new(Spec::default().with(|spec| {
        spec.machine = Machine { max_memory: None, ..request.run.machine.clone() };
        spec.tree = request.run.tree;
        spec.control.cancel.clone_from(&request.run.control.cancel);
    }))
    .with_recursion(request.by_recursion)
}

/// The largest number of points for which 32 bits can index the cells.
const MOST_POINTS: u64 = 1 << 26;

/// Bytes of memory per point of a mesh: measured peaks, rounded up.
const BYTES_PER_POINT: u64 = 3000;
