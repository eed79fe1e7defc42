//! The fold of a ledger: totals, phases, and the critical path.
//!
//! **Depth.** Every subproblem has its own clock. The dependencies follow the recursion:
//! 1. A phase that goes down the tree starts at a node when it has ended at the parent. At the root, it starts when all
//!    earlier phases have ended at every leaf.
//! 2. A phase that goes up the tree starts at a node when it has ended at all nodes below.
//! 3. A local phase starts at a node when the node's previous phase has ended.
//! 4. In a phase whose subproblems step together, a step starts when the previous step has ended at every node, because
//!    a node may need the messages of any other node. The first step starts when all earlier phases have ended.
//!
//! Workers, rounds and the coordinator have no influence on the depth.
//!
//! **Associativity.** The fold of a subtree is computed from the charges of its root and the folds of its children
//! ([`subtree`]).

mod chains;
mod plan;
mod subtree;

use std::collections::BTreeMap;

use septet_geometry::cost::Price;

use super::levels::TreeSums;
use super::part::{Account, Charge, LedgerPart};
use super::totals::{PathStep, PhaseTotal, Totals};
use crate::ids::{NodeId, Phase};

pub use plan::PhaseSet;
pub(super) use plan::Plan;
use subtree::Depths;
pub(super) use subtree::{Fold, Folds};

/// The folded ledger of a run.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// The merged parts of all ranks. Charges of leaders are added to the charges of members. If the ledger was condensed,
    /// the nodes of condensed subtrees have no rows.
    pub part: LedgerPart,
    /// The sums over the nodes of each level of the partition tree.
    pub tree: TreeSums,
    /// The totals of the groups of phases.
    pub totals: Totals,
    /// The totals of the phases that occurred, in order.
    pub phases: Vec<PhaseTotal>,
    /// The longest chain of the paper's phases, first step first. Its depths add up to `totals.paper.depth`. Of chains of equal
    /// length, it ends as high in the tree as possible, and then in an interior child.
    pub critical_path: Vec<PathStep>,
}

/// Returns the work of a phase.
pub(super) fn work_of(part: &LedgerPart, phase: Phase) -> u64 {
    part.members(phase).map(|(_, charge)| charge.cost.work()).sum()
}

/// The costs of the bottom-up correction below a node, by the level of the corrected balls' ancestor and the node. They
/// are closed: their scans have their prices.
pub(super) type Passes = BTreeMap<(u32, NodeId), Price>;

/// Adds the charges of leaders, of passes and of steps to the charges of the members of the same nodes. `below` contains the
/// costs of passes below nodes of the part whose rows are not in the part. Returns the costs of passes below nodes that
/// have no row.
pub(super) fn settle(part: &mut LedgerPart, below: Passes) -> Passes {
    part.join_leaders();
    let Corrections { done, open } = corrections(part, below);
    for (node, charge) in done {
        part.charges.insert(Account::member(Phase::Neighbours, node), charge);
    }
    for (account, charge) in steps_of_nodes(part) {
        part.charges.insert(account, charge);
    }
    open
}

/// The costs of the bottom-up correction in a part.
struct Corrections {
    /// For each node whose balls are corrected, the charge of the whole descent below it.
    done: BTreeMap<NodeId, Charge>,
    /// The costs below nodes without a row.
    open: Passes,
}

/// Returns the cost of the bottom-up correction at each node. The correction of a node is a descent below it, so its
/// chain goes from the node to its children. The scans at each node are over its own items.
fn corrections(part: &LedgerPart, mut below: Passes) -> Corrections {
    let mut done = BTreeMap::new();
    let mut rows: Vec<_> = part.passes().collect();
    // Children before their parents.
    rows.sort_by_key(|&(_, node, _)| std::cmp::Reverse(node));
    for (level, node, charge) in rows {
        let mut all = *charge;
        all.cost = all.cost.closed(charge.items);
        all.cost.then(below.remove(&(level, node)).unwrap_or_default());
        match node.parent().filter(|_| node.level() > level) {
            Some(parent) => below.entry((level, parent)).or_default().join(all.cost),
            None => drop(done.insert(node, all)),
        }
    }
    Corrections { done, open: below }
}

/// Returns, for each node, the sum of its charges over all steps.
fn steps_of_nodes(part: &LedgerPart) -> BTreeMap<Account, Charge> {
    let mut sums: BTreeMap<Account, Charge> = BTreeMap::new();
    for phase in Phase::ALL {
        for (_, node, charge) in part.steps(phase) {
            let sum = sums.entry(Account::member(phase, node)).or_default();
            sum.cost.then(charge.cost.closed(charge.items));
            sum.items = sum.items.max(charge.items);
        }
    }
    sums
}

/// Returns the total of a phase with its work and its exact tests.
pub(super) fn phase_total(
    part: &LedgerPart,
    (phase, work, exact_tests): (Phase, u64, u64),
    alone: Depths,
    critical_depth: u64,
) -> Option<PhaseTotal> {
    let rounds: Vec<_> = part.rounds.iter().filter(|(key, _)| key.phase == phase).map(|(_, t)| t).collect();
    if rounds.is_empty() && work == 0 {
        return None;
    }
    Some(PhaseTotal {
        phase,
        rounds: rounds.iter().filter(|t| t.messages > 0).count() as u64,
        work,
        exact_tests,
        depth: alone.depth,
        depth_log_scan: alone.depth_log_scan,
        critical_depth,
        messages: rounds.iter().map(|t| t.messages).sum(),
        bytes: rounds.iter().map(|t| t.bytes).sum(),
    })
}

#[cfg(test)]
mod tests {
    use septet_geometry::cost::Price;

