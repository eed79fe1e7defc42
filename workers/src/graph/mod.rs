//! The supergraph: its choice, its separator sets, its edges, and the maximal independent set over it.

pub mod choice;
pub(crate) mod edges;
pub(crate) mod ghosts;
pub(crate) mod independent;
pub(crate) mod sets;
pub mod summaries;
