//! The errors of a run.

use thiserror::Error;

use septet_geometry::incremental::IncrementalError;
use septet_geometry::range::RangeError;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::transport::TransportError;
use septet_workers::config::cores::Stopped;

pub use crate::periodic_error::PeriodicError;
use crate::remedy::Remedy;
use crate::result::outcome::Outcome;
pub use crate::result::refutation::Refutation;
use crate::spec::SpecError;

/// The error of [`crate::triangulate`], [`crate::simulate`] and [`crate::independent()`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// The configuration cannot run.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The points cannot be triangulated exactly.
    #[error(transparent)]
    Points(#[from] RangeError),
    /// The sites have no conflict graph.
    #[error(transparent)]
    Sites(#[from] SiteError),
    /// The periodic box cannot be used, or a point lies outside of it.
    #[error(transparent)]
    Periodic(#[from] PeriodicError),
    /// Points of different processes have the same input index.
    #[error("{rows} points have input indices between {first} and {last}, so some have the same index")]
    Indices {
        /// Number of points of all processes.
        rows: u64,
        /// The smallest input index.
        first: u64,
        /// The largest input index.
        last: u64,
    },
    /// The memory forecast exceeds the limit.
    #[error("about {forecast} bytes would be needed for {points} points, more than the limit of {limit}")]
    Memory {
        /// Expected peak in bytes.
        forecast: u64,
        /// The limit in bytes.
        limit: u64,
        /// Number of points.
        points: u64,
    },
    /// The run reached the limit of memory.
    #[error("the run needs {used} bytes of memory or more, but the limit is {limit}")]
    Exceeded {
        /// The bytes that the process used, or was about to use.
        used: u64,
        /// The limit in bytes.
        limit: u64,
    },
    /// One worker would have more points than its local indices can address.
    #[error("one worker would have to triangulate about {points} points, more than the limit of {most}")]
    Piece {
        /// Expected number of points of the largest subdomain.
        points: u64,
        /// The largest number of points of one worker.
        most: u64,
        /// Number of workers that suffices.
        workers: u64,
    },
    /// A worker or the transport failed.
    #[error(transparent)]
    Machine(TransportError),
    /// The threads of the workers could not be started.
    #[error("cannot start the workers: {0}")]
    Start(#[from] std::io::Error),
    /// The stars disagree after every repair. This is a bug in septet.
    #[error("the certificate failed: {refutation}")]
    NotCertified {
        /// The reasons why the stars do not form a triangulation.
        refutation: Refutation,
        /// The run with its counts, without cells.
        run: Box<Outcome>,
    },
    /// There are more points than the indices of the baseline can address.
    #[error("incremental insertion cannot take these points: {0}")]
    Baseline(#[source] IncrementalError),
    /// The run was cancelled.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        match self {
            Error::Spec(error) => error.remedy(),
            Error::Sites(error) => error.remedy(),
            Error::Periodic(error) => error.remedy(),
            Error::Points(RangeError::NotFinite { .. }) => {
                Some(Remedy::of("correct it, or drop such points with {skip-invalid}"))
            }
            Error::Points(RangeError::Spread { .. }) => {
                Some(Remedy::of("round the coordinates to a common grid, or drop these points"))
            }
            Error::Indices { .. } => {
                Some(Remedy::of("pass each process a first index beyond the indices of the others"))
            }
            Error::Memory { .. } | Error::Exceeded { .. } | Error::Machine(TransportError::Memory { .. }) => {
                Some(Remedy::of("raise {max-memory}, or reduce the number of points"))
            }
            Error::Piece { workers, .. } => Some(Remedy::of("use at least ").set("workers", workers)),
            Error::Machine(TransportError::WorkerFailed { .. } | TransportError::BadMessage { .. })
            | Error::Start(_) => {
                Some(Remedy::of("run it again; if it fails again, please report it with the input"))
            }
            Error::NotCertified { .. } => Some(Remedy::REPORT),
            Error::Machine(TransportError::Stopped) | Error::Baseline(_) | Error::Interrupted => None,
        }
    }
}

impl From<Stopped> for Error {
    fn from(_: Stopped) -> Self {
        Error::Interrupted
    }
}

impl From<TransportError> for Error {
    fn from(error: TransportError) -> Self {
        match error {
            TransportError::Memory { used, limit } => Error::Exceeded { used, limit },
            other => Error::Machine(other),
        }
    }
}

/// Returns the error for a result that is incomplete.
pub(crate) fn incomplete(reason: String) -> Error {
    TransportError::WorkerFailed { rank: COORDINATOR, reason }.into()
}

/// Sites that have no conflict graph.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SiteError {
    /// The numbers of places and sizes differ.
    #[error("{places} places and {sizes} sizes: every site needs one of each")]
    Lengths {
        /// Number of places.
        places: usize,
        /// Number of sizes.
        sizes: usize,
    },
    /// More sites are fixed than given.
    #[error("{fixed} sites are fixed, but there are only {sites}")]
    Fixed {
        /// Number of fixed sites.
        fixed: usize,
        /// Number of sites.
        sites: usize,
    },
    /// A size is not a positive finite number.
    #[error("site {index}: the size {size} is not a positive number")]
    Size {
        /// Position of the site.
        index: usize,
        /// The size.
        size: f64,
    },
    /// Two sites have the same coordinates.
    #[error("sites {first} and {second} have the same coordinates")]
    Coincident {
        /// Position of the first.
        first: usize,
        /// Position of the second.
        second: usize,
    },
}

impl SiteError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        match self {
            SiteError::Coincident { .. } => Some(Remedy::of("omit one of them")),
            SiteError::Lengths { .. } | SiteError::Fixed { .. } | SiteError::Size { .. } => None,
        }
    }

    /// Checks the numbers of places and fixed sites, and the sizes.
    pub(crate) fn check(places: usize, sizes: &[f64], fixed: usize) -> Result<(), SiteError> {
        if places != sizes.len() {
            return Err(SiteError::Lengths { places, sizes: sizes.len() });
        }
        if fixed > places {
            return Err(SiteError::Fixed { fixed, sites: places });
        }
        match sizes.iter().position(|&size| !(size > 0.0 && size < f64::INFINITY)) {
            Some(index) => Err(SiteError::Size { index, size: sizes[index] }),
            None => Ok(()),
        }
    }
}
