//! Why a claim has no verdict.

use thiserror::Error;

use crate::experiment::RunError;
use crate::experiment::fit::FitError;

/// Why a claim has no verdict.
#[derive(Debug, Error)]
pub enum ClaimError {
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A question that the runs do not answer.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A domain of the experiment's own could not be meshed.
    #[error("a mesh of the experiment failed: {reason}")]
    Mesh {
        /// Why.
        reason: String,
    },
    /// No claim of this name.
    #[error("there is no claim `{name}`; `septet reproduce --list` names them")]
    Unknown {
        /// As given.
        name: String,
    },
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
