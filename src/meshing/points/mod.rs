//! The first points of a stage: candidates, conflicts, and a maximal independent set.
//!
//! **Statement.** The cells of a tree over the size function f have a constant number of candidates each. Two sites
//! conflict iff they are closer than the smaller of their sizes. A maximal independent set is taken of the candidates
//! that do not conflict with an earlier point. Together with the earlier points, it is spaced by f, and every candidate
//! conflicts with a member.
//!
//! All steps are pure functions of their arguments. Random values are hashes of the identity of a candidate. They do
//! not depend on the rank that computes them or on the order of the candidates.
//!
//! **Source.** Section 5 of the paper (Definition 5.2 and the algorithm after Theorem 5.3; its "larger" for the edges
//! of the graph is read as "smaller"); Luby (1986) for the rounds. **Departures.** Segments, facets, the Gabriel rule
//! and the completion by circumcentres are in [`crate::generate`].

pub mod candidates;
pub mod conflicts;
pub mod independent;

#[cfg(test)]
mod tests;
