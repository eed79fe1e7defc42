//! A condensed ledger: rows of the nodes that several ranks charge, and sums of the subtrees that one rank charges.
//!
//! **Statement.** Each process condenses its part, and one process unites the condensed parts. The folded ledger is then that
//! of the merged parts: equal totals, phases, critical path and sums of the tree.
//!
//! **Why.** Only one rank charges the nodes of a condensed subtree, so their charges are complete before the parts are
//! merged. The fold of a subtree is all that the fold of the tree needs of it ([`super::fold`]). A bottom-up correction of the
//! balls of a node above the subtree descends into it. Its cost within the subtree is one price, which joins the cost at
//! the parent of the subtree's root. Work and facts of nodes enter as sums.
//!
//! **Size.** A rank has at most one condensed subtree. The rows are those of the shared nodes, and a condensed subtree has the
//! size of its fold: the number of phases times the number of levels, plus the number of steps of splaying and of
//! independent sets. The number of points of a rank enters only by the numbers of levels and of steps.

mod words;

use std::collections::{BTreeMap, BTreeSet};

use thiserror::Error;

use super::fold::{Fold, Folds, Ledger, Passes, PhaseSet, Plan, phase_total, settle, work_of};
use super::levels::TreeSums;
use super::part::{Account, LedgerPart};
use crate::ids::{NodeId, Phase};

/// How a process condenses its part of the ledger.
#[derive(Clone, Copy, Debug)]
pub struct Condensing<'a> {
    /// The roots of disjoint subtrees that only one rank charges.
    pub roots: &'a [NodeId],
    /// The phases of all processes.
    pub phases: PhaseSet,
    /// Number of coordinates of a point.
    pub space: usize,
    /// Whether the facts of all nodes remain rows.
    pub keeps_nodes: bool,
}

/// A ledger in which subtrees are sums.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CondensedLedger {
    /// All rows that are not condensed.
    pub part: LedgerPart,
    /// The phases of all processes.
    pub(super) phases: PhaseSet,
    /// The folds of the condensed subtrees.
    pub(super) folds: Folds,
    /// The costs of passes in condensed subtrees for nodes above them, by level and parent of the subtree.
    pub(super) passes: Passes,
    /// The work of each phase in condensed subtrees.
    pub(super) work: BTreeMap<Phase, u64>,
    /// The sums over the nodes of condensed subtrees. If the facts of nodes are rows, the sums have only depths.
    pub(super) tree: TreeSums,
    /// Whether the facts of all nodes are rows.
    keeps_nodes: bool,
}

/// Condensed ledgers that do not belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LedgerError {
    /// Two processes have rows or sums of one subtree.
    #[error("two processes have counts of node {}", node.0)]
    Shared {
        /// The node.
        node: NodeId,
    },
    /// The processes have condensed their parts for different phases, or with different rows.
    #[error("the processes have condensed their counts in different ways")]
    Mixed,
}

/// Returns a node and its ancestors, from the node up.
fn ancestors(node: NodeId) -> impl Iterator<Item = NodeId> {
    std::iter::successors(Some(node), |node| node.parent())
}

impl LedgerPart {
    /// Returns the part with sums in place of the rows of subtrees.
    #[must_use]
    pub fn condense(mut self, condensing: &Condensing<'_>) -> CondensedLedger {
        let &Condensing { roots, phases, space, keeps_nodes } = condensing;
        let roots: BTreeSet<NodeId> = roots.iter().copied().collect();
        let is_own = |node: &NodeId| ancestors(*node).any(|node| roots.contains(&node));
        let mut own = LedgerPart {
            charges: self.charges.extract_if(.., |Account { node, .. }, _| is_own(node)).collect(),
            ..LedgerPart::default()
        };
        if !keeps_nodes {
            own.nodes = self.nodes.extract_if(.., |node, _| is_own(node)).collect();
        }
        let mut passes = settle(&mut own, Passes::new());
        // Costs below a node without a row that is itself condensed belong to no chain, as in one process.
        passes.retain(|(_, node), _| !is_own(node));
        let mut tree = TreeSums::default();
        tree.add_rows(&own, space);
        let work = Phase::ALL.into_iter().map(|phase| (phase, work_of(&own, phase)));
        let work = work.filter(|(_, work)| *work > 0).collect();
        let plan = Plan::of(phases);
        let mut folds = Fold::of_subtrees(&plan, &roots, &own, Folds::new());
        for root in roots {
            folds.entry(root).or_insert_with(|| Fold::empty(&plan));
        }
        CondensedLedger { part: self, phases, folds, passes, work, tree, keeps_nodes }
    }
}

