//! Meshes of domains: what is asked for, the mesh as files take it, and its report.
//!
//! [`generate`] makes a mesh, [`labelled::Labelled`] is what writers take of it, [`report`] what `--json` says, [`tables`] what
//! `--profile` says. [`record`] is what the machine did meanwhile, [`view`] the picture in the report.

pub mod field;
pub mod labelled;
pub mod machine;
pub mod pipeline;
pub mod record;
pub mod view;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use septet_meshing::conformity::{self, Conformity, Follow};
use septet_meshing::distance::Features;
use septet_meshing::domain::{Domain, Feature};
use septet_meshing::facet::Triangulate;
use septet_meshing::generate::remesh::{DEFAULT_PARTS, Kept, Options, remesh};
use septet_meshing::generate::{self, Failure, Rules};
use septet_meshing::improve::{Target, improve};
use septet_meshing::input::Kind;
use septet_meshing::mesh::{Mesh, StageLine};
use septet_meshing::quality::balls::Balls;
pub use septet_meshing::quality::promise::Promise;
use septet_meshing::quality::zones::Zones;
use septet_meshing::quality::{Measure, Quality, quality};
use septet_meshing::size::user::{Singularity, Wishes};
use septet_meshing::size::{SizeError, SizeFunction, SizeOptions};
use septet_workers::profile::stage_span;
use thiserror::Error;

use crate::config::{Config, Transport, Workers};
use crate::run::memory;
use field::SizeField;
use machine::{AllCores, Counted};
pub use pipeline::{Dimension, Keep, Made, MakeError, check, make, make_of};
use record::Record;

/// The Lipschitz constant where nothing is asked for. Radius-edge ratios are then at most `1/(1-L) = 2` away from the
/// boundary, the bound that mesh generators take by default; a smaller L costs points everywhere, a larger one saves
/// few, since sizes grow by L on each unit of length and no faster than the local feature size does.
pub const DEFAULT_LIPSCHITZ: f64 = 0.5;

/// The feature angle where nothing is asked for, in degrees.
pub const DEFAULT_FEATURE_ANGLE: f64 = 60.0;

/// What is kept of the boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Every segment and every facet of the input.
    Exact,
    /// Corners, and ridges above the feature angle.
    Remesh,
}

impl Boundary {
    /// What is kept if nothing is asked for: of a complex all that it states, of a surface what it describes.
    pub fn of(kind: Kind) -> Self {
        match kind {
            Kind::Complex => Boundary::Exact,
            Kind::Surface => Boundary::Remesh,
        }
    }
}

/// The shape of a singularity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A point, the middle of the domain's box if no place is given.
    Point,
    /// A segment, the middle third of the box's first axis if no place is given.
    Line,
}

/// A place towards which sizes fall to the smallest one.
#[derive(Clone, Debug, PartialEq)]
pub struct SingularityRequest {
    /// Point or line.
    pub shape: Shape,
    /// Its coordinates, one point or two; none for the default.
    pub at: Vec<f64>,
}

/// What is asked for. Lengths are in the unit of the file.
#[derive(Clone, Debug)]
pub struct MeshRequest {
    /// What is kept of the boundary; by the kind of the domain if not said.
    pub boundary: Option<Boundary>,
    /// The largest size anywhere.
    pub size: Option<f64>,
    /// Sizes at points.
    pub field: Option<SizeField>,
    /// Where sizes fall to the smallest one.
    pub singularity: Option<SingularityRequest>,
    /// The smallest size anywhere.
    pub min_size: Option<f64>,
    /// The Lipschitz constant L, between 0 and 1.
    pub lipschitz: f64,
    /// Edges whose faces turn by more than this, in degrees, are ridges.
    pub feature_angle: f64,
    /// The largest distance between the boundary of a remeshed surface and the surface.
    pub max_distance: Option<f64>,
    /// Are slivers to be removed?
    pub improve: bool,
    /// Largest leaf of the partition trees of independent sets; by dimension if none.
    pub leaf: Option<u64>,
    /// Workers of the machine.
    pub workers: Workers,
    /// Threads that run them.
    pub threads: usize,
    /// How their messages travel.
    pub transport: Transport,
    /// Seed of every random draw.
    pub seed: u64,
    /// Refuse to start if more memory is expected, in bytes. If not said, a mesh ends where it is sure to need more than there is.
    pub max_memory: Option<u64>,
    /// Ends the machine's next run with [`Error::Interrupted`](crate::Error::Interrupted) once it is true.
    pub cancel: Option<Arc<AtomicBool>>,
}

