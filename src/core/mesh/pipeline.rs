//! From a domain to a mesh that conforms to it: the order of the steps for both dimensions.
//!
//! [`make`] is compiled here for the plane and for space, so that callers do not compile the generator.

use std::time::Instant;

use glam::{DVec2, DVec3};
use septet_meshing::Accepted;
use septet_meshing::conformity::Conformity;
use septet_meshing::constrain::Constrain;
use septet_meshing::defect::{Defect, Element};
use septet_meshing::domain::Domain;
use septet_meshing::facet::Triangulate;
use septet_meshing::input::{DomainKind, Input};
use septet_meshing::mesh::{Mesh, StageLine};
use septet_meshing::quality::Quality;
use septet_meshing::repair::Tolerance;
use septet_meshing::size::SizeFunction;
use septet_workers::config::cores::within;
use thiserror::Error;

use super::run_log::RunLog;
use super::{Built, MeshError, MeshSpec, assess, build, conform, machine, sizes_on};
use crate::remedy::Remedy;

/// Limits on the data that the result keeps besides the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshKeep {
    /// The largest number of cells for which the owners of cells are kept.
    pub owned: usize,
    /// The number of worst cells kept in each list.
    pub worst: usize,
}

impl Default for MeshKeep {
    fn default() -> Self {
        MeshKeep { owned: 0, worst: 10 }
    }
}

/// A mesh with its check and quality. [`make`] returns it only if the mesh conforms to its domain.
#[derive(Debug)]
#[non_exhaustive]
pub struct Made<P: Triangulate> {
    /// The mesh.
    pub mesh: Mesh<P>,
    /// The size function used.
    pub size: SizeFunction<P>,
    /// The stages of generation.
    pub stages: Vec<StageLine>,
    /// The runs of the machine.
    pub run_log: RunLog,
    /// The worker that owned each cell, if requested.
    pub owners: Option<Vec<u32>>,
    /// The comparison with the domain.
    pub conformity: Conformity,
    /// The shapes, sizes and angles of its cells.
    pub quality: Quality<P>,
    /// Measured seconds of generation, including the size function.
    pub seconds: f64,
}

/// Errors of [`make`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MakeError<P: Triangulate> {
    /// The input is not a domain.
    #[error("the input is not a domain: {} defects, the first is: {}", .0.len(), first(.0))]
    Input(Vec<Defect>),
    /// The mesh could not be generated.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The indices of the mesh are invalid, so it cannot be compared with the domain.
    #[error("the arrays of the mesh are inconsistent: {} defects", .0.defects.len())]
    Shapeless(Conformity),
    /// The mesh does not conform to its domain. This is a bug in septet.
    #[error("the mesh does not conform to its domain: {} defects", .0.conformity.defects.len())]
    NotConforming(Box<Made<P>>),
}

impl<P: Triangulate> MakeError<P> {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        match self {
            MakeError::Input(defects) => Some(remedy(defects)),
            MakeError::Mesh(error) => error.remedy(),
            MakeError::Shapeless(_) | MakeError::NotConforming(_) => Some(Remedy::REPORT),
        }
    }
}

/// Returns what to do about the defects of a domain.
pub fn remedy(defects: &[Defect]) -> Remedy {
    let is_mendable = |defect: &Defect| match defect {
        Defect::Degenerate { .. }
        | Defect::Doubled { .. }
        | Defect::OpenEdge { .. }
        | Defect::NotPlanar { .. }
        | Defect::NonManifoldEdge { .. } => true,
        Defect::Intersect { elements, .. } => matches!(elements, [Element::Point(_), Element::Segment(_)]),
        _ => false,
    };
    if defects.iter().any(is_mendable) {
        return Remedy::of(
            "fix the defects of the domain, or use {repair} to divide edges at points on them, to drop double and flat facets \
             and to close small holes, and {weld} for points that nearly coincide",
        );
    }
    Remedy::of("fix the defects of the domain")
}

fn first(defects: &[Defect]) -> &'static str {
    defects.first().map_or("none", Defect::kind)
}

/// A dimension whose mesh generation is compiled in this crate: the plane or space.
pub trait Dimension: Triangulate {
    /// Runs [`septet_meshing::check`] in this dimension.
    ///
    /// # Errors
    /// Returns the defects of the input.
    fn check(input: &Input<Self>) -> Result<Domain<Self>, Vec<Defect>>;

    /// Runs [`septet_meshing::accept`] in this dimension.
    ///
    /// # Errors
    /// Returns the defects of the input.
    fn accept(input: &Input<Self>, tolerance: &Tolerance) -> Result<Accepted<Self>, Vec<Defect>>;

