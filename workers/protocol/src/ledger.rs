//! The ledger: the work of subproblems and the traffic of ranks, folded into phases and a critical path.
//!
//! Every rank keeps a [`LedgerPart`]. It holds the charges of its computations (prices by [`Account`]), its work and
//! messages in each round, and the facts of the nodes that it leads or holds. Parts are merged by sums and maxima, which
//! do not depend on order. [`Ledger::finish`] folds the merged part. Several processes condense their parts first
//! ([`LedgerPart::condense`]): the subtrees of ranks travel as sums.

mod brent;
mod condensed;
mod counts;
mod fold;
mod levels;
mod part;
mod round;
mod totals;
mod words;

pub use brent::{BrentCurve, steps_on};
pub use condensed::{CondensedLedger, Condensing, LedgerError};
pub use counts::{Count, Join};
pub use fold::{Ledger, PhaseSet};
pub use levels::{LevelSums, Ratios, TreeSums};
pub use part::{
    Account, Charge, LedgerPart, LinkKey, NodeFacts, NodeKind, RankKey, RankTally, Role, Traffic,
};
pub use round::{RoundKey, RoundRow, RoundTally};
pub use totals::{PathStep, PhaseTotal, Total, Totals};
