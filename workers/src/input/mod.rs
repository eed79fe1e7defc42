//! The input of a run: each rank reads its block of the rows, and all ranks prepare them together.

pub mod load;

mod loaded;

mod repeats;

mod rows;

mod source;

pub use crate::state::blocks::block_of;
pub use loaded::Loaded;
pub use rows::squared_radius;
pub use source::{Rows, Source};

#[cfg(test)]
mod tests;
