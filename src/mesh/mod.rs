//! Meshes of domains: what is asked for, the mesh as files take it, and its report.
//!
//! [`generate`] makes a mesh, [`labelled::Labelled`] is what writers take of it, [`report`] what `--json` says.

pub mod field;
pub mod labelled;
pub mod report;
pub mod show;

use septet_meshing::conformity::{self, Conformity};
use septet_meshing::distance::Features;
use septet_meshing::domain::Domain;
use septet_meshing::facet::Triangulate;
use septet_meshing::input::Kind;
use septet_meshing::mesh::{Mesh, StageLine};
use septet_meshing::quality::zones::Zones;
use septet_meshing::quality::{Measure, Quality, quality};
use septet_meshing::size::user::{Singularity, Wishes};
use septet_meshing::size::{SizeError, SizeFunction, SizeOptions};
use thiserror::Error;

use crate::config::{Transport, Workers};
use field::SizeField;

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
    /// What is kept of a domain of this kind if nothing is asked for.
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
#[derive(Clone, Debug, PartialEq)]
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
    /// Are slivers to be removed?
    pub improve: bool,
    /// Workers of the machine.
    pub workers: Workers,
    /// Threads that run them.
    pub threads: usize,
    /// How their messages travel.
    pub transport: Transport,
    /// Seed of every random draw.
    pub seed: u64,
    /// Refuse to start if more memory is expected, in bytes.
    pub max_memory: Option<u64>,
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
    /// The largest radius-edge ratio away from the boundary: `1/(1-L)`.
    pub fn radius_edge(&self) -> f64 {
        1.0 / (1.0 - self.lipschitz)
    }

    /// What the size function is asked for in this domain.
    ///
    /// # Errors
    /// A field or a singularity of another dimension.
    pub fn size_options<P: Triangulate>(&self, domain: &Domain<P>) -> Result<SizeOptions<P>, MeshError> {
        let field = self.field.as_ref().map(|f| f.cones::<P>()).transpose()?.unwrap_or_default();
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

/// The radius-edge bounds that hold where corners leave angles of at least 90 degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise {
    /// Of cells whose circumcentres lie in the domain, farther than `zone * f` from all segments and facets: `1/(1-L)`.
    pub free: f64,
    /// Of those nearer: `g/(1-gL)` with `g = sqrt((1 + zone L)^2 + zone^2)`; none where `g L >= 1`.
    pub near: Option<f64>,
    /// The width of the protected zone over f.
    pub zone: f64,
}

/// The width of the protected zone over f.
pub const ZONE: f64 = 1.0;

impl Promise {
    /// The bounds at this Lipschitz constant.
    pub fn of(lipschitz: f64) -> Self {
        let g = ((1.0 + ZONE * lipschitz).powi(2) + ZONE * ZONE).sqrt();
        let near = (g * lipschitz < 1.0).then(|| g / (1.0 - g * lipschitz));
        Promise { free: 1.0 / (1.0 - lipschitz), near, zone: ZONE }
    }
}

/// Compares a mesh with its domain, as far as what is kept of the boundary asks for.
pub fn conform<P: Triangulate>(domain: &Domain<P>, mesh: &Mesh<P>, request: &MeshRequest) -> Conformity {
    match request.boundary.unwrap_or(Boundary::of(domain.kind)) {
        Boundary::Exact => conformity::check(domain, mesh),
        Boundary::Remesh => conformity::check_remeshed(domain, mesh),
    }
}

/// How good a mesh is, against the size function asked for and the promise.
///
/// # Errors
/// Sizes out of range.
pub fn measure<P: Triangulate>(
    domain: &Domain<P>,
    mesh: &Mesh<P>,
    request: &MeshRequest,
    worst: usize,
) -> Result<Quality<P>, MeshError> {
    let size = SizeFunction::new(domain, &request.size_options(domain)?)?;
    let features = Features::new(domain);
    let promise = Promise::of(request.lipschitz);
    let zones = Zones { domain, features: &features, size: &|x| size.at(x), zone: promise.zone };
    let measure = Measure {
        place: &|centre, radius| zones.place(centre, radius),
        local_size: Some(&|x| features.local_size(x).radius),
        promised: [Some(promise.free), promise.near],
        worst,
    };
    Ok(quality(domain, mesh, &measure))
}

/// Makes a mesh of a domain.
///
/// # Errors
/// [`MeshError`].
pub fn generate<P: Triangulate>(
    domain: &Domain<P>,
    request: &MeshRequest,
) -> Result<(Mesh<P>, Vec<StageLine>), MeshError> {
    request.size_options(domain)?;
    Err(MeshError::Unsupported("this septet checks domains and makes no meshes yet"))
}

#[cfg(test)]
mod tests;
