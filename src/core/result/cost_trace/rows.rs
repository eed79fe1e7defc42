//! Rows of a cost trace: chains, barriers and subproblems.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::cost::{Step, Tape};
use septet_protocol::ids::{Group, NodeId, Phase, Rank};

/// A row of a cost trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CostRow {
    /// The phase.
    pub phase: Phase,
    /// The subproblem. `None` for a barrier of a whole phase.
    pub node: Option<NodeId>,
    /// The step of a phase in which all subproblems step together, or the level of the ancestor whose balls the bottom-up
    /// correction corrects.
    pub step: Option<u32>,
    /// The rank. `None` for a barrier.
    pub rank: Option<Rank>,
    /// The round in which the rank charged the call. `None` for a barrier.
    pub round: Option<u32>,
    /// The call or the vector step. `None` for a barrier.
    pub entry: Option<Step>,
    /// Positions of the rows that end before this row starts. They are smaller than the position of this row.
    pub after: Vec<u64>,
}

/// The position of a row.
pub(super) type RowId = u64;

/// The phase, the subproblem and the step of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) phase: Phase,
    pub(super) node: Option<NodeId>,
    pub(super) step: Option<u32>,
}

impl Place {
    /// Returns the place of rows that belong to a whole phase.
    pub(super) fn of_phase(phase: Phase) -> Self {
        Place { phase, node: None, step: None }
    }
}

/// A round of a subproblem. The leader follows the members that charge in the same round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Stage {
    pub(super) round: u32,
    pub(super) is_leader: bool,
}

/// The calls for a subproblem: by round, then by rank.
pub(super) type Stages = BTreeMap<Stage, BTreeMap<Rank, Tape>>;

/// The rows so far.
#[derive(Default)]
pub(super) struct Rows {
    rows: Vec<CostRow>,
    /// The rows of each group that no other row names. Each group has an order of its own.
    open: BTreeMap<Group, BTreeSet<RowId>>,
}

impl Rows {
    fn push(&mut self, row: CostRow) -> RowId {
        let id = self.rows.len() as RowId;
        for open in self.open.values_mut() {
            for before in &row.after {
                open.remove(before);
            }
        }
        self.open.entry(row.phase.group()).or_default().insert(id);
        self.rows.push(row);
        id
    }

    /// Appends a barrier.
    pub(super) fn barrier(&mut self, place: Place, after: Vec<RowId>) -> RowId {
        let Place { phase, node, step } = place;
        self.push(CostRow { phase, node, step, rank: None, round: None, entry: None, after })
    }

    /// Returns the only row of `after`, or a barrier that follows all of them.
    pub(super) fn join(&mut self, place: Place, after: Vec<RowId>) -> RowId {
        if let [only] = after[..] { only } else { self.barrier(place, after) }
    }

    /// Returns the rows of a group that no other row names.
    pub(super) fn open(&self, group: Group) -> Vec<RowId> {
        self.open.get(&group).into_iter().flatten().copied().collect()
    }

    /// Returns the rows of all other groups that no other row names.
    pub(super) fn open_elsewhere(&self, group: Group) -> Vec<RowId> {
        let others = self.open.iter().filter(|(other, _)| **other != group);
        others.flat_map(|(_, open)| open).copied().collect()
    }

    /// Appends the calls for a subproblem, which start after the rows `start`. Returns the last row.
    pub(super) fn subproblem(&mut self, place: Place, stages: Stages, start: Vec<RowId>) -> RowId {
        let mut front = start;
        for (Stage { round, .. }, ranks) in stages {
            if ranks.len() > 1 {
                front = vec![self.join(place, front)];
            }
            let chains = ranks.into_iter().map(|(rank, tape)| {
                let steps = tape.into_steps().into_iter();
                steps.fold(front.clone(), |after, step| vec![self.call(place, (rank, round), step, after)])
            });
            front = chains.collect::<Vec<_>>().concat();
        }
        self.join(place, front)
    }

    fn call(&mut self, place: Place, (rank, round): (Rank, u32), step: Step, after: Vec<RowId>) -> RowId {
        let Place { phase, node, step: number } = place;
        let (rank, round, entry) = (Some(rank), Some(round), Some(step));
        self.push(CostRow { phase, node, step: number, rank, round, entry, after })
    }

    pub(super) fn finish(self) -> Vec<CostRow> {
        self.rows
    }
}
