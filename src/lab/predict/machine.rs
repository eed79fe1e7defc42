//! The state of a replay: the record, the placement, and the messages sent.

use septet_protocol::tasks::TaskLog;

use super::placement::Placement;
use super::sizes::MessageSizes;
use super::traffic::PhaseTraffic;

/// The state of a replay.
pub(super) struct Replay<'a> {
    pub(super) log: &'a TaskLog,
    pub(super) place: Placement,
    pub(super) sizes: MessageSizes,
    pub(super) traffic: PhaseTraffic,
}
