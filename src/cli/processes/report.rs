//! The report of a run by several processes, on the first of them.

use std::time::Instant;

use septet_core::result::subdomain::Part;
use septet_core::run::memory::peak_rss;
use septet_core::run::processes::ProcessRun;
use septet_lab::report::{ProcessReport, bin_ranks};
use septet_protocol::ledger::LedgerPart;

use super::team::Team;
use crate::errors::{Code, Failure};

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

/// Returns the ledgers of all processes, on the first one. The counts of pairs of ranks travel only if the report shows them,
/// by bins.
pub(super) fn ledgers(
    team: &mut Team<'_>,
    run: Option<&mut ProcessRun>,
    shows_pairs: bool,
) -> Result<Vec<LedgerPart>, Failure> {
    let words = run.map_or_else(Vec::new, |run| {
        let ledger = &mut run.ledger;
        if shows_pairs {
            bin_ranks(ledger, run.part.placement.workers());
        } else {
            ledger.links.clear();
            ledger.ranks.clear();
        }
        std::mem::take(ledger).to_words()
    });
    let all = team.processes.gather(&words)?;
    let part = |words: Vec<u64>| LedgerPart::from_words(&words);
    let parts: Option<Vec<LedgerPart>> = all.into_iter().filter(|w| !w.is_empty()).map(part).collect();
    team.agree(parts.ok_or_else(|| Failure::new(Code::Machine, "the counts of a process do not decode")))
}
