//! The result of a run: pieces of the triangulation, cells in canonical order, a picture.

pub mod canonical;
pub mod cost_trace;
pub mod part;
pub mod pieces;
pub(crate) mod point_owner;
pub mod refutation;
pub mod run;
pub mod subdomain;
pub mod view;
