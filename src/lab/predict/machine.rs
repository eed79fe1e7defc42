//! The state of a replay: the record, the placement, and the messages sent.

use septet_protocol::tasks::TaskLog;

use super::placement::Placement;
use super::sizes::Sizes;
use super::traffic::PhaseTraffic;

/// The state of a replay.
pub(super) struct Replay<'a> {
    pub(super) log: &'a TaskLog,
    pub(super) place: Placement,
    pub(super) sizes: Sizes,
    pub(super) traffic: PhaseTraffic,
}
