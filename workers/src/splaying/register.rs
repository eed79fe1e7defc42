//! Registers of cells: which of its vertices have a cell in their stars.
//!
//! **Statement.** The smallest vertex of a cell keeps its *register*: the vertices whose stars have the cell, the *holders*. A
//! cell is *open* if some but not all of its vertices are holders. All stars agree if and only if no cell is open. After a step,
//! every star reports its changes to the registers. Then each register whose cell is open and has a new report sends messages:
//! 1. If some star has refuted the cell, the holders receive the witnesses.
//! 2. Otherwise the cell asks for a point in its circumsphere ([`crate::splaying::probes`]), once. If it gets no answer, the other
//!    vertices receive the cell.
//!
//! A rank stores only the registers of open cells. A cell without a register had either all holders or none: all if the first
//! report refutes it, none if the first report is a gain.
//!
//! **Source.** None. Shewchuk's stars send each cell to its vertices, and do not know who has it.
//!
//! **Work and depth.** The reports to the smallest vertices in a leaf are delivered. A report has at most one witness, so it is one
//! item. This brings the reports about a cell together: O(m log m) work and O(log m) depth for `m` reports.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;

use crate::machine::context::Context;
use crate::splaying::messages::{Objections, Proposal, Question};
use crate::splaying::pending::{Pending, StarInbox, StepOutput};
use crate::state::tree::{Leaf, leaf_number};

/// The register of an open cell.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The owned smallest vertex.
    smallest: u32,
    /// A bit for each vertex in the order of the cell: whether it is a holder.
    holders: u8,
    /// Whether the cell has asked.
    asked: bool,
}

/// The registers of the open cells whose smallest vertex is on this rank.
#[derive(Debug)]
pub(super) struct Registers<P: Point> {
    open: BTreeMap<P::Cell, Entry>,
    /// The open cells without a report since the check.
    fresh: BTreeSet<P::Cell>,
}

/// The messages of the registers.
pub(super) struct Notices<P: Point> {
    pub(super) messages: StepOutput<P>,
    /// The cells that ask.
    pub(super) questions: Vec<Question<P::Cell>>,
}

impl<P: Point> Default for Notices<P> {
    fn default() -> Self {
        Notices { messages: StepOutput::default(), questions: Vec::new() }
    }
}

impl<P: Point> Registers<P> {
    /// Creates the registers of no cells.
    pub(super) fn new() -> Self {
        Registers { open: BTreeMap::new(), fresh: BTreeSet::new() }
    }

    /// Returns `true` if cells are open that no star has reported since the check.
    pub(super) fn has_fresh(&self) -> bool {
        !self.fresh.is_empty()
    }

    /// Opens the cell of the smallest vertex `found.from`, whose star has it, because the star of `found.to` lacks it.
    pub(super) fn open(&mut self, found: &Proposal<P::Cell>) {
        let entry = Entry { smallest: found.from, holders: all::<P>(), asked: false };
        let entry = self.open.entry(found.cell).or_insert(entry);
        entry.holders &= !bit(&found.cell, found.to);
        self.fresh.insert(found.cell);
    }

    /// Enters the reports of all stars. Returns the messages of the registers. `reports` must be sorted.
    pub(super) fn settle(
        &mut self,
        cx: &mut Context<P>,
        leaves: &[Leaf<P>],
        reports: &Pending<P>,
        step: u32,
    ) -> Notices<P> {
        let mut touched: BTreeMap<P::Cell, Vec<u32>> =
            std::mem::take(&mut self.fresh).into_iter().map(|cell| (cell, Vec::new())).collect();
        let mut delivered: BTreeMap<u32, Sweep> = BTreeMap::new();
        for cell in touched.keys() {
            delivered.entry(leaf_number(leaves, self.open[cell].smallest)).or_default().visit();
        }
        for inbox in reports.by_star() {
            let sweep = delivered.entry(leaf_number(leaves, inbox.vertex)).or_default();
            self.enter(&inbox, sweep, &mut touched);
        }
        for (leaf, sweep) in delivered {
            let mut cost: Cost = cx.own_cost();
            cost.charge_delivery(sweep);
            cx.charge(Account::step(Phase::Repair, step, leaves[leaf as usize].id()), cost, sweep.items());
        }
        self.notices(touched)
    }

    /// Enters the reports to one smallest vertex.
    fn enter(
        &mut self,
        inbox: &StarInbox<'_, P>,
        sweep: &mut Sweep,
        touched: &mut BTreeMap<P::Cell, Vec<u32>>,
    ) {
        for report in sweep.visit_all(inbox.proposals) {
            let entry = Entry { smallest: inbox.vertex, holders: 0, asked: false };
            self.open.entry(report.cell).or_insert(entry).holders |= bit(&report.cell, report.from);
            touched.entry(report.cell).or_default();
        }
        for report in sweep.visit_all(inbox.objections) {
            let entry = Entry { smallest: inbox.vertex, holders: all::<P>(), asked: false };
            self.open.entry(report.cell).or_insert(entry).holders &= !bit(&report.cell, report.from);
            touched.entry(report.cell).or_default().extend(inbox.witnesses(report));
        }
    }

