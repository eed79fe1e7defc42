//! The supergraph: its selection, separator sets and edges, and the maximal independent set.

pub(crate) mod edges;
pub(crate) mod ghosts;
pub(crate) mod independent;
pub(crate) mod reverse;
pub mod selection;
pub(crate) mod separator_sets;
pub mod sharing;
pub mod summaries;
pub(crate) mod supergraph;
