//! The HTML text of the page, which contains the style, data and scripts.

use std::fmt::Write;

use serde_json::{Value, json};

use super::axes::{grouped, si};
use super::card::card;
use super::data::{RunData, number, text};
use super::mesh::{self, MeshData};
use super::svg::{STYLE, escape};
use super::triangulation;
use super::{Page, PageFigure};

const PAGE_STYLE: &str = include_str!("assets/page.css");

/// The names and texts of the script modules, for the import map.
const MODULES: [(&str, &str); 13] = [
    ("three", include_str!("assets/three/three.min.js")),
    ("septet/data", include_str!("assets/data.js")),
    ("septet/theme", include_str!("assets/theme.js")),
    ("septet/tables", include_str!("assets/tables.js")),
    ("septet/camera", include_str!("assets/camera.js")),
    ("septet/plain", include_str!("assets/plain.js")),
    ("septet/stage", include_str!("assets/stage.js")),
    ("septet/layers", include_str!("assets/layers.js")),
    ("septet/surfaces", include_str!("assets/surfaces.js")),
    ("septet/scene", include_str!("assets/scene.js")),
    ("septet/cells", include_str!("assets/cells.js")),
    ("septet/scales", include_str!("assets/scales.js")),
    ("septet/mesh", include_str!("assets/mesh.js")),
];

const MAIN: &str = include_str!("assets/main.js");
const SCENE: &str = include_str!("assets/scene.html");
const MESH: &str = include_str!("assets/mesh.html");
const LICENCE: &str = include_str!("assets/three/LICENSE");

/// Writes JSON that cannot close the surrounding script element.
fn embedded(value: &Value) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string(value)?.replace('<', "\\u003c"))
}

/// Returns a module as a data URL.
fn address(source: &str) -> String {
    let mut out = String::from("data:text/javascript;charset=utf-8,");
    for byte in source.bytes() {
        match byte {
            b'A'..=b'Z'
            | b'a'..=b'z'
            | b'0'..=b'9'
            | b'-'
            | b'_'
            | b'.'
            | b'!'
            | b'~'
            | b'*'
            | b'('
            | b')'
            | b';'
            | b','
            | b'/'
            | b'?'
            | b':'
            | b'@'
            | b'='
            | b'+'
            | b'$' => out.push(char::from(byte)),
            _ => {
                let _ = write!(out, "%{byte:02X}");
            }
        }
    }
    out
}

pub(super) fn page(page: &Page) -> Result<String, serde_json::Error> {
    let shown = page.shown.map(|at| &page.runs[at]);
    let imports: serde_json::Map<String, Value> =
        MODULES.iter().map(|(name, source)| ((*name).to_owned(), json!(address(source)))).collect();
    let tables: serde_json::Map<String, Value> =
        page.all_figures().map(|f| (f.id.to_owned(), tables_of(f))).collect();
    let view = shown.map_or(Value::Null, |run| run.value["view"].clone());
    let space = shown.map_or(3.0, RunData::space);
    let mesh = page.meshes.first();
    let direct = shown.is_some_and(RunData::is_direct);
    let data =
        json!({ "tables": tables, "view": view, "direct": direct, "space": space, "mesh": picture(mesh) });
    let mut out = String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    out.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    out.push_str(
        "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n",
    );
    let title = shown.map(headline).or_else(|| mesh.filter(|_| page.runs.is_empty()).map(mesh::headline));
    let title = title.unwrap_or_else(|| format!("{} runs", page.runs.len()));
    let _ = writeln!(out, "<title>septet: {}</title>\n<style>{STYLE}{PAGE_STYLE}</style>", escape(&title));
    let imports = embedded(&json!({ "imports": imports }))?;
    let _ = writeln!(out, "<script type=\"importmap\">{imports}</script>\n</head>\n<body>");
    header(page, &title, &mut out);
    out.push_str("<main id=\"main\">\n");
    // A person who triangulates looks for the data first, and a person who simulates for the proof.
    let first = if direct { page.data_figures() } else { 1 };
    if direct && view.is_object() {
        out.push_str(SCENE);
    }
    if let Some(run) = shown {
        summary(run, &mut out);
    }
    for figure in page.figures.iter().take(first) {
        section(figure, &mut out);
    }
    if let Some(run) = shown.filter(|_| direct) {
        triangulation::details(run, &mut out);
    }
    if !direct && view.is_object() {
        out.push_str(SCENE);
    }
    for figure in page.figures.iter().skip(first) {
        section(figure, &mut out);
    }
    if let Some(mesh) = mesh {
        mesh::section(mesh, &mut out);
        if mesh.file.view.is_some() {
            out.push_str(MESH);
        }
    }
    for figure in &page.mesh_figures {
        section(figure, &mut out);
    }
    runs_table(page, &mut out);
    out.push_str("</main>\n");
    footer(&mut out);
    let _ = writeln!(out, "<script type=\"application/json\" id=\"data\">{}</script>", embedded(&data)?);
    let _ = writeln!(out, "<script type=\"module\">{MAIN}</script>\n</body>\n</html>");
    Ok(out)
}

