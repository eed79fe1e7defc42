//! The decision of the coordinator on a certificate.

/// The decision on a certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// All stars agree. The result is collected.
    #[default]
    Passed,
    /// The unresolved stars are gathered, then splaying continues.
    GatherUnresolved,
    /// All points are gathered, then splaying continues.
    GatherAll,
    /// The stars disagree after both gatherings. The run fails.
    Failed,
}

impl Outcome {
    /// Returns the number that represents the outcome in messages.
    pub fn number(self) -> u8 {
        self as u8
    }

    /// Returns the decision with this number, or `None`.
    pub fn from_number(n: u8) -> Option<Self> {
        [Outcome::Passed, Outcome::GatherUnresolved, Outcome::GatherAll, Outcome::Failed]
            .get(usize::from(n))
            .copied()
    }
}
