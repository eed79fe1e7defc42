//! The order of the subproblems of each phase.
//!
//! 1. A phase that goes down the tree starts at a node when it has ended at the nearest ancestor. At the first node, it
//!    starts when all earlier phases have ended.
//! 2. A phase that goes up the tree starts at a node when it has ended at all nodes below, and when the previous phase has
//!    ended there.
//! 3. A local phase starts at a node when the previous phase has ended at the node or at its nearest ancestor.
//! 4. If all subproblems step together, a step starts when everything before it has ended.
//! 5. The bottom-up correction goes up the tree. At each node, it descends to the leaves below.

use std::collections::{BTreeMap, BTreeSet};

use septet_protocol::ids::{Flow, Group, NodeId, Phase, Rank};
use septet_protocol::ledger::Role;
use septet_workers::config::{ChargeRecord, ChargesByRank};

use super::rows::{CostRow, Place, RowId, Rows, Stage, Stages};

/// The number of a step, if there is one, and a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Site {
    step: Option<u32>,
    /// The level of the node.
    level: u32,
    node: NodeId,
}

impl Site {
    fn of(role: Role, node: NodeId) -> Self {
        let step = match role {
            Role::Pass(step) | Role::Step(step) => Some(step),
            Role::Member | Role::Leader => None,
        };
        Site { step, level: node.level(), node }
    }

    fn place(self, phase: Phase) -> Place {
        Place { phase, node: Some(self.node), step: self.step }
    }
}

/// The calls of a phase: steps in their order, then nodes from the root down.
type Calls = BTreeMap<Site, Stages>;

/// The last row of each node.
type Ends = BTreeMap<NodeId, RowId>;

/// The rows of the phases so far.
#[derive(Default)]
pub(super) struct Order {
    rows: Rows,
    /// The rows at which the previous phase of each group ended.
    ends: BTreeMap<Group, Ends>,
}

/// A phase, and the rows before it.
struct Current {
    phase: Phase,
    /// The rows of the group that have no followers.
    open: Vec<RowId>,
    /// The barrier after `open`, once a row needs it.
    barrier: Option<RowId>,
    /// The gate: the barrier after the rows of the other groups, if there are new ones.
    gate: Option<RowId>,
}

impl Order {
    /// Orders the charges of all ranks, phase after phase. The first row is a barrier that every other row follows, and
    /// the last row is a barrier that follows every other row.
    pub(super) fn run(mut self, charges: ChargesByRank) -> Vec<CostRow> {
        self.rows.barrier(Place::of_phase(Phase::Load), Vec::new());
        let mut previous = Group::Machine;
        for (phase, calls) in by_phase(charges) {
            let group = phase.group();
            let open = self.rows.open(group);
            let mut current = Current { phase, open, barrier: None, gate: None };
            if group != previous {
                let elsewhere = self.rows.open_elsewhere(group);
                current.gate = Some(self.rows.barrier(Place::of_phase(phase), elsewhere));
            }
            previous = group;
            self.phase(current, calls);
        }
        let mut open = self.rows.open(Group::Machine);
        open.extend(self.rows.open_elsewhere(Group::Machine));
        self.rows.barrier(Place::of_phase(Phase::Done), open);
        self.rows.finish()
    }

    fn phase(&mut self, current: Current, calls: Calls) {
        let group = current.phase.group();
        let before = self.ends.remove(&group).unwrap_or_default();
        let has_steps = calls.keys().any(|site| site.step.is_some());
        let ends = match current.phase.flow() {
            Flow::Steps if has_steps => self.steps(current, calls),
            Flow::Down if has_steps => self.up(current, &before, corrections(calls)),
            Flow::Up => self.up(current, &before, subproblems(calls)),
            Flow::Down => self.down(current, Ends::new(), calls),
            Flow::Local | Flow::Steps => self.down(current, before, calls),
        };
        self.ends.insert(group, ends);
    }

    /// Starts each node when its nearest ancestor in `ends` has ended, or when everything before the phase has ended.
    fn down(&mut self, mut current: Current, mut ends: Ends, calls: Calls) -> Ends {
        for (site, stages) in calls {
            let from = nearest_ancestor(&ends, site.node);
            let start = self.start(&mut current, from.into_iter().collect());
            ends.insert(site.node, self.rows.subproblem(site.place(current.phase), stages, start));
        }
        ends
    }