/// Returns the data of a mesh for the script.
fn picture(mesh: Option<&MeshData>) -> Value {
    let Some(mesh) = mesh else { return Value::Null };
    let mut value = json!(mesh.file.view);
    if let Value::Object(fields) = &mut value {
        fields.insert("dimension".to_owned(), json!(mesh.file.domain.dimension));
    }
    value
}

fn tables_of(figure: &PageFigure) -> Value {
    figure.variants.iter().map(|v| json!(v.table)).collect()
}

fn headline(run: &RunData) -> String {
    let n = run.n().map_or_else(|| "no".to_owned(), grouped);
    format!("{n} points, {}", run.kind())
}

fn header(page: &Page, title: &str, out: &mut String) {
    out.push_str("<a class=\"skip\" href=\"#main\">To the figures</a>\n<header>\n<div>\n<p class=\"mark\">septet</p>\n");
    let _ = writeln!(out, "<h1>{}</h1>\n</div>", escape(title));
    out.push_str("<nav aria-label=\"Figures\">\n");
    let mut links: Vec<(&str, &str)> = page.figures.iter().map(|f| (f.id, f.title)).collect();
    let shown = page.shown.map(|at| &page.runs[at]);
    let direct = shown.is_some_and(RunData::is_direct);
    let place = if direct { 0 } else { links.len().min(1) };
    if direct {
        links.insert(page.data_figures(), ("details", "The run"));
    }
    if shown.is_some_and(|run| run.value["view"].is_object()) {
        links.insert(place, ("partition", if direct { "The points" } else { "The partition" }));
    }
    if page.meshes.first().is_some_and(|mesh| mesh.file.view.is_some()) {
        links.push(("mesh", "The mesh"));
    }
    links.extend(page.mesh_figures.iter().map(|f| (f.id, f.title)));
    for (id, title) in links {
        let _ = writeln!(out, "<a href=\"#{id}\">{}</a>", escape(title));
    }
    out.push_str(
        "</nav>\n<button id=\"theme\" type=\"button\" aria-label=\"Light or dark\">Theme: system</button>\n",
    );
    out.push_str("</header>\n");
}

fn summary(run: &RunData, out: &mut String) {
    let get = |pointer: &str| run.number(pointer);
    let say = |pointer: &str| get(pointer).map_or_else(|| "–".to_owned(), grouped);
    let word = |pointer: &str| run.value.pointer(pointer).map_or("", text).to_owned();
    let cell = match run.space() as usize {
        2 => "triangles",
        3 => "tetrahedra",
        _ => "cells",
    };
    out.push_str("<section id=\"summary\" aria-label=\"Summary of the run\">\n<dl class=\"cards\">\n");
    let duplicates = format!("{} duplicate, {} refused", say("/points/duplicate"), say("/points/refused"));
    card(out, "points", &say("/points/used"), &duplicates);
    card(out, cell, &say("/simplices"), &format!("{} hull facets", say("/hull_facets")));
    let repair = format!("{} stars repaired in {} rounds", say("/repair/stars"), say("/repair/rounds"));
    card(out, "certificate", &word("/certificate"), &repair);
    let machine =
        format!("{} messages, {}B", say("/machine/messages"), si(get("/machine/bytes").unwrap_or(0.0)));
    card(out, "workers", &say("/machine/workers"), &machine);
    let cut = match word("/parameters/partition").as_str() {
        "kd" => ", cut by k-d planes",
        "hilbert" => ", cut along a Hilbert curve",
        _ => "",
    };
    let balls = match word("/parameters/neighbours").as_str() {
        "naive" => ", balls corrected bottom-up",
        "fmt" => ", balls corrected bottom-up in stages",
        "pairs" => ", balls from well-separated pairs",
        _ => "",
    };
    let tree = format!("{} levels of the tree{cut}{balls}", say("/tree/levels"));
    card(out, "rounds", &say("/machine/rounds"), &tree);
    if let Some(depth) = get("/machine/paper/depth") {
        let work = si(get("/machine/paper/work").unwrap_or(0.0));
        card(out, "depth", &grouped(depth), &format!("work {work}, the paper's phases"));
    }
    let parameter = |name: &&str| Some(format!(", {name} {}", get(&format!("/supergraph/{name}"))?));
    let parameters: String = ["alpha", "k"].iter().filter_map(parameter).collect();
    let kind = format!("{}{parameters}", word("/supergraph/kind"));
    card(out, "supergraph", &kind, &word("/supergraph/why"));
    let seconds = get("/seconds/triangulate").map_or_else(|| "–".to_owned(), |s| format!("{}s", si(s)));
    card(out, "measured time", &seconds, &format!("seed {}, version {}", say("/seed"), word("/version")));
    out.push_str("</dl>\n</section>\n");
}