impl CondensedLedger {
    /// Returns a ledger of rows only.
    pub fn of_rows(part: LedgerPart) -> Self {
        CondensedLedger { phases: PhaseSet::of(&part), part, keeps_nodes: true, ..CondensedLedger::default() }
    }

    /// Unites the condensed ledgers of all processes.
    ///
    /// # Errors
    /// Fails if two processes have charges of one condensed subtree, or facts of its nodes that are not rows. Also fails
    /// if the processes did not agree on the phases.
    pub fn united(all: impl IntoIterator<Item = CondensedLedger>) -> Result<CondensedLedger, LedgerError> {
        let mut all = all.into_iter();
        let mut united = all.next().unwrap_or_default();
        for other in all {
            united.merge(other)?;
        }
        united.check()?;
        Ok(united)
    }

    fn merge(&mut self, other: CondensedLedger) -> Result<(), LedgerError> {
        if (self.phases, self.keeps_nodes) != (other.phases, other.keeps_nodes) {
            return Err(LedgerError::Mixed);
        }
        self.part.merge(&other.part);
        for (node, fold) in other.folds {
            if self.folds.insert(node, fold).is_some() {
                return Err(LedgerError::Shared { node });
            }
        }
        for (key, cost) in other.passes {
            self.passes.entry(key).or_default().join(cost);
        }
        for (phase, work) in other.work {
            *self.work.entry(phase).or_default() += work;
        }
        self.tree.join(&other.tree);
        Ok(())
    }

    /// Checks that no row and no subtree lies in a condensed subtree, and that no row has a phase of its own.
    fn check(&self) -> Result<(), LedgerError> {
        if self.phases.union(PhaseSet::of(&self.part)) != self.phases {
            return Err(LedgerError::Mixed);
        }
        let is_condensed = |node: NodeId| ancestors(node).any(|node| self.folds.contains_key(&node));
        let charged = self.part.charges.keys().map(|account| account.node).filter(|&node| is_condensed(node));
        let known = self.part.nodes.keys().copied().filter(|&node| !self.keeps_nodes && is_condensed(node));
        let below = self.folds.keys().copied().filter(|node| node.parent().is_some_and(is_condensed));
        charged.chain(known).chain(below).next().map_or(Ok(()), |node| Err(LedgerError::Shared { node }))
    }
}

impl Ledger {
    /// Folds the merged parts of a run over `population` points with `space` coordinates.
    pub fn finish(part: LedgerPart, population: u64, space: usize) -> Ledger {
        Ledger::of_condensed(CondensedLedger::of_rows(part), population, space)
    }

    /// Folds the condensed ledger of a run over `population` points with `space` coordinates.
    pub fn of_condensed(condensed: CondensedLedger, population: u64, space: usize) -> Ledger {
        let CondensedLedger { mut part, phases, folds, passes, work, mut tree, .. } = condensed;
        let plan = Plan::of(phases);
        settle(&mut part, passes);
        tree.add_rows(&part, space);
        let fold = Fold::of_tree(&plan, &part, folds);
        let folded = fold.totals(&plan, population.max(1));
        let totals = folded.as_ref().map(|(total, _)| *total);
        let (_, path) = folded.paper;
        let alone = fold.alone(&plan);
        let phases = Phase::ALL.into_iter().filter_map(|phase| {
            let on_path = path.iter().filter(|s| s.phase == phase).map(|s| s.depth).sum();
            let condensed = work.get(&phase).copied().unwrap_or(0);
            let work = condensed + work_of(&part, phase);
            phase_total(
                &part,
                (phase, work, fold.exact_tests(phase)),
                alone.get(&phase).copied().unwrap_or_default(),
                on_path,
            )
        });
        let phases = phases.collect();
        Ledger { totals, phases, critical_path: path, tree, part }
    }
}

#[cfg(test)]
mod tests;