    /// Starts each node when all nodes below have ended, and when the previous phase has ended there.
    fn up(&mut self, mut current: Current, before: &Ends, tasks: Tasks) -> Ends {
        let nodes: BTreeSet<NodeId> = tasks.keys().map(|(_, node)| *node).collect();
        let mut pending: BTreeMap<NodeId, Vec<RowId>> = BTreeMap::new();
        for (&node, &end) in before {
            if let Some(at) = nearest(&nodes, Some(node)) {
                pending.entry(at).or_default().push(end);
            }
        }
        let mut ends = Ends::new();
        for ((_, node), calls) in tasks.into_iter().rev() {
            let from = pending.remove(&node).or_else(|| nearest_ancestor(before, node).map(|end| vec![end]));
            let start = self.start(&mut current, from.unwrap_or_default());
            let end = self.descent(current.phase, calls, &start);
            ends.insert(node, end);
            if let Some(parent) = nearest(&nodes, node.parent()) {
                pending.entry(parent).or_default().push(end);
            }
        }
        ends
    }

    /// Starts each step when everything before it has ended. The next phase waits for all nodes of the last step.
    fn steps(&mut self, mut current: Current, calls: Calls) -> Ends {
        let mut number = None;
        for (site, stages) in calls {
            if number.is_some() && number != site.step {
                let open = self.rows.open(current.phase.group());
                current = Current { phase: current.phase, open, barrier: None, gate: None };
            }
            number = site.step;
            let start = self.start(&mut current, Vec::new());
            self.rows.subproblem(site.place(current.phase), stages, start);
        }
        Ends::new()
    }

    /// Runs the calls from a node down the tree. Returns the row that follows all of them.
    fn descent(&mut self, phase: Phase, calls: Calls, start: &[RowId]) -> RowId {
        let (mut ends, mut open) = (Ends::new(), BTreeSet::new());
        let top = calls.keys().next().map(|site| site.place(phase));
        for (site, stages) in calls {
            let from = nearest_ancestor(&ends, site.node);
            let start = from.map_or_else(|| start.to_vec(), |end| vec![end]);
            open.retain(|row| !start.contains(row));
            let end = self.rows.subproblem(site.place(phase), stages, start);
            ends.insert(site.node, end);
            open.insert(end);
        }
        self.rows.join(top.unwrap_or(Place::of_phase(phase)), open.into_iter().collect())
    }

    /// Returns the rows after which a node starts: the given ones, or the barrier before the phase. Rows of earlier phases
    /// do not follow the new rows of other groups. So the gate is added, unless one of the rows comes after it.
    fn start(&mut self, current: &mut Current, from: Vec<RowId>) -> Vec<RowId> {
        let Current { phase, barrier, gate, .. } = *current;
        let is_late = |rows: &[RowId]| gate.is_none_or(|gate| rows.iter().any(|&row| row > gate));
        let with_gate = |mut rows: Vec<RowId>| {
            if !is_late(&rows) {
                rows.extend(gate);
            }
            rows
        };
        if !from.is_empty() {
            return with_gate(from);
        }
        let rows = &mut self.rows;
        let open = &mut current.open;
        let made =
            barrier.unwrap_or_else(|| rows.join(Place::of_phase(phase), with_gate(std::mem::take(open))));
        current.barrier = Some(made);
        vec![made]
    }
}

/// The tasks of a phase that goes up the tree, by the level and the node that each belongs to.
type Tasks = BTreeMap<(u32, NodeId), Calls>;

/// Returns the calls of each phase, in the order of the phases.
fn by_phase(charges: ChargesByRank) -> BTreeMap<Phase, Calls> {
    let mut phases: BTreeMap<Phase, Calls> = BTreeMap::new();
    let all = charges.into_iter().flat_map(|(rank, records)| records.into_iter().map(move |r| (rank, r)));
    for (rank, ChargeRecord { account, round, tape }) in all {
        let calls = phases.entry(account.phase).or_default();
        let stages = calls.entry(Site::of(account.role, account.node)).or_default();
        let stage = Stage { round, is_leader: account.role == Role::Leader };
        let ranks: &mut BTreeMap<Rank, _> = stages.entry(stage).or_default();
        ranks.entry(rank).or_default().append(tape);
    }
    phases
}

/// Returns one task for each node.
fn subproblems(calls: Calls) -> Tasks {
    calls
        .into_iter()
        .map(|(site, stages)| ((site.level, site.node), BTreeMap::from([(site, stages)])))
        .collect()
}

/// Returns one task for each node whose balls the bottom-up correction corrects: the descent below the node.
fn corrections(calls: Calls) -> Tasks {
    let mut tasks = Tasks::new();
    for (site, stages) in calls {
        let level = site.step.unwrap_or(site.level).min(site.level);
        let top = NodeId(site.node.0 >> (site.level - level));
        tasks.entry((level, top)).or_default().insert(site, stages);
    }
    tasks
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
fn nearest_ancestor(ends: &Ends, node: NodeId) -> Option<RowId> {
    let mut at = Some(node);
    while let Some(node) = at {
        if let Some(&end) = ends.get(&node) {
            return Some(end);
        }
        at = node.parent();
    }
    None
}
