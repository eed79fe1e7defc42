//! The fold of a ledger: totals, phases, and the critical path.
//!
//! **Depth.** The clock belongs to the subproblem. Dependencies are those of the recursion: a phase that
//! goes down the tree starts at a node when it has ended at the parent; one that goes up, when it has ended
//! at both children; a local one follows the node's own last phase. A phase that starts at the root needs
//! what it reads from every leaf. No worker, round or coordinator appears in it.

use std::collections::{BTreeMap, BTreeSet};

use super::{Charge, LEADER, LedgerPart};
use crate::ids::{NodeId, Phase};

/// Totals of one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseTotal {
    /// Which.
    pub phase: Phase,
    /// Rounds in which it sent.
    pub rounds: u64,
    /// Work over all subproblems.
    pub work: u64,
    /// Its longest chain by itself, from its first start.
    pub depth: u64,
    /// The same with every scan at `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Its share of the run's critical path.
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
    /// Depth, a scan counting 1.
    pub depth: u64,
    /// Depth, a scan counting `ceil(log2 m)`.
    pub depth_log_scan: u64,
    /// Brent's bound on the time with `n` processors: over the steps (a phase at a level of the tree),
    /// the sum of `floor((work - depth) / n) + depth`.
    pub brent: u64,
}

/// One link of the critical path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathStep {
    /// The subproblem.
    pub node: NodeId,
    /// The phase.
    pub phase: Phase,
    /// Depth spent there.
    pub depth: u64,
}

/// The folded ledger of a run.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// All parts, merged.
    pub part: LedgerPart,
    /// The paper's phases.
    pub paper: Total,
    /// Repair's phases.
    pub repair: Total,
    /// Phase by phase, in order, those that occurred.
    pub phases: Vec<PhaseTotal>,
    /// The paper's longest chain, first step first; depths add up to `paper.depth`.
    pub critical_path: Vec<PathStep>,
}

/// How a phase runs over the tree.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Flow {
    Down,
    Up,
    Local,
}

/// Passes of each phase over the tree, in order. A descent whose answers return is two passes, charged
/// together at each node on the way down; the way up costs what [`Charge`] holds for it as well.
fn flow(phase: Phase, part: &LedgerPart) -> Flow {
    match phase {
        Phase::Neighbours if !part.corrections.is_empty() => Flow::Up,
        Phase::Summaries | Phase::Merge | Phase::Check | Phase::Certificate => Flow::Up,
        Phase::Partition | Phase::Sets | Phase::Probe | Phase::Neighbours | Phase::KnnProbe | Phase::Knn => {
            Flow::Down
        }
        _ => Flow::Local,
    }
}

