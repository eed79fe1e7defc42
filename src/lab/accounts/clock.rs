//! The longest paths through the rows of a cost trace.
//!
//! **Clocks.** A clock measures the longest path through the rows of one phase, of one group of phases, or of one step
//! of Brent's bound. It ignores all other rows.

use std::collections::BTreeMap;

use super::error::AccountError;
use super::price::{self, Price};
use super::row::{Header, Row};
use super::totals::{Accounts, PhaseAccount, TotalAccount};

/// The phases in the paper's total.
const PAPER: [&str; 19] = [
    "octree",
    "sizes",
    "candidates",
    "conflicts",
    "completion",
    "partition",
    "radii",
    "probe",
    "neighbours",
    "summaries",
    "knn-radii",
    "knn-probe",
    "knn",
    "separator-sets",
    "own-sets",
    "graph",
    "independent",
    "hulls",
    "merge",
];

/// The phases in the total of repair.
const REPAIR: [&str; 5] = ["check", "repair", "probe-cells", "certificate", "fallback"];

/// The phases in the total of selection.
const SELECTION: [&str; 1] = ["choice"];

/// The other phases of a run.
const OTHERS: [&str; 6] = ["load", "halo", "pieces", "seam", "collect", "done"];

/// The group of a phase: the total to which it belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    Paper,
    Repair,
    Selection,
    Neither,
}

impl Group {
    /// Returns the group of a phase, or `None` if no phase has this name.
    pub(super) fn of(phase: &str) -> Option<Self> {
        if PAPER.contains(&phase) {
            Some(Group::Paper)
        } else if REPAIR.contains(&phase) {
            Some(Group::Repair)
        } else if SELECTION.contains(&phase) {
            Some(Group::Selection)
        } else {
            OTHERS.contains(&phase).then_some(Group::Neither)
        }
    }
}

/// A step of Brent's bound: the rows of a phase at one level of the tree, or in one step of the phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct BrentStep {
    /// The index of the phase in [`Clocks::phases`].
    phase: usize,
    number: u32,
}

/// The times at which a row ends on the clocks of its phase, its group and its step.
#[derive(Clone, Copy, Debug)]
struct Ends {
    phase: (usize, u64),
    group: (Group, u64),
    step: (Option<BrentStep>, u64),
}

impl Ends {
    /// Returns the ends of a row that starts at these times, or `None` if one is above the largest 64-bit number.
    fn after(self, depth: u64) -> Option<Self> {
        Some(Ends {
            phase: (self.phase.0, self.phase.1.checked_add(depth)?),
            group: (self.group.0, self.group.1.checked_add(depth)?),
            step: (self.step.0, self.step.1.checked_add(depth)?),
        })
    }
}

/// The clocks of the rows so far.
#[derive(Debug, Default)]
pub(super) struct Clocks {
    phases: Vec<PhaseAccount>,
    totals: [TotalAccount; 3],
    /// For each step of Brent's bound, the index of its total, and the work and depth of the step.
    steps: BTreeMap<BrentStep, (usize, Price)>,
    ends: Vec<Ends>,
    /// For each row, whether a later row names it.
    named: Vec<bool>,
}

impl Clocks {
    /// Adds a row.
    pub(super) fn add(&mut self, row: &Row) -> Result<(), AccountError> {
        let expected = self.ends.len() as u64;
        if row.row != expected {
            return Err(AccountError::Missing { expected, found: row.row });
        }
        if row.after.is_empty() && expected > 0 {
            return Err(AccountError::Loose { row: row.row });
        }
        let price = price::of_entry(row.row, &row.entry)?;
        let mut ends = self.start(row)?;
        for &after in &row.after {
            let before = usize::try_from(after).ok().filter(|&at| at < self.ends.len());
            let at = before.ok_or(AccountError::Order { row: row.row, after })?;
            self.named[at] = true;
            let earlier = self.ends[at];
            later(&mut ends.phase, &earlier.phase);
            later(&mut ends.group, &earlier.group);
            later(&mut ends.step, &earlier.step);
        }
        let counted = ends.after(price.depth).and_then(|ends| self.count(ends, price.work).map(|()| ends));
        self.ends.push(counted.ok_or(AccountError::Overflow { row: row.row })?);
        self.named.push(false);
        Ok(())
    }

    /// Returns the clocks of a row, all at time 0.
    fn start(&mut self, row: &Row) -> Result<Ends, AccountError> {
        let unknown = || AccountError::Phase { row: row.row, phase: row.phase.clone() };
        let group = Group::of(&row.phase).ok_or_else(unknown)?;
        let level = match row.node {
            Some(node) => Some(node.checked_ilog2().ok_or(AccountError::Node { row: row.row })?),
            None => None,
        };
        let phase = self.phase(&row.phase);
        let step = row.step.or(level).map(|number| BrentStep { phase, number });
        Ok(Ends { phase: (phase, 0), group: (group, 0), step: (step, 0) })
    }

    /// Returns the index of a phase, which is added if it is new.
    fn phase(&mut self, name: &str) -> usize {
        let at = self.phases.iter().rposition(|account| account.phase == name);
        at.unwrap_or_else(|| {
            self.phases.push(PhaseAccount { phase: name.to_owned(), work: 0, depth: 0 });
            self.phases.len() - 1
        })
    }

    /// Adds the work of a row to its phase, total and step, and keeps the latest ends. Returns `None` if a sum is above
    /// the largest 64-bit number.
    fn count(&mut self, ends: Ends, work: u64) -> Option<()> {
        let phase = &mut self.phases[ends.phase.0];
        phase.work = phase.work.checked_add(work)?;
        phase.depth = phase.depth.max(ends.phase.1);
        let number = match ends.group.0 {
            Group::Paper => 0,
            Group::Repair => 1,
            Group::Selection => 2,
            Group::Neither => return Some(()),
        };
        let total = &mut self.totals[number];
        total.work = total.work.checked_add(work)?;
        total.depth = total.depth.max(ends.group.1);
        if let (Some(step), depth) = ends.step {
            let (_, sum) = self.steps.entry(step).or_insert((number, Price::default()));
            *sum = Price { work: sum.work.checked_add(work)?, depth: sum.depth.max(depth) };
        }
        Some(())
    }

    /// Checks that the trace is complete, and returns its account.
    pub(super) fn finish(mut self, header: &Header) -> Result<Accounts, AccountError> {
        let found = self.ends.len() as u64;
        if found != header.rows {
            return Err(AccountError::Incomplete { expected: header.rows, found });
        }
        self.named.pop();
        if let Some(row) = self.named.iter().position(|named| !named) {
            return Err(AccountError::Unused { row: row as u64 });
        }
        let points = header.points.max(1);
        for (total, Price { work, depth }) in self.steps.into_values() {
            let total = &mut self.totals[total];
            let bound = work.saturating_sub(depth).div_ceil(points).checked_add(depth);
            let sum = bound.and_then(|bound| total.brent.checked_add(bound));
            // A sum over steps belongs to no single row. The error names the last row.
            total.brent = sum.ok_or(AccountError::Overflow { row: found.saturating_sub(1) })?;
        }
        let [paper, repair, selection] = self.totals;
        let phases = self.phases.into_iter().filter(|phase| phase.work > 0 || phase.depth > 0).collect();
        Ok(Accounts { points: header.points, seed: header.seed, phases, paper, repair, selection })
    }
}

/// Keeps the later of two ends on the same clock. An end on another clock does not count.
fn later<C: PartialEq>(end: &mut (C, u64), other: &(C, u64)) {
    if end.0 == other.0 {
        end.1 = end.1.max(other.1);
    }
}
