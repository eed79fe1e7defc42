//! Errors of mesh generation.

use septet_meshing::domain::Feature;
use septet_meshing::generate::Reason;
use septet_meshing::octree::TooFine;
use septet_meshing::size::SizeError;
use thiserror::Error;

use crate::remedy::Remedy;

/// Errors of mesh generation.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The request is not supported.
    #[error("{0}")]
    Unsupported(&'static str),
    /// The sizes requested are out of range or too fine.
    #[error(transparent)]
    Size(#[from] SizeError),
    /// A size field or a singularity has a different dimension than the domain.
    #[error("the {what} has {found} coordinates per point, but the domain has {expected}")]
    Dimension {
        /// The input at fault: size field or singularity.
        what: &'static str,
        /// The dimension of the domain.
        expected: usize,
        /// The dimension of this input.
        found: usize,
    },
    /// Features could not be recovered.
    #[error("{} segments and facets of the domain cannot be recovered {}", features.len(), because(*reason))]
    Missing {
        /// The features, and the number of missing subsegments or subfacets of each.
        features: Vec<(Feature, u32)>,
        /// Why they are missing.
        reason: Reason,
    },
    /// The coordinates of the file are too coarse for its features.
    #[error(
        "the coordinates are too coarse: they are multiples of {step:e}, but features are {size:e} apart"
    )]
    Coarse {
        /// The feature with the smallest local feature size.
        feature: Feature,
        /// The local feature size there, in the unit of the file.
        size: f64,
        /// The step between adjacent coordinates, in the unit of the file.
        step: f64,
    },
    /// The mesh needs more points than the limit.
    #[error("the mesh needs more than {most} points, the limit of the memory or of 32-bit indices")]
    TooMany {
        /// The limit.
        most: u64,
    },
    /// The mesh needs more memory than the limit.
    #[error("{points} points need about {forecast} bytes of memory, but the limit is {limit}")]
    Memory {
        /// The forecast in bytes.
        forecast: u64,
        /// The limit in bytes.
        limit: u64,
        /// The number of points expected.
        points: u64,
    },
    /// A run of the machine failed.
    #[error(transparent)]
    Run(#[from] crate::Error),
}

/// Says why features cannot be recovered.
fn because(reason: Reason) -> &'static str {
    match reason {
        Reason::Angles => "because features meet at small angles",
        Reason::Rounding => "because their points would be closer than the rounding of coordinates",
        Reason::Rounds => "in the permitted number of rounds",
    }
}

impl MeshError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(match self {
            Self::Dimension { .. } => Remedy::of(
                "use as many coordinates as the domain has; in a size field, the size follows them",
            ),
            Self::Missing { reason: Reason::Angles, .. } => {
                Remedy::of("{check} lists the small angles of the domain; a smaller {size} may help")
            }
            Self::Missing { reason: Reason::Rounding, .. } => {
                Remedy::of("write coordinates relative to a point of the domain, or raise {min-size}")
            }
            Self::Missing { reason: Reason::Rounds, .. } => Remedy::of("a smaller {size} may help"),
            Self::Coarse { .. } => Remedy::of(
                "write coordinates relative to a point of the domain, or join features that are closer",
            ),
            Self::TooMany { .. } | Self::Memory { .. } => {
                Remedy::of("raise {max-memory}, or increase {size} or {min-size}")
            }
            Self::Size(SizeError::TooFine(TooFine::Cells { .. })) => {
                Remedy::of("raise {min-size} or {max-memory}")
            }
            Self::Size(SizeError::TooFine(TooFine::Levels { .. })) => Remedy::of("raise {min-size}"),
            Self::Run(error) => return error.remedy(),
            Self::Unsupported(_)
            | Self::Size(
                SizeError::Lipschitz(_) | SizeError::Loss { .. } | SizeError::Size(_) | SizeError::Place,
            ) => return None,
        })
    }
}
