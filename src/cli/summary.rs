//! The human-readable summary of a run: counts, time by part, memory, output files, and a suggested next step.

use std::fs;
use std::path::{Path, PathBuf};

use septet_core::spec::{Correction, Partition, Words};
use septet_io::read::FileList;
use septet_io::without_gz;
use septet_lab::report::{PeriodicReport, RunReport};

use super::text::{bytes, cell_noun, counted, grouped, name, seconds};

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
    let cell = cell_noun(report.space);
    let [points, cells, hull] =
        [(report.points.used, "point"), (report.simplices, cell), (report.hull_facets, "hull facet")]
            .map(|(count, noun)| counted(count, noun));
    let faces = faces(report).map_or_else(String::new, |faces| format!("{faces}, "));
    let certificate = &report.certificate;
    let mut lines = vec![format!("septet: {points}, {faces}{cells}, {hull}, certificate {certificate}")];
    let input = report.parameters.input.as_str();
    let source = name(Path::new(if input == "-" { "standard input" } else { input }));
    lines.extend(report.input.as_ref().map(|input| row("read", input.line(&source))));
    lines.extend(set_aside(report));
    lines.extend(report.periodic.as_ref().map(periodic));
    if report.machine.traffic.rounds > 0 {
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

/// Counts the edges, in space also the facets, and above three dimensions only the facets. Returns `None` without cells, or if the certificate failed.
///
/// Each facet has two cells, or one on the hull. A triangulation of a ball in space has `V - E + F - T = 1` (Euler).
fn faces(report: &RunReport) -> Option<String> {
    let (points, cells) = (report.points.used, report.simplices);
    if cells == 0 || report.certificate != "passed" {
        return None;
    }
    let facets = u64::midpoint((report.space as u64 + 1) * cells, report.hull_facets);
    if report.space == 2 {
        return Some(counted(facets, "edge"));
    }
    if report.space > 3 {
        // Euler's formula leaves the numbers of other faces open.
        return Some(counted(facets, "facet"));
    }
    if let Some(periodic) = &report.periodic {
        // The Euler characteristic of a torus is 0.
        let edges = (points + facets).checked_sub(cells).filter(|_| periodic.is_closed())?;
        return Some(format!("{}, {}", counted(edges, "edge"), counted(facets, "facet")));
    }
    let edges = (points + facets).checked_sub(cells + 1)?;
    Some(format!("{}, {}", counted(edges, "edge"), counted(facets, "facet")))
}

/// Describes the periodic box.
fn periodic(report: &PeriodicReport) -> String {
    let lengths: Vec<String> =
        report.lengths.iter().map(|length| length.map_or("none".to_owned(), |l| l.to_string())).collect();
    let sheets: Vec<String> = report.sheets.iter().map(u32::to_string).collect();
    let complex = if report.simplicial {
        "a simplicial complex".to_owned()
    } else {
        format!("no simplicial complex, but {} boxes are one", sheets.join(" x "))
    };
    row("periodic", format!("{}, {complex}, {}", lengths.join(" x "), counted(report.images_sent, "image")))
}

/// Counts the points of the input that are not vertices.
fn set_aside(report: &RunReport) -> Option<String> {
    let p = &report.points;
    let duplicate =
        (p.duplicate > 0).then(|| format!("{} of earlier points", counted(p.duplicate, "duplicate")));
    let hidden = p.hidden.filter(|hidden| *hidden > 0);
    let hidden = hidden.map(|hidden| format!("{} hidden by weights", counted(hidden, "point")));
    let refused = (p.refused > 0).then(|| format!("{} refused", counted(p.refused, "point")));
    let all: Vec<String> = duplicate.into_iter().chain(hidden).chain(refused).collect();
    (!all.is_empty()).then(|| row("left out", all.join(", ")))
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
            counted(machine.traffic.rounds, "round"),
            counted(machine.traffic.messages, "message"),
            bytes(machine.traffic.bytes)
        ),
    ));
    if let (Some(work), Some(depth)) = (machine.totals.paper.total.work, machine.totals.paper.total.depth) {
        lines.push(row("counts", format!("work {}, depth {}", grouped(work), grouped(depth))));
    }
    lines
}

/// Names the baselines that replace steps of the paper, if there are any.
fn baselines(report: &RunReport) -> Option<String> {
    let p = &report.parameters.options;
    let partition = Partition::ALL.iter().copied().find(|c| c.name() == p.text("partition"));
    let cut = partition.and_then(|partition| match partition {
        Partition::Sphere => None,
        Partition::Kd => Some("k-d planes separate subproblems"),
        Partition::Hilbert => Some("cuts of a Hilbert curve separate subproblems"),
    });
    let correction = Correction::ALL.iter().copied().find(|c| c.name() == p.text("neighbours"));
    let balls = correction.and_then(|correction| match correction {
        Correction::Descent => None,
        Correction::BottomUp => Some("balls are corrected bottom-up, node by node"),
        Correction::Stages => Some("balls are corrected bottom-up, in stages"),
        Correction::Pairs => Some("balls come from well-separated pairs"),
    });
    let both: Vec<&str> = cut.into_iter().chain(balls).collect();
    (!both.is_empty()).then(|| row("baseline", both.join(", ")))
}

