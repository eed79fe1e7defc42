//! The partition tree: nodes that several ranks share, and the subtree that one rank grows alone.

pub mod leader;
mod levelling;
pub(crate) mod local;
pub(crate) mod parts;
pub(crate) mod shared;
mod sides;