impl Ledger {
    /// Folds the merged parts of a run over `population` points.
    pub fn finish(mut part: LedgerPart, population: u64) -> Ledger {
        let leaders = part.charges.split_off(&(LEADER, NodeId(0)));
        for ((phase, node), charge) in leaders {
            part.charges.entry((phase & !LEADER, node)).or_default().cost.then(charge.cost);
        }
        for (node, charge) in corrections(&part) {
            part.charges.insert((Phase::Neighbours as u8, node), charge);
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

/// Where balls are corrected node by node: what each node's correction costs. It is a descent below the node,
/// so its chain goes from the node to its children; the scans of each are over its own items.
fn corrections(part: &LedgerPart) -> BTreeMap<NodeId, Charge> {
    let mut below: BTreeMap<(u32, NodeId), Charge> = BTreeMap::new();
    let mut done = BTreeMap::new();
    let mut rows: Vec<_> = part.corrections.iter().collect();
    // Children before their parents.
    rows.sort_by_key(|((_, node), _)| std::cmp::Reverse(*node));
    for (&(level, node), charge) in rows {
        let mut all = *charge;
        all.cost.close(charge.items);
        all.cost.then(below.remove(&(level, node)).unwrap_or_default().cost);
        match node.parent().filter(|_| node.level() > level) {
            Some(parent) => below.entry((level, parent)).or_default().cost.join(all.cost),
            None => drop(done.insert(node, all)),
        }
    }
    done
}

fn phase_total(part: &LedgerPart, phase: Phase, critical_depth: u64) -> Option<PhaseTotal> {
    let number = phase as u8;
    let rounds: Vec<_> = part.rounds.iter().filter(|((_, p), _)| *p == number).map(|(_, t)| t).collect();
    let work = part.charges.iter().filter(|((p, _), _)| *p == number).map(|(_, c)| c.cost.work()).sum();
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
    let mut steps: BTreeMap<(u8, u32), (u64, u64)> = BTreeMap::new();
    let mut work = 0;
    for ((phase, node), charge) in &part.charges {
        if phases.iter().any(|p| *p as u8 == *phase) {
            work += charge.cost.work();
            let step = steps.entry((*phase, node.level())).or_default();
            step.0 += charge.cost.work();
            step.1 = step.1.max(charge.cost.depth());
        }
    }
    let n = population.max(1);
    let brent = steps.values().map(|&(w, d)| w.saturating_sub(d) / n + d).sum();
    Total {
        work,
        depth: Clock::run(part, phases, false).end(),
        depth_log_scan: Clock::run(part, phases, true).end(),
        brent,
    }
}

/// The clocks of all subproblems, phase after phase.
struct Clock {
    /// End of the last phase so far at a node that matters to what follows: leaves, and the barrier.
    steps: Vec<(PathStep, Option<usize>)>,
    /// For each node with a running clock: time and index of its last step.
    ends: BTreeMap<NodeId, (u64, Option<usize>)>,
    last: (u64, Option<usize>),
}

impl Clock {
    fn run(part: &LedgerPart, phases: &[Phase], log_scan: bool) -> Clock {
        let mut clock = Clock { steps: Vec::new(), ends: BTreeMap::new(), last: (0, None) };
        for &phase in phases {
            let number = phase as u8;
            let mut charges: Vec<(NodeId, u64)> = part
                .charges
                .range((number, NodeId(0))..=(number, NodeId(u64::MAX)))
                .map(|((_, node), c)| {
                    let depth = if log_scan { c.cost.depth_log_scan(c.items) } else { c.cost.depth() };
                    (*node, depth)
                })
                .collect();
            if charges.is_empty() {
                continue;
            }
            charges.sort_by_key(|(node, _)| (node.level(), node.0));
            match flow(phase, part) {
                Flow::Down => clock.down(phase, &charges),
                Flow::Up => clock.up(phase, &charges),
                Flow::Local => clock.local(phase, &charges),
            }
        }
        clock
    }

    fn push(
        &mut self,
        node: NodeId,
        phase: Phase,
        depth: u64,
        from: (u64, Option<usize>),
    ) -> (u64, Option<usize>) {
        self.steps.push((PathStep { node, phase, depth }, from.1));
        let end = (from.0 + depth, Some(self.steps.len() - 1));
        if end.0 > self.last.0 || self.last.1.is_none() {
            self.last = end;
        }
        end
    }

    /// The root starts when everything before has ended; a node when its parent has.
    fn down(&mut self, phase: Phase, charges: &[(NodeId, u64)]) {
        let barrier = self.last;
        let mut ends: BTreeMap<NodeId, (u64, Option<usize>)> = BTreeMap::new();
        for &(node, depth) in charges {
            let from = nearest_ancestor(&ends, node).unwrap_or(barrier);
            let end = self.push(node, phase, depth, from);
            ends.insert(node, end);
        }
        self.ends = ends;
    }

    /// A node starts when its children, or for a leaf its own last phase, have ended.
    fn up(&mut self, phase: Phase, charges: &[(NodeId, u64)]) {
        let before = std::mem::take(&mut self.ends);
        let barrier = self.last;
        let charged: BTreeSet<NodeId> = charges.iter().map(|c| c.0).collect();
        let mut pending: BTreeMap<NodeId, (u64, Option<usize>)> = BTreeMap::new();
        for (&node, &end) in &before {
            let mut at = Some(node);
            while let Some(n) = at.filter(|n| !charged.contains(n)) {
                at = n.parent();
            }
            if let Some(n) = at {
                later(pending.entry(n).or_insert(end), end);
            }
        }
        let mut ends = BTreeMap::new();
        for &(node, depth) in charges.iter().rev() {
            let above = || nearest_ancestor(&before, node).unwrap_or(barrier);
            let from = pending.get(&node).copied().unwrap_or_else(above);
            let end = self.push(node, phase, depth, from);
            ends.insert(node, end);
            if let Some(parent) = node.parent() {
                later(pending.entry(parent).or_insert(end), end);
            }
        }
        self.ends = ends;
    }

    /// A node goes on from its own last phase.
    fn local(&mut self, phase: Phase, charges: &[(NodeId, u64)]) {
        let barrier = self.last;
        for &(node, depth) in charges {
            let from = nearest_ancestor(&self.ends, node).unwrap_or(barrier);
            let end = self.push(node, phase, depth, from);
            self.ends.insert(node, end);
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
fn later(slot: &mut (u64, Option<usize>), end: (u64, Option<usize>)) {
    if end.0 > slot.0 {
        *slot = end;
    }
}

fn nearest_ancestor(
    ends: &BTreeMap<NodeId, (u64, Option<usize>)>,
    node: NodeId,
) -> Option<(u64, Option<usize>)> {
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
    use super::*;
    use septet_geometry::cost::Cost;

    fn cost(trips: usize) -> Cost {
        let mut c = Cost::ZERO;
        c.sequential(trips, (), |(), _| ());
        c
    }

    #[test]
    fn depth_is_the_longest_chain_and_the_path_adds_up() {
        let mut part = LedgerPart::default();
        let (l, r) = (NodeId(2), NodeId(3));
        part.charge(Phase::Partition, NodeId::ROOT, cost(5), 10);
        part.charge(Phase::Partition, l, cost(1), 4);
        part.charge(Phase::Partition, r, cost(7), 6);
        part.charge(Phase::Hulls, l, cost(20), 4);
        part.charge(Phase::Hulls, r, cost(3), 6);
        part.charge(Phase::Merge, NodeId::ROOT, cost(1), 2);
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
        part.charge(Phase::Radii, ll, cost(2), 4);
        part.charge(Phase::Radii, r, cost(3), 4);
        // The left child: itself, then a leaf. The root: itself, then beside each other left and leaf, right.
        for (level, node, steps) in
            [(1, l, 5), (1, ll, 7), (0, NodeId::ROOT, 11), (0, l, 1), (0, ll, 2), (0, r, 4)]
        {
            part.charge_correction(level, node, cost(steps), 10);
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
    fn parts_survive_the_wire_and_merge_in_any_order() {
        let mut a = LedgerPart::default();
        a.charge(Phase::Partition, NodeId::ROOT, cost(5), 10);
        a.tally(3, Phase::Partition).messages = 2;
        a.facts(NodeId::ROOT).population = 20;
        let mut b = LedgerPart::default();
        b.charge(Phase::Partition, NodeId::ROOT, cost(5), 10);
        b.facts(NodeId(2)).edges = 4;
        assert_eq!(LedgerPart::from_words(&a.to_words()).as_ref(), Some(&a));
        assert_eq!(LedgerPart::from_words(&a.to_words()[..5]), None);
        let (mut ab, mut ba) = (a.clone(), b.clone());
        ab.merge(&b);
        ba.merge(&a);
        assert_eq!(ab, ba);
        assert_eq!(ab.charges[&(Phase::Partition as u8, NodeId::ROOT)].cost.depth(), 5);
        assert_eq!(ab.charges[&(Phase::Partition as u8, NodeId::ROOT)].items, 20);
    }
}
