//! What the page shows of `septet triangulate` besides the machine: the quality of the cells, the degrees, and where the data
//! came from.

use std::fmt::Write;

use serde_json::Value;

use septet_core::Spec;
use septet_core::spec::{Commands, Setting, options_of};
use septet_lab::report::mesh::histogram::HistogramReport;

use super::axes::{grouped, si};
use super::card::card;
use super::data::{RunData, number, text};
use super::histograms::{Drawn, draw, table};
use super::svg::escape;
use super::{PageFigure, Variant};

/// The identifiers of the figures.
pub(super) const FIGURES: [&str; 2] = ["quality", "degrees"];

/// Draws the histograms of quality and degrees, if the report has the numbers of the triangulation.
pub(super) fn figures(run: &RunData) -> Vec<PageFigure> {
    let stats = &run.value["stats"];
    let angle = if run.space() == 2.0 { "angles" } else { "dihedral angles" };
    let quality = [
        ("radius-edge ratios".to_owned(), Drawn::RadiusEdge, "radius_edge"),
        (format!("smallest {angle}"), Drawn::LeastAngles, "least_angles"),
        (format!("largest {angle}"), Drawn::LargestAngles, "largest_angles"),
        (angle.to_owned(), Drawn::Angles, "angles"),
    ];
    let quality =
        quality.into_iter().filter_map(|(name, drawn, key)| variant(name, drawn, &stats["quality"][key]));
    let quality: Vec<Variant> = quality.collect();
    let degrees: Vec<Variant> =
        variant(String::new(), Drawn::Degrees, &stats["degrees"]).into_iter().collect();
    let slivers = stats["quality"]["slivers"].get(0).filter(|_| run.space() == 3.0).map_or_else(String::new, |sliver| {
        let [cells, angle, ratio] = ["cells", "angle", "radius_edge"].map(|key| number(&sliver[key]));
        format!(
            " {} cells are slivers: an angle below {angle} degrees and a radius-edge ratio below {ratio}.",
            grouped(cells)
        )
    });
    let of_quality = format!(
        "The radius-edge ratio is the circumradius divided by the length of the shortest edge. The counts beyond the axis are \
         at its ends.{slivers}"
    );
    let of_degrees = "The number of edges at each vertex, hull vertices included.".to_owned();
    [("quality", "Quality of the cells", of_quality, quality), ("degrees", "Degrees", of_degrees, degrees)]
        .into_iter()
        .filter(|figure| !figure.3.is_empty())
        .map(|(id, title, caption, variants)| PageFigure { id, title, caption, variants })
        .collect()
}

/// Draws a histogram, unless it is absent or empty.
fn variant(name: String, drawn: Drawn, value: &Value) -> Option<Variant> {
    let histogram: HistogramReport = serde_json::from_value(value.clone()).ok()?;
    let is_sound = !histogram.counts.is_empty() && histogram.from < histogram.to && histogram.total() > 0;
    let histogram = if drawn == Drawn::Degrees { trimmed(histogram) } else { histogram };
    let bars = drawn.bars(&histogram, f64::INFINITY);
    is_sound.then(|| Variant { name, body: draw(&bars), table: table(&bars) })
}

/// Removes empty bins at the upper end, but keeps ten bins.
fn trimmed(mut histogram: HistogramReport) -> HistogramReport {
    if histogram.above > 0 {
        return histogram;
    }
    let used = histogram.counts.iter().rposition(|count| *count > 0).map_or(0, |last| last + 1);
    let bins = used.max(10).min(histogram.counts.len());
    if bins > 0 {
        histogram.to = histogram.bin(bins - 1)[1];
        histogram.counts.truncate(bins);
    }
    histogram
}

/// Appends the section on the run: times, memory, file, columns, extent, and the command that repeats it.
pub(super) fn details(run: &RunData, out: &mut String) {
    out.push_str(
        "<section id=\"details\" class=\"plate\" aria-labelledby=\"details-title\">\n<h2 id=\"details-title\">The run</h2>\n\
         <dl class=\"cards\">\n",
    );
    let seconds = |key: &str| {
        run.number(&format!("/seconds/{key}")).map_or_else(|| "–".to_owned(), |s| format!("{}s", si(s)))
    };
    let parts = format!(
        "read {}, triangulate {}, write {}",
        seconds("read"),
        seconds("triangulate"),
        seconds("write")
    );
    card(out, "time", &seconds("total"), &parts);
    let memory =
        run.number("/peak_rss_bytes").map_or_else(|| "–".to_owned(), |bytes| format!("{}B", si(bytes)));
    card(out, "memory", &memory, "at the peak");
    file(run, out);
    let axes: Vec<String> =
        ["x", "y", "z"].into_iter().zip(extent(run)).map(|(axis, ends)| format!("{axis} {ends}")).collect();
    if !axes.is_empty() {
        card(out, "extent", &axes.join(", "), "least and largest coordinates");
    }
    hull(run, out);
    out.push_str("</dl>\n");
    if run.value["stats"].is_null() {
        out.push_str(
            "<p class=\"caption\">The report has neither quality nor a picture. `septet triangulate FILE --stats --json run.json` \
             adds both.</p>\n",
        );
    }
    let _ = writeln!(
        out,
        "<p class=\"caption\">The command that repeats the run:</p>\n<code class=\"repeat\">{}</code>\n</section>",
        escape(&command(run))
    );
}

