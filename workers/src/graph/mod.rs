//! The supergraph: its selection, separator sets and edges, and the maximal independent set.
//!
#![doc = include_str!("proof.md")]

pub(crate) mod edges;
pub(crate) mod ghosts;
pub(crate) mod independent;
mod own_draw;
pub(crate) mod own_spheres;
mod own_steps;
pub(crate) mod reverse;
pub mod selection;
pub(crate) mod separator_sets;
mod set_members;
pub mod sharing;
pub mod summaries;
pub(crate) mod supergraph;
