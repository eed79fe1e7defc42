//! The machine as a replay sees it: the record, who holds what, and what was sent.

use septet_protocol::tasks::TaskLog;

use super::placement::Placement;
use super::sizes::Sizes;
use super::traffic::Traffic;

/// What a replay reads and writes.
pub(super) struct Replay<'a> {
    pub(super) log: &'a TaskLog,
    pub(super) place: Placement,
    pub(super) sizes: Sizes,
    pub(super) traffic: Traffic,
}
