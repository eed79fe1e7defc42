//! The report of a run by several processes, on the first of them.

use std::time::Instant;

use septet_core::result::subdomain::Part;
use septet_core::run::memory::peak_rss;
use septet_core::run::processes::ProcessRun;
use septet_lab::report::ProcessReport;
use septet_protocol::ledger::LedgerPart;

use super::team::Team;
use crate::errors::{Code, Failure};

/// The row of a process as it travels: points, ghosts, bytes received and sent, peak of memory plus 1 (0 if unknown), and
/// seconds.
type Row = ([u64; 5], f64);

/// Returns the rows of all processes.
pub(super) fn gather(
    team: &mut Team<'_>,
    part: &Part,
    start: Instant,
) -> Result<Vec<ProcessReport>, Failure> {
    let owned: usize = part.subdomains.iter().map(|subdomain| subdomain.owned).sum();
    let all: usize = part.subdomains.iter().map(|subdomain| subdomain.ids.len()).sum();
    let [bytes_in, bytes_out] = team.processes.moved();
    let peak = peak_rss().map_or(0, |bytes| bytes + 1);
    let own: Row =
        ([owned as u64, (all - owned) as u64, bytes_in, bytes_out, peak], start.elapsed().as_secs_f64());
    let rows = team.processes.all_gather(&own).map_err(lost)?;
    let report = |(process, (counts, seconds)): (u32, Row)| {
        let [points, ghosts, bytes_in, bytes_out, peak] = counts;
        let workers = part.placement.workers_of(process).len() as u32;
        let peak_rss_bytes = peak.checked_sub(1);
        ProcessReport { process, workers, points, ghosts, bytes_in, bytes_out, peak_rss_bytes, seconds }
    };
    Ok((0..).zip(rows).map(report).collect())
}

/// Returns the ledgers of all processes, on the first one.
pub(super) fn ledgers(team: &mut Team<'_>, run: Option<&ProcessRun>) -> Result<Vec<LedgerPart>, Failure> {
    let words = run.map_or_else(Vec::new, |run| run.ledger.to_words());
    let all = team.processes.gather(&words).map_err(lost)?;
    let part = |words: Vec<u64>| LedgerPart::from_words(&words);
    let parts: Option<Vec<LedgerPart>> = all.into_iter().filter(|w| !w.is_empty()).map(part).collect();
    team.agree(parts.ok_or_else(|| Failure::new(Code::Machine, "the counts of a process do not decode")))
}

/// Returns the failure for lost processes.
pub(super) fn lost(error: septet_protocol::wire::WireError) -> Failure {
    septet_protocol::wire::Ended::from(error).into()
}
