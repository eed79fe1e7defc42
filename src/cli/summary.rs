//! The human-readable summary of a run: counts, time by part, memory, output files, and a suggested next step.

use std::fs;
use std::path::{Path, PathBuf};

use septet_core::config::{Correction, Partition};
use septet_lab::report::RunReport;

use super::text::{bytes, counted, grouped, name, seconds};

/// Formats a line of a summary: a label, then the text.
pub fn row(label: &str, text: impl AsRef<str>) -> String {
    format!("  {label:<12}{}", text.as_ref())
}

/// Formats the rows of the files that were written, with their sizes.
pub fn written(files: &[PathBuf]) -> Vec<String> {
    let size = |file: &Path| fs::metadata(file).ok().filter(fs::Metadata::is_file).map(|found| found.len());
    let line = |file: &PathBuf| {
        let size = size(file).map_or_else(String::new, |size| format!(" ({})", bytes(size)));
        row("wrote", name(file) + &size)
    };
    files.iter().map(line).collect()
}

/// Formats the summary of a run. `is_sample` is `true` if its points were generated.
pub fn of_run(report: &RunReport, is_sample: bool) -> Vec<String> {
    let cell = if report.space == 2 { "triangle" } else { "tetrahedron" };
    let mut lines = vec![format!(
        "septet: {}, {}, {}, certificate {}",
        counted(report.points.used, "point"),
        counted(report.simplices, cell),
        counted(report.hull_facets, "hull facet"),
        report.certificate
    )];
    lines.extend(set_aside(report));
    if report.machine.rounds > 0 {
        lines.extend(machine(report));
    }
    let s = &report.seconds;
    let input = if is_sample { "generate" } else { "read" };
    let [read, triangulate, write, total] = [s.read, s.triangulate, s.write, s.total].map(seconds);
    lines.push(row(
        "time",
        format!("{input} {read}, triangulate {triangulate}, write {write}, total {total}"),
    ));
    if let Some(peak) = report.peak_rss_bytes {
        lines.push(row("memory", format!("{} at the peak", bytes(peak))));
    }
    lines
}

/// Counts the points of the input that are not vertices.
fn set_aside(report: &RunReport) -> Option<String> {
    let p = &report.points;
    let duplicate =
        (p.duplicate > 0).then(|| format!("{} of earlier points", counted(p.duplicate, "duplicate")));
    let refused = (p.refused > 0).then(|| format!("{} refused", counted(p.refused, "point")));
    let both: Vec<String> = duplicate.into_iter().chain(refused).collect();
    (!both.is_empty()).then(|| row("left out", both.join(", ")))
}

/// Describes the graph, the repair and the traffic of the machine.
fn machine(report: &RunReport) -> Vec<String> {
    let mut lines = Vec::new();
    if report.supergraph.kind != "none" {
        let graph = &report.supergraph;
        let parameter = match (graph.alpha, graph.k) {
            (Some(alpha), _) => format!(", alpha {alpha}"),
            (_, Some(k)) => format!(", k {k}"),
            _ => String::new(),
        };
        lines.push(row("supergraph", format!("{}{parameter} ({})", graph.kind, graph.why)));
    }
    lines.extend(baselines(report));
    let (repair, machine) = (&report.repair, &report.machine);
    if repair.stars > 0 || report.fallback.is_some() {
        let fallback = report.fallback.as_ref().map_or_else(String::new, |f| {
            format!("; {} gathered on the coordinator: {}", counted(f.points, "point"), f.reason)
        });
        let [stars, rounds] = [counted(repair.stars, "star"), counted(repair.rounds, "round")];
        lines.push(row("repair", format!("{stars} in {rounds}{fallback}")));
    }
    lines.push(row(
        "machine",
        format!(
            "{}, {}, {}, {}",
            counted(machine.workers, "worker"),
            counted(machine.rounds, "round"),
            counted(machine.messages, "message"),
            bytes(machine.bytes)
        ),
    ));
    if let (Some(work), Some(depth)) = (machine.paper.work, machine.paper.depth) {
        lines.push(row("counts", format!("work {}, depth {}", grouped(work), grouped(depth))));
    }
    lines
}

/// Names the baselines that replace steps of the paper, if there are any.
fn baselines(report: &RunReport) -> Option<String> {
    let p = &report.parameters;
    let cut = (p.partition != Partition::Sphere.name()).then_some("k-d planes separate subproblems");
    let bottom_up =
        (p.neighbours != Correction::Descent.name()).then_some("balls are corrected bottom-up, node by node");
    let both: Vec<&str> = cut.into_iter().chain(bottom_up).collect();
    (!both.is_empty()).then(|| row("baseline", both.join(", ")))
}

/// Suggests the next step after `septet triangulate` or `septet simulate`.
pub fn next_step(input: &str, outputs: &[PathBuf], json: Option<&Path>) -> String {
    let has = |ending: &str| outputs.iter().find(|o| o.extension().is_some_and(|e| e == ending));
    let plain = |text: &str| !text.contains(char::is_whitespace) && !text.contains(char::is_control);
    let text = match (has("vtu"), json) {
        (Some(mesh), _) if plain(&mesh.to_string_lossy()) => {
            format!("open {0} in ParaView, or check it: septet verify {0} {0}", mesh.display())
        }
        (_, Some(json)) if json.as_os_str() != "-" && plain(&json.to_string_lossy()) => {
            format!("septet report {} -o report.html", json.display())
        }
        (None, _) if outputs.is_empty() && input != "-" && plain(input) => {
            "add -o mesh.vtu to write the cells, or --json run.json for all counts".to_owned()
        }
        _ => "`septet verify POINTS CELLS` checks the cells independently".to_owned(),
    };
    row("next", text)
}
