//! The partition tree of a run, by level and by node.

use serde_json::json;

use super::axes::si;
use super::data::{RunData, number};
use super::fit::{power_law, scaled, straight};
use super::plot::{Plot, PlotSeries};
use super::{DataTable, PageFigure, Variant};

/// Draws the tree.
pub(super) fn figures(run: &RunData) -> Vec<PageFigure> {
    [depths(run), separators(run)].into_iter().flatten().collect()
}

/// Draws the largest depth of a node on each level.
fn depths(run: &RunData) -> Option<PageFigure> {
    let levels = run.rows("/tree/by_level");
    let phases = ["partition", "neighbours", "merge"];
    let mut table = DataTable::new(&["level", "nodes", "leaves", "points", "largest node"]);
    table.columns.extend(phases.map(|p| format!("depth of {p}")));
    for l in levels {
        let keys = ["level", "nodes", "leaves", "points", "largest"];
        let mut row: Vec<_> = keys.iter().map(|&k| l[k].clone()).collect();
        row.extend(phases.iter().map(|p| l[&format!("{p}_depth")].clone()));
        table.rows.push(row);
    }
    let line = |phase: &&str| {
        let key = format!("{phase}_depth");
        let marks: Vec<(f64, f64)> =
            levels.iter().filter_map(|l| Some((number(&l["level"]), l[&key].as_f64()?))).collect();
        let marks = marks.into_iter().filter(|m| m.1 > 0.0).collect();
        PlotSeries { name: (*phase).to_owned(), marks, joined: true, ..PlotSeries::default() }
    };
    let depth: Vec<PlotSeries> = phases.iter().map(line).filter(|s| !s.marks.is_empty()).collect();
    let size = |key: &str, name: &str| PlotSeries {
        name: name.to_owned(),
        marks: levels.iter().map(|l| (number(&l["level"]), number(&l[key]))).filter(|m| m.1 > 0.0).collect(),
        joined: true,
        ..PlotSeries::default()
    };
    let sizes = vec![
        size("points", "points of all nodes"),
        size("largest", "points of the largest"),
        size("separator_points", "separator points"),
        size("nodes", "nodes"),
    ];
    let mut variants = Vec::new();
    if !depth.is_empty() {
        let plot =
            Plot { x: ("level (root 0)", false), y: ("depth of a node [steps]", false), series: depth };
        variants.push(Variant { name: "depth".to_owned(), body: plot.draw(), table: table.clone() });
    }
    if levels.len() > 1 {
        let plot = Plot { x: ("level (root 0)", false), y: ("number", true), series: sizes };
        variants.push(Variant { name: "sizes".to_owned(), body: plot.draw(), table });
    }
    let caption =
        "The recursion takes O(1) steps per level at every size, so the lines are flat. O(log n) levels give a \
                   depth of O(log n). The depth of a level is the largest depth of its nodes."
            .to_owned();
    (!variants.is_empty()).then_some(PageFigure { id: "levels", title: "Depth by level", caption, variants })
}

/// Draws the separator sizes of all nodes with their law.
fn separators(run: &RunData) -> Option<PageFigure> {
    let mut table = DataTable::new(&["node", "level", "points", "separator points", "kind"]);
    let mut marks = Vec::new();
    for node in run.rows("/nodes").iter().filter(|n| n["kind"] != "leaf") {
        let crossing = number(&node["crossing_inside"]) + number(&node["crossing_outside"]);
        table.rows.push(vec![
            node["id"].clone(),
            node["level"].clone(),
            node["population"].clone(),
            json!(crossing),
            node["kind"].clone(),
        ]);
        marks.push((number(&node["population"]), crossing));
    }
    marks.retain(|m| m.1 > 0.0);
    if marks.len() < 3 {
        return None;
    }
    let exponent = 1.0 - 1.0 / run.space();
    let power = format!("m^({}/{})", run.space() - 1.0, run.space());
    let law = LawShape { of: &|m| m.powf(exponent), affine: false, name: &power };
    let series = with_law("every split", &marks, &law);
    let plot = Plot {
        x: ("points of the node, m", true),
        y: ("points whose ball meets the separator", true),
        series: vec![series],
    };
    let variants = vec![Variant { name: String::new(), body: plot.draw(), table }];
    let caption = format!(
        "Each mark is one split. Dashed: the law c {power} of sphere separators; solid: the power law fitted to the \
         marks."
    );
    Some(PageFigure { id: "separators", title: "Separator sizes", caption, variants })
}

/// A law for the marks: `c of(x)`, or `a + b of(x)` if the law is affine.
pub(super) struct LawShape<'a> {
    pub(super) of: &'a dyn Fn(f64) -> f64,
    pub(super) affine: bool,
    pub(super) name: &'a str,
}

/// Returns marks with the fitted power law and the proved law.
pub(super) fn with_law(name: &str, marks: &[(f64, f64)], law: &LawShape<'_>) -> PlotSeries {
    let low = marks.iter().map(|m| m.0).fold(f64::INFINITY, f64::min);
    let high = marks.iter().map(|m| m.0).fold(0.0, f64::max);
    let along = |f: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        let at = |i: u32| low * (high / low).powf(f64::from(i) / 40.0);
        (0..=40).map(|i| (at(i), f(at(i)))).collect()
    };
    let mut series = PlotSeries { name: name.to_owned(), marks: marks.to_vec(), ..PlotSeries::default() };
    let Some(fit) = power_law(marks) else { return series };
    series.notes.push(fit.words());
    series.fit = along(&|x| fit.coefficient * x.powf(fit.exponent));
    let shaped: Vec<(f64, f64)> = marks.iter().map(|m| ((law.of)(m.0), m.1)).collect();
    if law.affine {
        if let Some((a, b)) = straight(&shaped) {
            series.law = along(&|x| a + b * (law.of)(x));
            let sign = if a < 0.0 { "−" } else { "+" };
            let (a, b) = (significant(a.abs()), significant(b));
            series.notes.push(format!("law {b} {} {sign} {a}, dashed", law.name));
        }
    } else if let Some(c) = scaled(marks, law.of) {
        series.law = along(&|x| c * (law.of)(x));
        series.notes.push(format!("law {} {}, dashed", significant(c), law.name));
    }
    series
}

/// Formats a number with at least two significant digits.
fn significant(c: f64) -> String {
    if c.abs() >= 1e6 {
        return si(c);
    }
    let digits = usize::try_from(1 - c.abs().max(1e-9).log10().floor() as i32).unwrap_or(0).min(6);
    format!("{c:.digits$}")
}
