//! The comparison of the second account with the counts of the ledger.

use std::fmt;

use serde::Deserialize;

use super::error::ReportError;
use super::totals::{Accounts, TotalAccount};

/// Name and version of the format of the reports of runs.
const RUN_SCHEMA: &str = "septet-run/2";

/// A run, as its report states it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportedRun {
    /// The seed.
    pub seed: u64,
    /// Number of distinct points.
    pub points: u64,
    /// The counts.
    pub counts: ReportedCounts,
}

/// The name of the format, which is read first: other formats have other fields.
#[derive(Deserialize)]
struct Format {
    schema: String,
}

/// The fields of a report that identify its run.
#[derive(Deserialize)]
struct Identity {
    seed: u64,
    points: UsedPoints,
}

#[derive(Deserialize)]
struct UsedPoints {
    used: u64,
}

impl ReportedRun {
    /// Reads the report of a run (`--json`).
    ///
    /// # Errors
    /// Fails if the text is not the report of a run with counts.
    pub fn parse(text: &[u8]) -> Result<Self, ReportError> {
        let Format { schema } = serde_json::from_slice(text)?;
        if schema != RUN_SCHEMA {
            return Err(ReportError::Schema { found: schema });
        }
        let Identity { seed, points } = serde_json::from_slice(text)?;
        let counts: ReportedCounts = serde_json::from_slice(text)?;
        if counts.machine.paper.work.is_none() {
            return Err(ReportError::NoCounts);
        }
        Ok(ReportedRun { seed, points: points.used, counts })
    }
}

/// The counts of a run, as its report states them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct ReportedCounts {
    /// The totals.
    pub machine: ReportedTotals,
    /// The phases in their order.
    pub phases: Vec<ReportedPhase>,
}

/// The totals of a run, as its report states them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct ReportedTotals {
    /// The phases of the paper.
    pub paper: ReportedTotal,
    /// The phases of agreement and repair.
    pub repair: ReportedTotal,
    /// The choice of the supergraph. `None` in reports of earlier versions.
    #[serde(default)]
    pub selection: Option<ReportedTotal>,
}

/// A total of a run. Its fields are `None` if the run does not count work and depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct ReportedTotal {
    /// Work.
    pub work: Option<u64>,
    /// Depth.
    pub depth: Option<u64>,
    /// Brent's bound.
    pub brent: Option<u64>,
}

/// A phase of a run. Its counts are `None` if the run does not count work and depth.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct ReportedPhase {
    /// The name.
    pub name: String,
    /// Work.
    pub work: Option<u64>,
    /// Depth.
    pub depth: Option<u64>,
}

/// A count that differs between both accounts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The name of the phase or of the total.
    pub phase: String,
    /// The count.
    pub count: &'static str,
    /// The value according to the cost trace.
    pub traced: u64,
    /// The value according to the ledger.
    pub reported: u64,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference { phase, count, traced, reported } = self;
        write!(f, "{count} of {phase}: {traced} by the cost trace, {reported} by the ledger")
    }
}

impl Accounts {
    /// Returns the counts that differ from the report of the same run (see [`Accounts::differences`]).
    ///
    /// # Errors
    /// Fails if the report is of a run with another seed or another number of points.
    pub fn compare(&self, run: &ReportedRun) -> Result<Vec<Difference>, ReportError> {
        if run.seed != self.seed {
            return Err(ReportError::Seed { reported: run.seed, traced: self.seed });
        }
        if run.points != self.points {
            return Err(ReportError::Points { reported: run.points, traced: self.points });
        }
        Ok(self.differences(&run.counts))
    }

    /// Returns the counts that differ from the counts of the ledger: first those of the phases, then those of the
    /// totals. A missing count is 0.
    pub fn differences(&self, reported: &ReportedCounts) -> Vec<Difference> {
        let mut names: Vec<&str> = self.phases.iter().map(|phase| phase.phase.as_str()).collect();
        let others = reported.phases.iter().map(|phase| phase.name.as_str());
        names.extend(others.filter(|name| self.phases.iter().all(|phase| phase.phase != *name)));
        let mut all = Vec::new();
        for name in names {
            let traced = self.phases.iter().find(|phase| phase.phase == name);
            let ledger = reported.phases.iter().find(|phase| phase.name == name);
            let row = |count, traced: Option<u64>, ledger: Option<Option<u64>>| {
                let (traced, reported) = (traced.unwrap_or(0), ledger.flatten().unwrap_or(0));
                (traced != reported).then(|| Difference { phase: name.to_owned(), count, traced, reported })
            };
            all.extend(row("work", traced.map(|p| p.work), ledger.map(|p| p.work)));
            all.extend(row("depth", traced.map(|p| p.depth), ledger.map(|p| p.depth)));
        }
        all.extend(of_total("paper", &self.paper, &reported.machine.paper));
        all.extend(of_total("repair", &self.repair, &reported.machine.repair));
        let selection = reported.machine.selection.as_ref();
        all.extend(selection.into_iter().flat_map(|total| of_total("selection", &self.selection, total)));
        all
    }
}

fn of_total(name: &str, traced: &TotalAccount, reported: &ReportedTotal) -> Vec<Difference> {
    let rows = [
        ("work", traced.work, reported.work),
        ("depth", traced.depth, reported.depth),
        ("brent", traced.brent, reported.brent),
    ];
    let rows = rows.into_iter().map(|(count, traced, reported)| (count, traced, reported.unwrap_or(0)));
    rows.filter(|(_, traced, reported)| traced != reported)
        .map(|(count, traced, reported)| Difference {
            phase: format!("{name} (total)"),
            count,
            traced,
            reported,
        })
        .collect()
}
