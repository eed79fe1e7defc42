//! Points before the machine sees them.

pub mod coincide;
pub mod prepare;
