//! The fold of a subtree: all that totals need of its charges.
//!
//! **Statement.** [`Fold::of_node`] joins the folds of a node's children with the node's own charges. The result is
//! the fold of the node's subtree, wherever the folds of the children were computed: see [`super::chains`]. So a rank
//! can fold the subtrees that it owns, a leader can join two folds, and a shared node travels as one row. The size of a
//! fold does not depend on the number of nodes. It is proportional to the number of phases times the number of levels,
//! plus the number of steps.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::cost::Price;

use super::chains::{Chains, Row};
use super::plan::{Plan, Stage};
use crate::ids::{ByGroup, Flow, NodeId, Phase};
use crate::ledger::brent::{BrentCurve, steps_on};
use crate::ledger::part::{Charge, LedgerPart};
use crate::ledger::totals::{PathStep, Total};
use crate::ledger::words::Reader;

/// Length of the longest chain of one phase alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::ledger) struct Depths {
    /// Length; a scan counts 1.
    pub(super) depth: u64,
    /// Length if a scan of `m` items counts `ceil(log2 m)`.
    pub(super) depth_log_scan: u64,
}

impl Depths {
    fn of(charge: &Charge) -> Self {
        Depths { depth: charge.cost.depth(), depth_log_scan: charge.cost.depth_log_scan(charge.items) }
    }

    fn or_longer(&mut self, other: Depths) {
        self.depth = self.depth.max(other.depth);
        self.depth_log_scan = self.depth_log_scan.max(other.depth_log_scan);
    }

    fn append(&mut self, next: Depths) {
        self.depth += next.depth;
        self.depth_log_scan += next.depth_log_scan;
    }
}

/// The chains of a subtree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Tree {
    /// In the order of the plan's phases. Zero for a phase with steps.
    alone: Vec<Depths>,
    chains: ByGroup<Chains>,
}

impl Tree {
    fn of_node(plan: &Plan, node: NodeId, row: &Row, children: Vec<Tree>) -> Tree {
        let alone = plan.phases.iter().enumerate().map(|(at, &(phase, flow))| {
            let own = row.charge(phase).map(Depths::of).unwrap_or_default();
            let mut below = Depths::default();
            for child in &children {
                below.or_longer(child.alone[at]);
            }
            match flow {
                Flow::Down | Flow::Up => below.append(own),
                Flow::Local => below.or_longer(own),
                Flow::Steps => {}
            }
            below
        });
        let alone = alone.collect();
        let mut below = ByGroup::<Vec<Chains>>::default();
        for child in children {
            below = below.zip(child.chains).map(|(mut all, chains)| {
                all.push(chains);
                all
            });
        }
        let stages = plan.stages.as_ref().zip(below);
        Tree { alone, chains: stages.map(|(stages, below)| Chains::of_node(stages, node, row, below)) }
    }
}

/// Nodes that work at the same time: the nodes of a level in a phase, or those of one step of a phase with steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Step {
    price: Price,
    depth_log_scan: u64,
    /// The node with the largest depth, and the smallest such node.
    deepest: NodeId,
}

impl Step {
    fn of(node: NodeId, charge: &Charge) -> Self {
        Step { price: charge.cost, depth_log_scan: Depths::of(charge).depth_log_scan, deepest: node }
    }

    fn join(&mut self, other: Step) {
        let key = |step: &Step| (step.price.depth(), std::cmp::Reverse(step.deepest));
        if key(&other) > key(self) {
            self.deepest = other.deepest;
        }
        self.price.join(other.price);
        self.depth_log_scan = self.depth_log_scan.max(other.depth_log_scan);
    }
}

/// A phase, and the number of a step or of a level.
type StepKey = (Phase, u32);

/// All steps of a subtree, sorted by phase and number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Steps(Vec<(StepKey, Step)>);

impl Steps {
    fn of_row(plan: &Plan, node: NodeId, row: &Row) -> Steps {
        let has_steps = |phase| plan.phases.contains(&(phase, Flow::Steps));
        let levels = row.charges().filter(|&(phase, _)| !has_steps(phase));
        let levels = levels.map(|(phase, charge)| ((phase, node.level()), Step::of(node, charge)));
        let steps = row.steps().map(|(phase, step, charge)| ((phase, step), Step::of(node, charge)));
        let mut all: Vec<_> = levels.chain(steps).collect();
        all.sort_unstable_by_key(|&(key, _)| key);
        Steps(all)
    }

