//! The stars of a rank's owned points: local hulls, their fingerprints, and the check that they agree.
//!
#![doc = include_str!("proof.md")]

pub(crate) mod check;
pub(crate) mod disagreements;
pub(crate) mod fingerprint_sums;
pub(crate) mod fingerprints;
pub(crate) mod hulls;
pub(crate) mod links;
pub(crate) mod look_up;
pub(crate) mod owned;
pub(crate) mod vertex_hashes;
