//! What is asked of a mesh.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use septet_meshing::domain::{Domain, Feature};
use septet_meshing::facet::Triangulate;
use septet_meshing::input::Kind;
use septet_meshing::size::user::{Singularity, Wishes};
use septet_meshing::size::{SizeError, SizeOptions};
use thiserror::Error;

use super::field::SizeField;
use crate::config::Machine;

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
    /// The machine. Its leaf is that of the partition trees of independent sets. Without a memory limit, meshing stops when
    /// it is certain to need more memory than is available.
    pub machine: Machine,
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
    pub(super) fn check_cancelled(&self) -> Result<(), MeshError> {
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
