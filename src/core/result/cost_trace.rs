//! The cost trace of a run: the calls of primitives on all ranks, without prices, and their dependencies.
//!
//! **Statement.** Each row is one call, one vector step whose items have their own calls, or a barrier. A row starts when
//! all rows that it names have ended. The longest path through the rows is the depth of the run, and the sum of their
//! prices is its work.
//!
//! **Dependencies.** The calls of one charge follow each other. The charges for a subproblem follow each other in the
//! order of rounds. Ranks that charge in the same round work at the same time, and the leader follows the members.
//! `order` connects the subproblems of a phase with each other and with earlier phases.
//!
//! **Groups.** The phases of the paper, the phases of repair, and the other phases have separate orders. The first rows of
//! a phase also follow all earlier rows of the other groups. The depth of a group is the
//! longest path through its own rows, so it does not count these rows.

mod order;
mod rows;

use septet_geometry::cost::Step;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_workers::config::ChargesByRank;

use order::Order;

/// A row of a cost trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CostRow {
    /// The phase.
    pub phase: Phase,
    /// The subproblem. `None` for a barrier of a whole phase.
    pub node: Option<NodeId>,
    /// The step of a phase in which all subproblems step together, or the level of the ancestor whose balls the bottom-up
    /// correction corrects.
    pub step: Option<u32>,
    /// The rank. `None` for a barrier.
    pub rank: Option<Rank>,
    /// The round in which the rank charged the call. `None` for a barrier.
    pub round: Option<u32>,
    /// The call or the vector step. `None` for a barrier.
    pub entry: Option<Step>,
    /// Positions of the rows that end before this row starts. They are smaller than the position of this row.
    pub after: Vec<u64>,
}

/// The cost trace of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CostTrace {
    rows: Vec<CostRow>,
}

impl CostTrace {
    /// Orders the charges of all ranks.
    pub(crate) fn of(charges: ChargesByRank) -> Self {
        CostTrace { rows: Order::default().run(charges) }
    }

    /// Returns the rows. A row follows all rows that it names.
    pub fn rows(&self) -> &[CostRow] {
        &self.rows
    }
}