    /// Merges two sorted lists.
    fn join(self, other: Steps) -> Steps {
        let mut all = Vec::with_capacity(self.0.len() + other.0.len());
        let mut others = other.0.into_iter().peekable();
        for (key, mut step) in self.0 {
            while let Some(before) = others.next_if(|(of, _)| *of < key) {
                all.push(before);
            }
            if let Some((_, same)) = others.next_if(|(of, _)| *of == key) {
                step.join(same);
            }
            all.push((key, step));
        }
        all.extend(others);
        Steps(all)
    }

    fn push_words(&self, out: &mut Vec<u64>) {
        out.push(self.0.len() as u64);
        for ((phase, number), step) in &self.0 {
            out.extend([*phase as u64, u64::from(*number), step.depth_log_scan, step.deepest.0]);
            out.extend(step.price.to_parts());
        }
    }

    fn read(words: &mut Reader<'_>) -> Option<Steps> {
        let [count] = words.take()?;
        let mut all: Vec<(StepKey, Step)> = Vec::new();
        for _ in 0..count {
            let key = (words.phase()?, words.small()?);
            let ([depth_log_scan], deepest, price) = (words.take()?, words.node()?, words.take()?);
            if all.last().is_some_and(|(last, _)| *last >= key) {
                return None;
            }
            all.push((key, Step { price: Price::from_parts(price), depth_log_scan, deepest }));
        }
        Some(Steps(all))
    }

    fn of_phase(&self, phase: Phase) -> impl Iterator<Item = &Step> {
        self.0.iter().filter(move |((of, _), _)| *of == phase).map(|(_, step)| step)
    }
}

/// The charges of a subtree, folded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Fold {
    tree: Tree,
    steps: Steps,
}

/// The folds of disjoint subtrees, by their roots.
pub(crate) type Folds = BTreeMap<NodeId, Fold>;

/// A node whose fold is not yet joined with that of its parent.
enum Open {
    /// The charges of the node, and the folds of its children, exterior child first.
    Row(Row, Vec<Fold>),
    Folded(Fold),
}

impl Default for Open {
    fn default() -> Self {
        Open::Row(Row::default(), Vec::new())
    }
}

impl Open {
    /// Adds the fold of a child. A node that is folded already has its children, so it takes no other.
    fn add_child(&mut self, fold: Fold) {
        if let Open::Row(_, children) = self {
            children.push(fold);
        }
    }
}

impl Fold {
    /// Folds a node's charges and the folds of its children, interior child first.
    pub(super) fn of_node(plan: &Plan, node: NodeId, row: &Row, children: Vec<Fold>) -> Fold {
        let mut steps = Steps::of_row(plan, node, row);
        let mut trees = Vec::with_capacity(children.len());
        for child in children {
            steps = steps.join(child.steps);
            trees.push(child.tree);
        }
        Fold { tree: Tree::of_node(plan, node, row, trees), steps }
    }

    /// Folds the charges of the subtrees of `roots`, which are disjoint. `below` contains the folds of subtrees whose rows
    /// are not in the part. The part has no rows outside of the subtrees, and its charges are settled (see
    /// [`super::settle`]). A subtree without charges has no fold.
    pub(crate) fn of_subtrees(
        plan: &Plan,
        roots: &BTreeSet<NodeId>,
        part: &LedgerPart,
        below: Folds,
    ) -> Folds {
        let mut open: BTreeMap<NodeId, Open> = BTreeMap::new();
        open.extend(rows(plan, part).into_iter().map(|(node, row)| (node, Open::Row(row, Vec::new()))));
        open.extend(below.into_iter().map(|(node, fold)| (node, Open::Folded(fold))));
        let mut folds = Folds::new();
        // Children come before their parents, and exterior children before interior children.
        while let Some((node, entry)) = open.pop_last() {
            let fold = match entry {
                Open::Folded(fold) => fold,
                Open::Row(row, mut children) => {
                    children.reverse();
                    Fold::of_node(plan, node, &row, children)
                }
            };
            match node.parent().filter(|_| !roots.contains(&node)) {
                Some(parent) => open.entry(parent).or_default().add_child(fold),
                None => drop(folds.insert(node, fold)),
            }
        }
        folds
    }

