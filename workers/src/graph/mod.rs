//! The supergraph: its choice, its separator sets, its edges, and the maximal independent set over it.
//!
#![doc = include_str!("proof.md")]

pub(crate) mod edges;
pub(crate) mod ghosts;
pub(crate) mod independent;
pub(crate) mod reverse;
pub mod selection;
pub(crate) mod separator_sets;
pub mod sharing;
pub mod summaries;
pub(crate) mod supergraph;
