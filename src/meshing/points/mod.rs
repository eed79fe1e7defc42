//! The first points of a stage: candidates, conflicts, and a maximal independent set.
//!
//! **Statement.** Each cell of a tree over the size function f has a constant number of candidates. Two sites conflict
//! iff they are closer than the smaller of their sizes. From the candidates that do not conflict with an earlier point,
//! a maximal independent set is chosen. Together with the earlier points, it is f-spaced, and every candidate is a
//! member or conflicts with a member or an earlier point.
//!
//! All steps are pure functions of their arguments. Random values are hashes of the identity of a candidate. They do
//! not depend on the rank that computes them or on the order of the candidates.
//!
//! **Source.** Section 5 of the paper (Definition 5.2 and the algorithm after Theorem 5.3, with "smaller" instead of
//! "larger" in the definition of the edges); Luby (1986) for the rounds. **Departures.** [`crate::generate`] adds
//! segments, facets, the Gabriel rule and the completion by circumcentres.

pub mod candidates;
pub mod conflicts;
pub mod independent;

#[cfg(test)]
mod tests;