    /// Folds the charges of the whole tree.
    pub(crate) fn of_tree(plan: &Plan, part: &LedgerPart, below: Folds) -> Fold {
        let whole =
            Fold::of_subtrees(plan, &BTreeSet::from([NodeId::ROOT]), part, below).remove(&NodeId::ROOT);
        whole.unwrap_or_else(|| Fold::empty(plan))
    }

    /// Returns the fold of a subtree without charges.
    pub(crate) fn empty(plan: &Plan) -> Fold {
        Fold::of_node(plan, NodeId::ROOT, &Row::default(), Vec::new())
    }

    /// Appends the fold as words.
    pub(crate) fn push_words(&self, plan: &Plan, out: &mut Vec<u64>) {
        let Fold { tree: Tree { alone, chains }, steps } = self;
        out.extend(alone.iter().flat_map(|depths| [depths.depth, depths.depth_log_scan]));
        chains.as_ref().zip(plan.stages.as_ref()).map(|(chains, stages)| chains.push_words(stages, out));
        steps.push_words(out);
    }

    /// Reads a fold. Its lists have the lengths that the plan requires.
    pub(crate) fn read(plan: &Plan, words: &mut Reader<'_>) -> Option<Fold> {
        let depths = |words: &mut Reader<'_>| {
            let [depth, depth_log_scan] = words.take()?;
            Some(Depths { depth, depth_log_scan })
        };
        let alone = plan.phases.iter().map(|_| depths(words)).collect::<Option<_>>()?;
        let chains = plan.stages.as_ref().map(|stages| Chains::read(stages, words)).all()?;
        Some(Fold { tree: Tree { alone, chains }, steps: Steps::read(words)? })
    }

    /// Returns the length of the longest chain of each phase of the plan alone.
    pub(in crate::ledger) fn alone(&self, plan: &Plan) -> BTreeMap<Phase, Depths> {
        let of = |(&(phase, flow), &depths): (&(Phase, Flow), &Depths)| match flow {
            Flow::Steps => (phase, self.depths_of_steps(phase)),
            _ => (phase, depths),
        };
        plan.phases.iter().zip(&self.tree.alone).map(of).collect()
    }

    /// Returns the total of each group on `processors` processors, and the longest chain of its phases.
    pub(in crate::ledger) fn totals(&self, plan: &Plan, processors: u64) -> ByGroup<(Total, Vec<PathStep>)> {
        let groups = plan.stages.as_ref().zip(self.tree.chains.as_ref());
        groups.map(|(stages, chains)| self.total(stages, chains, processors))
    }

    fn total(&self, stages: &[Stage], chains: &Chains, processors: u64) -> (Total, Vec<PathStep>) {
        let mut total = Total { brent_at: BrentCurve::up_to(processors), ..Total::default() };
        let mut path = Vec::new();
        for (stage, longest) in stages.iter().zip(chains.longest()) {
            let depths = match stage {
                Stage::Chained(phases) => {
                    for &(phase, _) in phases {
                        self.add_steps(phase, processors, &mut total);
                    }
                    path.extend(&longest.chain.steps);
                    Depths { depth: longest.chain.depth, depth_log_scan: longest.depth_log_scan }
                }
                &Stage::Steps(phase) => {
                    self.add_steps(phase, processors, &mut total);
                    path.extend(self.of_steps(phase));
                    self.depths_of_steps(phase)
                }
            };
            total.depth += depths.depth;
            total.depth_log_scan += depths.depth_log_scan;
        }
        (total, path)
    }

    /// Adds the work of a phase, and its share of Brent's bound.
    fn add_steps(&self, phase: Phase, processors: u64, total: &mut Total) {
        for Step { price, .. } in self.steps.of_phase(phase) {
            total.work += price.work();
            total.exact_tests += price.exact_tests();
            total.brent += steps_on(*price, processors);
            total.brent_at.add_step(*price);
        }
    }

    /// Returns the exact tests of a phase.
    pub(in crate::ledger) fn exact_tests(&self, phase: Phase) -> u64 {
        self.steps.of_phase(phase).map(|step| step.price.exact_tests()).sum()
    }

    /// Returns the longest chain of a phase with steps.
    fn of_steps(&self, phase: Phase) -> impl Iterator<Item = PathStep> {
        let step = move |s: &Step| PathStep { node: s.deepest, phase, depth: s.price.depth() };
        self.steps.of_phase(phase).map(step).filter(|step| step.depth > 0)
    }

    fn depths_of_steps(&self, phase: Phase) -> Depths {
        let mut sum = Depths::default();
        for step in self.steps.of_phase(phase) {
            sum.append(Depths { depth: step.price.depth(), depth_log_scan: step.depth_log_scan });
        }
        sum
    }
}

