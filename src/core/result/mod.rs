//! The result of a run: facts, the shares of the workers, cells in canonical order, a picture.

pub mod canonical;
pub mod cost_trace;
pub mod outcome;
pub mod own_counts;
pub mod periodic;
pub mod refutation;
pub mod share;
pub mod stats;
pub mod unfolded;
pub mod view;
