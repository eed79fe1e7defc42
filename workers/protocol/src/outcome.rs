//! The verdict of rank 0 on a certificate.

/// What follows a certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// All stars agree: collect.
    #[default]
    Passed,
    /// Gather the unresolved stars and exchange again.
    GatherUnresolved,
    /// Gather everything.
    GatherAll,
    /// The stars do not agree and nothing is left to try.
    Failed,
}

impl Outcome {
    /// As a number, for the wire.
    pub fn number(self) -> u8 {
        self as u8
    }

    /// From the wire.
    pub fn from_number(n: u8) -> Option<Self> {
        [Outcome::Passed, Outcome::GatherUnresolved, Outcome::GatherAll, Outcome::Failed]
            .get(usize::from(n))
            .copied()
    }
}
