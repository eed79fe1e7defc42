//! Why a run has no result.

use thiserror::Error;

use septet_geometry::incremental::IncrementalError;
use septet_geometry::range::RangeError;
use septet_protocol::transport::TransportError;

use crate::config::ConfigError;
use crate::run::Run;
use crate::run::independent::SiteError;

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

/// Why stars are no triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{disagreements} disagreements, {minima} minima, {stars} of {points} stars")]
pub struct Refutation {
    /// Cells missing from stars.
    pub disagreements: u64,
    /// Vertices without a smaller neighbour (1 is right).
    pub minima: u64,
    /// Stars that hold a cell.
    pub stars: u64,
    /// Number of points.
    pub points: u64,
}