/// Returns the charges of each node.
fn rows(plan: &Plan, part: &LedgerPart) -> BTreeMap<NodeId, Row> {
    let mut rows: BTreeMap<NodeId, Row> = BTreeMap::new();
    for &(phase, flow) in &plan.phases {
        for (node, &charge) in part.members(phase) {
            rows.entry(node).or_default().push(phase, charge);
        }
        if flow == Flow::Steps {
            for (step, node, &charge) in part.steps(phase) {
                rows.entry(node).or_default().push_step(phase, step, charge);
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::super::plan::PhaseSet;
    use super::*;
    use crate::ledger::part::Account;

    /// A tree of five levels with holes, and charges that differ for every node and phase.
    fn part() -> LedgerPart {
        let mut part = LedgerPart::default();
        let mut random = 7u64;
        let mut next = |below: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) % below
        };
        for node in (1..64).map(NodeId) {
            for phase in Phase::ALL {
                let cost = Price::from_parts([next(100), next(40), next(4), next(3), next(9)]);
                match phase.flow() {
                    Flow::Steps if next(3) > 0 => {
                        part.charge(Account::member(phase, node), cost, 1 + next(50));
                        part.charge(Account::step(phase, next(5) as u32, node), cost, 1 + next(50));
                    }
                    _ if next(3) > 0 => part.charge(Account::member(phase, node), cost, 1 + next(50)),
                    _ => {}
                }
            }
        }
        part
    }

    /// Folds the tree with a cut below every node for which `is_shared` returns `false`.
    fn cut(plan: &Plan, node: NodeId, part: &LedgerPart, is_shared: &impl Fn(NodeId) -> bool) -> Fold {
        if !is_shared(node) {
            let mut below = part.clone();
            below.charges.retain(|account, _| node.contains(account.node));
            let fold = Fold::of_subtrees(plan, &BTreeSet::from([node]), &below, Folds::new()).remove(&node);
            return fold.unwrap_or_else(|| Fold::empty(plan));
        }
        let row = rows(plan, part).remove(&node).unwrap_or_default();
        let children = [0, 1].map(|side| cut(plan, node.child(side), part, is_shared));
        Fold::of_node(plan, node, &row, children.into())
    }

    #[test]
    fn a_fold_is_the_same_wherever_the_tree_is_cut() {
        let part = part();
        let plan = Plan::of(PhaseSet::of(&part));
        let whole = Fold::of_tree(&plan, &part, Folds::new());
        for seed in 0..40 {
            let is_cut = |node: NodeId| (node.0 * 0x9E37_79B9 + seed * 77).is_multiple_of(5);
            let is_shared = |node: NodeId| node.level() < 5 && !is_cut(node);
            assert_eq!(cut(&plan, NodeId::ROOT, &part, &is_shared), whole, "{seed}");
        }
        let (total, path) = whole.totals(&plan, 100).paper;
        assert_eq!(path.iter().map(|step| step.depth).sum::<u64>(), total.depth);
        assert!(total.depth > 500 && total.depth_log_scan > total.depth && total.brent > total.depth);
    }
}
