//! What a run computes.

use septet_protocol::ids::Phase;
use serde::{Deserialize, Serialize};

/// The task of a run. Each call of the library chooses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Task {
    /// A triangulation by the direct path.
    Triangulate,
    /// A triangulation by the paper's recursion, with work and depth.
    Simulate,
    /// The counts of the recursion up to a phase.
    Count(Until),
    /// A maximal independent set. The first `fixed` sites are members from the start.
    Independent {
        /// Number of these sites.
        fixed: u64,
    },
}

impl Task {
    /// Returns `true` if the run splits down to the leaf size and counts work and depth.
    pub fn is_counted(self) -> bool {
        self != Task::Triangulate
    }

    /// Returns the phase after which the run stops, if it stops before its end.
    pub fn until(self) -> Option<Until> {
        match self {
            Task::Count(until) => Some(until),
            Task::Triangulate | Task::Simulate | Task::Independent { .. } => None,
        }
    }

    /// Returns `true` if the run selects sites.
    pub fn is_independent(self) -> bool {
        matches!(self, Task::Independent { .. })
    }
}

/// A phase after which a run may stop, for its counts, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Until {
    /// The partition tree.
    Partition,
    /// The nearest-neighbour balls.
    Neighbours,
    /// The supergraph.
    Graph,
}

words!(Until {
    Partition "partition" "The partition tree",
    Neighbours "neighbours" "The nearest-neighbour balls",
    Graph "graph" "The supergraph",
});

impl Until {
    /// Returns the last phase.
    pub(crate) fn phase(self) -> Phase {
        match self {
            Until::Partition => Phase::Partition,
            Until::Neighbours => Phase::Neighbours,
            Until::Graph => Phase::Graph,
        }
    }
}
