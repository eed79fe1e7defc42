//! The errors of a claim.

use septet_core::Remedy;
use thiserror::Error;

use crate::accounts::AccountError;
use crate::experiment::RunError;
use crate::experiment::fit::FitError;

/// A reason why a claim could not be checked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ClaimError {
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The runs do not determine a figure.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A domain of the experiment could not be meshed.
    #[error("a mesh of the experiment failed: {reason}")]
    Mesh {
        /// The reason.
        reason: String,
    },
    /// A cost trace cannot be folded.
    #[error(transparent)]
    Account(#[from] AccountError),
    /// A cost trace cannot be written.
    #[error("a cost trace cannot be written: {0}")]
    Trace(#[from] std::io::Error),
    /// There is no claim with this name.
    #[error("there is no claim `{name}`")]
    Unknown {
        /// The unknown name.
        name: String,
    },
}

impl ClaimError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        match self {
            ClaimError::Run(error) => error.remedy(),
            ClaimError::Fit(error) => error.remedy(),
            ClaimError::Account(error) => error.remedy(),
            ClaimError::Unknown { .. } => Some(Remedy::of("`septet reproduce` lists all claims with {list}")),
            ClaimError::Mesh { .. } | ClaimError::Trace(_) => None,
        }
    }

    /// Returns `true` if the caller interrupted the experiment.
    pub(super) fn is_interruption(&self) -> bool {
        matches!(self, ClaimError::Run(RunError::Run(septet_core::Error::Interrupted)))
    }
}

impl From<septet_core::Error> for ClaimError {
    fn from(error: septet_core::Error) -> Self {
        ClaimError::Run(error.into())
    }
}

impl From<septet_core::generate::GenerateError> for ClaimError {
    fn from(error: septet_core::generate::GenerateError) -> Self {
        ClaimError::Run(error.into())
    }
}