fn section(figure: &PageFigure, out: &mut String) {
    let (id, title) = (figure.id, escape(figure.title));
    let _ = writeln!(out, "<section id=\"{id}\" class=\"plate\" aria-labelledby=\"{id}-title\">");
    let _ = writeln!(out, "<h2 id=\"{id}-title\">{title}</h2>");
    if figure.variants.len() > 1 {
        let _ = writeln!(out, "<label class=\"choice\">Show <select data-figure=\"{id}\">");
        for (i, variant) in figure.variants.iter().enumerate() {
            let _ = writeln!(out, "<option value=\"{i}\">{}</option>", escape(&variant.name));
        }
        out.push_str("</select></label>\n");
    }
    for (i, variant) in figure.variants.iter().enumerate() {
        let hidden = if i == 0 { "" } else { " hidden" };
        let label = format!("{} {}", figure.title, variant.name);
        let _ = writeln!(out, "<div class=\"drawing\"{hidden}>{}</div>", variant.body.inline(label.trim()));
    }
    let _ = writeln!(out, "<p class=\"caption\">{}</p>", escape(&figure.caption));
    let _ = writeln!(
        out,
        "<details data-table=\"{id}\"><summary>Table</summary><button type=\"button\" class=\"csv\">Download as \
         CSV</button><div class=\"rows\" tabindex=\"0\" role=\"region\" aria-label=\"Table of {title}\"></div></details>\n\
         </section>"
    );
}

/// Maximum number of runs, and of meshes, in the table.
const MOST_RUNS: usize = 200;

/// The table of all runs with their parameters.
fn runs_table(page: &Page, out: &mut String) {
    out.push_str(
        "<section id=\"runs\" class=\"plate\"><h2>Runs on this page</h2>\n<div class=\"rows\" tabindex=\"0\"",
    );
    out.push_str(" role=\"region\" aria-label=\"Runs\"><table><thead><tr>");
    for head in ["run", "kind", "d", "n", "workers", "seed", "messages", "bytes"] {
        let _ = write!(out, "<th scope=\"col\">{head}</th>");
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    let count = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), grouped);
    for run in page.runs.iter().take(MOST_RUNS) {
        let cells = [
            escape(&run.name),
            escape(&run.kind()),
            count(Some(run.space())),
            count(run.n()),
            count(run.workers()),
            count(Some(number(&run.value["seed"]))),
            count(run.total("messages")),
            count(run.total("bytes")),
        ];
        row(&cells, out);
    }
    for mesh in page.meshes.iter().take(MOST_RUNS) {
        let file = &mesh.file;
        let cells = [
            escape(&mesh.name),
            format!("mesh of {}", escape(&file.parameters.input)),
            count(Some(file.domain.dimension as f64)),
            count(Some(file.mesh.points as f64)),
            count(file.settled.workers.map(f64::from)),
            count(Some(file.parameters.seed as f64)),
            count(Some(mesh.messages() as f64)),
            count(Some(mesh.bytes() as f64)),
        ];
        row(&cells, out);
    }
    out.push_str("</tbody></table></div>\n");
    for (length, what) in [(page.runs.len(), "runs"), (page.meshes.len(), "meshes")] {
        if length > MOST_RUNS {
            let _ = writeln!(out, "<p class=\"caption\">The first {MOST_RUNS} of {length} {what}.</p>");
        }
    }
    out.push_str("</section>\n");
}

fn row(cells: &[String], out: &mut String) {
    out.push_str("<tr>");
    for cell in cells {
        let _ = write!(out, "<td>{cell}</td>");
    }
    out.push_str("</tr>\n");
}

fn footer(out: &mut String) {
    let version = env!("CARGO_PKG_VERSION");
    let _ = writeln!(
        out,
        "<footer><p>Made by septet {version}. Counts belong to the modelled machine and repeat exactly; times are \
         measured. Points and cells are drawn with three.js.</p><details><summary>Licence of three.js</summary><pre>{}</pre>\
         </details></footer>",
        escape(LICENCE)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_ends_its_element() {
        let text = embedded(&json!({ "a": "</script><!--<script>" })).unwrap();
        assert!(!text.contains('<'));
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap()["a"], "</script><!--<script>");
        assert_eq!(address("a<b %\"\n"), "data:text/javascript;charset=utf-8,a%3Cb%20%25%22%0A");
        assert!(!MAIN.contains("</script"));
    }
}
