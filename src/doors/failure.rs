//! Failures in the words of a door.

use septet_core::cores::Stopped;
use septet_core::error::{PeriodicError, SiteError};
use septet_core::{Code, Door, Error, Remedy};
use septet_geometry::range::RangeError;
use septet_queries::QueryError;

/// The memory that a call would need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Forecast {
    /// The expected peak, or the bytes that were used when the call stopped.
    pub bytes: u64,
    /// The limit in bytes.
    pub limit: u64,
}

/// A failed call.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Failure {
    /// The kind, which is also the exit code of the program.
    pub code: Code,
    /// The reason, its place, and the remedy in the words of the door.
    pub message: String,
    /// The row of the point that is the reason.
    pub index: Option<u64>,
    /// The memory that a call above its limit would need.
    pub forecast: Option<Forecast>,
}

impl Failure {
    /// Creates a failure with a text.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Failure { code, message: message.into(), index: None, forecast: None }
    }

    /// Creates the failure of an argument or an option.
    pub fn usage(message: impl Into<String>) -> Self {
        Failure::new(Code::Usage, message)
    }

    /// Creates the failure of a cancelled call.
    pub fn interrupted() -> Self {
        Failure::new(Code::Interrupted, Error::Interrupted.to_string())
    }

    /// Creates the failure of a call that panicked, which no caller can cause.
    pub fn panicked(door: Door) -> Self {
        Failure::of(Code::Failed, "internal error".to_owned(), (Some(Remedy::REPORT), door))
    }

    /// Adds the row of the point that is the reason.
    #[must_use]
    pub fn at(mut self, index: u64) -> Self {
        self.index = Some(index);
        self
    }

    /// Creates a failure from an error of a run.
    pub fn of_run(error: &Error, door: Door) -> Self {
        let failure = Failure::of(error.code(), error.to_string(), (error.remedy(), door));
        let index = match error {
            Error::Points(range) => Some(row_of(range)),
            Error::Periodic(PeriodicError::Outside { index, .. } | PeriodicError::Far { index, .. })
            | Error::Sites(SiteError::Size { index, .. } | SiteError::Coincident { second: index, .. }) => {
                Some(*index as u64)
            }
            _ => None,
        };
        let forecast = match error {
            Error::Memory { forecast: bytes, limit, .. } | Error::Exceeded { used: bytes, limit } => {
                Some(Forecast { bytes: *bytes, limit: *limit })
            }
            _ => None,
        };
        Failure { index, forecast, ..failure }
    }

    /// Creates a failure from an error of a query.
    pub fn of_query(error: &QueryError, door: Door) -> Self {
        let failure = Failure::of(error.code(), error.to_string(), (None, door));
        Failure { index: error.row(), ..failure }
    }

    fn of(code: Code, mut message: String, (remedy, door): (Option<Remedy>, Door)) -> Self {
        if let Some(remedy) = remedy {
            message += "; ";
            message += &remedy.spelled(door);
        }
        Failure::new(code, message)
    }
}

impl From<Stopped> for Failure {
    fn from(_: Stopped) -> Self {
        Failure::interrupted()
    }
}

/// Returns the row of the point that is the reason.
fn row_of(range: &RangeError) -> u64 {
    match range {
        RangeError::NotFinite { index, .. } | RangeError::Spread { low: index, .. } => *index as u64,
    }
}
