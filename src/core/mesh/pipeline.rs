//! From a domain to a mesh that is known to conform: the order of the steps, for both dimensions.
//!
//! [`make`] is compiled here for the plane and for space, so that a caller does not compile the generator.

use std::time::Instant;

use glam::{DVec2, DVec3};
use septet_meshing::conformity::Conformity;
use septet_meshing::defect::Defect;
use septet_meshing::domain::Domain;
use septet_meshing::facet::Triangulate;
use septet_meshing::input::Input;
use septet_meshing::mesh::{Mesh, StageLine};
use septet_meshing::quality::Quality;
use septet_meshing::size::SizeFunction;
use thiserror::Error;

use super::run_log::RunLog;
use super::{Built, MeshError, MeshRequest, assess, build, conform, sizes};

/// What is kept of a mesh besides itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keep {
    /// The owners of cells are kept of a mesh of at most this many cells.
    pub owned: usize,
    /// This many worst cells are kept of each kind.
    pub worst: usize,
}

impl Default for Keep {
    fn default() -> Self {
        Keep { owned: 0, worst: 10 }
    }
}

/// A mesh with the judgement of it. [`make`] returns it only if the mesh conforms to its domain.
#[derive(Debug)]
#[non_exhaustive]
pub struct Made<P: Triangulate> {
    /// The mesh.
    pub mesh: Mesh<P>,
    /// The size function that it was made by.
    pub size: SizeFunction<P>,
    /// The stages of generation.
    pub stages: Vec<StageLine>,
    /// The runs of the machine.
    pub run_log: RunLog,
    /// The worker that owned each cell, if asked for.
    pub owners: Option<Vec<u32>>,
    /// The comparison with the domain.
    pub conformity: Conformity,
    /// Its shapes, sizes and angles.
    pub quality: Quality<P>,
    /// Measured seconds of generation, sizes included.
    pub seconds: f64,
}

/// Why [`make`] returns no mesh.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MakeError<P: Triangulate> {
    /// The input is not a domain.
    #[error("the input is not a domain: {} defects, the first one: {}", .0.len(), first(.0))]
    Input(Vec<Defect>),
    /// The mesh could not be made.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A mesh was made whose cells do not bound anything that could be compared with the domain.
    #[error("the mesh has no shape: {} defects", .0.defects.len())]
    Shapeless(Conformity),
    /// A mesh was made that does not conform to its domain: a fault of septet.
    #[error("the mesh does not conform to its domain: {} defects", .0.conformity.defects.len())]
    NotConforming(Box<Made<P>>),
}

fn first(defects: &[Defect]) -> &'static str {
    defects.first().map_or("none", Defect::kind)
}

/// A dimension whose meshes are made by code that is compiled in this crate: the plane and space.
pub trait Dimension: Triangulate {
    /// [`septet_meshing::check`] in this dimension.
    ///
    /// # Errors
    /// The defects of the input.
    fn check(input: &Input<Self>) -> Result<Domain<Self>, Vec<Defect>>;

    /// [`make_of`] in this dimension.
    ///
    /// # Errors
    /// [`MakeError`].
    fn make(domain: &Domain<Self>, request: &MeshRequest, keep: Keep) -> Result<Made<Self>, MakeError<Self>>;
}

impl Dimension for DVec2 {
    fn check(input: &Input<Self>) -> Result<Domain<Self>, Vec<Defect>> {
        septet_meshing::check(input)
    }

    fn make(domain: &Domain<Self>, request: &MeshRequest, keep: Keep) -> Result<Made<Self>, MakeError<Self>> {
        checked(domain, request, keep)
    }
}

impl Dimension for DVec3 {
    fn check(input: &Input<Self>) -> Result<Domain<Self>, Vec<Defect>> {
        septet_meshing::check(input)
    }

    fn make(domain: &Domain<Self>, request: &MeshRequest, keep: Keep) -> Result<Made<Self>, MakeError<Self>> {
        checked(domain, request, keep)
    }
}

/// The domain that an input describes.
///
/// # Errors
/// Its defects.
pub fn check<P: Dimension>(input: &Input<P>) -> Result<Domain<P>, Vec<Defect>> {
    P::check(input)
}

/// Checks an input, makes a mesh of its domain, and checks the mesh: it conforms to the domain exactly, or there is none.
/// The result is the same for every number of workers, threads and every transport.
///
/// # Errors
/// [`MakeError`].
pub fn make<P: Dimension>(input: &Input<P>, request: &MeshRequest) -> Result<Made<P>, MakeError<P>> {
    let domain = P::check(input).map_err(MakeError::Input)?;
    P::make(&domain, request, Keep::default())
}

/// [`make`] of an input that is checked already.
///
/// # Errors
/// [`MakeError`].
pub fn make_of<P: Dimension>(
    domain: &Domain<P>,
    request: &MeshRequest,
    keep: Keep,
) -> Result<Made<P>, MakeError<P>> {
    P::make(domain, request, keep)
}

/// Sizes, mesh, conformity, quality: in this order.
fn checked<P: Triangulate>(
    domain: &Domain<P>,
    request: &MeshRequest,
    keep: Keep,
) -> Result<Made<P>, MakeError<P>> {
    if request.max_distance.is_some() && !request.remeshes(domain) {
        let what = "a largest distance is for remeshed boundaries: this one is kept exactly";
        return Err(MeshError::Unsupported(what).into());
    }
    let start = Instant::now();
    let size = sizes(domain, request)?;
    let Built { mesh, stages, run_log, owners } = build(domain, &size, request, keep.owned)?;
    let seconds = start.elapsed().as_secs_f64();
    request.check_cancelled()?;
    let conformity = conform(domain, &mesh, request);
    if conformity.is_shapeless() {
        return Err(MakeError::Shapeless(conformity));
    }
    let quality = assess(domain, &mesh, &size, request, keep.worst);
    let made = Made { mesh, size, stages, run_log, owners, conformity, quality, seconds };
    if made.conformity.defects.is_empty() { Ok(made) } else { Err(MakeError::NotConforming(Box::new(made))) }
}
