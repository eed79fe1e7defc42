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
//! a phase also follow all earlier rows of the other groups. The depth of a group is the longest
//! path through its own rows, so the rows of other groups do not count.

mod order;
mod rows;

use septet_workers::config::ChargesByRank;

use order::Order;
pub use rows::CostRow;

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