    /// Runs [`make_of`] in this dimension.
    ///
    /// # Errors
    /// Returns [`MakeError`].
    fn make(domain: &Domain<Self>, request: &MeshSpec, keep: MeshKeep)
    -> Result<Made<Self>, MakeError<Self>>;
}

impl Dimension for DVec2 {
    fn check(input: &Input<Self>) -> Result<Domain<Self>, Vec<Defect>> {
        septet_meshing::check(input)
    }

    fn accept(input: &Input<Self>, tolerance: &Tolerance) -> Result<Accepted<Self>, Vec<Defect>> {
        septet_meshing::accept(input, tolerance)
    }

    fn make(
        domain: &Domain<Self>,
        request: &MeshSpec,
        keep: MeshKeep,
    ) -> Result<Made<Self>, MakeError<Self>> {
        checked(domain, request, keep)
    }
}

impl Dimension for DVec3 {
    fn check(input: &Input<Self>) -> Result<Domain<Self>, Vec<Defect>> {
        septet_meshing::check(input)
    }

    fn accept(input: &Input<Self>, tolerance: &Tolerance) -> Result<Accepted<Self>, Vec<Defect>> {
        septet_meshing::accept(input, tolerance)
    }

    fn make(
        domain: &Domain<Self>,
        request: &MeshSpec,
        keep: MeshKeep,
    ) -> Result<Made<Self>, MakeError<Self>> {
        checked(domain, request, keep)
    }
}

/// Checks an input exactly, and returns the domain that it describes.
///
/// # Errors
/// Returns the defects of the input.
pub fn check<P: Dimension>(input: &Input<P>) -> Result<Domain<P>, Vec<Defect>> {
    P::check(input)
}

/// Prepares an input within the tolerance of the request, checks it, and returns its domain and the changes.
///
/// # Errors
/// Returns the defects of the input.
pub fn accept<P: Dimension>(input: &Input<P>, request: &MeshSpec) -> Result<Accepted<P>, Vec<Defect>> {
    P::accept(input, &request.tolerance)
}

/// Accepts an input ([`accept`]), makes a mesh of its domain, and checks the mesh. A mesh that does not conform to the domain is an
/// error. The result is the same for every number of workers and threads and every transport.
///
/// # Errors
/// See [`MakeError`].
pub fn make<P: Dimension>(input: &Input<P>, request: &MeshSpec) -> Result<Made<P>, MakeError<P>> {
    let domain = accept(input, request).map_err(MakeError::Input)?.domain;
    P::make(&domain, request, MeshKeep::default())
}

/// Runs [`make`] on a domain that is already checked.
///
/// # Errors
/// Returns [`MakeError`].
pub fn make_of<P: Dimension>(
    domain: &Domain<P>,
    request: &MeshSpec,
    keep: MeshKeep,
) -> Result<Made<P>, MakeError<P>> {
    P::make(domain, request, keep)
}

/// Runs [`made`] on the threads of the request.
fn checked<P: Constrain>(
    domain: &Domain<P>,
    request: &MeshSpec,
    keep: MeshKeep,
) -> Result<Made<P>, MakeError<P>> {
    let (machine, cancel) = (&request.run.machine, request.run.control.cancel.clone());
    let made = within(machine.thread_count(), cancel, || made(domain, request, keep));
    made.unwrap_or_else(|stopped| Err(MeshError::Run(stopped.into()).into()))
}

/// Computes sizes, mesh, conformity and quality, in this order.
fn made<P: Constrain>(
    domain: &Domain<P>,
    request: &MeshSpec,
    keep: MeshKeep,
) -> Result<Made<P>, MakeError<P>> {
    if request.max_distance.is_some() && !request.remeshes(domain) {
        let what =
            "a largest distance applies only to remeshed boundaries, but this boundary is kept exactly";
        return Err(MeshError::Unsupported(what).into());
    }
    if request.remeshes(domain) && !domain.manifold {
        let what = match domain.kind {
            DomainKind::Complex => "only closed surfaces in space can be remeshed",
            DomainKind::Surface => {
                "the surface is not a manifold, or has regions, so its boundary cannot be remeshed"
            }
        };
        return Err(MeshError::Unsupported(what).into());
    }
    let start = Instant::now();
    let machine = machine(request);
    let size = sizes_on(domain, request, &machine)?;
    let Built { mesh, stages, run_log, owners } = build(domain, &size, request, (machine, keep.owned))?;
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
