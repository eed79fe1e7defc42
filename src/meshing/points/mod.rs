//! The start of point generation: candidates, conflicts, and a maximal independent set.
//!
//! **Statement.** Cells of a tree over the size function f hold a constant number of candidates each. Two sites
//! conflict iff they are closer than the smaller of their sizes. Of the candidates that conflict with no earlier
//! point a maximal independent set is taken: with the earlier points it is spaced by f, and every candidate
//! conflicts with a member.
//!
//! All steps are pure functions of their arguments; what is random is a hash of a candidate's identity, so it
//! depends neither on who works on it nor on the order of the candidates.
//!
//! **Source.** Section 5 of the paper (Definition 5.2 and the algorithm after Theorem 5.3; its "larger" for the
//! edges of the graph is read as "smaller"); Luby (1986) for the rounds. **Departures.** Segments, facets and the
//! Gabriel rule, and the completion by circumcentres, are not here yet.

pub mod candidates;
pub mod conflicts;
pub mod independent;

#[cfg(test)]
mod tests;