/// Appends the file with its columns.
fn file(run: &RunData, out: &mut String) {
    let name = run.value.pointer("/parameters/input").map_or("", text);
    let input = &run.value["input"];
    let words = |key: &str| {
        let words = input[key].as_array().map_or(&[][..], Vec::as_slice);
        words.iter().map(text).collect::<Vec<_>>().join(" ")
    };
    let note = if input.is_null() {
        "a generated set".to_owned()
    } else {
        let (columns, ignored) = (words("columns"), words("ignored"));
        let mut note = format!("{} rows", grouped(number(&input["rows"])));
        if !columns.is_empty() {
            let _ = write!(note, ", columns {columns}");
        }
        if !ignored.is_empty() {
            let _ = write!(note, ", ignored {ignored}");
        }
        note
    };
    card(out, "file", name, &note);
}

/// Returns the ends of the coordinates on each axis.
fn extent(run: &RunData) -> Vec<String> {
    let of_stats = run.rows("/stats/extent");
    let rows = if of_stats.is_empty() { run.rows("/input/extent") } else { of_stats };
    rows.iter().map(|ends| format!("{} to {}", six_digits(&ends[0]), six_digits(&ends[1]))).collect()
}

/// Returns a number with six digits, because a card is narrow.
fn six_digits(value: &Value) -> f64 {
    let x = number(value);
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// Appends the hull with its measures.
fn hull(run: &RunData, out: &mut String) {
    let hull = &run.value["stats"]["hull"];
    if hull.is_null() {
        return;
    }
    let [volume, surface] = if run.space() == 2.0 { ["area", "perimeter"] } else { ["volume", "area"] };
    let say = |key: &str| hull[key].as_f64().map_or_else(|| "–".to_owned(), si);
    let value = format!("{volume} {}, {surface} {}", say("volume"), say("surface"));
    let [facets, vertices] = ["facets", "vertices"].map(|key| grouped(number(&hull[key])));
    card(out, "convex hull", &value, &format!("{facets} facets, {vertices} vertices"));
}

/// Returns the command that repeats a run: its input, its outputs, and the options that differ from their defaults.
fn command(run: &RunData) -> String {
    let parameters = &run.value["parameters"];
    let mut words = vec!["septet".to_owned(), text(&parameters["command"]).to_owned()];
    words.push(quoted(text(&parameters["input"])));
    for output in run.rows("/parameters/outputs") {
        words.extend(["-o".to_owned(), quoted(text(output))]);
    }
    for option in ["weights", "radii"] {
        if let Some(value) = parameters[option].as_str() {
            words.extend([format!("--{option}"), quoted(value)]);
        }
    }
    let usual = Spec::default();
    for row in options_of(Commands::TRIANGULATE) {
        let is_settled = row.key == "leaf" && parameters["leaf_auto"] == Value::Bool(true);
        let given: Option<Setting> = serde_json::from_value(parameters[row.key].clone()).ok();
        let Some(given) = given.filter(|given| !is_settled && given.text() != row.get(&usual).text()) else {
            continue;
        };
        match given.text() {
            Some(value) if value.is_empty() => words.push(format!("--{}", row.name)),
            Some(value) => words.extend([format!("--{}", row.name), quoted(&value)]),
            None => {}
        }
    }
    if !run.value["stats"].is_null() {
        words.push("--stats".to_owned());
    }
    words.join(" ")
}

/// Returns a word as a shell reads it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn run(value: Value) -> RunData {
        RunData { name: "r".to_owned(), value }
    }

    #[test]
    fn the_command_repeats_the_run() {
        let mut parameters = json!({
            "command": "triangulate", "input": "my points.csv", "outputs": ["a.vtu"], "workers": "8",
            "leaf": 100, "leaf_auto": true, "dimension": 2, "skip_invalid": true, "radii": "R [m]",
        });
        let usual = Spec::default();
        for row in options_of(Commands::TRIANGULATE) {
            let fields = parameters.as_object_mut().unwrap();
            fields.entry(row.key).or_insert_with(|| json!(row.get(&usual)));
        }
        let line = command(&run(json!({ "parameters": parameters, "stats": {} })));
        assert!(line.starts_with("septet triangulate 'my points.csv' -o a.vtu "), "{line}");
        for part in [" --skip-invalid", " --dimension 2", " --workers 8", " --stats", " --radii 'R [m]'"] {
            assert!(line.contains(part), "no {part} in {line}");
        }
        assert!(!line.contains("leaf") && !line.contains("seed"), "{line}");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }

    #[test]
    fn histograms_are_drawn_if_the_report_has_them() {
        assert!(figures(&run(json!({}))).is_empty());
        let histogram = json!({
            "from": 0.0, "to": 64.0, "below": 0, "above": 0, "least": 2.0, "most": 4.0, "mean": 3.0,
            "counts": (0..64).map(|i| u64::from(i == 3)).collect::<Vec<_>>(),
        });
        let stats = json!({ "degrees": histogram, "quality": { "angles": histogram } });
        let made = figures(&run(json!({ "stats": stats, "space": 2 })));
        assert_eq!(made.iter().map(|figure| figure.id).collect::<Vec<_>>(), FIGURES);
        assert_eq!(made[1].variants[0].table.rows.len(), 10);
        assert_eq!(made[0].variants[0].table.rows.len(), 64);
    }
}