    /// Returns the messages of the registers with new reports, and closes the cells on which all vertices agree.
    fn notices(&mut self, touched: BTreeMap<P::Cell, Vec<u32>>) -> Notices<P> {
        let (mut proposals, mut objections, mut questions) = (Vec::new(), Objections::default(), Vec::new());
        for (cell, mut witnesses) in touched {
            let Some(entry) = self.open.get_mut(&cell) else { continue };
            if entry.holders == 0 || entry.holders == all::<P>() {
                self.open.remove(&cell);
                continue;
            }
            let Entry { smallest, holders, .. } = *entry;
            let vertices = || cell.as_ref().iter().copied();
            if witnesses.is_empty() {
                let others = vertices().filter(|&v| holders & bit(&cell, v) == 0);
                proposals.extend(others.map(|to| Proposal { to, cell, from: smallest }));
                if !std::mem::replace(&mut entry.asked, true) {
                    questions.push(Question { star: smallest, cell });
                }
            } else {
                witnesses.sort_unstable();
                witnesses.dedup();
                let held = vertices().filter(|&v| holders & bit(&cell, v) != 0);
                objections.add(held, cell, smallest, &witnesses);
            }
        }
        Notices { messages: StepOutput { proposals, objections }, questions }
    }
}

/// Returns the holders if all vertices of a cell are.
fn all<P: Point>() -> u8 {
    (1 << (P::DIM + 1)) - 1
}

/// Returns the bit of a vertex of a cell; 0 if it is not one.
fn bit<C: AsRef<[u32]>>(cell: &C, vertex: u32) -> u8 {
    cell.as_ref().iter().position(|&v| v == vertex).map_or(0, |at| 1 << at)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    /// Returns sorted reports: gains and refutations of the cell 1, 5, 7 by vertices, to its smallest vertex 5.
    fn reports(gains: &[u32], refutations: &[(u32, u32)]) -> Pending<DVec2> {
        let mut reports = Pending::new(Vec::new());
        reports.proposals = gains.iter().map(|&from| Proposal { to: 5, cell: [1, 5, 7], from }).collect();
        for &(from, witness) in refutations {
            reports.objections.add([5].into_iter(), [1, 5, 7], from, &[witness]);
        }
        reports.sort();
        reports
    }

    /// The receivers of a cell, the receivers of witnesses with the witnesses, and the number of questions.
    type Settled = (Vec<u32>, Vec<(u32, Vec<u32>)>, usize);

    /// Settles the registers after these reports.
    fn settle(registers: &mut Registers<DVec2>, reports: &Pending<DVec2>) -> Settled {
        let mut touched =
            std::mem::take(&mut registers.fresh).into_iter().map(|cell| (cell, Vec::new())).collect();
        for inbox in reports.by_star() {
            registers.enter(&inbox, &mut Sweep::default(), &mut touched);
        }
        let Notices { messages, questions } = registers.notices(touched);
        let witnesses = messages.objections.witnesses();
        let list = messages.objections.list().iter().map(|o| (o.to, witnesses[o.witnesses.clone()].to_vec()));
        (messages.proposals.iter().map(|p| p.to).collect(), list.collect(), questions.len())
    }

    #[test]
    fn a_cell_that_few_gain_is_told_and_asks_once() {
        let mut registers = Registers::new();
        assert_eq!(settle(&mut registers, &reports(&[7], &[])), (vec![1, 5], vec![], 1));
        assert_eq!(settle(&mut registers, &reports(&[1], &[])), (vec![5], vec![], 0));
        assert_eq!(settle(&mut registers, &reports(&[5], &[])), (vec![], vec![], 0));
        assert!(registers.open.is_empty());
        assert_eq!(settle(&mut registers, &reports(&[1, 5, 7], &[])), (vec![], vec![], 0));
        assert!(registers.open.is_empty());
    }

    #[test]
    fn holders_of_a_refuted_cell_receive_the_witnesses() {
        let mut registers = Registers::new();
        let lost = reports(&[], &[(1, 30)]);
        assert_eq!(settle(&mut registers, &lost), (vec![], vec![(5, vec![30]), (7, vec![30])], 0));
        assert_eq!(settle(&mut registers, &reports(&[], &[(5, 30), (7, 30)])), (vec![], vec![], 0));
        assert!(registers.open.is_empty());
        let both = reports(&[7], &[]);
        settle(&mut registers, &both);
        let refuted = reports(&[], &[(1, 40), (5, 30)]);
        assert_eq!(settle(&mut registers, &refuted), (vec![], vec![(7, vec![30, 40])], 0));
    }

    #[test]
    fn the_check_opens_cells() {
        let mut registers = Registers::<DVec2>::new();
        registers.open(&Proposal { to: 7, cell: [1, 5, 7], from: 5 });
        assert!(registers.has_fresh());
        assert_eq!(settle(&mut registers, &reports(&[], &[])), (vec![7], vec![], 1));
        assert!(!registers.has_fresh());
    }
}
