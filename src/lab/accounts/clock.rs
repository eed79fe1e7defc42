//! The longest paths through the rows of a cost trace.

use std::collections::BTreeMap;

use super::error::AccountError;
use super::price::{self, Price};
use super::row::{Header, Row};
use super::{Accounts, PhaseAccount, TotalAccount};

/// The phases of the paper's total.
const PAPER: [&str; 13] = [
    "partition",
    "radii",
    "probe",
    "neighbours",
    "summaries",
    "knn-radii",
    "knn-probe",
    "knn",
    "separator-sets",
    "graph",
    "independent",
    "hulls",
    "merge",
];

/// The phases of the total of repair.
const REPAIR: [&str; 4] = ["check", "repair", "certificate", "fallback"];

/// The total to which a phase belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    Paper,
    Repair,
    Neither,
}

impl Group {
    fn of(phase: &str) -> Self {
        if PAPER.contains(&phase) {
            Group::Paper
        } else if REPAIR.contains(&phase) {
            Group::Repair
        } else {
            Group::Neither
        }
    }
}

/// A step of Brent's bound: the rows of a phase at one level of the tree, or in one step of the phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct BrentStep {
    /// The position of the phase.
    phase: usize,
    number: u32,
}

/// The ends of a row on the clocks of its phase, its group and its step. A clock ignores the rows of others.
#[derive(Clone, Copy, Debug)]
struct Ends {
    phase: (usize, u64),
    group: (Group, u64),
    step: (Option<BrentStep>, u64),
}

/// The clocks of the rows so far.
#[derive(Debug, Default)]
pub(super) struct Clocks {
    phases: Vec<PhaseAccount>,
    totals: [TotalAccount; 2],
    steps: BTreeMap<BrentStep, Price>,
    ends: Vec<Ends>,
    /// Whether a later row names the row.
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
        let phase = self.phase(&row.phase);
        let number = row.step.or(row.node.map(u64::ilog2));
        let step = number.map(|number| BrentStep { phase, number });
        let group = Group::of(&row.phase);
        let (mut in_phase, mut in_group, mut in_step) = (0, 0, 0);
        for &after in &row.after {
            let before = usize::try_from(after).ok().filter(|&at| at < self.ends.len());
            let at = before.ok_or(AccountError::Order { row: row.row, after })?;
            self.named[at] = true;
            let ends = self.ends[at];
            in_phase = later(in_phase, ends.phase.1, ends.phase.0 == phase);
            in_group = later(in_group, ends.group.1, ends.group.0 == group);
            in_step = later(in_step, ends.step.1, ends.step.0 == step);
        }
        let ends = Ends {
            phase: (phase, in_phase + price.depth),
            group: (group, in_group + price.depth),
            step: (step, in_step + price.depth),
        };
        self.count(ends, price.work);
        self.ends.push(ends);
        self.named.push(false);
        Ok(())
    }

    /// Returns the position of a phase.
    fn phase(&mut self, name: &str) -> usize {
        let at = self.phases.iter().rposition(|account| account.phase == name);
        at.unwrap_or_else(|| {
            self.phases.push(PhaseAccount { phase: name.to_owned(), work: 0, depth: 0 });
            self.phases.len() - 1
        })
    }

    /// Adds the work of a row, and keeps the latest ends.
    fn count(&mut self, ends: Ends, work: u64) {
        let phase = &mut self.phases[ends.phase.0];
        phase.work += work;
        phase.depth = phase.depth.max(ends.phase.1);
        let total = match ends.group.0 {
            Group::Paper => &mut self.totals[0],
            Group::Repair => &mut self.totals[1],
            Group::Neither => return,
        };
        total.work += work;
        total.depth = total.depth.max(ends.group.1);
        if let (Some(step), depth) = ends.step {
            let sum = self.steps.entry(step).or_default();
            *sum = Price { work: sum.work + work, depth: sum.depth.max(depth) };
        }
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
        for (step, Price { work, depth }) in self.steps {
            let total =
                &mut self.totals[usize::from(Group::of(&self.phases[step.phase].phase) == Group::Repair)];
            total.brent += work.saturating_sub(depth).div_ceil(points) + depth;
        }
        let [paper, repair] = self.totals;
        let phases = self.phases.into_iter().filter(|phase| phase.work + phase.depth > 0).collect();
        Ok(Accounts { phases, paper, repair })
    }
}

/// Returns the later end, if the other row counts.
fn later(end: u64, other: u64, counts: bool) -> u64 {
    if counts { end.max(other) } else { end }
}
