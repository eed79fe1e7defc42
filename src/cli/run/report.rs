//! The report of a run.

use std::path::PathBuf;
use std::time::Instant;

use septet_core::run::memory::peak_rss;
use septet_core::spec::{Nodes, Task};
use septet_core::{Door, Outcome, Spec};
use septet_lab::report::{InputReport, ProcessReport, RunReport, bin_ranks};
use septet_protocol::ledger::{CondensedLedger, PhaseSet};

use super::goal::Goal;
use super::team::Team;
use crate::errors::{Code, Failure};
use crate::files;
use crate::instruments::Tables;
use crate::options::RunArgs;
use crate::progress::Talk;
use crate::stats;
use crate::summary;

/// Returns the reports of all processes of a team.
pub(super) fn gather(
    team: &mut Team<'_>,
    run: &Outcome,
    start: Instant,
) -> Result<Vec<ProcessReport>, Failure> {
    let process = team.processes.process();
    let points = run.shares.iter().map(|share| share.owned as u64).sum();
    let all: u64 = run.shares.iter().map(|share| share.ids.len() as u64).sum();
    let [bytes_in, bytes_out] = team.processes.moved();
    team.all_gather(&ProcessReport {
        process,
        workers: run.placement.workers_of(process).len() as u32,
        points,
        ghosts: all - points,
        bytes_in,
        bytes_out,
        peak_rss_bytes: peak_rss(),
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Sets the counts of all processes of a team on the first one. The processes condense their ledgers before they send them: the
/// report shows the counts of pairs of ranks, by bins, and of every node of the tree only as JSON.
pub(super) fn unite_counts(
    team: &mut Team<'_>,
    run: &mut Outcome,
    (goal, nodes): (Goal<'_>, Nodes),
) -> Result<(), Failure> {
    if team.is_alone() {
        return Ok(());
    }
    let has_pairs = goal.args().json.is_some();
    let has_nodes = has_pairs && goal.task() == Task::Simulate && nodes == Nodes::All;
    let workers = run.placement.workers();
    let mut counts = run.own_counts.as_mut();
    let own = counts.as_ref().map_or_else(PhaseSet::default, |own| PhaseSet::of(&own.ledger));
    let mut phases = PhaseSet::default();
    for bits in team.processes.all_gather(&own.bits())? {
        phases = phases.union(PhaseSet::from_bits(bits).ok_or_else(malformed)?);
    }
    let words = counts.take().map_or_else(Vec::new, |own| {
        if has_pairs {
            bin_ranks(&mut own.ledger, workers);
        } else {
            own.ledger.links.clear();
            own.ledger.ranks.clear();
        }
        own.condense(phases, has_nodes).to_words()
    });
    let all = team.processes.gather(&words)?;
    drop(words);
    let parts = all.into_iter().filter(|words| !words.is_empty());
    let parts: Option<Vec<_>> = parts.map(|words| CondensedLedger::from_words(&words)).collect();
    let united = parts.ok_or_else(malformed).and_then(|parts| {
        CondensedLedger::united(parts).map_err(|error| Failure::new(Code::Machine, error.to_string()))
    });
    run.unite(team.agree(united)?);
    Ok(())
}

fn malformed() -> Failure {
    Failure::new(Code::Machine, "the counts of a process do not decode")
}

/// Writes the tables and the report, and prints the summary. Cells with break lines are no Delaunay triangulation. `files` are the files written before. Returns all files.
pub(super) fn publish(
    (args, requested, is_delaunay): (&RunArgs, &Spec, bool),
    tables: &Tables,
    report: &RunReport,
    mut files: Vec<PathBuf>,
    talk: &Talk,
) -> Result<Vec<PathBuf>, Failure> {
    let rendered = |format, which| report.tables(format, which);
    files.extend(tables.write(&rendered)?);
    print_report((args, requested, is_delaunay), report, &files, talk)?;
    tables.print(&rendered);
    files.extend(args.json.clone().filter(|path| path.as_os_str() != "-"));
    Ok(files)
}

/// Writes the report as JSON and prints its summary.
fn print_report(
    (args, requested, is_delaunay): (&RunArgs, &Spec, bool),
    report: &RunReport,
    files: &[PathBuf],
    talk: &Talk,
) -> Result<(), Failure> {
    if let Some(path) = &args.json {
        let mut text = report
            .to_json()
            .map_err(|e| Failure::new(Code::Failed, format!("the report cannot be written: {e}")))?;
        text.push('\n');
        files::write_text(path, &text)?;
    }
    let is_sample = args.input.starts_with("sample:");
    let stats = report.stats.as_ref().map(|stats| stats::lines(stats, report.space)).unwrap_or_default();
    for line in summary::of_run(report, is_sample).into_iter().chain(stats).chain(summary::written(files)) {
        talk.note(line);
    }
    if let Some(note) = report.input.as_ref().and_then(InputReport::height_note) {
        talk.note(format!("note: {note}"));
    }
    if report.dimension < report.space as isize {
        talk.note(format!("note: {}", report.flat_note(Door::Shell)));
    } else if is_delaunay
        && report.certificate == "passed"
        && !report.has_weights()
        && report.periodic.is_none()
    {
        let raw = requested.input.raw.as_ref();
        let reading = raw.map_or_else(String::new, |rows| format!(" --raw {rows}"));
        let terrain = if requested.input.terrain { " --terrain" } else { "" };
        talk.note(summary::next_step(
            &args.input,
            (&reading, terrain),
            (&args.output, report.space),
            args.json.as_deref(),
        ));
    }
    Ok(())
}
