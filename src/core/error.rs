//! Why a run has no result.

use thiserror::Error;

use septet_geometry::incremental::IncrementalError;
use septet_geometry::range::RangeError;
use septet_protocol::transport::TransportError;

use crate::config::ConfigError;
pub use crate::result::refutation::Refutation;
use crate::result::run::Run;

/// The error of [`crate::triangulate`], [`crate::simulate`] and [`crate::independent()`].
#[derive(Debug, Error)]
pub enum Error {
    /// Parameters that cannot be run.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Points that cannot be triangulated exactly.
    #[error(transparent)]
    Points(#[from] RangeError),
    /// Sites that have no conflict graph.
    #[error(transparent)]
    Sites(#[from] SiteError),
    /// More memory expected than allowed.
    #[error(
        "about {forecast} bytes would be needed for {points} points, more than the limit of {limit}: use more \
         machines, fewer points, or raise --max-memory"
    )]
    Memory {
        /// Expected peak.
        forecast: u64,
        /// The limit.
        limit: u64,
        /// Number of points.
        points: u64,
    },
    /// More points on one worker than its numbers can tell apart.
    #[error(
        "about {points} points would fall to one worker, more than the {most} that it can triangulate: use at \
         least {workers} workers"
    )]
    Piece {
        /// Points of the largest piece expected.
        points: u64,
        /// Allowed.
        most: u64,
        /// Workers that suffice.
        workers: u64,
    },
    /// A worker or the transport failed.
    #[error(transparent)]
    Machine(#[from] TransportError),
    /// Threads could not be started.
    #[error("workers could not be started: {0}")]
    Start(#[from] std::io::Error),
    /// The stars do not agree after every remedy: a fault of this program.
    #[error(
        "the certificate failed: {refutation}; this is a fault of septet: please report it with the input"
    )]
    NotCertified {
        /// What is wrong with the stars.
        refutation: Refutation,
        /// The run with its counts, without cells.
        run: Box<Run>,
    },
    /// More points than the rival's numbers can tell apart.
    #[error("the rival cannot take these points: {0}")]
    Rival(#[source] IncrementalError),
    /// The run was cancelled.
    #[error("interrupted")]
    Interrupted,
}

/// Sites that have no conflict graph.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SiteError {
    /// Not one size a site.
    #[error("{places} places and {sizes} sizes: every site needs one of each")]
    Lengths {
        /// Places given.
        places: usize,
        /// Sizes given.
        sizes: usize,
    },
    /// More sites fixed than there are.
    #[error("{fixed} sites are fixed, but there are only {sites}")]
    Fixed {
        /// Asked for.
        fixed: usize,
        /// Sites given.
        sites: usize,
    },
    /// A size that is no length.
    #[error("site {index}: the size {size} is not a positive number")]
    Size {
        /// Position of the site.
        index: usize,
        /// As given.
        size: f64,
    },
    /// Two sites at one place.
    #[error("sites {first} and {second} have the same coordinates: leave one of them out")]
    Coincident {
        /// Position of the first.
        first: usize,
        /// Position of the other.
        second: usize,
    },
}