/// Why there is no mesh.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// This cannot be done.
    #[error("{0}")]
    Unsupported(&'static str),
    /// The sizes asked for are out of range, or too fine.
    #[error(transparent)]
    Size(#[from] SizeError),
    /// A size field or a singularity has another dimension than the domain.
    #[error("{what} has {found} coordinates a point, the domain has {expected}")]
    Dimension {
        /// Which.
        what: &'static str,
        /// The domain's.
        expected: usize,
        /// Its own.
        found: usize,
    },
    /// Features that meet at small angles and could not be kept.
    #[error("{} of the domain's segments and facets cannot be kept, where features meet at small angles", features.len())]
    Missing {
        /// The features, and how many of their pieces or triangles are missing.
        features: Vec<(Feature, u32)>,
    },
    /// More points than allowed.
    #[error("the mesh needs more than {most} points, which is more than memory or ids of 32 bits hold")]
    TooMany {
        /// The limit.
        most: u64,
    },
    /// More memory than allowed would be needed.
    #[error("about {forecast} bytes would be needed for {points} points, the limit is {limit}")]
    Memory {
        /// Bytes expected.
        forecast: u64,
        /// Bytes allowed.
        limit: u64,
        /// Points expected.
        points: u64,
    },
    /// The machine failed, or the triangulation.
    #[error(transparent)]
    Run(#[from] crate::Error),
}

impl MeshRequest {
    /// Has the caller given up?
    fn check_cancelled(&self) -> Result<(), MeshError> {
        let cancelled = self.cancel.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed));
        if cancelled { Err(MeshError::Run(crate::Error::Interrupted)) } else { Ok(()) }
    }

    /// What is kept of the boundary of such a domain.
    pub fn boundary_of(&self, kind: Kind) -> Boundary {
        self.boundary.unwrap_or_else(|| Boundary::of(kind))
    }

    /// Is this domain remeshed?
    pub fn remeshes<P: Triangulate>(&self, domain: &Domain<P>) -> bool {
        self.boundary_of(domain.kind) == Boundary::Remesh
    }

    /// The largest radius-edge ratio away from the boundary: `1/(1-L)`.
    pub fn radius_edge(&self) -> f64 {
        1.0 / (1.0 - self.lipschitz)
    }

    /// What the size function is asked for in this domain.
    ///
    /// # Errors
    /// A field or a singularity of another dimension.
    pub fn size_options<P: Triangulate>(&self, domain: &Domain<P>) -> Result<SizeOptions<P>, MeshError> {
        let field = self.field.as_ref().map(SizeField::cones::<P>).transpose()?.unwrap_or_default();
        let singularities = match (&self.singularity, self.min_size) {
            (Some(singularity), Some(size)) => vec![(singularity.place(domain)?, size)],
            _ => Vec::new(),
        };
        let wishes = Wishes { most: self.size, least: self.min_size, field, singularities };
        Ok(SizeOptions { wishes, ..SizeOptions::new(self.lipschitz) })
    }
}

