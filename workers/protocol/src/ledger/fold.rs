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

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::cost::Price;

use super::{Account, Charge, LedgerPart};
use crate::ids::{NodeId, Phase};

/// Totals of one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseTotal {
    /// The phase.
    pub phase: Phase,
    /// Rounds in which a rank sent messages.
    pub rounds: u64,
    /// Work over all subproblems.
    pub work: u64,
    /// Length of the longest chain of the phase alone; a scan counts 1.
    pub depth: u64,
    /// Length of that chain if a scan of `m` items counts `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Share of the phase in the critical path of the run.
    pub critical_depth: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
}

/// Work, depth and Brent's bound over a group of phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Total {
    /// Work.
    pub work: u64,
    /// Depth; a scan counts 1.
    pub depth: u64,
    /// Depth if a scan of `m` items counts `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Brent's bound on the time with `n` processors. A step is a phase at a level of the tree. The bound is the sum
    /// of `ceil((work - depth) / n) + depth` over all steps.
    pub brent: u64,
}

/// One step of the critical path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathStep {
    /// The subproblem.
    pub node: NodeId,
    /// The phase.
    pub phase: Phase,
    /// Depth of the phase at the subproblem.
    pub depth: u64,
}

/// The folded ledger of a run.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// The merged parts of all ranks. Charges of leaders are added to the charges of members.
    pub part: LedgerPart,
    /// The total of the paper's phases.
    pub paper: Total,
    /// The total of the repair phases.
    pub repair: Total,
    /// The totals of the phases that occurred, in order.
    pub phases: Vec<PhaseTotal>,
    /// The longest chain of the paper's phases, first step first. Its depths add up to `paper.depth`.
    pub critical_path: Vec<PathStep>,
}

/// The direction of a phase over the tree.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Flow {
    Down,
    Up,
    Local,
    Steps,
}

/// Returns the direction of a phase. A descent whose replies return makes two passes over the tree. Both are charged
/// on the way down, so its flow is [`Flow::Down`].
fn flow(phase: Phase, part: &LedgerPart) -> Flow {
    match phase {
        Phase::Repair | Phase::Independent => Flow::Steps,
        Phase::Neighbours if part.passes().next().is_some() => Flow::Up,
        Phase::Summaries | Phase::Merge | Phase::Check | Phase::Certificate | Phase::Fallback => Flow::Up,
        // A leaf may receive the ends of edges from any other leaf, so the graph waits for everything before it.
        Phase::Graph
        | Phase::Partition
        | Phase::Choice
        | Phase::Sets
        | Phase::Probe
        | Phase::Neighbours
        | Phase::KnnProbe
        | Phase::Knn => Flow::Down,
        _ => Flow::Local,
    }
}

impl Ledger {
    /// Folds the merged parts of a run over `population` points.
    pub fn finish(mut part: LedgerPart, population: u64) -> Ledger {
        part.join_leaders();
        for (node, charge) in corrections(&part) {
            part.charges.insert(Account::member(Phase::Neighbours, node), charge);
        }
        for (account, charge) in steps_of_nodes(&part) {
            part.charges.insert(account, charge);
        }
        let paper: Vec<Phase> = Phase::ALL.into_iter().filter(|p| p.is_paper()).collect();
        let repair: Vec<Phase> = Phase::ALL.into_iter().filter(|p| p.is_repair()).collect();
        let clock = Clock::run(&part, &paper, false);
        let path = clock.path();
        let mut phases = Vec::new();
        for phase in Phase::ALL {
            let on_path: u64 = path.iter().filter(|s| s.phase == phase).map(|s| s.depth).sum();
            phases.extend(phase_total(&part, phase, on_path));
        }
        Ledger {
            paper: total(&part, &paper, population),
            repair: total(&part, &repair, population),
            phases,
            critical_path: path,
            part,
        }
    }
}

