//! Bar charts of the proofs of the stars and of the cost of each phase.

use std::collections::BTreeSet;

use septet_protocol::ids::{Group, Phase};
use serde_json::{Value, json};

use super::axes::{Axis, grouped, si};
use super::data::{RunData, number, text};
use super::svg::Drawing;
use super::{DataTable, PageFigure, Variant};

/// Draws the number of stars with each kind of proof. For `simulate`, these numbers show how well the hypothesis of the
/// theorem holds.
pub(super) fn proofs(run: &RunData) -> Option<PageFigure> {
    let certified = if run.is_direct() {
        ("direct", "certificate over exact subdomain triangulations; no hypothesis")
    } else {
        ("hypothesis", "supergraph and certificate alone, as the paper assumes")
    };
    let kinds = [
        certified,
        ("local_radius", "a ball of the known radius would suffice"),
        ("exchange", "changed by star splaying"),
    ];
    let counts = kinds.map(|(key, _)| run.number(&format!("/how_proved/{key}")).unwrap_or(0.0));
    let total: f64 = counts.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let mut out = Drawing::new(820.0, 132.0);
    let mut table = DataTable::new(&["proved by", "stars", "share"]);
    let mut left = 10.0;
    for (i, ((key, what), count)) in kinds.into_iter().zip(counts).enumerate() {
        let width = 800.0 * count / total;
        out.rect(&format!("bar c{i}"), (left, 10.0), ((width - 1.5).max(0.0), 34.0));
        left += width;
        let name = key.replace('_', " ");
        let y = 68.0 + 23.0 * i as f64;
        out.mark(&format!("mark c{i}"), 1, (17.0, y - 4.5), 6.0);
        out.text("legend", (32.0, y), "start", &name);
        out.text("legend number", (228.0, y), "end", &grouped(count));
        out.text("legend number", (296.0, y), "end", &format!("{:.2} %", 100.0 * count / total));
        out.text("note", (316.0, y), "start", what);
        table.rows.push(vec![json!(name), json!(count), json!(count / total)]);
    }
    let caption =
        "If the hypothesis of the theorem holds, splaying changes no star. Every star passed the certificate."
            .to_owned();
    let variants = vec![Variant { name: String::new(), body: out, table }];
    Some(PageFigure { id: "proofs", title: "How each star was certified", caption, variants })
}

/// A measure of a phase: key, name, unit.
const MEASURES: [(&str, &str, &str); 7] = [
    ("critical_depth", "critical path", "steps"),
    ("depth", "depth", "steps"),
    ("work", "work", "operations"),
    ("exact_tests", "exact tests", "tests"),
    ("bytes", "bytes", "B"),
    ("messages", "messages", "messages"),
    ("seconds", "time (measured)", "s"),
];

/// Draws the cost of each phase, with a chart per measure.
pub(super) fn phases(run: &RunData) -> Option<PageFigure> {
    let variants: Vec<Variant> = MEASURES.iter().filter_map(|m| phase_bars(run, m)).collect();
    let caption = "Steps, operations, messages and bytes are counts of the modelled machine; seconds are measured. The \
                   pattern of a bar shows the group of its phase."
        .to_owned();
    (!variants.is_empty()).then_some(PageFigure { id: "phases", title: "Cost by phase", caption, variants })
}

fn phase_bars(run: &RunData, (key, name, unit): &(&str, &str, &str)) -> Option<Variant> {
    let all = run.rows("/phases").iter().filter(|p| p[key].as_f64().is_some());
    let drawn = all.map(|p| Bar { name: text(&p["name"]), group: group(p), value: number(&p[key]) });
    let rows: Vec<Bar<'_>> = drawn.filter(|bar| bar.value > 0.0).collect();
    if rows.is_empty() {
        return None;
    }
    let label = format!("{name} [{unit}]");
    let mut table = DataTable::new(&["phase", "group", &label]);
    table.rows = rows
        .iter()
        .map(|bar| vec![json!(bar.name), json!(bar.group.map(Group::name)), json!(bar.value)])
        .collect();
    Some(Variant { name: (*name).to_owned(), body: bars(&rows, &label), table })
}

/// Returns the group of a phase in a report. Reports of earlier versions and lines of sweeps state only its name.
fn group(phase: &Value) -> Option<Group> {
    let stated = serde_json::from_value(phase["group"].clone()).ok();
    stated.or_else(|| Phase::from_name(text(&phase["name"])).map(Phase::group))
}

/// A bar of a chart.
#[derive(Clone, Copy)]
pub(super) struct Bar<'a> {
    pub(super) name: &'a str,
    /// The group of the phase, if the bar belongs to one.
    pub(super) group: Option<Group>,
    pub(super) value: f64,
}

/// Returns the class of the bars of a group, and the name of the group in the legend.
fn legend(group: Group) -> (&'static str, &'static str) {
    match group {
        Group::Paper => ("bar c0", "the paper"),
        Group::Repair => ("hatched", "agreement and repair"),
        Group::Selection => ("bar c1", "choice of the supergraph"),
        Group::Direct => ("bar c3", "direct triangulation"),
        Group::Machine => ("bar c4", "the machine"),
    }
}

/// Draws horizontal bars, with a legend of their groups.
pub(super) fn bars(rows: &[Bar<'_>], label: &str) -> Drawing {
    let (left, right, step) = (130.0, 720.0, 22.0);
    let bottom = 12.0 + step * rows.len() as f64;
    let axis = Axis::around(label, false, rows.iter().map(|r| r.value), (left, right));
    let groups: BTreeSet<Group> = rows.iter().filter_map(|row| row.group).collect();
    let mut out = Drawing::new(820.0, bottom + if groups.is_empty() { 54.0 } else { 78.0 });
    out.raw(HATCH);
    for tick in axis.ticks() {
        out.line("grid", (axis.at(tick), 8.0), (axis.at(tick), bottom));
        out.text("tick", (axis.at(tick), bottom + 17.0), "middle", &si(tick));
    }
    for (i, &Bar { name, group, value }) in rows.iter().enumerate() {
        let y = 12.0 + step * i as f64;
        let class = group.map_or("bar c0", |group| legend(group).0);
        out.rect(class, (left, y), (axis.at(value) - left, step - 6.0));
        out.text("legend", (left - 8.0, y + 12.5), "end", name);
        out.text("note number", (axis.at(value) + 7.0, y + 12.5), "start", &si(value));
    }
    out.line("axis", (left, 8.0), (left, bottom));
    out.text("label", (f64::midpoint(left, right), bottom + 40.0), "middle", label);
    let mut x = left;
    for (class, name) in groups.into_iter().map(legend) {
        out.rect(class, (x, bottom + 54.0), (14.0, 14.0));
        out.text("legend", (x + 20.0, bottom + 65.5), "start", name);
        x += 44.0 + 6.6 * name.len() as f64;
    }
    out
}

const HATCH: &str = r#"<defs><pattern id="hatch" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><rect class="hatch-ground" width="6" height="6"/><rect class="bar c0" width="2.5" height="6"/></pattern></defs>"#;
