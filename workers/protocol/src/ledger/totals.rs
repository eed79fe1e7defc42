//! The totals of a folded ledger.

use serde::{Deserialize, Serialize};

use super::brent::BrentCurve;
use crate::ids::{ByGroup, NodeId, Phase, names};

/// Totals of one phase. `C` is the type of counts of work and depth, which are optional in reports of runs that may not
/// count them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PhaseTotal<C = u64> {
    /// The phase: its name and its group.
    #[serde(flatten, with = "identity")]
    #[cfg_attr(feature = "schema", schemars(with = "identity::Identity"))]
    pub phase: Phase,
    /// Number of rounds with messages.
    pub rounds: u64,
    /// Number of operations. `None` if not counted.
    pub work: C,
    /// Number of tests of predicates that needed exact arithmetic. The work contains them. `None` if not counted.
    pub exact_tests: C,
    /// Longest chain within the phase, with each scan counted as 1.
    pub depth: C,
    /// Longest chain within the phase, with a scan of m items counted as `ceil(log2 m)`.
    pub depth_log_scan: C,
    /// Steps of the phase on the critical path of the run.
    pub critical_depth: C,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
}

impl PhaseTotal {
    /// Returns the totals of a phase without counts.
    pub fn empty(phase: Phase) -> Self {
        PhaseTotal {
            phase,
            rounds: 0,
            work: 0,
            exact_tests: 0,
            depth: 0,
            depth_log_scan: 0,
            critical_depth: 0,
            messages: 0,
            bytes: 0,
        }
    }

    /// Returns the totals for a report: without work and depth, unless the run `counted` them.
    pub fn known(self, counted: bool) -> PhaseTotal<Option<u64>> {
        let known = |count: u64| counted.then_some(count);
        PhaseTotal {
            phase: self.phase,
            rounds: self.rounds,
            work: known(self.work),
            exact_tests: known(self.exact_tests),
            depth: known(self.depth),
            depth_log_scan: known(self.depth_log_scan),
            critical_depth: known(self.critical_depth),
            messages: self.messages,
            bytes: self.bytes,
        }
    }
}

/// The facts of a phase in a report. Only its name is read back, because the table of phases has the others.
mod identity {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use crate::ids::{Group, Phase, names};

    /// The facts.
    #[derive(Serialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    pub(super) struct Identity {
        /// The name.
        name: &'static str,
        /// Whether the phase belongs to the paper.
        paper: bool,
        /// Whether the phase belongs to agreement or repair.
        repair: bool,
        /// The group of the phase.
        group: Group,
    }

    #[derive(Deserialize)]
    struct Named {
        #[serde(with = "names")]
        name: Phase,
    }

    #[allow(clippy::trivially_copy_pass_by_ref)] // The signature that serde calls.
    pub(super) fn serialize<S: Serializer>(phase: &Phase, serializer: S) -> Result<S::Ok, S::Error> {
        let (name, group) = (phase.name(), phase.group());
        let (paper, repair) = (group == Group::Paper, group == Group::Repair);
        Identity { name, paper, repair, group }.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Phase, D::Error> {
        Named::deserialize(deserializer).map(|named| named.name)
    }
}

/// Work, depth and Brent's bound over a group of phases. `C` is the type of counts, which are optional in reports of runs
/// that may not count them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Total<C = u64> {
    /// Number of operations. `None` if not counted.
    pub work: C,
    /// Number of tests of predicates that needed exact arithmetic. The work contains them. `None` if not counted.
    pub exact_tests: C,
    /// Longest chain of vector steps, with each scan counted as 1.
    pub depth: C,
    /// Longest chain, with a scan of m items counted as `ceil(log2 m)`.
    pub depth_log_scan: C,
    /// Brent's bound on the steps with as many processors as points. A step is a phase at a level of the tree. The bound
    /// is the sum of `ceil((work - depth) / n) + depth` over all steps.
    pub brent: C,
    /// Brent's bound for each power of two of processors up to the number of points. Empty if not counted.
    #[serde(default)]
    pub brent_at: BrentCurve,
}

impl Total {
    /// Returns the total of two groups, one after the other.
    #[must_use]
    pub fn then(self, next: Total) -> Total {
        Total {
            work: self.work + next.work,
            exact_tests: self.exact_tests + next.exact_tests,
            depth: self.depth + next.depth,
            depth_log_scan: self.depth_log_scan + next.depth_log_scan,
            brent: self.brent + next.brent,
            brent_at: self.brent_at.then(next.brent_at),
        }
    }

    /// Returns the total for a report: without counts, unless the run `counted` them.
    pub fn known(self, counted: bool) -> Total<Option<u64>> {
        let known = |count: u64| counted.then_some(count);
        Total {
            work: known(self.work),
            exact_tests: known(self.exact_tests),
            depth: known(self.depth),
            depth_log_scan: known(self.depth_log_scan),
            brent: known(self.brent),
            brent_at: if counted { self.brent_at } else { BrentCurve::default() },
        }
    }
}

/// The totals of the groups whose phases count work.
pub type Totals = ByGroup<Total>;

impl Totals {
    /// Returns the total of all groups.
    pub fn sum(&self) -> Total {
        self.each().into_iter().fold(Total::default(), |sum, (_, total)| sum.then(*total))
    }
}

/// One step of the critical path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PathStep {
    /// Id of the node: the root is 1, and the children of s are 2s (inside) and 2s + 1 (outside).
    #[serde(rename = "subproblem")]
    #[cfg_attr(feature = "schema", schemars(with = "u64"))]
    pub node: NodeId,
    /// The phase.
    #[serde(with = "names")]
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub phase: Phase,
    /// Steps of the phase at this node.
    pub depth: u64,
}
