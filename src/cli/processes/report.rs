//! The report of a run by several processes, on the first of them.

use std::time::Instant;

use septet_core::Spec;
use septet_core::result::subdomain::Part;
use septet_core::run::memory::peak_rss;
use septet_core::run::processes::ProcessRun;
use septet_core::spec::Nodes;
use septet_lab::report::{ProcessReport, bin_ranks};
use septet_protocol::ledger::{CondensedLedger, PhaseSet};

use super::team::Team;
use crate::errors::{Code, Failure};
use crate::triangulate::Goal;

/// Returns the reports of all processes.
pub(super) fn gather(
    team: &mut Team<'_>,
    part: &Part,
    start: Instant,
) -> Result<Vec<ProcessReport>, Failure> {
    let process = team.processes.process();
    let points = part.subdomains.iter().map(|subdomain| subdomain.owned as u64).sum();
    let all: u64 = part.subdomains.iter().map(|subdomain| subdomain.ids.len() as u64).sum();
    let [bytes_in, bytes_out] = team.processes.moved();
    team.all_gather(&ProcessReport {
        process,
        workers: part.placement.workers_of(process).len() as u32,
        points,
        ghosts: all - points,
        bytes_in,
        bytes_out,
        peak_rss_bytes: peak_rss(),
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// The rows of the ledger that the report shows. All others travel as sums.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows {
    /// Whether it shows the counts of pairs of ranks, by bins.
    has_pairs: bool,
    /// Whether it shows every node of the partition tree.
    has_nodes: bool,
}

impl Rows {
    /// Returns the rows that the report of a goal shows.
    pub(super) fn of(goal: Goal<'_>, spec: &Spec) -> Self {
        let has_pairs = goal.args().json.is_some();
        let has_nodes = has_pairs && matches!(goal, Goal::Simulate(_)) && spec.keep.nodes == Nodes::All;
        Rows { has_pairs, has_nodes }
    }
}

/// Returns the ledger of all processes on the first one, and an empty ledger on the others. Processes condense their ledgers
/// before they send them.
pub(super) fn united_ledger(
    team: &mut Team<'_>,
    run: Option<&mut ProcessRun>,
    rows: Rows,
) -> Result<CondensedLedger, Failure> {
    let own = run.as_ref().map_or_else(PhaseSet::default, |run| PhaseSet::of(&run.ledger));
    let mut phases = PhaseSet::default();
    for bits in team.processes.all_gather(&own.bits())? {
        phases = phases.union(PhaseSet::from_bits(bits).ok_or_else(malformed)?);
    }
    let words = run.map_or_else(Vec::new, |run| {
        let ledger = &mut run.ledger;
        if rows.has_pairs {
            bin_ranks(ledger, run.part.placement.workers());
        } else {
            ledger.links.clear();
            ledger.ranks.clear();
        }
        run.condense(phases, rows.has_nodes).to_words()
    });
    let all = team.processes.gather(&words)?;
    drop(words);
    let parts = all.into_iter().filter(|words| !words.is_empty());
    let parts: Option<Vec<_>> = parts.map(|words| CondensedLedger::from_words(&words)).collect();
    let united = parts.ok_or_else(malformed).and_then(|parts| {
        CondensedLedger::united(parts).map_err(|error| Failure::new(Code::Machine, error.to_string()))
    });
    team.agree(united)
}

fn malformed() -> Failure {
    Failure::new(Code::Machine, "the counts of a process do not decode")
}
