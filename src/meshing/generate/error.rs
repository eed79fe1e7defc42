//! What can go wrong when a mesh is generated.

use crate::domain::Feature;

/// The features of which parts are missing from the triangulation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The features, ascending, with the numbers of missing parts.
    pub features: Vec<(Feature, u32)>,
    /// Why they are missing.
    pub reason: Reason,
}

/// The reason why parts of features are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Features meet at small angles.
    Angles,
    /// Points would be as close to each other as the rounding of coordinates.
    Rounding,
    /// The rounds of recovery did not suffice.
    Rounds,
}

/// Errors of generation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GenerationError<E> {
    /// The machine failed.
    Machine(E),
    /// Features could not be recovered.
    Missing(Missing),
    /// The mesh needs more vertices than the limit.
    TooMany(u64),
    /// The domain is not supported.
    Unsupported(&'static str),
}