/// Returns the cost of the bottom-up correction at each node. The correction of a node is a descent below it, so its
/// chain goes from the node to its children. The scans at each node are over its own items.
fn corrections(part: &LedgerPart) -> BTreeMap<NodeId, Charge> {
    let mut below: BTreeMap<(u32, NodeId), Charge> = BTreeMap::new();
    let mut done = BTreeMap::new();
    let mut rows: Vec<_> = part.passes().collect();
    // Children before their parents.
    rows.sort_by_key(|&(_, node, _)| std::cmp::Reverse(node));
    for (level, node, charge) in rows {
        let mut all = *charge;
        all.cost = all.cost.closed(charge.items);
        all.cost.then(below.remove(&(level, node)).unwrap_or_default().cost);
        match node.parent().filter(|_| node.level() > level) {
            Some(parent) => below.entry((level, parent)).or_default().cost.join(all.cost),
            None => drop(done.insert(node, all)),
        }
    }
    done
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

fn phase_total(part: &LedgerPart, phase: Phase, critical_depth: u64) -> Option<PhaseTotal> {
    let rounds: Vec<_> = part.rounds.iter().filter(|(key, _)| key.phase == phase).map(|(_, t)| t).collect();
    let work = part.members(phase).map(|(_, charge)| charge.cost.work()).sum();
    if rounds.is_empty() && work == 0 {
        return None;
    }
    Some(PhaseTotal {
        phase,
        rounds: rounds.iter().filter(|t| t.messages > 0).count() as u64,
        work,
        depth: Clock::run(part, &[phase], false).end(),
        depth_log_scan: Clock::run(part, &[phase], true).end(),
        critical_depth,
        messages: rounds.iter().map(|t| t.messages).sum(),
        bytes: rounds.iter().map(|t| t.bytes).sum(),
    })
}

fn total(part: &LedgerPart, phases: &[Phase], population: u64) -> Total {
    // Each step of Brent's bound: the nodes of one level in a phase, or one step of a phase that has steps.
    let mut steps: BTreeMap<(Phase, u32), Price> = BTreeMap::new();
    for &phase in phases {
        match flow(phase, part) {
            Flow::Steps => {
                for (step, _, charge) in part.steps(phase) {
                    steps.entry((phase, step)).or_default().join(charge.cost);
                }
            }
            _ => {
                for (node, charge) in part.members(phase) {
                    steps.entry((phase, node.level())).or_default().join(charge.cost);
                }
            }
        }
    }
    let n = population.max(1);
    let work = steps.values().map(Price::work).sum();
    let brent = steps.values().map(|p| p.work().saturating_sub(p.depth()).div_ceil(n) + p.depth()).sum();
    Total {
        work,
        depth: Clock::run(part, phases, false).end(),
        depth_log_scan: Clock::run(part, phases, true).end(),
        brent,
    }
}

/// A time, and the step that ended then.
type End = (u64, Option<usize>);

/// The clocks of all subproblems, phase after phase.
struct Clock {
    /// All steps so far, each with the step that it waited for.
    steps: Vec<(PathStep, Option<usize>)>,
    /// The end of the previous phase at each node.
    ends: BTreeMap<NodeId, End>,
    /// The latest end of all.
    last: End,
}

impl Clock {
    fn run(part: &LedgerPart, phases: &[Phase], log_scan: bool) -> Clock {
        let mut clock = Clock { steps: Vec::new(), ends: BTreeMap::new(), last: (0, None) };
        for &phase in phases {
            let depth = |c: &Charge| if log_scan { c.cost.depth_log_scan(c.items) } else { c.cost.depth() };
            if flow(phase, part) == Flow::Steps {
                clock.steps(phase, part.steps(phase).map(|(step, node, charge)| (step, node, depth(charge))));
                continue;
            }
            let mut charges: Vec<(NodeId, u64)> =
                part.members(phase).map(|(node, charge)| (node, depth(charge))).collect();
            if charges.is_empty() {
                continue;
            }
            charges.sort_by_key(|(node, _)| (node.level(), node.0));
            match flow(phase, part) {
                Flow::Down => clock.down(phase, &charges),
                Flow::Up => clock.up(phase, &charges),
                Flow::Local | Flow::Steps => clock.local(phase, &charges),
            }
        }
        clock
    }

    /// Adds a step that starts at `from`. Returns its end.
    fn push(&mut self, node: NodeId, phase: Phase, depth: u64, from: End) -> End {
        self.steps.push((PathStep { node, phase, depth }, from.1));
        let end = (from.0 + depth, Some(self.steps.len() - 1));
        if end.0 > self.last.0 || self.last.1.is_none() {
            self.last = end;
        }
        end
    }

    /// Runs a phase down the tree: the root starts when all earlier phases have ended, a node when its parent has ended.
    fn down(&mut self, phase: Phase, charges: &[(NodeId, u64)]) {
        let barrier = self.last;
        let mut ends: BTreeMap<NodeId, End> = BTreeMap::new();
        for &(node, depth) in charges {
            let from = nearest_ancestor(&ends, node).unwrap_or(barrier);
            let end = self.push(node, phase, depth, from);
            ends.insert(node, end);
        }
        self.ends = ends;
    }

    /// Runs a phase up the tree: a node starts when its children have ended, a leaf when its previous phase has ended.
    fn up(&mut self, phase: Phase, charges: &[(NodeId, u64)]) {
        let before = std::mem::take(&mut self.ends);
        let barrier = self.last;
        let charged: BTreeSet<NodeId> = charges.iter().map(|c| c.0).collect();
        let mut pending: BTreeMap<NodeId, End> = BTreeMap::new();
        for (&node, &end) in &before {
            if let Some(n) = nearest(&charged, Some(node)) {
                later(pending.entry(n).or_insert(end), end);
            }
        }
        let mut ends = BTreeMap::new();
        for &(node, depth) in charges.iter().rev() {
            let above = || nearest_ancestor(&before, node).unwrap_or(barrier);
            let from = pending.get(&node).copied().unwrap_or_else(above);
            let end = self.push(node, phase, depth, from);
            ends.insert(node, end);
            if let Some(parent) = nearest(&charged, node.parent()) {
                later(pending.entry(parent).or_insert(end), end);
            }
        }
        self.ends = ends;
    }

    /// Runs a local phase: a node starts when its previous phase has ended.
    fn local(&mut self, phase: Phase, charges: &[(NodeId, u64)]) {
        let barrier = self.last;
        for &(node, depth) in charges {
            let from = nearest_ancestor(&self.ends, node).unwrap_or(barrier);
            let end = self.push(node, phase, depth, from);
            self.ends.insert(node, end);
        }
    }

    /// Runs a phase whose subproblems step together: a step starts when everything before it has ended.
    fn steps(&mut self, phase: Phase, charges: impl Iterator<Item = (u32, NodeId, u64)>) {
        let (mut current, mut barrier) = (None, self.last);
        for (step, node, depth) in charges {
            if current != Some(step) {
                (current, barrier) = (Some(step), self.last);
                // Every later step and every later phase waits for all stars.
                self.ends.clear();
            }
            self.push(node, phase, depth, barrier);
        }
    }

    fn end(&self) -> u64 {
        self.last.0
    }

    fn path(&self) -> Vec<PathStep> {
        let mut path = Vec::new();
        let mut at = self.last.1;
        while let Some(i) = at {
            path.push(self.steps[i].0);
            at = self.steps[i].1;
        }
        path.reverse();
        path.retain(|s| s.depth > 0);
        path
    }
}

/// Keeps the later of two ends.
fn later(slot: &mut End, end: End) {
    if end.0 > slot.0 {
        *slot = end;
    }
}

/// Returns the node, or its nearest ancestor, that belongs to the set.
fn nearest(nodes: &BTreeSet<NodeId>, from: Option<NodeId>) -> Option<NodeId> {
    let mut at = from;
    while let Some(node) = at.filter(|node| !nodes.contains(node)) {
        at = node.parent();
    }
    at
}

/// Returns the end of the node, or of its nearest ancestor that has one.
fn nearest_ancestor(ends: &BTreeMap<NodeId, End>, node: NodeId) -> Option<End> {
    let mut at = Some(node);
    while let Some(n) = at {
        if let Some(&end) = ends.get(&n) {
            return Some(end);
        }
        at = n.parent();
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::RoundKey;
    use super::*;

    /// The price of a loop.
    fn cost(trips: u64) -> Price {
        Price::from_parts([trips, trips, 0, 0])
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
        let ledger = Ledger::finish(part, 10);
        // Root 5, left 1 + 20 against right 7 + 3, then the merge.
        assert_eq!(ledger.paper.depth, 5 + 1 + 20 + 1);
        let sum: u64 = ledger.critical_path.iter().map(|s| s.depth).sum();
        assert_eq!(sum, ledger.paper.depth);
        assert_eq!(ledger.paper.work, 37);
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
        let ledger = Ledger::finish(part, 10);
        assert_eq!(ledger.paper.depth, 2 + (5 + 7) + (11 + 4));
        assert_eq!(ledger.paper.work, 2 + 3 + 5 + 7 + 11 + 1 + 2 + 4);
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
        let ledger = Ledger::finish(part, 10);
        assert_eq!(ledger.repair.depth, 4 + (10 + 20 + 7) + 5);
        assert_eq!(ledger.repair.work, 3 + 4 + 10 + 2 + 1 + 20 + 7 + 5);
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
        assert_eq!(Ledger::finish(part, 10).paper.depth, 10);
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