    use super::super::round::RoundKey;
    use super::*;

    /// The price of a loop.
    fn cost(trips: u64) -> Price {
        Price::from_parts([trips, trips, 0, 0, 0])
    }

    #[test]
    fn depth_is_the_longest_chain_and_the_path_adds_up() {
        let mut part = LedgerPart::default();
        let (l, r) = (NodeId(2), NodeId(3));
        part.charge(Account::member(Phase::Partition, NodeId::ROOT), cost(5), 10);
        part.charge(Account::member(Phase::Partition, l), cost(1), 4);
        part.charge(Account::member(Phase::Partition, r), cost(7), 6);
        part.charge(Account::member(Phase::Hulls, l), cost(20), 4);
        part.charge(Account::member(Phase::Hulls, r), cost(3), 6);
        part.charge(Account::member(Phase::Merge, NodeId::ROOT), cost(1), 2);
        let ledger = Ledger::finish(part, 10, 3);
        // Root 5, left 1 + 20 against right 7 + 3, then the merge.
        assert_eq!(ledger.totals.paper.depth, 5 + 1 + 20 + 1);
        let sum: u64 = ledger.critical_path.iter().map(|s| s.depth).sum();
        assert_eq!(sum, ledger.totals.paper.depth);
        assert_eq!(ledger.totals.paper.work, 37);
    }

    #[test]
    fn a_node_corrects_after_its_children_and_as_deep_as_its_descent() {
        let mut part = LedgerPart::default();
        let (l, r, ll) = (NodeId(2), NodeId(3), NodeId(4));
        part.charge(Account::member(Phase::Radii, ll), cost(2), 4);
        part.charge(Account::member(Phase::Radii, r), cost(3), 4);
        // The left child: itself, then a leaf. The root: itself, then in parallel the left child with its leaf, and the right.
        for (level, node, steps) in
            [(1, l, 5), (1, ll, 7), (0, NodeId::ROOT, 11), (0, l, 1), (0, ll, 2), (0, r, 4)]
        {
            part.charge(Account::pass(level, node), cost(steps), 10);
        }
        let words = part.to_words();
        assert_eq!(LedgerPart::from_words(&words).as_ref(), Some(&part));
        let ledger = Ledger::finish(part, 10, 3);
        assert_eq!(ledger.totals.paper.depth, 2 + (5 + 7) + (11 + 4));
        assert_eq!(ledger.totals.paper.work, 2 + 3 + 5 + 7 + 11 + 1 + 2 + 4);
        let path: Vec<NodeId> = ledger.critical_path.iter().map(|s| s.node).collect();
        assert_eq!(path, [ll, l, NodeId::ROOT]);
    }

    #[test]
    fn steps_wait_for_all_nodes_of_the_step_before() {
        let mut part = LedgerPart::default();
        let (l, r) = (NodeId(2), NodeId(3));
        part.charge(Account::member(Phase::Check, l), cost(3), 10);
        part.charge(Account::member(Phase::Check, r), cost(4), 10);
        for (step, node, trips) in [(1, l, 10), (1, r, 2), (2, l, 1), (2, r, 20), (9, l, 7)] {
            part.charge(Account::step(Phase::Repair, step, node), cost(trips), 10);
        }
        part.charge(Account::member(Phase::Certificate, l), cost(5), 10);
        let ledger = Ledger::finish(part, 10, 3);
        assert_eq!(ledger.totals.repair.depth, 4 + (10 + 20 + 7) + 5);
        assert_eq!(ledger.totals.repair.work, 3 + 4 + 10 + 2 + 1 + 20 + 7 + 5);
        let repair = ledger.phases.iter().find(|total| total.phase == Phase::Repair);
        assert_eq!(repair.map(|total| (total.work, total.depth)), Some((40, 37)));
        let sum = ledger.part.charges[&Account::member(Phase::Repair, l)].cost;
        assert_eq!((sum.work(), sum.depth()), (18, 18));
    }

    #[test]
    fn a_phase_without_steps_is_no_barrier() {
        let mut part = LedgerPart::default();
        let (l, r) = (NodeId(2), NodeId(3));
        for (phase, node, trips) in
            [(Phase::Graph, l, 1), (Phase::Graph, r, 9), (Phase::Hulls, l, 9), (Phase::Hulls, r, 1)]
        {
            part.charge(Account::member(phase, node), cost(trips), 10);
        }
        // `independent` lies between these phases, and this run does not have it.
        assert_eq!(Ledger::finish(part, 10, 3).totals.paper.depth, 10);
    }

    #[test]
    fn parts_survive_the_wire_and_merge_in_any_order() {
        let mut a = LedgerPart::default();
        a.charge(Account::member(Phase::Partition, NodeId::ROOT), cost(5), 10);
        a.tally(RoundKey { round: 3, phase: Phase::Partition }).messages = 2;
        a.facts(NodeId::ROOT).population = 20;
        let mut b = LedgerPart::default();
        b.charge(Account::member(Phase::Partition, NodeId::ROOT), cost(5), 10);
        b.facts(NodeId(2)).edges = 4;
        assert_eq!(LedgerPart::from_words(&a.to_words()).as_ref(), Some(&a));
        assert_eq!(LedgerPart::from_words(&a.to_words()[..5]), None);
        let (mut ab, mut ba) = (a.clone(), b.clone());
        ab.merge(&b);
        ba.merge(&a);
        assert_eq!(ab, ba);
        let root = ab.charges[&Account::member(Phase::Partition, NodeId::ROOT)];
        assert_eq!((root.cost.depth(), root.items), (5, 20));
    }
}
