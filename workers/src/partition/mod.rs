//! The partition tree: nodes that several ranks share, and the subtree that one worker grows alone.

pub mod leader;
pub(crate) mod local;
pub mod shared;

pub use crate::state::subdomain::Group;
pub use shared::*;
