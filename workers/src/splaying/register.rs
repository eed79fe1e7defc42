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
//! item. This brings the reports about a cell together: O(m log m) work and O(log m) depth for `m` reports. The registers are sorted
//! as the reports are, so that one pass merges them.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;

use crate::machine::context::Context;
use crate::splaying::messages::{Objection, Objections, Proposal, Question};
use crate::splaying::pending::{Pending, StarInbox, StepOutput};
use crate::state::tree::{Leaf, leaf_number};

/// The register of an open cell.
#[derive(Clone, Copy, Debug)]
struct Entry<C> {
    /// The smallest vertex, which is owned.
    star: u32,
    cell: C,
    /// A bit for each vertex in the order of the cell: whether it is a holder.
    holders: u8,
    /// Whether the cell has asked.
    asked: bool,
}

impl<C: Copy + Ord> Entry<C> {
    /// Compares the place of the register with that of another cell.
    fn cmp(&self, star: u32, cell: &C) -> Ordering {
        (self.star, self.cell).cmp(&(star, *cell))
    }
}

/// An open cell whose register sends messages.
struct Notice<C> {
    entry: Entry<C>,
    /// Sorted, without repetitions. If there are none, the cell is told to the other vertices.
    witnesses: Vec<u32>,
    /// Whether the cell asks now.
    asks: bool,
}

/// The reports about one cell to its smallest vertex.
struct Reports<'a, P: Point> {
    cell: P::Cell,
    gains: &'a [Proposal<P::Cell>],
    losses: &'a [Objection<P::Cell>],
}

/// The registers of the open cells whose smallest vertex is on this rank.
#[derive(Debug)]
pub(super) struct Registers<P: Point> {
    /// By smallest vertex, then by cell.
    open: Vec<Entry<P::Cell>>,
    /// Whether the check opened all of them.
    is_new: bool,
}

/// The messages of the registers.
pub(super) struct Notices<P: Point> {
    /// The proposals are sorted by sender, then by cell.
    pub(super) messages: StepOutput<P>,
    /// The cells that ask, sorted.
    pub(super) questions: Vec<Question<P::Cell>>,
}

impl<P: Point> Default for Notices<P> {
    fn default() -> Self {
        Notices { messages: StepOutput::default(), questions: Vec::new() }
    }
}

impl<P: Point> Registers<P> {
    /// Opens the cells that the check found. The smallest vertex `from` has the cell, and the star of `to` lacks it.
    pub(super) fn new(mut found: Vec<Proposal<P::Cell>>) -> Self {
        found.sort_unstable_by_key(|found| (found.from, found.cell));
        let open = found.chunk_by(|a, b| a.from == b.from && a.cell == b.cell).map(|own| {
            let Proposal { from: star, cell, .. } = own[0];
            let lacking = own.iter().fold(0, |bits, found| bits | bit(&cell, found.to));
            Entry { star, cell, holders: all::<P>() & !lacking, asked: false }
        });
        Registers { open: open.collect(), is_new: true }
    }

    /// Returns `true` if cells are open that no star has reported since the check.
    pub(super) fn has_fresh(&self) -> bool {
        self.is_new && !self.open.is_empty()
    }

    /// Enters the reports of all stars. Returns the messages of the registers. `reports` must be sorted.
    pub(super) fn settle(
        &mut self,
        cx: &mut Context<P>,
        leaves: &[Leaf<P>],
        reports: &Pending<P>,
        step: u32,
    ) -> Notices<P> {
        let inboxes = reports.by_star();
        let mut delivered: BTreeMap<u32, Sweep> = BTreeMap::new();
        for entry in self.open.iter().filter(|_| self.is_new) {
            delivered.entry(leaf_number(leaves, entry.star)).or_default().visit();
        }
        for inbox in &inboxes {
            let sweep = delivered.entry(leaf_number(leaves, inbox.vertex)).or_default();
            sweep.visit_all(inbox.proposals);
            sweep.visit_all(inbox.objections);
        }
        for (leaf, sweep) in delivered {
            let mut cost: Cost = cx.own_cost();
            cost.charge_delivery(sweep);
            cx.charge(Account::step(Phase::Repair, step, leaves[leaf as usize].id()), cost, sweep.items());
        }
        messages_of::<P>(self.merge(&inboxes))
    }