impl SingularityRequest {
    fn place<P: Triangulate>(&self, domain: &Domain<P>) -> Result<Singularity<P>, MeshError> {
        let due = if self.shape == Shape::Point { P::DIM } else { 2 * P::DIM };
        if self.at.len() == due {
            let (p, q) = (P::from_coords(&self.at), P::from_coords(&self.at[due - P::DIM..]));
            return Ok(if self.shape == Shape::Point {
                Singularity::Point(p)
            } else {
                Singularity::Line(p, q)
            });
        }
        if !self.at.is_empty() {
            let found = if self.shape == Shape::Point { self.at.len() } else { self.at.len() / 2 };
            return Err(MeshError::Dimension { what: "--singularity", expected: P::DIM, found });
        }
        let unscaled = |p: P| septet_geometry::range::scale(p, -domain.simplices.exponent);
        let live = domain.corners.iter().map(|&v| domain.points()[v as usize]);
        let bounds = septet_meshing::bvh::Bounds::of(live);
        let middle = bounds.low + (bounds.high - bounds.low) * 0.5;
        if self.shape == Shape::Point {
            return Ok(Singularity::Point(unscaled(middle)));
        }
        let third = (bounds.high.coord(0) - bounds.low.coord(0)) / 3.0;
        let at = |x: f64| {
            let mut p = middle;
            p.set_coord(0, x);
            unscaled(p)
        };
        Ok(Singularity::Line(at(bounds.low.coord(0) + third), at(bounds.low.coord(0) + 2.0 * third)))
    }
}

/// Compares a mesh with its domain, as far as what is kept of the boundary asks for.
pub fn conform<P: Triangulate>(domain: &Domain<P>, mesh: &Mesh<P>, request: &MeshRequest) -> Conformity {
    let _span = stage_span(request.seed, "conformity");
    match request.boundary_of(domain.kind) {
        Boundary::Exact => conformity::check(domain, mesh),
        Boundary::Remesh => {
            let follow = Follow { feature_angle: request.feature_angle, distance: request.max_distance };
            conformity::check_remeshed(domain, mesh, &follow)
        }
    }
}

/// The size function that is asked for.
///
/// # Errors
/// Sizes out of range, or too fine.
pub fn sizes<P: Triangulate>(
    domain: &Domain<P>,
    request: &MeshRequest,
) -> Result<SizeFunction<P>, MeshError> {
    let _span = stage_span(request.seed, "sizes");
    let mut options = request.size_options(domain)?;
    if !request.remeshes(domain) {
        return Ok(SizeFunction::of_features(domain, &Features::new(domain), &options, &AllCores)?);
    }
    let wishes = &mut options.wishes;
    if wishes.most.is_none() && wishes.field.is_empty() && wishes.singularities.is_empty() {
        let live = domain.corners.iter().map(|&v| domain.points()[v as usize]);
        let extent = septet_meshing::bvh::Bounds::of(live).extent();
        let diagonal = septet_geometry::range::scale(extent, -domain.simplices.exponent).norm2().sqrt();
        wishes.most = Some(diagonal / DEFAULT_PARTS);
    }
    let kept = Kept::new(domain, request.feature_angle);
    Ok(SizeFunction::of_features(domain, &kept.features(domain), &options, &AllCores)?)
}

/// How good a mesh is that was asked for so. Of a remeshed surface nothing is promised about radius-edge ratios, and the
/// local feature size is that of its corners and ridges.
pub fn assess<P: Triangulate>(
    domain: &Domain<P>,
    mesh: &Mesh<P>,
    size: &SizeFunction<P>,
    request: &MeshRequest,
    worst: usize,
) -> Quality<P> {
    let _span = stage_span(request.seed, "quality");
    if !request.remeshes(domain) {
        return measure(domain, mesh, size, worst);
    }
    let features = Features::new(domain);
    let kept = Kept::new(domain, request.feature_angle).features(domain);
    let zone = 1.0 / (1.0 - size.lipschitz());
    let zones = Zones { domain, features: &features, size: &|x| size.at(x), zone };
    let measure = Measure {
        place: &|centre, radius| zones.place(centre, radius),
        local_size: Some(&|x| kept.local_size(x).radius),
        promised: [None; 3],
        worst,
    };
    quality(domain, mesh, &measure)
}

/// How good a mesh is, against the size function asked for and the promise.
pub fn measure<P: Triangulate>(
    domain: &Domain<P>,
    mesh: &Mesh<P>,
    size: &SizeFunction<P>,
    worst: usize,
) -> Quality<P> {
    let features = Features::new(domain);
    let at = |x| size.at(x);
    let balls = Balls::new(domain, &features, mesh, &at, size.lipschitz());
    let measure = Measure {
        place: &|centre, radius| balls.place(centre, radius),
        local_size: Some(&|x| features.local_size(x).radius),
        promised: balls.promise(size.lipschitz()).all(),
        worst,
    };
    quality(domain, mesh, &measure)
}

