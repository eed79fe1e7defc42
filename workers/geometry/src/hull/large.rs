//! The rule by which stars with many candidates leave the order of distance.
//!
//! **Statement.** Candidates are added by distance as long as the link remains small, because most stars are then soon
//! complete. If the link is large, or if many candidates have been added, the remaining candidates are added at random
//! ([`super::random_order`]), provided that they are many.
//!
//! **Work and depth.** The first candidates take O(1) sweeps over O(1) facets.

/// How stars with many candidates are built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LargeStars {
    /// By random insertion with conflict lists.
    #[default]
    AtRandom,
    /// By distance, as small stars: a planted fault.
    ByDistance,
}

/// Number of candidates in a batch. After each batch, the construction ends if the remaining candidates are out of
/// reach.
pub(super) const BATCH: usize = 24;

/// Number of candidates above which a set of candidates is large.
pub(super) const LARGE: usize = 64;

/// Number of new candidates of a kept star above which they are added at random. The depth of conflict lists is less from about a
/// dozen candidates on, and their work is the same.
pub(super) const MANY: usize = 12;

/// Number of candidates that are added by distance, at most, if the remaining set is large.
pub(super) const MOST_BY_DISTANCE: usize = 128;

/// Number of vertices of a link above which candidates of a large set are no longer added by distance.
pub(super) const LARGE_LINK: usize = 20;
