//! The paper's claims as experiments: each runs, measures apart from the algorithm, and is held against a bound
//! that was stated before.
//!
//! **What a claim is.** A sentence of the paper with its place, an experiment, and figures with their bounds. A
//! figure comes from runs: from their ledger, or measured on their points, cells and separators by code that shares
//! nothing with the algorithm ([`measure`]: all pairs, Cramer's rule, plain distances). A bound has a reason: a proof,
//! or a measurement at other sizes with the slack that is named.
//!
//! **Readings.** Where a sentence does not hold as it is printed, the claim says so, reports the figure of the printed
//! form beside it, and is judged by the reading that the algorithm needs ([`Reading::AsRead`]).
//!
//! **Repetition.** Everything is a function of (claims, [`Extent`], seed): no clock decides anything.

mod generation;
mod hulls;
mod lab;
mod machine;
mod measure;
mod random;
mod ratio;
mod recursion;
mod report;
mod separators;
mod tree;

use serde::Serialize;
use thiserror::Error;

pub use lab::{Lab, Setting};
pub use report::{ClaimReport, Judged, SCHEMA};

use crate::experiment::RunError;
use crate::experiment::fit::FitError;

/// How much is run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// A third of the quick sizes and fewer sets, for tests of claims themselves: not offered on the command line.
    Brief,
    /// Under three minutes on two cores.
    #[default]
    Quick,
    /// To 2^24 points where the phase allows; hours.
    Full,
}

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
    judge: fn(&mut Lab) -> Result<Vec<Figure>, ClaimError>,
}

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

/// How a figure stands to its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// Not above.
    AtMost,
    /// Not below.
    AtLeast,
}

/// A measured number and its bound.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What was measured.
    pub what: String,
    /// On which points.
    pub on: String,
    /// The first seed of the sets and of the runs.
    pub seed: u64,
    /// The number.
    pub value: f64,
    /// How it has to stand to the bound.
    pub relation: Relation,
    /// The bound.
    pub bound: f64,
    /// Of the sentence as printed, where the claim is judged by another reading: reported, not judged.
    pub as_printed: bool,
}

impl Figure {
    fn at_most(what: impl Into<String>, on: impl Into<String>, seed: u64, value: f64, bound: f64) -> Figure {
        let (what, on) = (what.into(), on.into());
        Figure { what, on, seed, value, relation: Relation::AtMost, bound, as_printed: false }
    }

    fn at_least(what: impl Into<String>, on: impl Into<String>, seed: u64, value: f64, bound: f64) -> Figure {
        Figure { relation: Relation::AtLeast, ..Figure::at_most(what, on, seed, value, bound) }
    }

    /// Of the sentence as printed.
    fn printed(self) -> Figure {
        Figure { as_printed: true, ..self }
    }

    /// Does it keep its bound? What is no number keeps none.
    pub fn holds(&self) -> bool {
        match self.relation {
            Relation::AtMost => self.value <= self.bound,
            Relation::AtLeast => self.value >= self.bound,
        }
    }

    /// How near it is to its bound: 1 at the bound, above 1 beyond it.
    fn strain(&self) -> f64 {
        let (above, below) = match self.relation {
            Relation::AtMost => (self.value, self.bound),
            Relation::AtLeast => (self.bound, self.value),
        };
        match (self.holds(), below == 0.0) {
            // Nothing where nothing is allowed says more than what is far from its bound, and less than what is near.
            (true, true) => 0.5,
            (false, true) => f64::INFINITY,
            _ => above / below,
        }
    }
}

/// All claims, in the paper's order.
pub fn registry() -> impl Iterator<Item = &'static Claim> {
    let groups: [&'static [Claim]; 8] = [
        separators::CLAIMS,
        ratio::CLAIMS,
        hulls::CLAIMS,
        recursion::CLAIMS,
        tree::CLAIMS,
        random::CLAIMS,
        machine::CLAIMS,
        generation::CLAIMS,
    ];
    groups.into_iter().flatten()
}

/// The claims of these names, in the paper's order; all for none.
///
/// # Errors
/// A name that no claim has.
pub fn select(names: &[String]) -> Result<Vec<&'static Claim>, ClaimError> {
    if let Some(name) = names.iter().find(|name| registry().all(|claim| claim.name != **name)) {
        return Err(ClaimError::Unknown { name: name.clone() });
    }
    Ok(registry().filter(|claim| names.is_empty() || names.iter().any(|n| n == claim.name)).collect())
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