    /// Merges the reports to all smallest vertices into the registers.
    fn merge(&mut self, inboxes: &[StarInbox<'_, P>]) -> Vec<Notice<P::Cell>> {
        let mut notices = Vec::new();
        let mut known = std::mem::take(&mut self.open).into_iter().peekable();
        for inbox in inboxes {
            for reports in by_cell(inbox) {
                while let Some(other) = known.next_if(|open| open.cmp(inbox.vertex, &reports.cell).is_lt()) {
                    self.keep(other, &mut notices);
                }
                let open = known.next_if(|open| open.cmp(inbox.vertex, &reports.cell).is_eq());
                self.enter(inbox, &reports, open, &mut notices);
            }
        }
        for other in known {
            self.keep(other, &mut notices);
        }
        self.is_new = false;
        notices
    }

    /// Keeps the register of a cell that no star has reported.
    fn keep(&mut self, mut entry: Entry<P::Cell>, notices: &mut Vec<Notice<P::Cell>>) {
        if self.is_new {
            notices.push(notice(&mut entry, Vec::new()));
        }
        self.open.push(entry);
    }

    /// Enters the reports about a cell. `open` is its register, if there is one.
    fn enter(
        &mut self,
        inbox: &StarInbox<'_, P>,
        &Reports { cell, gains, losses }: &Reports<'_, P>,
        open: Option<Entry<P::Cell>>,
        notices: &mut Vec<Notice<P::Cell>>,
    ) {
        let first = if gains.is_empty() { all::<P>() } else { 0 };
        let mut entry = open.unwrap_or(Entry { star: inbox.vertex, cell, holders: first, asked: false });
        entry.holders = gains.iter().fold(entry.holders, |held, gain| held | bit(&cell, gain.from));
        entry.holders = losses.iter().fold(entry.holders, |held, loss| held & !bit(&cell, loss.from));
        if entry.holders == 0 || entry.holders == all::<P>() {
            return;
        }
        let mut witnesses: Vec<u32> =
            losses.iter().flat_map(|loss| inbox.witnesses(loss).iter().copied()).collect();
        witnesses.sort_unstable();
        witnesses.dedup();
        notices.push(notice(&mut entry, witnesses));
        self.open.push(entry);
    }
}

/// Returns the notice of an open cell. A cell without witnesses asks, once.
fn notice<C: Copy>(entry: &mut Entry<C>, witnesses: Vec<u32>) -> Notice<C> {
    let asks = witnesses.is_empty() && !std::mem::replace(&mut entry.asked, true);
    Notice { entry: *entry, witnesses, asks }
}

/// Returns the messages of some open cells.
fn messages_of<P: Point>(notices: Vec<Notice<P::Cell>>) -> Notices<P> {
    let (mut proposals, mut objections, mut questions) = (Vec::new(), Objections::default(), Vec::new());
    for Notice { entry: Entry { star, cell, holders, .. }, witnesses, asks } in notices {
        let vertices = || cell.as_ref().iter().copied();
        if witnesses.is_empty() {
            let others = vertices().filter(|&v| holders & bit(&cell, v) == 0);
            proposals.extend(others.map(|to| Proposal { to, cell, from: star }));
        } else {
            let held = vertices().filter(|&v| holders & bit(&cell, v) != 0);
            objections.add(held, cell, star, &witnesses);
        }
        if asks {
            questions.push(Question { star, cell });
        }
    }
    Notices { messages: StepOutput { proposals, objections }, questions }
}

/// Returns the reports to a smallest vertex, cell by cell.
fn by_cell<'a, P: Point>(inbox: &StarInbox<'a, P>) -> impl Iterator<Item = Reports<'a, P>> {
    let mut gains = inbox.proposals.chunk_by(|a, b| a.cell == b.cell).peekable();
    let mut losses = inbox.objections.chunk_by(|a, b| a.cell == b.cell).peekable();
    std::iter::from_fn(move || {
        let heads = [gains.peek().map(|own| own[0].cell), losses.peek().map(|own| own[0].cell)];
        let cell = heads.into_iter().flatten().min()?;
        Some(Reports {
            cell,
            gains: gains.next_if(|own| own[0].cell == cell).unwrap_or_default(),
            losses: losses.next_if(|own| own[0].cell == cell).unwrap_or_default(),
        })
    })
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
        let Notices { messages, questions } = messages_of::<DVec2>(registers.merge(&reports.by_star()));
        let witnesses = messages.objections.witnesses();
        let list = messages.objections.list().iter().map(|o| (o.to, witnesses[o.witnesses.clone()].to_vec()));
        (messages.proposals.iter().map(|p| p.to).collect(), list.collect(), questions.len())
    }

    #[test]
    fn a_cell_that_few_gain_is_told_and_asks_once() {
        let mut registers = Registers::new(Vec::new());
        assert_eq!(settle(&mut registers, &reports(&[7], &[])), (vec![1, 5], vec![], 1));
        assert_eq!(settle(&mut registers, &reports(&[1], &[])), (vec![5], vec![], 0));
        assert_eq!(settle(&mut registers, &reports(&[5], &[])), (vec![], vec![], 0));
        assert!(registers.open.is_empty());
        assert_eq!(settle(&mut registers, &reports(&[1, 5, 7], &[])), (vec![], vec![], 0));
        assert!(registers.open.is_empty());
    }

    #[test]
    fn holders_of_a_refuted_cell_receive_the_witnesses() {
        let mut registers = Registers::new(Vec::new());
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
        let mut registers = Registers::<DVec2>::new(vec![Proposal { to: 7, cell: [1, 5, 7], from: 5 }]);
        assert!(registers.has_fresh());
        assert_eq!(settle(&mut registers, &reports(&[], &[])), (vec![7], vec![], 1));
        assert!(!registers.has_fresh());
    }
}
