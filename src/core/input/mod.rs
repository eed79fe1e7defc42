//! The input of a run: points before the machine receives them.

pub mod coincide;
pub mod prepare;
