//! A claim: its statement, its reading, its experiment and the function that checks it.

use serde::Serialize;

use super::error::ClaimError;
use super::figure::Figure;
use super::lab::Lab;
use super::report::CheckedClaim;

/// The form of the paper's statement that is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Reading {
    /// The statement as printed.
    AsPrinted,
    /// The form that the algorithm needs.
    AsRead {
        /// The reading.
        instead: &'static str,
        /// The reason why the printed statement is not checked.
        because: &'static str,
    },
}

/// One claim.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// The name on the command line.
    pub name: &'static str,
    /// The section or theorem of the paper.
    pub source: &'static str,
    /// The statement.
    pub statement: &'static str,
    /// The form that is checked.
    pub reading: Reading,
    /// The runs and measurements.
    pub experiment: &'static str,
    /// The bound and its reason.
    pub bound: &'static str,
    pub(super) check: fn(&mut Lab) -> Result<Vec<Figure>, ClaimError>,
}

impl Claim {
    /// Runs the experiment.
    ///
    /// # Errors
    /// See [`ClaimError`].
    pub fn check(&self, lab: &mut Lab) -> Result<CheckedClaim, ClaimError> {
        let figures = (self.check)(lab)?;
        Ok(CheckedClaim::of(self, figures))
    }

    /// Returns two lines: the statement, and how it is checked.
    pub fn explained(&self) -> [String; 2] {
        let read = match self.reading {
            Reading::AsPrinted => String::new(),
            Reading::AsRead { instead, because } => format!(" As read: {instead}, because {because}."),
        };
        [
            format!("{}: {}.{read}", self.source, self.statement),
            format!("{}. Bound: {}.", self.experiment, self.bound),
        ]
    }
}