/// A mesh before it is checked, and what it took.
struct Built<P: Triangulate> {
    mesh: Mesh<P>,
    stages: Vec<StageLine>,
    record: Record,
    /// The worker that owned each cell, if asked for.
    owners: Option<Vec<u32>>,
}

/// Makes a mesh of a domain, unchecked: [`make`] compares it with the domain. The stage `improve` counts bad cells as candidates, moves as points and sweeps as rounds of
/// completion. The result is the same for every number of workers, threads and every transport.
///
/// # Errors
/// [`MeshError`].
pub fn generate<P: Triangulate>(
    domain: &Domain<P>,
    size: &SizeFunction<P>,
    request: &MeshRequest,
) -> Result<(Mesh<P>, Vec<StageLine>), MeshError> {
    build(domain, size, request, 0).map(|made| (made.mesh, made.stages))
}

/// [`generate`] with all that the machine did. The owners of cells are kept of a mesh of at most `owned` cells.
///
/// # Errors
/// [`MeshError`].
fn build<P: Triangulate>(
    domain: &Domain<P>,
    size: &SizeFunction<P>,
    request: &MeshRequest,
    owned: usize,
) -> Result<Built<P>, MeshError> {
    let at = |x| size.at(x);
    let mut rules = Rules { size: &at, lipschitz: size.lipschitz(), seed: request.seed, most: MOST_POINTS };
    let mut machine = machine(request);
    if let Some(limit) = request.max_memory.or_else(memory::available) {
        rules.most = MOST_POINTS.min(limit / BYTES_PER_POINT);
    }
    if let Some(limit) = request.max_memory {
        let points = generate::expected_points(domain, rules, &machine);
        let forecast = points.saturating_mul(BYTES_PER_POINT).saturating_add(64 << 20);
        if forecast > limit {
            return Err(MeshError::Memory { forecast, limit, points });
        }
    }
    let made = if request.remeshes(domain) {
        let options = Options { distance: request.max_distance };
        remesh(domain, rules, request.feature_angle, options, &mut machine)
    } else {
        generate::generate(domain, rules, &mut machine)
    };
    let made = made.map_err(|failure| match failure {
        Failure::Machine(error) => MeshError::Run(error),
        Failure::Missing(missing) => MeshError::Missing { features: missing.features },
        Failure::TooMany(most) => MeshError::TooMany { most },
        Failure::Unsupported(what) => MeshError::Unsupported(what),
    })?;
    let inside = (0..made.delaunay.cells.len() as u32).filter(|&c| made.labels.is_inside(c)).count();
    let home = machine.owners(P::DIM, made.delaunay.cells.len()).filter(|_| inside <= owned);
    let home = home.map(|owners| (made.delaunay.cells.clone(), owners.to_vec()));
    let (mut stages, record) = machine.finish(&made.stages);
    let mut mesh = made.into_mesh(domain);
    let owners = home.and_then(|(cells, owners)| view::owned(&cells, &owners, &mesh));
    if request.improve {
        let _span = stage_span(request.seed, "improve");
        let start = Instant::now();
        let fixed = request.remeshes(domain);
        let target = Target { ratio: request.radius_edge(), fixed, ..Target::default() };
        let done = improve(domain, &mut mesh, &target);
        stages.push(StageLine {
            name: "improve".to_string(),
            candidates: done.bad[0],
            points: done.moved,
            completion_rounds: u64::from(done.sweeps),
            seconds: start.elapsed().as_secs_f64(),
            ..StageLine::default()
        });
    }
    Ok(Built { mesh, stages, record, owners })
}

fn machine(request: &MeshRequest) -> Counted {
    Counted::new(Config {
        workers: request.workers,
        threads: request.threads,
        seed: request.seed,
        transport: request.transport,
        leaf: request.leaf,
        cancel: request.cancel.clone(),
        ..Config::default()
    })
}

/// Points that cells of 32 bits can have.
const MOST_POINTS: u64 = 1 << 26;

/// Bytes a point of a mesh: measured peaks, rounded up.
const BYTES_PER_POINT: u64 = 3000;
