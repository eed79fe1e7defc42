//! The contents of a result, progress and cancellation, and the faults that tests plant.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use septet_workers::config::Fault;

/// The optional contents of a result, besides cells and counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Keep {
    /// Whether the edges of the supergraph are kept, or the radii of the balls if the run ends with them. [`crate::simulate`]
    /// and [`crate::count`] only.
    pub graph: bool,
    /// Whether the separator sets of the leaves are kept. [`crate::simulate`] with a rule that forms them only.
    pub sets: bool,
    /// Whether [`crate::simulate`] finds the neighbours of cells, as [`crate::triangulate`] always does. This takes two more
    /// rounds of messages.
    pub neighbours: bool,
    /// Whether the worker and the leaf of each cell are kept.
    pub owner: bool,
    /// Whether the calls of primitives are kept, for a cost trace ([`crate::run::CostTrace`]). Only runs that count, with
    /// all ranks in the caller's process.
    pub costs: bool,
    /// Whether [`crate::triangulate`] charges its phases, for a comparison with other algorithms. It then triangulates each
    /// subdomain a second time, to count.
    pub prices: bool,
    /// Whether [`crate::triangulate`] charges its phases by the operations of its workers, one after the other. This takes no
    /// time. It has no effect with [`Keep::prices`].
    pub operations: bool,
    /// Expected number of points in the picture of the result ([`crate::result::outcome::Kept::picture`]), at most
    /// [`MOST_POINTS`]. By default, there is no picture.
    pub view: Option<u32>,
    /// The nodes of the partition tree that reports list.
    pub nodes: Nodes,
}

/// Largest number of points shown.
pub const MOST_POINTS: u32 = 20_000;

/// The nodes of the partition tree that a report lists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Nodes {
    /// All nodes.
    #[default]
    All,
    /// No node.
    None,
}
words!(Nodes {
    All "all" "Every node",
    None "none" "No node; with several processes, no process then receives the nodes of the others",
});

/// The progress of a run.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// The phase.
    pub phase: &'static str,
    /// Position of the phase among all phases, and the number of phases.
    pub position: (usize, usize),
    /// Rounds so far.
    pub round: u32,
}

/// A callback for progress. It is called on the caller's thread.
pub type ProgressFn = Arc<dyn Fn(Progress) + Send + Sync>;

/// Progress and cancellation of a call.
#[derive(Clone, Default)]
#[non_exhaustive]
pub struct Control {
    /// A flag that ends the call with [`crate::Error::Interrupted`] when it becomes `true`.
    pub cancel: Option<Arc<AtomicBool>>,
    /// The callback for phases and rounds.
    pub progress: Option<ProgressFn>,
}

impl Control {
    /// Returns `true` if the caller cancelled the call.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control").field("cancel", &self.cancel).finish_non_exhaustive()
    }
}

/// Faults and limits that tests plant in a machine.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct Planted {
    /// A fault, for tests of errors that fault-free runs do not reach.
    pub fault: Option<Fault>,
    /// Rounds of splaying before unresolved regions are gathered; `6 log2 n` if none.
    pub exchange_cap: Option<u32>,
}
