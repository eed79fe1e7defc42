//! A claim: its statement, its reading, its role, its experiment and the function that checks it.

use serde::Serialize;

use super::error::ClaimError;
use super::figure::Figure;
use super::lab::Lab;

/// The form of the paper's statement that is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Reading {
    /// The statement as printed.
    AsPrinted,
    /// The form that the algorithm needs.
    AsRead {
        /// The reading that is checked instead.
        instead: &'static str,
        /// The reason why the printed statement is not checked.
        because: &'static str,
    },
}

/// The role of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// A fault of the machine or of its counts can make the claim fail.
    Test,
    /// The claim is a theorem about points, or an identity of the machine. Its figures show the sizes of constants. No
    /// fault of the machine can make them exceed their bounds, so the claim does not count as passed.
    Illustration,
}

/// The error probabilities of a statistical claim. Such a claim compares an end of a one-sided 95 % interval with a
/// bound.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Statistics {
    /// Probability that any statistical claim of a report passes although its bound is exceeded. Holm's method
    /// adjusts the p-values of the claims of the report to this level.
    pub level: f64,
    /// The fault against which the power is counted.
    pub fault: &'static str,
    /// Number of seeds, of [`Statistics::of`], at which the claim detects this fault.
    pub caught: u32,
    /// Number of seeds at which the fault was planted.
    pub of: u32,
    /// The smallest fault of this form that was planted and that the claim detects.
    pub smallest: &'static str,
}

/// The significance level of all statistical claims of a report together ([`Statistics::level`]).
pub(super) const LEVEL: f64 = 0.05;

/// One claim.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// The name on the command line.
    pub name: &'static str,
    /// The role: test or illustration.
    pub role: Role,
    /// The error probabilities of a statistical claim. `None` if the figures have no statistical error.
    pub statistics: Option<Statistics>,
    /// The section or theorem of the paper.
    pub source: &'static str,
    /// The statement.
    pub statement: &'static str,
    /// The form of the statement that is checked.
    pub reading: Reading,
    /// The runs and measurements.
    pub experiment: &'static str,
    /// The bound and its reason.
    pub bound: &'static str,
    pub(super) check: fn(&mut Lab) -> Result<Vec<Figure>, ClaimError>,
}

impl Claim {
    /// Returns two lines. The first has the source, the statement and its reading. The second has the experiment, the
    /// bound, and the role and the error probabilities if there are any to state.
    pub fn explained(&self) -> [String; 2] {
        let read = match self.reading {
            Reading::AsPrinted => String::new(),
            Reading::AsRead { instead, because } => format!(" As read: {instead}, because {because}."),
        };
        let role = if self.role == Role::Illustration { " An illustration." } else { "" };
        let power = self.statistics.map_or_else(String::new, |s| s.explained());
        [
            format!("{}: {}.{read}", self.source, self.statement),
            format!("{}. Bound: {}.{role}{power}", self.experiment, self.bound),
        ]
    }
}

impl Statistics {
    fn explained(&self) -> String {
        let Statistics { level, fault, caught, of, smallest } = self;
        format!(
            " Level {level} over all claims (Holm); detects {fault} at {caught} of {of} seeds; smallest fault: {smallest}."
        )
    }
}