/// Suggests the next step after `septet triangulate` or `septet simulate` in a space of `space` dimensions. `reading` are the options to read the input again,
/// and `terrain` the one to read the outputs.
pub fn next_step(
    input: &str,
    (reading, terrain): (&str, &str),
    (outputs, space): (&[PathBuf], usize),
    json: Option<&Path>,
) -> String {
    let plain = |text: &str| !text.contains(char::is_whitespace) && !text.contains(char::is_control);
    let is_plain = |path: &Path| path.as_os_str() != "-" && plain(&path.to_string_lossy());
    let ends = |path: &Path, ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
    let picture = outputs.iter().find(|o| (ends(o, "vtu") || ends(o, "vtk")) && is_plain(o));
    let pieces = outputs.iter().find(|o| ends(o, "pvtu") && is_plain(o));
    // The file of a surface has all points of a terrain.
    let is_surface = |o: &Path| !terrain.is_empty() && ["off", "obj", "ply"].iter().any(|e| ends(o, e));
    let check = |o: &PathBuf| {
        if is_surface(o) {
            return Some((o.display().to_string(), o.clone()));
        }
        Some((points_of(o, input)?, cells_of(o)?))
    };
    let checks = outputs.iter().filter(|o| is_plain(o)).find_map(check);
    let text = match (picture.or(pieces), json, checks) {
        (Some(mesh), _, _) => {
            format!("open {0} in ParaView, or check it: septet verify {0}{terrain}", mesh.display())
        }
        (_, Some(json), _) if is_plain(json) => format!("septet report {} -o report.html", json.display()),
        (_, _, Some((points, cells))) if plain(&points) => {
            let reading = if points == input { reading } else { "" };
            // A set of files has points in the plane.
            let is_set = split(&cells).is_some_and(|(_, ending, _)| ending == "ele");
            let terrain = if is_set && points != input { "" } else { terrain };
            let points = if Path::new(&points) == cells { String::new() } else { points + " " };
            format!(
                "check the cells independently: septet verify {points}{}{reading}{terrain}",
                cells.display()
            )
        }
        (..) if outputs.is_empty() && space > 3 => {
            "add -o cells.npy to write the cells, or --json run.json for all counts".to_owned()
        }
        (..) if outputs.is_empty() && input != "-" && plain(input) => {
            "add -o mesh.vtu to write the cells, or --json run.json for all counts".to_owned()
        }
        _ => "`septet verify POINTS CELLS` checks the cells independently".to_owned(),
    };
    row("next", text)
}

/// Splits a path into the part before its extension, the extension in lower case, and `.gz` or an empty string.
fn split(path: &Path) -> Option<(String, String, &'static str)> {
    let (plain, zipped) = without_gz(path);
    let extension = plain.extension()?.to_str()?.to_ascii_lowercase();
    let stem = plain.with_extension("").to_str()?.to_owned();
    Some((stem, extension, if zipped { ".gz" } else { "" }))
}

/// Returns the file with the points of an output: the output itself, the `.node` file of its set, or the input.
fn points_of(output: &Path, input: &str) -> Option<String> {
    let (stem, extension, zip) = split(output)?;
    match extension.as_str() {
        "vtu" | "vtk" | "msh" | "mesh" => Some(output.display().to_string()),
        "node" | "ele" | "face" | "edge" | "neigh" => Some(format!("{stem}.node{zip}")),
        // `septet verify` reads the points of one file.
        "npy" => (input != "-" && !FileList::is_named_by(input)).then(|| input.to_owned()),
        _ => None,
    }
}

/// Returns the file with the cells of an output: the output itself, or the `.ele` file of its set.
fn cells_of(output: &Path) -> Option<PathBuf> {
    let (stem, extension, zip) = split(output)?;
    match extension.as_str() {
        "vtu" | "vtk" | "msh" | "mesh" | "npy" => Some(output.to_owned()),
        "node" | "ele" | "face" | "edge" | "neigh" => Some(format!("{stem}.ele{zip}").into()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_step_names_the_files() {
        for (output, expected) in [
            ("a.vtu", "open a.vtu in ParaView, or check it: septet verify a.vtu"),
            ("a.vtk", "open a.vtk in ParaView, or check it: septet verify a.vtk"),
            ("a.pvtu", "open a.pvtu in ParaView, or check it: septet verify a.pvtu"),
            ("a.vtu.gz", "septet verify a.vtu.gz"),
            ("b/a.1.ele", "septet verify b/a.1.node b/a.1.ele"),
            ("a.neigh.gz", "septet verify a.node.gz a.ele.gz"),
            ("a.msh", "septet verify a.msh"),
            ("a.npy", "septet verify p.xyz a.npy"),
            ("a b.msh", "septet verify POINTS CELLS"),
            ("a.stl", "septet verify POINTS CELLS"),
        ] {
            let text = next_step("p.xyz", ("", ""), (&[output.into()], 3), None);
            assert!(text.contains(expected), "{text}");
        }
        let json = Some(Path::new("run.json"));
        let raw = next_step("p.raw", (" --raw f64,3", " --terrain"), (&["a.npy".into()], 3), None);
        assert!(raw.contains("septet verify p.raw a.npy --raw f64,3 --terrain"), "{raw}");
        let tin = next_step("p.xyz", ("", " --terrain"), (&["a.vtu".into()], 3), None);
        assert!(tin.ends_with("septet verify a.vtu --terrain"), "{tin}");
        let tin = next_step("p.xyz", ("", " --terrain"), (&["a.obj".into()], 3), None);
        assert!(tin.ends_with("septet verify a.obj --terrain"), "{tin}");
        let set = next_step("p.raw", (" --raw f64,3", " --terrain"), (&["a.ele".into()], 3), None);
        assert!(set.ends_with("septet verify a.node a.ele"), "{set}");
        assert!(
            next_step("p.xyz", ("", ""), (&[], 3), json).contains("septet report run.json -o report.html")
        );
        assert!(next_step("-", ("", ""), (&["a.npy".into()], 3), None).contains("POINTS CELLS"));
        assert!(next_step("p.xyz", ("", ""), (&[], 3), None).contains("-o mesh.vtu"));
        assert!(next_step("p.npy", ("", ""), (&[], 4), None).contains("-o cells.npy"));
    }
}
