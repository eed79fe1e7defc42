//! Plots of several runs with the growth laws of the paper.

use std::collections::BTreeMap;

use serde_json::json;

use super::data::{RunData, text};
use super::levels::{LawShape, with_law};
use super::plot::{Plot, PlotSeries};
use super::{DataTable, PageFigure, Variant};

/// A growth law, as a function of n and as a formula.
struct PlottedLaw {
    shape: fn(n: f64, space: f64) -> f64,
    name: &'static str,
    affine: bool,
}

const LOG: PlottedLaw = PlottedLaw { shape: |n, _| n.log2(), name: "log₂ n", affine: true };
const SURFACE: PlottedLaw =
    PlottedLaw { shape: |n, d| n.powf(1.0 - 1.0 / d), name: "n^(1−1/d)", affine: false };
const LINEARITHMIC: PlottedLaw = PlottedLaw { shape: |n, _| n * n.log2(), name: "n log₂ n", affine: false };

/// Draws the figures, if the runs have at least two sizes.
pub(super) fn figures(runs: &[RunData]) -> Vec<PageFigure> {
    let mut sizes: Vec<u64> = runs.iter().filter_map(RunData::n).map(|n| n as u64).collect();
    sizes.sort_unstable();
    sizes.dedup();
    if sizes.len() < 2 {
        return Vec::new();
    }
    let one = |id, title, caption: &str, variants: Vec<Option<Variant>>| {
        let variants: Vec<Variant> = variants.into_iter().flatten().collect();
        (!variants.is_empty()).then(|| PageFigure { id, title, caption: caption.to_owned(), variants })
    };
    let total = |key: &'static str| move |r: &RunData| r.total(key);
    let figures = [
        one("law-depth", "Depth and its law", DEPTH, depth(runs)),
        one(
            "law-levels",
            "Levels of the tree",
            "If each split leaves at most a constant fraction of the points on a side, the number of levels is logarithmic.",
            vec![variant(
                runs,
                "",
                "levels",
                &|r| r.number("/tree/levels").or_else(|| r.number("/levels")),
                &LOG,
            )],
        ),
        one(
            "law-separators",
            "Separators of the root",
            "Points whose balls cross the separator of the root, with the surface law.",
            vec![variant(runs, "", "separator points", &RunData::root_separator, &SURFACE)],
        ),
        one(
            "law-traffic",
            "Bytes and rounds with their laws",
            "The bytes of the separator sets grow with the surfaces between workers, like n^(1−1/d). The bytes of moves, \
             of loading and of results grow like n and are omitted. The rounds of the recursion are logarithmic until \
             every worker has its leaf.",
            vec![
                variant(
                    runs,
                    "ghost bytes",
                    "bytes of the separator sets [B]",
                    &|r| r.phase("separator-sets", "bytes"),
                    &SURFACE,
                ),
                variant(runs, "rounds", "rounds", &total("rounds"), &LOG),
            ],
        ),
        one(
            "law-work",
            "Work and its law",
            "Operations of the phases of the paper.",
            vec![variant(
                runs,
                "",
                "work [operations]",
                &|r| r.number("/machine/paper/work").or_else(|| r.total("work")),
                &LINEARITHMIC,
            )],
        ),
    ];
    figures.into_iter().flatten().collect()
}

const DEPTH: &str = "Solid: the power law fitted to the marks. Dashed: b log₂ n + a, by least squares. On these axes, a \
                     logarithm bends below every power law.";

/// Draws the depth of the whole run, then of each phase.
fn depth(runs: &[RunData]) -> Vec<Option<Variant>> {
    let whole = |r: &RunData| r.number("/machine/paper/depth").or_else(|| r.number("/depth"));
    let mut names: Vec<&str> = Vec::new();
    for phase in runs.iter().flat_map(|r| r.rows("/phases")) {
        let name = text(&phase["name"]);
        if !names.contains(&name) && phase["depth"].as_f64().is_some_and(|d| d > 0.0) {
            names.push(name);
        }
    }
    let mut all = vec![variant(runs, "paper's phases", "depth [steps]", &whole, &LOG)];
    all.extend(names.iter().map(|&name| {
        variant(runs, name, &format!("depth of {name} [steps]"), &|r| r.phase(name, "depth"), &LOG)
    }));
    all
}

/// Plots a quantity against n, with a series for the runs that differ only in size and seed.
fn variant(
    runs: &[RunData],
    name: &str,
    label: &str,
    value: &dyn Fn(&RunData) -> Option<f64>,
    law: &PlottedLaw,
) -> Option<Variant> {
    let mut table = DataTable::new(&["run", "kind", "workers", "d", "n", label]);
    let mut groups: BTreeMap<(String, u64, String), Vec<(f64, f64)>> = BTreeMap::new();
    let many_workers = varied(runs);
    for run in runs {
        let (Some(n), Some(y)) = (run.n(), value(run)) else { continue };
        let (kind, space, workers) = (run.kind(), run.space(), run.workers());
        table.rows.push(vec![json!(run.name), json!(kind), json!(workers), json!(space), json!(n), json!(y)]);
        let mut by = run.options();
        by.extend(many_workers.then(|| format!("p = {}", run.asked_workers())));
        if y > 0.0 {
            groups.entry((kind, space as u64, by.join(", "))).or_default().push((n, y));
        }
    }
    let series: Vec<PlotSeries> = groups
        .iter()
        .map(|((kind, space, by), marks)| {
            let by = if by.is_empty() { String::new() } else { format!(", {by}") };
            let shape = |n: f64| (law.shape)(n, *space as f64);
            let law = LawShape { of: &shape, affine: law.affine, name: law.name };
            with_law(&format!("{kind}, {space}D{by}"), marks, &law)
        })
        .collect();
    if series.iter().all(|s| s.fit.is_empty()) {
        return None;
    }
    let plot = Plot { x: ("points, n", true), y: (label, true), series };
    Some(Variant { name: name.to_owned(), body: plot.draw(), table })
}

/// Returns `true` if runs differ in the requested number of workers.
fn varied(runs: &[RunData]) -> bool {
    runs.windows(2).any(|pair| pair[0].asked_workers() != pair[1].asked_workers())
}
