//! A claim: its sentence, its reading, its experiment and its judge.

use serde::Serialize;

use super::error::ClaimError;
use super::figure::Figure;
use super::lab::Lab;
use super::report::Judged;

/// What of the paper's sentence is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Reading {
    /// The sentence as it stands.
    AsPrinted,
    /// What the algorithm needs in its place.
    AsRead {
        /// The reading.
        instead: &'static str,
        /// Why not the sentence.
        because: &'static str,
    },
}

/// One claim.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its place in the paper.
    pub source: &'static str,
    /// What it says.
    pub statement: &'static str,
    /// Which form is judged.
    pub reading: Reading,
    /// What is run and measured.
    pub experiment: &'static str,
    /// The bound and its reason.
    pub bound: &'static str,
    pub(super) judge: fn(&mut Lab) -> Result<Vec<Figure>, ClaimError>,
}

impl Claim {
    /// Runs the experiment.
    ///
    /// # Errors
    /// See [`ClaimError`].
    pub fn judge(&self, lab: &mut Lab) -> Result<Judged, ClaimError> {
        let figures = (self.judge)(lab)?;
        Ok(Judged::of(self, figures))
    }

    /// The claim in two lines: what it says, and how it is judged.
    pub fn explained(&self) -> [String; 2] {
        let read = match self.reading {
            Reading::AsPrinted => String::new(),
            Reading::AsRead { instead, because } => format!(" As read: {instead}, for {because}."),
        };
        [
            format!("{}: {}.{read}", self.source, self.statement),
            format!("{}. Bound: {}.", self.experiment, self.bound),
        ]
    }
}
