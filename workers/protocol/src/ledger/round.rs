//! The counts of a round.

use serde::{Deserialize, Serialize};

use super::counts::counts;
use crate::ids::{Phase, names};

/// A round of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RoundKey {
    /// Number of the round.
    pub round: u32,
    /// The phase of the round.
    #[serde(with = "names")]
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub phase: Phase,
}

counts! {
    /// The counts of one round of a phase.
    RoundTally:
    /// Number of subproblems whose leader acted.
    active "active" Sum;
    /// Number of results merged from two children.
    merged "merged" Sum;
    /// Number of separators drawn.
    separators "separators" Sum;
    /// Number of separators drawn after a rejected one.
    retries "retries" Sum;
    /// Number of points sent.
    points "points" Sum;
    /// Number of messages.
    messages "messages" Sum;
    /// Bytes of all messages.
    bytes "bytes" Sum;
    /// Bytes of the longest message.
    largest "largest" Max;
    /// Largest number of points of a worker once the points of the round have arrived; 0 except after moves of points to
    /// their owners.
    largest_load "largest-load" Max;
    /// Number of cells that asked the leaf of their circumcentre for a point.
    probes "probes" Sum;
    /// Number of visits of these cells to leaves.
    probe_visits "probe-visits" Sum;
}

/// One round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RoundRow {
    /// The round and its phase.
    #[serde(flatten)]
    pub key: RoundKey,
    /// The counts.
    #[serde(flatten)]
    pub tally: RoundTally,
}
