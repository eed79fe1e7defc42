//! The longest chains in a subtree.
//!
//! **Statement.** A subtree has a summary from which the rest of the tree needs nothing else: for each stage, the
//! longest chain from the start of its root to the end of each phase at its root, and the longest chain of all. The
//! summary of a node follows from its charges and the summaries of its two children. So a rank can fold a subtree that
//! it owns, and a leader can join two subtrees with one row, its own charges. Every order of joining gives the same
//! summary.
//!
//! **Why.** Within a stage, a chain enters a subtree only at its root: at the end of the phase that goes down, or at the
//! start of the stage. It leaves the subtree only at its root, in a phase that goes up. In between, the times within
//! the subtree are the time of entry plus a length that depends only on charges of the subtree.
//!
//! **Work.** For each node, its number of phases.

use std::collections::VecDeque;

use super::plan::Stage;
use crate::ids::{Flow, NodeId, Phase};
use crate::ledger::part::Charge;
use crate::ledger::totals::PathStep;
use crate::ledger::words::Reader;

/// A chain of dependent phases at subproblems.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Chain {
    /// Length; a scan counts 1.
    pub(super) depth: u64,
    /// Its steps of positive length, first step first.
    pub(super) steps: VecDeque<PathStep>,
}

impl Chain {
    fn append(&mut self, step: PathStep) {
        self.depth += step.depth;
        if step.depth > 0 {
            self.steps.push_back(step);
        }
    }

    /// Puts a chain in front of this one.
    fn prepend(&mut self, before: &Chain) {
        self.depth += before.depth;
        for &step in before.steps.iter().rev() {
            self.steps.push_front(step);
        }
    }

    /// Keeps the longer chain, or this one if the lengths are equal.
    fn or_longer(&mut self, other: Chain) {
        if other.depth > self.depth {
            *self = other;
        }
    }
}

/// The longest chain if a scan counts 1, and the length of the longest chain if a scan of `m` items counts
/// `ceil(log2 m)`. These may be different chains.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Longest {
    pub(super) chain: Chain,
    pub(super) depth_log_scan: u64,
}

impl Longest {
    fn append(&mut self, node: NodeId, phase: Phase, charge: &Charge) {
        self.chain.append(PathStep { node, phase, depth: charge.cost.depth() });
        self.depth_log_scan += charge.cost.depth_log_scan(charge.items);
    }

    fn prepend(&mut self, before: &Longest) {
        self.chain.prepend(&before.chain);
        self.depth_log_scan += before.depth_log_scan;
    }

    fn or_longer(&mut self, other: Longest) {
        self.chain.or_longer(other.chain);
        self.depth_log_scan = self.depth_log_scan.max(other.depth_log_scan);
    }

    fn push_words(&self, out: &mut Vec<u64>) {
        out.extend([self.depth_log_scan, self.chain.steps.len() as u64]);
        for step in &self.chain.steps {
            out.extend([step.node.0, step.phase as u64, step.depth]);
        }
    }

    fn read(words: &mut Reader<'_>) -> Option<Self> {
        let [depth_log_scan, steps] = words.take()?;
        let mut chain = Chain::default();
        for _ in 0..steps {
            let (node, phase, [depth]) = (words.node()?, words.phase()?, words.take()?);
            chain.depth.checked_add(depth)?;
            chain.append(PathStep { node, phase, depth });
        }
        Some(Longest { chain, depth_log_scan })
    }
}

/// The charges of one node. A phase without a charge takes no time.
#[derive(Debug, Default)]
pub(super) struct Row {
    charges: Vec<(Phase, Charge)>,
    steps: Vec<(Phase, u32, Charge)>,
}

impl Row {
    /// Adds the charge of another phase.
    pub(super) fn push(&mut self, phase: Phase, charge: Charge) {
        self.charges.push((phase, charge));
    }

    /// Adds the charge of another step.
    pub(super) fn push_step(&mut self, phase: Phase, step: u32, charge: Charge) {
        self.steps.push((phase, step, charge));
    }

