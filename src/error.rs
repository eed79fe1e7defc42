//! Why a run has no result.

use thiserror::Error;

use septet_geometry::range::RangeError;
use septet_protocol::transport::TransportError;

use crate::config::ConfigError;

/// The error of [`crate::triangulate`] and [`crate::simulate`].
#[derive(Debug, Error)]
pub enum Error {
    /// Parameters that cannot be run.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Points that cannot be triangulated exactly.
    #[error(transparent)]
    Points(#[from] RangeError),
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
        "the certificate failed: {disagreements} disagreements, {minima} minima, {stars} of {points} stars; this \
         is a fault of septet: please report it with the input"
    )]
    NotCertified {
        /// Cells missing from stars.
        disagreements: u64,
        /// Vertices without a smaller neighbour (1 is right).
        minima: u64,
        /// Stars that hold a cell.
        stars: u64,
        /// Number of points.
        points: u64,
    },
    /// The run was cancelled.
    #[error("interrupted")]
    Interrupted,
}
