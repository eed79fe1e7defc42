//! The operations of insertions, one after another.

use crate::cost::{Cost, Sweep};
use crate::predicates::ExactTests;

/// The cells that insertions visited, removed and created, and their exact tests.
#[derive(Clone, Copy, Debug, Default)]
pub struct Operations {
    pub(super) cells: Sweep,
    pub(super) exact: ExactTests,
}

impl Operations {
    /// Charges the operations as one sequence. Each cell is one operation.
    pub fn charge(self, cost: &mut Cost) {
        cost.charge_sequence(self.cells);
        cost.charge_exact_tests(self.exact);
    }
}