    /// Returns the charge of a phase.
    pub(super) fn charge(&self, phase: Phase) -> Option<&Charge> {
        self.charges.iter().find(|(of, _)| *of == phase).map(|(_, charge)| charge)
    }

    /// Returns the charges of phases. That of a phase with steps is the sum of its steps.
    pub(super) fn charges(&self) -> impl Iterator<Item = (Phase, &Charge)> {
        self.charges.iter().map(|(phase, charge)| (*phase, charge))
    }

    /// Returns the charges of steps.
    pub(super) fn steps(&self) -> impl Iterator<Item = (Phase, u32, &Charge)> {
        self.steps.iter().map(|(phase, step, charge)| (*phase, *step, charge))
    }
}

/// The chains of one stage in a subtree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct StageChains {
    /// For each phase that goes up the tree, the longest chain that ends with the phase at the root of the subtree.
    ends: Vec<Longest>,
    /// The longest chain.
    longest: Longest,
}

impl StageChains {
    fn of_node(phases: &[(Phase, Flow)], node: NodeId, row: &Row, mut children: Vec<StageChains>) -> Self {
        let mut end = Longest::default();
        let mut ends = Vec::new();
        for &(phase, flow) in phases {
            if flow == Flow::Up {
                for child in &mut children {
                    end.or_longer(std::mem::take(&mut child.ends[ends.len()]));
                }
            }
            if let Some(charge) = row.charge(phase) {
                end.append(node, phase, charge);
            }
            match flow {
                Flow::Down => children.iter_mut().for_each(|child| child.enter_after(&end)),
                Flow::Up => ends.push(end.clone()),
                Flow::Local | Flow::Steps => {}
            }
        }
        for child in children {
            end.or_longer(child.longest);
        }
        StageChains { ends, longest: end }
    }

    /// Starts all chains when a chain above the subtree has ended.
    fn enter_after(&mut self, above: &Longest) {
        self.ends.iter_mut().for_each(|end| end.prepend(above));
        self.longest.prepend(above);
    }
}

/// The longest chains of the stages of a group of phases, in a subtree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Chains {
    /// In the order of the stages. Empty for a phase with steps.
    stages: Vec<StageChains>,
}

impl Chains {
    /// Computes the chains of a subtree from the charges of its root and the chains of its root's children.
    pub(super) fn of_node(stages: &[Stage], node: NodeId, row: &Row, children: Vec<Chains>) -> Chains {
        let mut children: Vec<_> = children.into_iter().map(|child| child.stages.into_iter()).collect();
        let stages = stages.iter().map(|stage| {
            let below = children.iter_mut().filter_map(Iterator::next).collect();
            match stage {
                Stage::Chained(phases) => StageChains::of_node(phases, node, row, below),
                Stage::Steps(_) => StageChains::default(),
            }
        });
        Chains { stages: stages.collect() }
    }

    /// Appends the chains of these stages as words. A phase with steps has no chains here.
    pub(super) fn push_words(&self, stages: &[Stage], out: &mut Vec<u64>) {
        let chained = stages.iter().zip(&self.stages).filter(|(of, _)| matches!(of, Stage::Chained(_)));
        for (_, stage) in chained {
            for chain in stage.ends.iter().chain([&stage.longest]) {
                chain.push_words(out);
            }
        }
    }

    /// Reads the chains of these stages.
    pub(super) fn read(stages: &[Stage], words: &mut Reader<'_>) -> Option<Chains> {
        let stages = stages.iter().map(|stage| {
            let Stage::Chained(phases) = stage else { return Some(StageChains::default()) };
            let up = phases.iter().filter(|(_, flow)| *flow == Flow::Up);
            let ends = up.map(|_| Longest::read(words)).collect::<Option<_>>()?;
            Some(StageChains { ends, longest: Longest::read(words)? })
        });
        stages.collect::<Option<_>>().map(|stages| Chains { stages })
    }

    /// Returns the longest chain of each stage.
    pub(super) fn longest(&self) -> impl Iterator<Item = &Longest> {
        self.stages.iter().map(|stage| &stage.longest)
    }
}
