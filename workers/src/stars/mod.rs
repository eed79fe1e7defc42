//! The stars of a rank's points: local hulls, their fingerprints, and the check that they agree.

pub(crate) mod check;
pub(crate) mod hulls;
pub(crate) mod links;
pub(crate) mod lookup;
pub(crate) mod rows;
pub(crate) mod sums;
